// A field's text: set where it becomes another, so that what is being typed stays when
// something else of the page is drawn anew.
export default {
  mounted(field, { value }) {
    field.value = value;
  },
  updated(field, { value, oldValue }) {
    if (value !== oldValue) field.value = value;
  },
};
