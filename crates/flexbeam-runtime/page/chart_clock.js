// The instant at the right end of a rolling plot: moves evenly although samples come in frames.
// Enters: the newest tick of the store and the time of the animation frame. Leaves: a tick, with a fraction.
// All plots of a store share one clock, so that they move together.

/** The plot stays this far behind the newest sample, so that uneven frames do not show [s]. */
const DELAY_S = 0.08;
/** Further off than this the clock jumps instead of drifting [s]. */
const JUMP_S = 0.4;
/** Share of its error that the clock makes up for in a frame. */
const PULL = 0.05;

const clocks = new WeakMap();

/** The clock of a store. */
export function clockOf(store) {
  if (!clocks.has(store)) clocks.set(store, new Clock(store));
  return clocks.get(store);
}

class Clock {
  constructor(store) {
    this.store = store;
    this.edge_s = NaN;
    this.now_ms = NaN;
  }

  /** Tick at the right end at an animation frame; NaN while there is nothing. */
  edge(now_ms) {
    const { period_s, last } = this.store;
    if (!(this.now_ms === now_ms)) this.advance(now_ms, last * period_s);
    // Never ahead of the data: when they stop, the plot stands still at the newest one.
    return Math.min(this.edge_s / period_s, last);
  }

  advance(now_ms, newest_s) {
    const wanted_s = newest_s - DELAY_S;
    const moved_s = this.edge_s + (now_ms - this.now_ms) / 1000;
    const off_s = wanted_s - moved_s;
    this.now_ms = now_ms;
    if (!(Math.abs(off_s) < JUMP_S)) this.edge_s = newest_s;
    else this.edge_s = Math.min(moved_s + PULL * off_s, newest_s);
  }
}
