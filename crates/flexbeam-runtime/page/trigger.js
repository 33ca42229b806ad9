// The instant at which a plot stands still: where a signal crosses a level.
// Enters: samples of one signal as they come. Leaves: the tick of the crossing, between two samples.

/**
 * Watches one signal of a store. A crossing is taken when the one before has been shown in full.
 */
export class Trigger {
  /**
   * @param {{signal: string, edge: "rising"|"falling"|"either", level: number, mode: "auto"|"normal"|"single",
   *   before: number}} wanted level in SI, before 0 to 1
   * @param {number} noise distance from the level that a signal must have had before it can cross again [SI]
   */
  constructor(wanted, noise = 0) {
    this.wanted = wanted;
    this.noise = noise;
    /** Tick of the crossing that is shown, with a fraction; NaN when there is none. */
    this.at = NaN;
    this.next = 0;
    this.epoch = NaN;
    this.side = 0;
  }

  /** Waits for the next crossing from now on; what `single` shows is let go. */
  arm(store) {
    this.at = NaN;
    this.next = store.count;
    this.epoch = store.epoch;
    this.side = 0;
  }

  /** True while the plot rolls for want of a crossing. */
  rolls(last, span) {
    if (Number.isNaN(this.at)) return this.wanted.mode === "auto";
    return this.wanted.mode === "auto" && last - this.at > 2 * span;
  }

  /** `armed`, `triggered` or `held`: what a person is told. */
  get state() {
    if (Number.isNaN(this.at)) return "armed";
    return this.wanted.mode === "single" ? "held" : "triggered";
  }

  /**
   * Looks at the samples that came since the last time.
   * @param {number} span what the plot shows [ticks]
   * @returns {number} tick of the crossing to stand at, NaN when there is none
   */
  update(store, span) {
    if (this.epoch !== store.epoch) {
      this.arm(store);
      this.next = 0;
    }
    const channel = store.channels.get(this.wanted.signal);
    if (channel === undefined) return NaN;
    const after = (1 - this.wanted.before) * span;
    for (let i = Math.max(this.next, store.rawFirst); i < store.count; i += 1) this.look(store, channel, i, after);
    this.next = store.count;
    return this.at;
  }

  look(store, channel, index, after) {
    const value = store.valueAt(channel, index);
    const { level, edge, mode } = this.wanted;
    // Across missing periods nobody knows when the level was crossed.
    const came = store.gapBefore(index) || !Number.isFinite(value) ? 0 : this.side;
    this.side = value < level - this.noise ? -1 : value > level + this.noise ? 1 : came;
    const rose = came < 0 && value >= level;
    const fell = came > 0 && value <= level;
    if (!rose && !fell) return;
    if (this.side === came) this.side = 0;
    if ((rose && edge === "falling") || (fell && edge === "rising")) return;
    if (mode === "single" && !Number.isNaN(this.at)) return;
    const tick = store.tickAt(index);
    if (tick < this.at + after) return;
    const before = store.valueAt(channel, index - 1);
    this.at = tick - ((value - level) / (value - before)) * (tick - store.tickAt(index - 1));
  }
}
