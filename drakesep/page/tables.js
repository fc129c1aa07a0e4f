// Tables of a case whose cells are fields: what is typed is told to the server, which
// answers with the tables as they are then, or with what is wrong with what was typed.
import shown from "drakesep-page/shown.js";

export default {
  template: `
<div class="tables" @keydown="move">
  <section v-for="t in tables" :key="t.key" :id="'table-' + t.key">
    <header>
      <h2>{{ t.title }}</h2>
      <button v-if="t.addable" class="tables-add" type="button"
        @click="$emit('add', {table: t.key})">Add {{ t.addable }}</button>
    </header>
    <div v-if="t.rows.length" class="tables-scroll" tabindex="-1">
      <table>
        <thead><tr>
          <th scope="col" class="tables-name">{{ t.first }}</th>
          <th v-for="(c, i) in t.columns" :key="i" scope="col" :class="{number: c.numeric}">
            {{ c.title }}<small v-if="c.unit">{{ c.unit }}</small></th>
          <th v-if="t.rows[0].removable"></th>
        </tr></thead>
        <tbody>
          <tr v-for="r in t.rows" :key="key(r.path)">
            <th scope="row" class="tables-name" :class="{wrong: r.problem}"
              :title="r.problem || r.name">{{ r.name }}</th>
            <td v-for="(c, i) in r.cells" :key="i" :class="{number: t.columns[i].numeric}">
              <span v-if="!c.path" class="tables-told">{{ c.text }}</span>
              <input v-else v-shown="shown(c)" :style="{width: t.columns[i].width + 'ch'}"
                :class="{wrong: problem(c)}" :title="problem(c) || null"
                :aria-invalid="!!problem(c)" :data-cell="key(c.path)"
                :aria-label="[r.name, t.columns[i].title, t.columns[i].unit].join(' ')"
                autocomplete="off" spellcheck="false"
                @change="e => typed(c, e.target.value)">
            </td>
            <td v-if="r.removable"><button class="tables-remove" type="button"
              :aria-label="'Remove ' + r.name" title="Remove"
              @click="$emit('remove', {path: r.path})">×</button></td>
          </tr>
        </tbody>
      </table>
    </div>
    <p v-else class="tables-none">None yet.</p>
  </section>
</div>`,
  props: { tables: Array, refused: Object },
  directives: { shown },
  methods: {
    key(path) {
      return JSON.stringify(path);
    },
    isRefused(cell) {
      return this.refused && this.refused.cell === this.key(cell.path);
    },
    shown(cell) {
      return this.isRefused(cell) ? this.refused.text : cell.text;
    },
    problem(cell) {
      return this.isRefused(cell) ? this.refused.problem : cell.problem;
    },
    typed(cell, text) {
      this.$emit("edit", { path: cell.path, text });
    },
    // Enter and arrows go to the cell below or above, Escape brings back what was there.
    move(e) {
      const field = e.target;
      if (field.tagName !== "INPUT") return;
      if (e.key === "Escape") {
        field.value = this.before(field) ?? field.value;
        field.select();
        return;
      }
      const step = { Enter: 1, ArrowDown: 1, ArrowUp: -1 }[e.key];
      if (!step) return;
      e.preventDefault();
      const row = field.closest("tr");
      const next = step > 0 ? row.nextElementSibling : row.previousElementSibling;
      const below = next?.children[field.closest("td").cellIndex]?.querySelector("input");
      if (below) {
        below.focus();
        below.select();
      } else if (e.key === "Enter") {
        field.blur();
        field.focus();
      }
    },
    before(field) {
      for (const t of this.tables)
        for (const r of t.rows)
          for (const c of r.cells)
            if (c.path && this.key(c.path) === field.dataset.cell) return c.text;
    },
  },
};
