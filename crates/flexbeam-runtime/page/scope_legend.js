// The legend of a scope: each signal with its colour and its newest value; a press hides it.
// Enters: the signals of a scope. Leaves: buttons, and the set of hidden keys.

import { quantity, readingDecimals } from "./chart_ticks.js";
import { colourOf, dashed } from "./colours.js";
import { element } from "./element.js";

export class Legend {
  /**
   * @param {import("./chart_signals.js").Signal[]} signals
   * @param {Set<string>} hidden changed in place
   * @param {() => void} changed
   */
  constructor(signals, hidden, changed) {
    this.signals = signals;
    this.hidden = hidden;
    this.changed = changed;
    this.element = element("div", { class: "scope-legend", role: "group", "aria-label": "Signals" });
    this.values = signals.map((signal) => this.add(signal));
    this.colour();
  }

  add(signal) {
    const value = element("span", { class: "scope-value" });
    const button = element(
      "button",
      {
        type: "button",
        "aria-pressed": !this.hidden.has(signal.key),
        title: "Show or hide",
        onclick: () => this.toggle(signal.key, button),
      },
      element("i", { class: dashed(signal.key) ? "scope-swatch dashed" : "scope-swatch", "aria-hidden": "true" }),
      element("span", { class: "scope-name", text: signal.label }),
      value,
    );
    this.element.append(button);
    return value;
  }

  toggle(key, button) {
    if (!this.hidden.delete(key)) this.hidden.add(key);
    button.setAttribute("aria-pressed", !this.hidden.has(key));
    this.changed();
  }

  /** Colours of the theme in force. */
  colour() {
    this.signals.forEach((signal, k) => this.element.children[k].style.setProperty("--signal", colourOf(signal.key)));
  }

  /** Newest values; called at most ten times a second. */
  update(store) {
    this.signals.forEach((signal, k) => {
      const text = quantity(store.latest(signal.key) * signal.factor, readingDecimals(signal.unit), signal.unit);
      if (this.values[k].textContent !== text) this.values[k].textContent = text;
    });
  }
}
