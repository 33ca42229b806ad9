// Signals over the first one: the newest stretch as a curve that fades with age.
// Enters: raw samples of the span. Leaves: a curve for each further signal, a spot at the newest sample.

import { drawWords, font, labelsX, placeX, placeY } from "./chart_axes.js";
import { Chart, clipped, spot, STROKE } from "./chart_base.js";
import { fit, AutoRange } from "./chart_range.js";
import { extentShown } from "./chart_signals.js";
import { quantity, readingDecimals } from "./chart_ticks.js";
import { Pen } from "./chart_traces.js";
import { colourOf, paper } from "./colours.js";

/** Pictures at most this often [ms]. */
const EVERY_MS = 50;
/** Steps of age, and how faint the oldest is. */
const AGES = 8;
const FAINTEST = 0.15;
/** Points closer than this to the one before are left out [CSS pixels]. */
const CLOSE = 0.6;

export class XyChart extends Chart {
  constructor(of) {
    super(of);
    this.width = new AutoRange();
  }

  /** All but the first, which is x. */
  get vertical() {
    return this.signals.slice(1);
  }

  stamp(now_ms) {
    return this.frozen
      ? `frozen ${this.store.epoch}`
      : `${this.store.epoch} ${this.store.count > 0} ${Math.floor(now_ms / EVERY_MS)}`;
  }

  compose(frame, hidden, now_ms) {
    if (this.epoch !== this.store.epoch) this.width.reset();
    this.begin();
    const end = this.newest + 1;
    const begin = end - this.scope.span_s / this.store.period_s;
    this.stretch = [Math.max(this.store.rawFirst, this.store.lower(begin)), this.store.upper(end)];
    const { low, high } = this.width.update(extentShown(this.store, this.signals.slice(0, 1), begin, end), now_ms, fit);
    this.axes = { x: this.view.x ?? [low, high], y: null };
    this.axes.y = this.fitValues(hidden, now_ms, (group) => extentShown(this.store, group, begin, end));
    return this;
  }

  render(context, frame, hidden) {
    this.drawPaper(context, frame, this.axes.x, labelsX(frame, this.axes.x, this.signals[0]?.unit ?? ""));
    if (this.signals.length < 2) return drawWords(context, frame, paper(), "An XY plot needs two signals");
    if (this.store.count === 0) return drawWords(context, frame, paper(), "No data yet");
    this.drawName(context, frame);
    clipped(context, frame, () => this.shown(hidden).forEach((signal) => this.drawOne(context, frame, signal)));
    this.shown(hidden).forEach((signal) => this.drawNewest(context, frame, signal));
    return undefined;
  }

  /** What is horizontal, just above its axis. */
  drawName(context, frame) {
    context.font = font(frame.unit);
    context.fillStyle = paper().soft;
    context.textAlign = "right";
    context.textBaseline = "alphabetic";
    const [right, bottom] = [frame.left + frame.width, frame.top + frame.height];
    context.fillText(this.signals[0].label, right - 8 * frame.unit, bottom - 8 * frame.unit);
  }

  /** Pixel of a sample, from the upper left corner of the plot. */
  place(frame, signal) {
    const [across, up] = [this.signals[0], signal].map((s) => this.store.channels.get(s.key));
    const ends = this.axes.y[this.axis(signal)];
    return (index) => [
      placeX(frame, this.axes.x, this.store.valueAt(across, index) * this.signals[0].factor) - frame.left,
      placeY(frame, ends, this.store.valueAt(up, index) * signal.factor) - frame.top,
    ];
  }

  drawOne(context, frame, signal) {
    const place = this.place(frame, signal);
    const [from, to] = this.stretch;
    context.strokeStyle = colourOf(signal.key);
    context.lineWidth = STROKE * frame.unit;
    context.lineJoin = "round";
    context.lineCap = "butt";
    for (let age = 0; age < AGES; age += 1) {
      const begin = from + Math.floor(((to - from) * age) / AGES);
      const end = from + Math.floor(((to - from) * (age + 1)) / AGES);
      context.globalAlpha = FAINTEST + ((1 - FAINTEST) * (age + 1)) / AGES;
      this.drawAge(context, frame, place, begin, Math.min(end + 1, to));
    }
    context.globalAlpha = 1;
  }

  drawAge(context, frame, place, begin, end) {
    const pen = new Pen(context);
    for (let i = begin; i < end; i += 1) {
      const [x, y] = place(i);
      if (Number.isNaN(x + y) || (i > begin && this.store.gapBefore(i))) pen.lift();
      if (Number.isNaN(x + y)) continue;
      const near = Math.abs(x - pen.x) + Math.abs(y - pen.y) < CLOSE * frame.unit;
      if (!near || i === end - 1) pen.to(x, y);
    }
    pen.finish();
  }

  drawNewest(context, frame, signal) {
    const [x, y] = this.place(frame, signal)(this.stretch[1] - 1);
    if (x >= 0 && x <= frame.width && y >= 0 && y <= frame.height)
      spot(context, frame, colourOf(signal.key), frame.left + x, frame.top + y);
  }

  /** Ticks that are shown: [begin, end). */
  stretchTicks() {
    const end = this.newest + 1;
    return { begin: Math.ceil(end - this.scope.span_s / this.store.period_s), end };
  }

  /** The newest pair. */
  table(hidden) {
    if (!this.axes || this.signals.length < 2 || this.store.count === 0) return null;
    const text = ({ key, factor, unit }) =>
      quantity(this.store.valueAt(this.store.channels.get(key), this.stretch[1] - 1) * factor, readingDecimals(unit), unit);
    const rows = this.shown(hidden).map((signal) => ({
      cells: [signal.label, text(this.signals[0]), text(signal)],
      colour: colourOf(signal.key),
    }));
    return { head: ["Signal", `x: ${this.signals[0].label}`, "y"], rows, note: "" };
  }
}
