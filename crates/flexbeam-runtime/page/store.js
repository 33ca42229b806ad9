// What the page remembers of a run: rings of fixed size with a pyramid of extremes above them.
// Enters: frames of samples. Leaves: the least and the greatest value of any stretch of ticks, and raw samples.
// Level 0: 2^17 raw samples (131 s at 1 kHz); level 1: extremes of 16 samples, 2^16 of them (17 min);
// level 2: of 256 samples, 2^15 of them (2.3 h). Nothing grows: ten signals take 16 MB from the first sample on.
// A stretch that raw samples still cover is answered exactly; an older one by whole blocks of 16 or 256 samples.

/** [log2 of the entries, log2 of the samples of an entry]. */
const RAW = 17;
const LEVELS = [
  { entries: 16, samples: 4 },
  { entries: 15, samples: 8 },
];
const RAW_MASK = 2 ** RAW - 1;

/** Extremes of blocks of samples, of all channels. */
class Level {
  constructor(shape, channels) {
    this.size = 2 ** shape.samples;
    this.capacity = 2 ** shape.entries;
    this.low = channels.map(() => new Float32Array(this.capacity));
    this.high = channels.map(() => new Float32Array(this.capacity));
    this.begin = new Float64Array(this.capacity);
    this.end = new Float64Array(this.capacity);
  }

  /** Index of the oldest sample that whole blocks still tell of, with `count` samples pushed. */
  oldest(count) {
    const newest = Math.floor((count - 1) / this.size);
    return Math.max(0, newest - this.capacity + 1) * this.size;
  }

  slot(index) {
    return Math.floor(index / this.size) & (this.capacity - 1);
  }

  /** Index of the first sample of the first block whose `ticks` (begin or end) reach `tick`. */
  search(ticks, tick, count) {
    let low = this.oldest(count) / this.size;
    let high = Math.ceil(count / this.size);
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (ticks[middle & (this.capacity - 1)] < tick) low = middle + 1;
      else high = middle;
    }
    return low * this.size;
  }
}

/** Samples of all signals of a run. Samples are counted from 0: `index`; the tick of a sample is its instant. */
export class Store {
  /**
   * @param {{signals: {key: string}[], period_s: number}} of signals as in `hello`, in the order of the columns
   */
  constructor({ signals, period_s }) {
    this.signals = signals;
    this.period_s = period_s;
    this.channels = new Map(signals.map((signal, k) => [signal.key, k]));
    this.ticks = new Float64Array(2 ** RAW);
    this.raw = signals.map(() => new Float32Array(2 ** RAW));
    this.levels = LEVELS.map((shape) => new Level(shape, signals));
    /** Raised by `clear`: what was computed from the samples before is void. */
    this.epoch = 0;
    this.clear();
  }

  /** Forgets all samples. */
  clear() {
    this.count = 0;
    /** Rows that the server says this viewer missed. */
    this.lost = 0;
    this.epoch += 1;
  }

  /** Oldest tick that is still told of [ticks]; NaN when empty. */
  get first() {
    if (this.count === 0) return NaN;
    const top = this.levels[this.levels.length - 1];
    return top.begin[top.slot(top.oldest(this.count))];
  }

  /** Newest tick; NaN when empty. */
  get last() {
    return this.count === 0 ? NaN : this.ticks[(this.count - 1) & RAW_MASK];
  }

  /** Index of the oldest raw sample. */
  get rawFirst() {
    return Math.max(0, this.count - 2 ** RAW);
  }

  /**
   * Appends a frame. Rows that are not newer than the newest (sent again after a reconnection) are passed over.
   * @param {{first: number, ticks: Uint32Array, columns: Float32Array[], lost: number}} frame
   */
  push({ first, ticks, columns, lost }) {
    if (columns.length !== this.raw.length) {
      throw new RangeError(`found a frame of ${columns.length} channels, needed ${this.raw.length}`);
    }
    this.lost += lost;
    let row = 0;
    while (row < ticks.length && first + ticks[row] <= this.last) row += 1;
    for (; row < ticks.length; row += 1) this.append(first + ticks[row], columns, row);
  }

  append(tick, columns, row) {
    const index = this.count;
    this.ticks[index & RAW_MASK] = tick;
    for (let c = 0; c < this.raw.length; c += 1) this.raw[c][index & RAW_MASK] = columns[c][row];
    for (const level of this.levels) {
      const slot = level.slot(index);
      const fresh = index % level.size === 0;
      if (fresh) level.begin[slot] = tick;
      level.end[slot] = tick;
      for (let c = 0; c < this.raw.length; c += 1) {
        const value = columns[c][row];
        // `!(a <= b)` and not `a > b`: a NaN that stands there gives way to any number.
        if (fresh || (value === value && !(level.low[c][slot] <= value))) level.low[c][slot] = value;
        if (fresh || (value === value && !(level.high[c][slot] >= value))) level.high[c][slot] = value;
      }
    }
    this.count += 1;
  }

  /** Newest value of a signal [SI]; NaN when there is none. */
  latest(key) {
    const channel = this.channels.get(key);
    return channel === undefined || this.count === 0 ? NaN : this.raw[channel][(this.count - 1) & RAW_MASK];
  }

  /** Tick of a raw sample. */
  tickAt(index) {
    return this.ticks[index & RAW_MASK];
  }

  /** Value of a raw sample [SI]. */
  valueAt(channel, index) {
    return this.raw[channel][index & RAW_MASK];
  }

  /** Index of the first sample at `tick` or later; where raw samples are gone, of the block that holds it. */
  lower(tick) {
    return this.find(tick, "end");
  }

  /** Index of the first sample at `tick` or later; where raw samples are gone, of the first block that begins there. */
  upper(tick) {
    return this.find(tick, "begin");
  }

  find(tick, side) {
    const old = this.rawFirst;
    if (old === 0 || tick > this.tickAt(old)) return this.findRaw(tick);
    const level = this.levels.find((l) => tick > l.begin[l.slot(l.oldest(this.count))]) ?? this.levels[1];
    return level.search(level[side], tick, this.count);
  }

  /** First raw sample at `tick` or later: a guess from even spacing, then bisection around it. */
  findRaw(tick) {
    let low = this.rawFirst;
    let high = this.count;
    if (high === low) return high;
    const guess = Math.round(high - 1 - (this.last - tick));
    if (guess > low && guess < high && this.tickAt(guess) >= tick) {
      if (this.tickAt(guess - 1) < tick) return guess;
      high = guess;
    }
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.tickAt(middle) < tick) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** True when periods are missing just before a sample, so that no line may lead to it. */
  gapBefore(index) {
    if (index <= 0) return true;
    if (index > this.rawFirst) return this.tickAt(index) - this.tickAt(index - 1) > 1;
    const level = this.levels.find((l) => index - l.size >= l.oldest(this.count));
    if (!level) return true;
    return level.begin[level.slot(index)] - level.end[level.slot(index - level.size)] > 1;
  }

  /**
   * Extremes of the samples [from, to): `out[0]` the least and `out[1]` the greatest; NaN when there is none.
   * Numerics: whole blocks where they fit, raw samples at the ends; at most 2*(16 + 16) raw and small blocks.
   */
  extremes(channel, from, to, out) {
    const raw = this.raw[channel];
    const rawFirst = this.rawFirst;
    const [small, large] = this.levels;
    let low = Infinity;
    let high = -Infinity;
    let index = from;
    while (index < to) {
      let level = null;
      if (index % large.size === 0 && index + large.size <= to) level = large;
      else if (index % small.size === 0 && index + small.size <= to) level = small;
      else if (index < rawFirst) level = small;
      if (level === small && index < small.oldest(this.count)) level = large;
      if (level === large && index < large.oldest(this.count)) {
        index = large.oldest(this.count);
        continue;
      }
      if (level) {
        const slot = level.slot(index);
        if (level.low[channel][slot] < low) low = level.low[channel][slot];
        if (level.high[channel][slot] > high) high = level.high[channel][slot];
        index = (Math.floor(index / level.size) + 1) * level.size;
      } else {
        const value = raw[index & RAW_MASK];
        if (value < low) low = value;
        if (value > high) high = value;
        index += 1;
      }
    }
    out[0] = low <= high ? low : NaN;
    out[1] = low <= high ? high : NaN;
  }

  /** Extremes of a signal over the ticks [begin, end): [least, greatest], NaN when there is no sample. */
  extent(channel, begin, end) {
    const out = [NaN, NaN];
    if (this.count > 0) this.extremes(channel, this.lower(begin), this.upper(end), out);
    return out;
  }

  /**
   * Samples of even columns: column k holds the ticks [origin + k*width, origin + (k + 1)*width).
   * Returns indices: column k has the samples [from[k], to[k]). The same for all channels.
   */
  columns(origin, width, first, n) {
    const from = new Float64Array(n);
    const to = new Float64Array(n);
    const old = this.rawFirst > 0 ? this.tickAt(this.rawFirst) : -Infinity;
    let start = this.count > 0 ? this.lower(origin + first * width) : 0;
    for (let k = 0; k < n && this.count > 0; k += 1) {
      const end = origin + (first + k + 1) * width;
      to[k] = this.upper(end);
      from[k] = start;
      start = end > old ? to[k] : this.lower(end);
    }
    return { from, to };
  }
}
