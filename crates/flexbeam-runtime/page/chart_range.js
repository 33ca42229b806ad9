// Ends of a value axis that fit the data and do not jitter.
// Enters: extremes of what is shown. Leaves: ends that are multiples of a step of 1, 2 or 5.
// Grows at once when data leave it; shrinks only after the data have asked for it for a while.

import { stepAbove } from "./chart_ticks.js";

/** Room above and below the data, share of their height. */
const ROOM = 0.06;
/** An axis shrinks when the data would need less than this share of it ... */
const LOOSE = 0.6;
/** ... for this long [ms]. */
const PATIENCE_MS = 1500;
/** A shared nought may make an axis this many times as long as its data need. */
const WASTE = 2.6;
/** Divisions of an axis that is fitted. */
const DIVISIONS = 6;

/**
 * Ends around [low, high], and the step that they are multiples of.
 * @param {boolean} grounded data that begin at nought have no room below
 * @returns {{low: number, high: number, step: number}}
 */
export function fit(low, high, grounded = false) {
  if (!(low <= high)) return fit(-0.9, 0.9);
  // A constant has no height of its own: a twentieth of its size, or one unit around nought.
  const height = high - low || Math.abs(high) * 0.05 || 1;
  const step = stepAbove(height / DIVISIONS);
  const room = ROOM * height;
  const below = grounded && low === 0 ? 0 : room;
  return { low: Math.floor((low - below) / step) * step, high: Math.ceil((high + room) / step) * step, step };
}

/**
 * Ends around [low, high] on the grid of another axis: as many steps, and nought on the same line where both have it.
 * @param {{low: number, high: number, step: number}} other
 * @returns {{low: number, high: number, step: number}}
 */
export function fitBeside(low, high, other, grounded = false) {
  const divisions = Math.round((other.high - other.low) / other.step);
  const nought = Math.round(-other.low / other.step);
  const tight = fit(low, high, grounded);
  if (nought >= 0 && nought <= divisions && tight.low <= 0 && tight.high >= 0) {
    // Above nought and below it as many divisions as the other axis has.
    const least = Math.max(nought > 0 ? -tight.low / nought : 0, nought < divisions ? tight.high / (divisions - nought) : 0);
    const step = stepAbove(least);
    const covers = -nought * step <= tight.low && (divisions - nought) * step >= tight.high;
    if (covers && divisions * step <= WASTE * (tight.high - tight.low))
      return { low: -nought * step, high: (divisions - nought) * step, step };
  }
  for (let step = stepAbove((tight.high - tight.low) / divisions); ; step = stepAbove(step * 1.01)) {
    const bottom = Math.floor(tight.low / step + 1e-9);
    const spare = divisions - (Math.ceil(tight.high / step - 1e-9) - bottom);
    if (spare < 0) continue;
    const from = bottom - Math.floor(spare / 2);
    return { low: from * step, high: (from + divisions) * step, step };
  }
}

/** The ends of one axis in the course of time. */
export class AutoRange {
  constructor() {
    this.ends = null;
    this.loose_since = NaN;
  }

  /** Forgets the past: the next ends fit tightly. */
  reset() {
    this.ends = null;
  }

  /**
   * @param {[number, number]} data extremes of what is shown, NaN when there is nothing
   * @param {number} now_ms
   * @param {(low: number, high: number) => {low: number, high: number, step: number}} how `fit` or one with fixed divisions
   */
  update([low, high], now_ms, how = fit) {
    if (!(low <= high)) return (this.ends ??= how(NaN, NaN));
    const wanted = how(low, high);
    if (!this.ends || low < this.ends.low || high > this.ends.high) return this.take(wanted);
    const loose = wanted.high - wanted.low < LOOSE * (this.ends.high - this.ends.low);
    if (!loose) this.loose_since = NaN;
    else if (!(this.loose_since <= now_ms)) this.loose_since = now_ms;
    else if (now_ms - this.loose_since > PATIENCE_MS) return this.take(wanted);
    return this.ends;
  }

  take(ends) {
    this.loose_since = NaN;
    this.ends = ends;
    return ends;
  }
}
