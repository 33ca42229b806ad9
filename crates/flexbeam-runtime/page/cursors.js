// Two cursors over a plot: where they stand and what the signals are there.
// Enters: places along the horizontal axis, as offsets from what the plot is anchored to. Leaves: readings.

/** Two places, A and B. */
export class Cursors {
  constructor() {
    this.on = false;
    this.at = [NaN, NaN];
  }

  /** Shows or hides them; shown for the first time, or out of sight, they stand at a third and two thirds. */
  toggle([low, high]) {
    this.on = !this.on;
    const seen = this.at.every((x) => x >= low && x <= high);
    if (this.on && !seen) this.at = [low + (high - low) / 3, low + ((high - low) * 2) / 3];
  }

  /** Index of the cursor within `reach` of a place, or -1. */
  near(place, reach) {
    if (!this.on) return -1;
    const off = this.at.map((x) => Math.abs(x - place));
    const k = off[0] <= off[1] ? 0 : 1;
    return off[k] <= reach ? k : -1;
  }
}

/**
 * Value of a signal at a tick: of the nearest sample within half a period; where raw samples are gone, the middle
 * between the extremes of the block that holds it.
 * @returns {number} SI; NaN in a gap
 */
export function valueAt(store, channel, tick) {
  if (store.count === 0) return NaN;
  const nearest = Math.round(tick);
  if (nearest >= store.tickAt(store.rawFirst)) {
    const index = store.lower(nearest);
    return index < store.count && store.tickAt(index) === nearest ? store.valueAt(channel, index) : NaN;
  }
  const [low, high] = store.extent(channel, nearest, nearest + 1);
  return (low + high) / 2;
}

/**
 * Readings of several signals at two instants.
 * @param {string[]} keys
 * @returns {{key: string, a: number, b: number, difference: number}[]} SI
 */
export function readings(store, keys, tick_a, tick_b) {
  return keys.map((key) => {
    const channel = store.channels.get(key);
    const a = valueAt(store, channel, tick_a);
    const b = valueAt(store, channel, tick_b);
    return { key, a, b, difference: b - a };
  });
}

/** Time between two instants [s], and how often that fits into a second [Hz]; NaN when they coincide. */
export function between(tick_a, tick_b, period_s) {
  const time_s = (tick_b - tick_a) * period_s;
  return { time_s, frequency_hz: time_s === 0 ? NaN : 1 / Math.abs(time_s) };
}
