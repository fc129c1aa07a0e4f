// Sliders with a field each; where they are moved is told to the server, the newest of
// each picture that the browser draws.
import shown from "drakesep-page/shown.js";

export default {
  template: `
<div class="sliders">
  <div v-for="s in sliders" :key="s.name" class="slider" :class="{moved: at(s) !== s.nominal}">
    <label :for="'slider-' + s.name" :title="s.name">{{ s.words }}</label>
    <input class="slider-value" v-shown="at(s)" :aria-label="s.words + ' in ' + s.unit"
      autocomplete="off" spellcheck="false" @change="e => typed(s, e.target)">
    <span class="slider-unit">{{ s.unit }}</span>
    <input type="range" :id="'slider-' + s.name" :min="s.low" :max="s.high" :step="s.step"
      :value="at(s)" :style="{'--nominal': (s.nominal - s.low) / (s.high - s.low)}"
      :title="s.low + ' to ' + s.high + ' ' + s.unit + '; double click: ' + s.nominal"
      @input="e => moved(s, Number(e.target.value))" @dblclick="moved(s, s.nominal)">
  </div>
</div>`,
  props: { sliders: Array },
  directives: { shown },
  data() {
    return { moving: {} };
  },
  watch: {
    // What the server says holds, but for what it has not heard of yet.
    sliders() {
      if (!this.waits) this.moving = {};
    },
  },
  methods: {
    at(s) {
      return this.moving[s.name] ?? s.value;
    },
    typed(s, field) {
      const value = Number(field.value.replace(",", "."));
      if (field.value.trim() === "" || !Number.isFinite(value)) {
        field.value = this.at(s);
        return;
      }
      this.moved(s, value);
    },
    moved(s, value) {
      this.moving = { ...this.moving, [s.name]: value };
      this.pending = { ...this.pending, [s.name]: value };
      if (this.waits) return;
      this.waits = true;
      requestAnimationFrame(() => {
        this.waits = false;
        const told = this.pending;
        this.pending = {};
        this.$emit("move", told);
      });
    },
  },
};
