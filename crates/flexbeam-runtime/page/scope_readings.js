// The table of what the cursors read.
// Enters: a heading and rows as text. Leaves: a table of the page, hidden when the cursors are.

import { element } from "./scope_parts.js";

const HEAD = ["", "A", "B", "B \u2212 A"];

export class Readings {
  constructor() {
    this.rows = element("tbody");
    this.note = element("caption");
    const head = element("tr", {}, ...HEAD.map((text) => element("th", { scope: "col", text })));
    this.element = element("table", { class: "scope-readings", hidden: true }, this.note, element("thead", {}, head), this.rows);
  }

  /**
   * @param {{head: object, rows: object[], note: string}|null} table null hides it
   */
  show(table) {
    this.element.hidden = !table;
    if (!table) return;
    const rows = [table.head, ...table.rows];
    while (this.rows.rows.length > rows.length) this.rows.deleteRow(-1);
    while (this.rows.rows.length < rows.length) this.rows.append(row());
    rows.forEach((entry, k) => fill(this.rows.rows[k], entry));
    put(this.note, table.note);
  }
}

function row() {
  return element("tr", {}, element("th", { scope: "row" }), ...[1, 2, 3].map(() => element("td")));
}

function fill(target, { label, colour, a, b, difference }) {
  [label, a, b, difference].forEach((text, k) => put(target.cells[k], text));
  target.cells[0].style.borderLeft = colour ? `3px solid ${colour}` : "3px solid transparent";
}

function put(target, text) {
  if (target.textContent !== text) target.textContent = text;
}
