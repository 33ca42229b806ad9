// What all plots have in common: signals on up to two vertical axes, a view, a paper.
// Enters: a store, a scope and its signals. Leaves: axes and strokes; what is horizontal is each plot's own.

import { drawBorder, drawX, drawY } from "./chart_axes.js";
import { axisOf, unitsOf } from "./chart_signals.js";
import { calm, ValueAxes } from "./chart_values.js";
import { View } from "./chart_view.js";
import { colourOf, paper } from "./colours.js";

/** Width of a trace [CSS pixels]. */
export const STROKE = 1.75;

/** Base of `TimeChart`, `XyChart` and `SpectrumChart`. */
export class Chart {
  /**
   * @param {{store: import("./store.js").Store, scope: object, signals: import("./chart_signals.js").Signal[]}} of
   *   scope as in `hello`, signals: those of the scope that are drawn, hidden ones too
   */
  constructor({ store, scope, signals }) {
    this.store = store;
    this.scope = scope;
    this.signals = signals;
    this.view = new View();
    this.values = new ValueAxes();
    this.frozen = null;
    this.epoch = NaN;
    /** Ends of the axes as they were drawn last; null before that. */
    this.axes = null;
  }

  /** Signals that have a vertical axis. */
  get vertical() {
    return this.signals;
  }

  /** Units of the vertical axes. */
  get units() {
    return unitsOf(this.vertical).slice(0, 2);
  }

  /** Number of vertical axes. */
  get axisCount() {
    return this.units.length;
  }

  /** Whether moving the horizontal axis by hand must stop the plot first. */
  get movesAway() {
    return false;
  }

  /** Newest tick that the plot may show. */
  get newest() {
    return this.frozen ? this.frozen.last : this.store.last;
  }

  /** Stops at what is shown now, or goes on. */
  pause(yes) {
    this.frozen = yes ? { last: this.store.last } : null;
  }

  /** A new run: nothing of the old one stays. */
  begin() {
    if (this.epoch === this.store.epoch) return;
    this.epoch = this.store.epoch;
    this.frozen = null;
    this.view.reset();
    this.values.reset();
  }

  axis(signal) {
    return axisOf(this.vertical, signal);
  }

  shown(hidden) {
    return this.vertical.filter((signal) => !hidden.has(signal.key));
  }

  /**
   * Ends of the vertical axes.
   * @param {(signals: object[]) => [number, number]} extent of the signals of an axis, as shown
   */
  fitValues(hidden, now_ms, extent, configured = this.configured()) {
    const extents = this.units.map((unit, k) => {
      const data = extent(this.shown(hidden).filter((signal) => this.axis(signal) === k));
      return this.values.grounded ? data : calm(data, unit);
    });
    this.fitted = this.values.update(extents, this.view.y, configured, now_ms);
    return this.fitted.map((axis) => axis.ends);
  }

  /** Configured ends of the left axis, as shown; null: fitted. */
  configured() {
    const factor = this.vertical[0]?.factor ?? 1;
    return this.scope.range?.map((value) => value * factor) ?? null;
  }

  /** Grid, numbers and border. */
  drawPaper(context, frame, ends, labels) {
    const { units } = this;
    drawX(context, frame, paper(), ends, labels);
    this.fitted.forEach((axis, k) => {
      const colour = this.fitted.length > 1 ? this.axisColour(k) : paper().soft;
      drawY(context, frame, paper(), { unit: units[k], ends: axis.ends, step: axis.step, colour }, k);
    });
    drawBorder(context, frame, paper());
  }

  /** An axis of one signal has its colour. */
  axisColour(k) {
    const own = this.vertical.filter((signal) => this.axis(signal) === k);
    return own.length === 1 ? colourOf(own[0].key) : paper().soft;
  }
}

/** Draws with the plot's upper left corner as origin, within the plot. */
export function clipped(context, frame, draw) {
  context.save();
  context.beginPath();
  context.rect(frame.left, frame.top, frame.width, frame.height);
  context.clip();
  context.translate(frame.left, frame.top);
  draw();
  context.restore();
}

/** A filled shape. */
export function fill(context, colour, corners) {
  context.fillStyle = colour;
  context.beginPath();
  corners.forEach(([x, y], k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.fill();
}

/** A round mark on a trace. */
export function spot(context, frame, colour, x, y) {
  context.fillStyle = colour;
  context.strokeStyle = paper().card;
  context.lineWidth = 1.5 * frame.unit;
  context.beginPath();
  context.arc(x, y, 4 * frame.unit, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
}
