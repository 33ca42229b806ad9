// A control panel: settings side by side. Enters: the panel as it is saved, the knobs, the state. Leaves: new values of settings, and
// the panel as it stands now.

import { Choice } from "./choice.js";
import { PATHS, attribute, element, iconButton, write } from "./element.js";
import { Slider } from "./slider.js";

let made = 0;

export class Panel {
  /**
   * @param {{panel: Object, knobs: Map<string, Object>, isOpen: boolean, commit: (key: string, value: number|string) => Promise<Object>,
   *   onedit: (panel: Panel) => void, onmove: (panel: Panel, way: number) => void}} about panel as in hello.screen
   */
  constructor({ panel, knobs, isOpen, commit, onedit, onmove }) {
    made += 1;
    const id = `panel-${made}`;
    this.commit = commit;
    this.heading = element("button", { type: "button", class: "fold", "aria-expanded": String(isOpen), "aria-controls": id, onclick: () => this.#fold() });
    this.edit = iconButton("", PATHS.edit, () => onedit(this));
    this.up = iconButton("", PATHS.up, () => onmove(this, -1));
    this.down = iconButton("", PATHS.down, () => onmove(this, 1));
    this.why = element("p", { class: "why" });
    this.rows = element("div", { class: "rows", id, hidden: !isOpen });
    this.element = element("section", { class: "card panel" },
      element("header", {}, element("h2", {}, this.heading), element("div", { class: "tools" }, this.edit, this.up, this.down)), this.rows);
    this.show(panel, knobs);
  }

  /** The panel as it is saved. */
  get panel() {
    return this.configuration;
  }

  /** Lays the panel out anew. */
  show(panel, knobs) {
    this.configuration = panel;
    const { title } = panel;
    write(this.heading, title);
    attribute(this.element, "aria-label", `Panel ${title}`);
    [[this.edit, `Edit panel ${title}`], [this.up, `Move panel ${title} up`], [this.down, `Move panel ${title} down`]].forEach(([button, label]) => {
      attribute(button, "aria-label", label);
      attribute(button, "title", label);
    });
    this.knobs = new Map(panel.settings.filter((key) => knobs.has(key)).map((key) => [key, this.#row(knobs.get(key))]));
    const gone = missing(panel, knobs).map((text) => element("p", { class: "note gone", text }));
    this.rows.replaceChildren(this.why, ...[...this.knobs.values()].map((row) => row.control.element), ...gone);
    if (this.state) this.update(this.state);
  }

  #row(knob) {
    const commit = (value) => this.commit(knob.key, value);
    const control = knob.words ? new Choice({ knob, commit }) : new Slider({ knob, ends: this.configuration.ranges?.[knob.key], commit });
    return { text: JSON.stringify(knob), control };
  }

  /** A knob whose limits, unit or words changed gets a control of its new kind. */
  #renew(key, knob) {
    const row = this.knobs.get(key);
    if (row.text === JSON.stringify(knob)) return row;
    const next = this.#row(knob);
    row.control.element.replaceWith(next.control.element);
    this.knobs.set(key, next);
    return next;
  }

  /** Shows the values in force and whether they may be changed. */
  update(state) {
    this.state = state;
    const why = state.whyLocked;
    write(this.why, why ?? "");
    this.element.classList.toggle("locked", why !== null);
    for (const key of [...this.knobs.keys()].filter((one) => state.knobs.has(one))) {
      const { control } = this.#renew(key, state.knobs.get(key));
      control.update({ value: state.values[key] ?? Infinity, why });
    }
  }

  #fold() {
    const isOpen = this.rows.hidden;
    this.rows.hidden = !isOpen;
    attribute(this.heading, "aria-expanded", String(isOpen));
  }
}

/** Settings that cannot be shown, in words; before the rig is armed there are none at all. */
function missing(panel, knobs) {
  if (knobs.size === 0) return ["Settings appear when the rig is armed."];
  return panel.settings.filter((key) => !knobs.has(key)).map((key) => `${key}: not a setting of this run`);
}
