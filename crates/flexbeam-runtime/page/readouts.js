// The numbers that one reads at two metres. Enters: the newest samples. Leaves: four figures, at most ten times a second.

import { element, write } from "./element.js";
import { fixed } from "./number.js";
import { colourOf } from "./colours.js";

/** What is shown, by the keys of a recording; those that a run lacks are left out. */
const SHOWN = ["psi_rad", "reference_rad", "error_rad", "voltage_v"];
const DECIMALS = 2;
const EVERY_MS = 100;
/** A figure space keeps the place of the minus. */
const NO_SIGN = "\u2007";

export class Readouts {
  /** @param {{root: HTMLElement, signals: Object[]}} about signals as in hello */
  constructor({ root, signals }) {
    this.drawn_ms = -Infinity;
    this.root = root;
    const known = SHOWN.map((key) => signals.find((signal) => signal.key === key)).filter(Boolean);
    this.figures = known.map((signal) => figure(signal));
    root.replaceChildren(...this.figures.map((one) => one.element));
    this.refresh();
  }

  /** Shows the newest values; called every frame. */
  draw(now_ms, store, isLive) {
    if (now_ms - this.drawn_ms < EVERY_MS) return;
    this.drawn_ms = now_ms;
    this.root.classList.toggle("stale", !isLive);
    for (const { signal, number } of this.figures) {
      const text = fixed(store.latest(signal.key) * signal.factor, DECIMALS);
      write(number, /^\d/.test(text) ? NO_SIGN + text : text);
    }
  }

  /** After the theme changed. */
  refresh() {
    this.figures.forEach((one) => one.element.style.setProperty("--signal", colourOf(one.signal.key)));
  }
}

function figure(signal) {
  const number = element("span", { class: "number" });
  const made = element("div", { class: "readout", role: "group", "aria-label": `${signal.label} in ${signal.unit}` },
    element("p", { class: "label", text: signal.label }),
    element("p", { class: "value" }, number, element("span", { class: signal.unit === "°" ? "unit degree" : "unit", text: signal.unit })));
  return { signal, number, element: made };
}
