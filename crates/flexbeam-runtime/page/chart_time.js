// Signals over time: rolling, standing at a trigger, or paused.
// Enters: a store, a scope and the time of the frame. Leaves: a picture on a context, ends of the axes, readings.
// The horizontal axis counts ticks from an anchor: the newest instant, or the crossing of the trigger.

import { drawTag, drawWords, hair, labelsX, placeX, placeY } from "./chart_axes.js";
import { Chart, clipped, fill, spot, STROKE } from "./chart_base.js";
import { clockOf } from "./chart_clock.js";
import { extentShown } from "./chart_signals.js";
import { quantity, readingDecimals, seconds } from "./chart_ticks.js";
import { drawColumns, TraceLayer } from "./chart_traces.js";
import { colourOf, dashed, paper } from "./colours.js";
import { between, Cursors, readings, valueAt } from "./cursors.js";
import { Trigger } from "./trigger.js";

/** How faint the sweep before is. */
const FAINT = 0.28;
/** Columns before the newest sample that its line may still change. */
const UNSETTLED = 4;
/** A trigger ignores crossings that come back within this share of the axis. */
const NOISE = 0.01;
/** Longer than this, minutes are counted [s]. */
const LONG_S = 240;
/** Least that the time axis shows [ticks]. */
const LEAST = 4;

export class TimeChart extends Chart {
  constructor(of) {
    super(of);
    this.cursors = new Cursors();
    this.layer = new TraceLayer();
    /** The sweep before, faint until the new one has come so far: its anchor and its picture. */
    this.before = NaN;
    this.ghost = new TraceLayer();
    this.trigger = this.scope.trigger ? new Trigger(this.scope.trigger) : null;
    this.rolls = !this.trigger;
    this.anchor = NaN;
    this.origin = NaN;
    /** The level is in someone's hand. */
    this.held = false;
  }

  /** Stops at what is shown now, or goes on. */
  pause(yes) {
    this.frozen = yes ? { anchor: this.anchor, rolls: this.rolls, last: this.store.last } : null;
  }

  get movesAway() {
    return this.rolls && !this.frozen;
  }

  /** Whether there is something new to draw. */
  stamp(now_ms) {
    if (this.frozen) return `frozen ${this.store.epoch}`;
    const edge = this.trigger && !this.rolls ? "" : Math.floor(clockOf(this.store).edge(now_ms) * 16);
    return `${this.store.epoch} ${this.store.count} ${edge}`;
  }

  /** Ends of the axes at a frame. Everything else is drawn from what is found here. */
  compose(frame, hidden, now_ms) {
    const { store, scope } = this;
    this.begin();
    const span = scope.span_s / store.period_s;
    this.anchor = this.anchorAt(now_ms, span);
    const [low, high] = this.horizontal(span);
    const width = (high - low) / frame.width;
    this.origin = this.rolls ? (Number.isNaN(this.origin) ? Math.floor(this.anchor) : this.origin) : this.anchor;
    const first = this.rolls ? Math.floor((this.anchor + high - this.origin) / width) - frame.width + 1 : Math.round(low / width);
    this.scale = { origin: this.origin, width, first };
    const begin = this.origin + first * width;
    const end = begin + frame.width * width;
    this.axes = { x: [begin - this.anchor, end - this.anchor], y: this.heights(hidden, begin, end, now_ms) };
    this.listen();
    return this;
  }

  begin() {
    if (this.epoch !== this.store.epoch) this.origin = this.before = NaN;
    super.begin();
  }

  anchorAt(now_ms, span) {
    if (this.frozen) {
      this.rolls = this.frozen.rolls;
      return this.frozen.anchor;
    }
    const edge = clockOf(this.store).edge(now_ms);
    const at = this.trigger ? this.trigger.update(this.store, span) : NaN;
    const rolls = !this.trigger || this.trigger.rolls(this.store.last, span);
    if (rolls !== this.rolls) this.view.x = null;
    if (rolls && !this.rolls) this.origin = NaN;
    if (rolls || this.rolls) this.before = NaN;
    else if (at !== this.anchor) this.swap();
    this.rolls = rolls;
    return rolls ? edge : at;
  }

  /** Another crossing: the sweep that was shown becomes the one before. */
  swap() {
    this.before = this.anchor;
    [this.layer, this.ghost] = [this.ghost, this.layer];
  }

  /** Ends of the time axis from the anchor [ticks]. */
  horizontal(span) {
    const before = this.rolls ? 1 : this.scope.trigger.before;
    const own = [-before * span, (1 - before) * span];
    if (!this.view.x) return own;
    let [low, high] = this.view.x;
    if (high - low < LEAST) [low, high] = [(low + high - LEAST) / 2, (low + high + LEAST) / 2];
    const reach = this.store.count > 0 ? this.store.last - this.store.first + span : span;
    if (high - low > reach) [low, high] = [high - reach, high];
    if (this.rolls && !this.frozen) [low, high] = [low - high, 0];
    this.view.x = [low, high];
    return this.view.x;
  }

  heights(hidden, begin, end, now_ms) {
    const last = Math.min(end, this.newest + 1);
    // A sweep that has only begun must not shrink the axes: what came before it counts, too.
    const from = this.rolls ? begin : Math.min(begin, last - (end - begin));
    return this.fitValues(hidden, now_ms, (group) => extentShown(this.store, group, from, last));
  }

  /** The trigger's noise follows the axis of its signal. */
  listen() {
    const signal = this.levelSignal();
    if (!signal) return;
    const [low, high] = this.fitted[this.axis(signal)].ends;
    this.trigger.noise = (NOISE * (high - low)) / Math.abs(signal.factor);
  }

  /** The signal that the trigger watches, when it has an axis here. */
  levelSignal() {
    if (!this.trigger) return null;
    const signal = this.signals.find((s) => s.key === this.trigger.wanted.signal);
    return signal ?? null;
  }

  /** @returns {import("./chart_traces.js").Look[]} */
  looks(frame, hidden) {
    return this.shown(hidden).map((signal) => {
      const [low, high] = this.axes.y[this.axis(signal)];
      const perShown = frame.height / (high - low);
      const { factor } = signal;
      const y = (value) => (high - value * factor) * perShown;
      return { channel: this.store.channels.get(signal.key), colour: colourOf(signal.key), dashed: dashed(signal.key), y };
    });
  }

  /** Draws what `compose` found. `vector`: strokes of its own, not a copy of the layer's pixels. */
  render(context, frame, hidden, vector = false) {
    this.drawTime(context, frame);
    if (this.store.count === 0) return drawWords(context, frame, paper(), "No data yet");
    if (Number.isNaN(this.anchor)) {
      this.drawLevel(context, frame);
      return drawWords(context, frame, paper(), "Waiting for the trigger");
    }
    this.drawTraces(context, frame, hidden, vector);
    this.drawLevel(context, frame);
    if (this.cursors.on) this.drawCursors(context, frame, hidden);
    return undefined;
  }

  drawTime(context, frame) {
    const shift = this.rolls ? this.anchor : 0;
    const ends = this.axes.x.map((ticks) => (ticks + shift) * this.store.period_s);
    const { unit, per_s } = timeUnit(ends, this.rolls);
    const shown = ends.map((end) => end * per_s);
    this.drawPaper(context, frame, shown, Number.isFinite(shown[0]) ? labelsX(frame, shown, unit) : []);
  }

  drawTraces(context, frame, hidden, vector) {
    const { origin, width } = this.scale;
    const newest = Math.floor((this.newest - origin) / width);
    const looks = this.looks(frame, hidden);
    const ends = this.scale.first + frame.width;
    if (!Number.isNaN(this.before) && newest + 1 < ends) this.drawGhost(context, frame, looks, newest + 1, vector);
    this.drawSweep(context, frame, this.layer, { looks, origin, newest, stop: this.frozen ? newest + 1 : Infinity, vector });
  }

  /** The sweep before, in the columns that the new one has not reached. */
  drawGhost(context, frame, looks, from, vector) {
    const left = Math.max(0, from - this.scale.first);
    context.save();
    context.beginPath();
    context.rect(frame.left + left, frame.top, frame.width - left, frame.height);
    context.clip();
    context.globalAlpha = FAINT;
    this.drawSweep(context, frame, this.ghost, { looks, origin: this.before, newest: Infinity, stop: Infinity, vector });
    context.restore();
  }

  /** Traces around an origin: columns up to `stop`, those up to `newest` settled. */
  drawSweep(context, frame, layer, { looks, origin, newest, stop, vector }) {
    const { store } = this;
    const { width, first } = this.scale;
    const stroke = STROKE * frame.unit;
    const draw = (target, a, b, x) => {
      const last = Math.min(b + 2, stop);
      if (last > a - 2) drawColumns(target, store, { origin, width }, looks, stroke, a - 2, last, x);
    };
    if (vector) return clipped(context, frame, () => draw(context, first, first + frame.width, (k) => k - first));
    const key = JSON.stringify([origin, width, this.axes.y, looks, store.epoch, stroke, stop]);
    layer.update(key, first, newest - UNSETTLED, frame.width, frame.height, draw);
    return layer.show(context, frame.left, frame.top);
  }

  /** Where the trigger's level stands [pixel], or NaN. */
  levelY(frame) {
    const signal = this.levelSignal();
    return signal ? placeY(frame, this.axes.y[this.axis(signal)], this.trigger.wanted.level * signal.factor) : NaN;
  }

  /** Level [SI] at a pixel. */
  levelAt(frame, y) {
    const signal = this.levelSignal();
    const [low, high] = this.axes.y[this.axis(signal)];
    return (high - ((y - frame.top) / frame.height) * (high - low)) / signal.factor;
  }

  drawLevel(context, frame) {
    const signal = this.levelSignal();
    if (!signal) return;
    const y = this.levelY(frame);
    const inside = Math.min(Math.max(y, frame.top), frame.top + frame.height);
    const right = this.axis(signal) === 1;
    const x = right ? frame.left + frame.width : frame.left;
    const d = (right ? -1 : 1) * 11 * frame.unit;
    const h = 7 * frame.unit;
    fill(context, colourOf(signal.key), [
      [x, inside - h],
      [x + d, inside],
      [x, inside + h],
    ]);
    if (!this.rolls && !Number.isNaN(this.anchor)) this.drawInstant(context, frame, colourOf(signal.key));
    if (!this.held) return;
    hair(context, frame, colourOf(signal.key), [[frame.left, inside, frame.left + frame.width, inside]]);
    const text = quantity(this.trigger.wanted.level * signal.factor, readingDecimals(signal.unit), signal.unit);
    drawTag(context, frame, paper(), text, frame.left + frame.width / 2, inside, colourOf(signal.key));
  }

  /** The crossing: a mark on the upper edge. */
  drawInstant(context, frame, colour) {
    const x = placeX(frame, this.axes.x, 0);
    if (x < frame.left || x > frame.left + frame.width) return;
    const d = 5 * frame.unit;
    fill(context, colour, [
      [x - d, frame.top - d],
      [x + d, frame.top - d],
      [x, frame.top + d],
    ]);
  }

  drawCursors(context, frame, hidden) {
    const looks = this.looks(frame, hidden);
    this.cursors.at.forEach((offset, k) => {
      const x = placeX(frame, this.axes.x, offset);
      if (x < frame.left || x > frame.left + frame.width) return;
      hair(context, frame, paper().ink, [[x, frame.top, x, frame.top + frame.height]]);
      for (const look of looks) {
        const y = look.y(valueAt(this.store, look.channel, this.anchor + offset));
        if (y >= 0 && y <= frame.height) spot(context, frame, look.colour, x, frame.top + y);
      }
      drawTag(context, frame, paper(), "AB"[k], x, frame.top + 9 * frame.unit, paper().ink);
    });
  }

  /** Ticks that are shown: [begin, end). */
  stretchTicks() {
    const [low, high] = this.axes.x.map((offset) => Math.ceil(this.anchor + offset));
    return { begin: low, end: Math.min(high, this.newest + 1) };
  }

  /** What the cursors read; null while they are away. */
  table(hidden) {
    if (!this.cursors.on || !this.axes) return null;
    const { period_s } = this.store;
    const signals = this.shown(hidden);
    const [a, b] = this.cursors.at.map((offset) => this.anchor + offset);
    const { time_s, frequency_hz } = between(a, b, period_s);
    const time = (tick) => seconds((tick - (this.rolls ? 0 : this.anchor)) * period_s, 4);
    const rows = readings(
      this.store,
      signals.map((signal) => signal.key),
      a,
      b,
    ).map((reading, k) => {
      const { label, unit, factor, key } = signals[k];
      const text = (value) => quantity(value * factor, readingDecimals(unit), unit);
      return { cells: [label, text(reading.a), text(reading.b), text(reading.difference)], colour: colourOf(key) };
    });
    return {
      head: ["Signal", "A", "B", "B \u2212 A"],
      rows: [{ cells: ["Time", time(a), time(b), seconds(time_s, 4)], colour: null }, ...rows],
      note: Number.isFinite(frequency_hz) ? `1/\u0394t = ${quantity(frequency_hz, 3, "Hz")}` : "",
    };
  }
}

/** Unit of the time axis: milliseconds around a crossing, minutes when there are many. */
function timeUnit([begin, end], rolls) {
  if (!rolls && Math.max(-begin, end) < 0.5) return { unit: "ms", per_s: 1000 };
  return end - begin > LONG_S ? { unit: "min", per_s: 1 / 60 } : { unit: "s", per_s: 1 };
}
