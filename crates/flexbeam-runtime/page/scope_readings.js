// The table of what the cursors read.
// Enters: a heading and rows as text. Leaves: a table of the page, hidden when the cursors are.

import { element } from "./element.js";

export class Readings {
  constructor() {
    this.rows = element("tbody");
    this.note = element("caption");
    this.head = element("tr");
    this.element = element(
      "table",
      { class: "scope-readings", hidden: true },
      this.note,
      element("thead", {}, this.head),
      this.rows,
    );
  }

  /**
   * @param {{head: string[], rows: {cells: string[], colour: string|null}[], note: string}|null} table null hides it
   */
  show(table) {
    this.element.hidden = !table;
    if (!table) return;
    if (this.head.cells.length !== table.head.length) {
      this.head.replaceChildren(...table.head.map(() => element("th", { scope: "col" })));
      this.rows.replaceChildren();
    }
    table.head.forEach((text, k) => put(this.head.cells[k], text));
    while (this.rows.rows.length > table.rows.length) this.rows.deleteRow(-1);
    while (this.rows.rows.length < table.rows.length) this.rows.append(row(table.head.length));
    table.rows.forEach(({ cells, colour }, k) => fill(this.rows.rows[k], cells, colour));
    put(this.note, table.note);
  }
}

function row(columns) {
  return element("tr", {}, element("th", { scope: "row" }), ...Array.from({ length: columns - 1 }, () => element("td")));
}

function fill(target, cells, colour) {
  cells.forEach((text, k) => put(target.cells[k], text));
  target.cells[0].style.borderLeft = `3px solid ${colour ?? "transparent"}`;
}

function put(target, text) {
  if (target.textContent !== text) target.textContent = text;
}
