// How often each lateness was. Enters: values [µs]. Leaves: counts in bins of equal width on a log axis, and their outline.
// Memory is fixed: a day of ticks takes as much as a second.

const BINS_A_DECADE = 10;
/** From 10 ns to 1 s. */
const [FIRST_DECADE, DECADES] = [-2, 8];

export class Histogram {
  constructor() {
    this.counts = new Float64Array(DECADES * BINS_A_DECADE);
    this.total = 0;
  }

  /** Counts every value of a column, each times `factor`; what is not finite is left out. */
  add(column, factor) {
    for (const value of column) {
      const bin = Math.floor((Math.log10(Math.max(value * factor, 1e-300)) - FIRST_DECADE) * BINS_A_DECADE);
      if (Number.isNaN(bin)) continue;
      this.counts[Math.max(0, Math.min(this.counts.length - 1, bin))] += 1;
      this.total += 1;
    }
  }

  /** Decades between which anything was counted. Null: nothing was. */
  get decades() {
    const first = this.counts.findIndex((count) => count > 0);
    if (first < 0) return null;
    const last = this.counts.findLastIndex((count) => count > 0);
    return [Math.floor(first / BINS_A_DECADE) + FIRST_DECADE, Math.ceil((last + 1) / BINS_A_DECADE) + FIRST_DECADE];
  }

  /** The outline as a path of steps: x(decade) and y(share of the ticks) give the places. */
  outline([low, high], x, y) {
    const from = (low - FIRST_DECADE) * BINS_A_DECADE;
    const bins = Array.from(this.counts.subarray(from, (high - FIRST_DECADE) * BINS_A_DECADE));
    const steps = bins.map((count, k) => `V${y(count / this.total).toFixed(1)}H${x(low + (k + 1) / BINS_A_DECADE).toFixed(1)}`);
    return `M${x(low).toFixed(1)},${y(0).toFixed(1)}${steps.join("")}V${y(0).toFixed(1)}`;
  }
}
