// How punctual the loop is. Enters: the run's own figures, and the lateness and execution signals. Leaves: a table and a histogram.

import { attribute, drawing, element, write } from "./element.js";
import { Histogram } from "./histogram.js";
import { colourOf } from "./colours.js";
import { count, shortTime } from "./number.js";

const SHOWN = ["lateness_ns", "execution_ns"];
const [WIDTH, HEIGHT, FOOT, TOP] = [288, 96, 18, 4];
/** Below this share of the ticks nothing is drawn: one in a million. */
const LEAST_LOG = -6;
const EVERY_MS = 1000;
const MICRO = { "-2": "10 ns", "-1": "100 ns", 0: "1 µs", 1: "10 µs", 2: "100 µs", 3: "1 ms", 4: "10 ms", 5: "100 ms", 6: "1 s" };

export class Lateness {
  /** @param {{root: HTMLElement, signals: Object[]}} about signals as in hello */
  constructor({ root, signals }) {
    this.drawn_ms = -Infinity;
    this.parts = SHOWN.map((key) => ({ key, at: signals.findIndex((signal) => signal.key === key) }))
      .filter(({ at }) => at >= 0)
      .map(({ key, at }) => ({ key, at, signal: signals[at], histogram: new Histogram(), path: drawing("path", { class: "outline" }) }));
    this.cells = Object.fromEntries(["Median", "99 %", "Longest", "Missed", "Stale"].map((name) => [name, element("dd", { text: "–" })]));
    const list = Object.entries(this.cells).map(([name, cell]) => element("div", {}, element("dt", { text: name }), cell));
    this.axis = drawing("g", { class: "axis" });
    this.picture = drawing("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", class: "histogram", "aria-label": "Histogram of lateness and execution time: no ticks yet" }, this.axis, ...this.parts.map((part) => part.path));
    const legend = this.parts.map((part) => element("span", { class: "key", style: { "--signal": colourOf(part.key) } }, part.signal.label));
    this.legend = element("p", { class: "legend" }, ...legend);
    root.replaceChildren(element("h2", { text: "Lateness of the loop" }), element("dl", { class: "timing" }, ...list), this.picture, this.legend);
    this.refresh();
  }

  /** Shows the run's own figures. */
  update({ timing }) {
    if (!timing) return;
    const texts = [shortTime(timing.median_s), shortTime(timing.p99_s), shortTime(timing.max_s), count(timing.missed), count(timing.stale)];
    Object.values(this.cells).forEach((cell, k) => write(cell, texts[k]));
    this.cells.Missed.classList.toggle("warn", timing.missed > 0);
    this.cells.Stale.classList.toggle("warn", timing.stale > 0);
  }

  /** Counts the samples of a frame. */
  take({ columns }) {
    this.parts.forEach(({ at, signal, histogram }) => histogram.add(columns[at], signal.factor));
  }

  /** Draws, once a second at most. */
  draw(now_ms) {
    if (now_ms - this.drawn_ms < EVERY_MS) return;
    this.drawn_ms = now_ms;
    const spans = this.parts.map(({ histogram }) => histogram.decades).filter(Boolean);
    if (spans.length === 0) return;
    const low = Math.min(...spans.map((span) => span[0]));
    const high = Math.max(low + 2, ...spans.map((span) => span[1]));
    const x = (decade) => (WIDTH - 2) * (decade - low) / (high - low) + 1;
    const y = (share) => HEIGHT - FOOT - (HEIGHT - FOOT - TOP) * Math.max(0, 1 - Math.log10(Math.max(share, 1e-300)) / LEAST_LOG);
    this.#drawAxis(low, high, x);
    this.parts.forEach(({ histogram, path }) => histogram.total && path.setAttribute("d", histogram.outline([low, high], x, y)));
    attribute(this.picture, "aria-label", `Histogram of lateness and execution time of ${count(this.parts[0].histogram.total)} ticks, logarithmic from ${MICRO[low]} to ${MICRO[high]}`);
  }

  #drawAxis(low, high, x) {
    if (this.axis.dataset.span === `${low},${high}`) return;
    this.axis.dataset.span = `${low},${high}`;
    const marks = Array.from({ length: high - low + 1 }, (_, k) => low + k);
    const foot = HEIGHT - FOOT;
    const anchor = (decade) => (decade === low ? "start" : decade === high ? "end" : "middle");
    this.axis.replaceChildren(
      ...marks.map((decade) => drawing("line", { x1: x(decade), x2: x(decade), y1: TOP, y2: foot })),
      drawing("line", { x1: 1, x2: WIDTH - 1, y1: foot, y2: foot, class: "foot" }),
      ...marks.map((decade) => drawing("text", { x: x(decade), y: HEIGHT - 4, "text-anchor": anchor(decade) }, MICRO[decade])));
  }

  /** After the theme changed. */
  refresh() {
    this.parts.forEach(({ key, path }, k) => {
      path.style.setProperty("--signal", colourOf(key));
      this.legend.children[k].style.setProperty("--signal", colourOf(key));
    });
  }
}
