// Vertical axes of a plot: configured, chosen by hand, or fitted to the data.
// Enters: extremes of the signals of each axis. Leaves: ends of the axes, as shown.

import { AutoRange, fit, fitBeside } from "./chart_range.js";
import { stepAbove } from "./chart_ticks.js";

/** Heights below these are noise of sensors at rest: an axis is not blown up to show nothing but that. */
const LEAST = { "°": 0.5, V: 0.1 };

/** The extremes, apart enough for an axis of this unit. */
export function calm([low, high], unit) {
  const short = ((LEAST[unit] ?? 0) - (high - low)) / 2;
  return short > 0 ? [low - short, high + short] : [low, high];
}

/** Up to two axes with one grid. */
export class ValueAxes {
  /** @param {boolean} grounded amplitudes: an axis begins at nought */
  constructor(grounded = false) {
    this.grounded = grounded;
    this.auto = [new AutoRange(), new AutoRange()];
    this.beside = "";
  }

  reset() {
    this.auto.forEach((range) => range.reset());
  }

  /**
   * @param {[number, number][]} extents of each axis, as shown
   * @param {([number, number]|null)[]} chosen ends chosen by hand
   * @param {[number, number]|null} configured ends of the left axis, as shown
   * @returns {{ends: [number, number], step: number|null}[]} step: of ends that are multiples of it
   */
  update(extents, chosen, configured, now_ms) {
    let left = null;
    return extents.map((data, k) => {
      const axis = k === 0 ? this.left(data, configured, now_ms) : this.right(data, left, now_ms);
      if (chosen[k]) return { ends: chosen[k], step: null };
      left = axis;
      return { ends: [axis.low, axis.high], step: axis.step };
    });
  }

  left(data, configured, now_ms) {
    if (configured) return whole(configured);
    return this.auto[0].update(data, now_ms, (low, high) => fit(low, high, this.grounded));
  }

  /** On the grid of the left axis, where that is divided evenly. */
  right(data, left, now_ms) {
    const beside = left?.step ? `${left.low} ${left.high} ${left.step}` : "";
    if (this.beside !== beside) this.auto[1].reset();
    this.beside = beside;
    const how = (low, high) => (beside ? fitBeside(low, high, left, this.grounded) : fit(low, high, this.grounded));
    return this.auto[1].update(data, now_ms, how);
  }
}

/** Configured ends, with a step when they are multiples of one. */
function whole([low, high]) {
  const step = stepAbove((high - low) / 8);
  const multiple = (value) => Math.abs(value / step - Math.round(value / step)) < 1e-6;
  return { low, high, step: multiple(low) && multiple(high) ? step : null };
}
