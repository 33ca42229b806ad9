// One scope of the page: title, tools, legend, plot, readings.
// Enters: the store, a scope as in `hello`, animation frames. Leaves: an element, and the scope as it is now.

import { frameOf } from "./chart_axes.js";
import { Gestures } from "./chart_gestures.js";
import { axisOf, pick, unitsOf } from "./chart_signals.js";
import { seconds } from "./chart_ticks.js";
import { TimeChart } from "./chart_time.js";
import { themeChanged } from "./colours.js";
import { ScopeBar, spanText } from "./scope_bar.js";
import { Legend } from "./scope_legend.js";
import { element } from "./element.js";
import { Readings } from "./scope_readings.js";
import { ScopeSheet } from "./scope_sheet.js";
import { takeSnapshot } from "./snapshot.js";
import { SpectrumChart } from "./spectrum.js";
import { XyChart } from "./xy.js";

/** Kinds of plots. */
const CHARTS = { time: TimeChart, xy: XyChart, spectrum: SpectrumChart };
/** Numbers change at most this often [ms]; the words for a screen reader less often. */
const NUMBERS_MS = 100;
const WORDS_MS = 2000;

export class ScopeCard {
  /**
   * @param {object} of
   * @param {import("./store.js").Store} of.store
   * @param {import("./chart_signals.js").Signal[]} of.signals of the run
   * @param {object} of.scope as in `hello.screen.scope`
   * @param {(card: ScopeCard) => void} of.onchange the scope is to be saved
   * @param {(card: ScopeCard) => void} of.onremove
   * @param {(card: ScopeCard, by: -1|1) => void} of.onmove
   */
  constructor({ store, signals, scope, onchange, onremove, onmove }) {
    this.store = store;
    this.all = signals;
    this.config = structuredClone(scope);
    this.onchange = onchange;
    this.hidden = new Set();
    this.paused = false;
    this.seen = true;
    this.stamp = "";
    this.numbers_ms = -Infinity;
    this.words_ms = -Infinity;
    this.size = { width: 0, height: 0 };
    this.build(onremove, onmove);
    this.rebuild();
    this.watch();
  }

  /** The present configuration, to be saved: SI. */
  get scope() {
    return structuredClone(this.config);
  }

  build(onremove, onmove) {
    const { config } = this;
    this.canvas = element("canvas", { role: "img" });
    this.context = this.canvas.getContext("2d");
    this.plot = element("div", { class: "scope-plot", tabindex: 0, role: "group" }, this.canvas);
    this.title = element("input", {
      class: "scope-title",
      "aria-label": "Title of the scope",
      spellcheck: "false",
      value: config.title,
      onchange: () => this.rename(),
    });
    this.state = element("span", { class: "scope-state" });
    this.again = element("button", {
      type: "button",
      class: "scope-again",
      text: "Arm again",
      hidden: true,
      onclick: () => this.arm(),
    });
    this.readings = new Readings();
    this.gone = element("p", { class: "scope-gone", hidden: true });
    this.bar = new ScopeBar(
      this,
      () => onremove(this),
      (by) => onmove(this, by),
    );
    this.head = element("header", { class: "scope-head" }, this.title, this.state, this.again, this.bar.element);
    this.element = element("section", { class: "scope" }, this.head, this.gone, this.plot, this.readings.element);
    this.gestures = new Gestures(this.plot, this);
  }

  /** Everything that follows from the configuration. */
  rebuild() {
    const { config } = this;
    const { signals, gone } = pick(this.all, config.signals);
    const third = signals.filter((signal) => axisOf(signals, signal) > 1);
    this.signals = signals.filter((signal) => axisOf(signals, signal) < 2);
    this.chart = new CHARTS[config.kind]({ store: this.store, scope: config, signals: this.signals });
    this.legend?.element.remove();
    this.legend = new Legend(this.chart.vertical, this.hidden, () => this.changed());
    this.head.after(this.legend.element);
    this.tell(gone, third);
    this.name();
    this.bar.offerSpans(config.span_s);
    this.bar.show(this);
    this.changed();
  }

  openSheet() {
    const ends = this.chart.axes?.y[0] ?? null;
    return new ScopeSheet({ scope: this.config, signals: this.all, ends, ontake: (scope) => this.take(scope) });
  }

  /** The scope of the settings sheet. */
  take(scope) {
    this.title.value = scope.title;
    this.change({ range: null, trigger: null, ...scope });
  }

  /** What cannot be drawn, and why. */
  tell(gone, third) {
    const parts = [];
    if (gone.length > 0) parts.push(`This run has no ${gone.join(", ")}.`);
    if (third.length > 0)
      parts.push(
        `Not drawn: ${third.map((s) => s.label).join(", ")}. A plot has two axes (${unitsOf(this.signals).join(", ")}).`,
      );
    this.gone.textContent = parts.join(" ");
    this.gone.hidden = parts.length === 0;
  }

  /** Says that it cannot be drawn, until its settings change. */
  fail(error) {
    this.gone.textContent = `Not drawn: ${error.message}. Other settings of this scope may help.`;
    this.gone.hidden = false;
  }

  name() {
    this.canvas.setAttribute("aria-label", this.config.title);
    this.element.setAttribute("aria-label", `Scope: ${this.config.title}`);
    this.plot.setAttribute(
      "aria-label",
      `Plot of ${this.config.title}. Arrows move, plus and minus zoom, space pauses, c shows cursors.`,
    );
  }

  /** Size, sight and the end of both. */
  watch() {
    this.resize = new ResizeObserver(([entry]) => {
      this.size = entry.contentRect;
      this.changed();
    });
    this.resize.observe(this.plot);
    this.watcher = new IntersectionObserver(([entry]) => (this.seen = entry.isIntersecting), { rootMargin: "80px" });
    this.watcher.observe(this.element);
  }

  /** To be drawn again at the next frame. */
  changed() {
    this.stamp = "";
  }

  /** Another configuration, to be saved. */
  change(part) {
    Object.assign(this.config, part);
    for (const key of ["range", "trigger"]) if (this.config[key] === null) delete this.config[key];
    this.rebuild();
    this.pause(false);
    this.onchange(this);
  }

  rename() {
    this.config.title = this.title.value.trim() || this.config.title;
    this.title.value = this.config.title;
    this.name();
    this.onchange(this);
  }

  /** Stops the plot or lets it go on; the store goes on in any case. */
  pause(yes) {
    this.paused = yes;
    this.chart.pause(yes);
    this.bar.show(this);
    this.changed();
  }

  back() {
    this.chart.view.reset();
    this.changed();
  }

  toggleCursors() {
    if (!this.chart.cursors || !this.chart.axes) return;
    this.chart.cursors.toggle(this.chart.axes.x);
    this.bar.show(this);
    this.numbers_ms = -Infinity;
    this.changed();
  }

  toggleTrigger() {
    if (this.config.trigger) return this.change({ trigger: null });
    const signal = this.signals.find((s) => !this.hidden.has(s.key)) ?? this.signals[0];
    if (!signal) return undefined;
    const [low, high] = this.chart.axes?.y[axisOf(this.signals, signal)] ?? [0, 0];
    const level = (low + high) / 2 / signal.factor;
    return this.change({ trigger: { signal: signal.key, edge: "rising", level, mode: "auto", before: 0.1 } });
  }

  /** The level of the trigger, dragged. */
  level(level, done) {
    this.config.trigger.level = level;
    this.chart.trigger.wanted.level = level;
    this.changed();
    if (done) this.onchange(this);
  }

  /** A trigger that holds its crossing waits for another. */
  arm() {
    this.chart.trigger?.arm(this.store);
    this.numbers_ms = -Infinity;
    this.changed();
  }

  /** Turns a style of the spectrum on or off. */
  restyle(name) {
    this.chart[name] = !this.chart[name];
    this.chart.restyled();
    Object.assign(this.config, this.chart.style);
    this.bar.show(this);
    this.changed();
    this.onchange(this);
  }

  /** Offers what one sees as a file. */
  snapshot(kind, when = new Date()) {
    if (!this.chart.axes) return undefined;
    this.changed();
    return takeSnapshot(kind, this.sight(when), when, devicePixelRatio);
  }

  sight(when) {
    const { width, height } = this.size;
    const run = this.store.count > 0 ? `, run time ${seconds(this.chart.newest * this.store.period_s, 3)}` : "";
    const stamp = `${when.toLocaleString("sv-SE")}${run}`;
    return { chart: this.chart, hidden: this.hidden, title: this.config.title, stamp, width, height, now_ms: this.now_ms };
  }

  /** Keys of the plot that are not the gestures' own. */
  key(name) {
    const action = {
      " ": () => this.pause(!this.paused),
      c: () => this.toggleCursors(),
      t: () => this.toggleTrigger(),
      z: () => this.back(),
      0: () => this.back(),
    }[name];
    action?.();
    return Boolean(action);
  }

  /**
   * Draws when there is something new. To be called once per animation frame.
   * @param {number} now_ms time of the frame
   */
  draw(now_ms) {
    if (!this.seen || this.size.width === 0) return;
    if (now_ms - this.numbers_ms >= NUMBERS_MS) this.drawNumbers(now_ms);
    const stamp = `${this.chart.stamp(now_ms)} ${devicePixelRatio}`;
    if (stamp === this.stamp) return;
    this.stamp = stamp;
    this.now_ms = now_ms;
    this.fitCanvas();
    this.chart.compose(this.frame, this.hidden, now_ms);
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.chart.render(this.context, this.frame, this.hidden);
  }

  fitCanvas() {
    const unit = devicePixelRatio;
    const [width, height] = [Math.floor(this.size.width * unit), Math.floor(this.size.height * unit)];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      Object.assign(this.canvas, { width, height });
      // Not stretched to a size that is no whole number of pixels: that would blur it.
      Object.assign(this.canvas.style, { width: `${width / unit}px`, height: `${height / unit}px` });
    }
    this.frame = frameOf(width, height, unit, this.chart.axisCount);
  }

  drawNumbers(now_ms) {
    this.numbers_ms = now_ms;
    this.legend.update(this.store);
    this.bar.back.disabled = !this.chart.view.zoomed;
    this.readings.show(this.chart.table(this.hidden));
    this.showState();
    if (now_ms - this.words_ms < WORDS_MS) return;
    this.words_ms = now_ms;
    this.canvas.setAttribute("aria-label", this.summary());
  }

  showState() {
    const { trigger } = this.chart;
    let [state, text] = ["rolling", ""];
    if (trigger) {
      state = this.chart.rolls ? "armed" : trigger.state;
      const at = Number.isNaN(trigger.at) ? "" : ` at ${seconds(trigger.at * this.store.period_s, 3)}`;
      text = { armed: "Waiting for trigger", triggered: `Triggered${at}`, held: `Held${at}` }[state];
    }
    if (this.paused) [state, text] = ["paused", "Paused"];
    if (this.state.textContent === text && this.state.dataset.state === state) return;
    this.state.textContent = text;
    this.state.dataset.state = state;
    this.again.hidden = state !== "held";
  }

  /** The plot in words. */
  summary() {
    const values = this.legend.signals
      .map((signal, k) => [signal, this.legend.values[k].textContent])
      .filter(([signal]) => !this.hidden.has(signal.key))
      .map(([signal, text]) => `${signal.label} ${text}`);
    return `${this.config.title}, ${spanText(this.config.span_s)}: ${values.join("; ")}`;
  }

  /** Theme or signals changed. */
  refresh(signals = this.all) {
    themeChanged();
    if (signals !== this.all) {
      this.all = signals;
      this.rebuild();
    }
    this.legend.colour();
    this.changed();
  }

  destroy() {
    this.resize.disconnect();
    this.watcher.disconnect();
    this.element.remove();
  }
}
