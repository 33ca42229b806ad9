import { Store } from "../page/store.js";
import { check, frameOf, random, same, SIGNALS } from "./check.js";

const RAW = 2 ** 17;

/** Pushes `n` rows in frames of uneven length; ticks leave gaps, values are NaN now and then. Returns all rows. */
function filled(store, n, seed, first = 0) {
  const draw = random(seed);
  const rows = [];
  let tick = first;
  while (rows.length < n) {
    const frame = [];
    const length = Math.min(1 + Math.floor(draw() * 900), n - rows.length);
    for (let k = 0; k < length; k += 1) {
      if (draw() < 0.002) tick += 1 + Math.floor(draw() * 400);
      const value = draw() < 0.001 ? NaN : Math.fround(Math.sin(tick / 700) + draw());
      frame.push([tick, value, Math.fround(-draw())]);
      tick += 1;
    }
    store.push(frameOf(frame));
    rows.push(...frame);
  }
  return rows;
}

/** Extremes of the rows with begin <= tick < end. */
function brute(rows, channel, begin, end) {
  let [low, high] = [Infinity, -Infinity];
  for (const row of rows) {
    if (row[0] < begin || row[0] >= end) continue;
    if (row[channel + 1] < low) low = row[channel + 1];
    if (row[channel + 1] > high) high = row[channel + 1];
  }
  return low <= high ? [low, high] : [NaN, NaN];
}

export function extremesAreExactWhereRawSamplesAre() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const rows = filled(store, 20000, 7);
  const draw = random(8);
  for (let k = 0; k < 400; k += 1) {
    const begin = Math.floor(draw() * store.last * 1.1) - 100;
    const end = begin + Math.floor(draw() ** 3 * 20000);
    for (const channel of [0, 1])
      same(store.extent(channel, begin, end), brute(rows, channel, begin, end), `channel ${channel}, ticks ${begin} to ${end}`);
  }
}

export function columnsAreExactWhereRawSamplesAre() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const rows = filled(store, 6000, 9);
  for (const width of [0.3, 1, 7.37, 90]) {
    const origin = 1234.56;
    const { from, to } = store.columns(origin, width, 3, 60);
    for (let k = 0; k < 60; k += 1) {
      const out = [0, 0];
      store.extremes(0, from[k], to[k], out);
      same(out, brute(rows, 0, origin + (k + 3) * width, origin + (k + 4) * width), `width ${width}, column ${k}`);
    }
  }
}

export function olderStretchesAreCoveredByWholeBlocks() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const n = 2 ** 20 + 300_000;
  const value = (tick) => Math.fround(Math.sin(tick / 3000) * (1 + (tick % 97) / 97));
  for (let tick = 0; tick < n; tick += 4096) {
    const length = Math.min(4096, n - tick);
    store.push(frameOf(Array.from({ length }, (_, k) => [tick + k, value(tick + k), 0])));
  }
  same(store.first, 0, "oldest tick");
  const direct = (begin, end) => {
    let [low, high] = [Infinity, -Infinity];
    for (let tick = Math.max(0, begin); tick < Math.min(n, end); tick += 1) {
      low = Math.min(low, value(tick));
      high = Math.max(high, value(tick));
    }
    return [low, high];
  };
  const draw = random(3);
  for (let k = 0; k < 60; k += 1) {
    const begin = Math.floor(draw() * n);
    const end = begin + 1 + Math.floor(draw() * 30000);
    // Blocks are of 16 samples for the newest 2^20, of 256 before that.
    const size = begin >= n - RAW ? 1 : begin > n - 2 ** 20 + 16 ? 16 : 256;
    const [low, high] = store.extent(0, begin, end);
    const inner = direct(begin, end);
    const outer = direct(Math.floor(begin / size) * size - size, Math.ceil(end / size) * size + size);
    check(low <= inner[0] && high >= inner[1], `ticks ${begin} to ${end}: found ${[low, high]}, needed to cover ${inner}`);
    check(low >= outer[0] && high <= outer[1], `ticks ${begin} to ${end}: found ${[low, high]}, needed within ${outer}`);
  }
}

export function memoryDoesNotGrow() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const bytes = () =>
    [store.ticks, ...store.raw, ...store.levels.flatMap((l) => [...l.low, ...l.high, l.begin, l.end])].reduce(
      (sum, a) => sum + a.byteLength,
      0,
    );
  const before = bytes();
  filled(store, 3 * RAW, 5);
  same(bytes(), before, "bytes after three times the raw samples");
  same(store.count - store.rawFirst, RAW, "raw samples kept");
}

export function gapsAndLossesBreakTheLine() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(
    frameOf([
      [10, 1, 1],
      [11, 2, 2],
      [13, 3, 3],
    ]),
  );
  store.push(
    frameOf([
      [14, 4, 4],
      [15, 5, 5],
    ]),
  );
  store.push(
    frameOf(
      [
        [30, 6, 6],
        [31, 7, 7],
      ],
      14,
    ),
  );
  same(
    [0, 1, 2, 3, 4, 5, 6].map((i) => store.gapBefore(i)),
    [true, false, true, false, false, true, false],
    "gaps",
  );
  same(store.lost, 14, "rows lost");
}

export function rowsThatComeAgainArePassedOver() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(
    frameOf([
      [1, 1, 0],
      [2, 2, 0],
      [3, 3, 0],
    ]),
  );
  store.push(
    frameOf([
      [2, 9, 0],
      [3, 9, 0],
      [4, 4, 0],
    ]),
  );
  same(
    [0, 1, 2, 3].map((i) => store.valueAt(0, i)),
    [1, 2, 3, 4],
    "values",
  );
  same(store.last, 4, "newest tick");
}

export function ticksAreWholeUpTo2To53() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const first = 2 ** 53 - 1000;
  store.push(frameOf(Array.from({ length: 900 }, (_, k) => [first + k, k, -k])));
  same(store.extent(0, first + 17, first + 24), [17, 23], "extremes near 2^53");
  same(store.last, first + 899, "newest tick");
}

export function emptyStoreHasNothing() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  same([store.first, store.last, store.latest("psi_rad")].map(Number.isNaN), [true, true, true], "NaN");
  same(store.extent(0, 0, 10).map(Number.isNaN), [true, true], "extent");
  store.push(frameOf([[5, 1, 2]]));
  same([store.first, store.last, store.latest("voltage_v"), store.latest("gone")], [5, 5, 2, NaN], "one sample");
  store.clear();
  same(Number.isNaN(store.last), true, "cleared");
}

export function framesOfOtherWidthAreRefused() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  let words = "";
  try {
    store.push(frameOf([[1, 2]]));
  } catch (error) {
    words = error.message;
  }
  same(words, "found a frame of 1 channels, needed 2", "message");
}
