// Vertical axes of a plot: configured, chosen by hand, or fitted to the data.
// Enters: extremes of the signals of each axis. Leaves: ends of the axes, as shown.

import { AutoRange, fit, fitDivisions } from "./chart_range.js";
import { stepAbove } from "./chart_ticks.js";

/** Up to two axes with one grid. */
export class ValueAxes {
  constructor() {
    this.auto = [new AutoRange(), new AutoRange()];
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
    let divisions = 0;
    return extents.map((data, k) => {
      if (chosen[k]) return { ends: chosen[k], step: null };
      const { low, high, step } = k === 0 ? this.left(data, configured, now_ms) : this.right(data, divisions, now_ms);
      if (k === 0 && step) divisions = Math.round((high - low) / step);
      return { ends: [low, high], step };
    });
  }

  left(data, configured, now_ms) {
    return configured ? whole(configured) : this.auto[0].update(data, now_ms);
  }

  /** Divided like the left axis, where that is divided evenly. */
  right(data, divisions, now_ms) {
    if (this.divisions !== divisions) this.auto[1].reset();
    this.divisions = divisions;
    const how = divisions > 0 ? (low, high) => fitDivisions(low, high, divisions) : fit;
    return this.auto[1].update(data, now_ms, how);
  }
}

/** Configured ends, with a step when they are multiples of one. */
function whole([low, high]) {
  const step = stepAbove((high - low) / 8);
  const multiple = (value) => Math.abs(value / step - Math.round(value / step)) < 1e-6;
  return { low, high, step: multiple(low) && multiple(high) ? step : null };
}
