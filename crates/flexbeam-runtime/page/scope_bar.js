// The tools of a scope: span, pause, cursors, zoom back, trigger, settings, snapshots, place on the page.
// Enters: the card that they act on. Leaves: a toolbar that shows what is on.

import { element } from "./element.js";
import { menu, retool, tool } from "./scope_parts.js";

/** Spans on offer [s]. */
const SPANS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600];
/** How a spectrum is drawn. */
const STYLES = [
  ["decibels", "dB", "Amplitude in decibels"],
  ["logarithmic", "log f", "Frequency by decades"],
];

export class ScopeBar {
  /**
   * @param {import("./scope_card.js").ScopeCard} card
   * @param {() => void} remove
   * @param {(by: -1|1) => void} move
   */
  constructor(card, remove, move) {
    this.span = element("select", {
      class: "scope-span",
      "aria-label": "Span",
      onchange: () => card.change({ span_s: Number(this.span.value) }),
    });
    this.styles = STYLES.map(([value, text, title]) => {
      const onclick = () => card.restyle(value);
      return element("button", { type: "button", class: "scope-tool scope-word", value, text, title, onclick });
    });
    this.pause = tool("pause", "Pause", () => card.pause(!card.paused), false);
    this.cursors = tool("cursors", "Cursors", () => card.toggleCursors(), false);
    this.back = tool("back", "Zoom back", () => card.back());
    this.trigger = tool("trigger", "Trigger", () => card.toggleTrigger(), false);
    const settings = tool("settings", "Signals and settings", () => card.openSheet());
    const more = menu("More", [
      ["Picture (PNG)", () => card.snapshot("png")],
      ["Drawing (SVG)", () => card.snapshot("svg")],
      ["Samples (CSV)", () => card.snapshot("csv")],
      ["Move up", () => move(-1)],
      ["Move down", () => move(1)],
      ["Remove", remove],
    ]);
    const tools = [...this.styles, this.span, this.pause, this.cursors, this.back, this.trigger, settings, ...more];
    this.element = element("div", { class: "scope-tools", role: "toolbar", "aria-label": "Tools of the scope" }, ...tools);
  }

  /** The usual spans, and the one in force. */
  offerSpans(span_s) {
    const spans = [...new Set([...SPANS, span_s])].sort((a, b) => a - b);
    this.span.replaceChildren(...spans.map((s) => element("option", { value: s, text: spanText(s) })));
    this.span.value = span_s;
  }

  /** What is on, and what there is for this kind of plot. */
  show({ config, chart, paused }) {
    retool(this.pause, paused ? "play" : "pause", paused ? "Go on" : "Pause");
    this.pause.setAttribute("aria-pressed", paused);
    this.cursors.setAttribute("aria-pressed", chart.cursors?.on ?? false);
    this.cursors.hidden = !chart.cursors;
    this.trigger.setAttribute("aria-pressed", Boolean(config.trigger));
    this.trigger.hidden = config.kind !== "time";
    for (const style of this.styles) {
      style.hidden = config.kind !== "spectrum";
      style.setAttribute("aria-pressed", Boolean(chart[style.value]));
    }
  }
}

/** A span in its usual unit. */
export function spanText(span_s) {
  return span_s < 1 ? `${span_s * 1000}\u2009ms` : span_s % 60 === 0 ? `${span_s / 60}\u2009min` : `${span_s}\u2009s`;
}
