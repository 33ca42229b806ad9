// Raw samples of the newest stretch of a signal, evenly spaced.
// Enters: a store and ticks. Leaves: one value a tick; missing periods filled by straight lines, and counted.

/** More missing samples than this share, and nothing true can be said. */
const MOST_MISSING = 0.01;

/**
 * Values of a channel at the ticks end - n + 1 .. end.
 * @returns {{values: Float64Array, missing: number}|null} null when raw samples do not reach back so far, or too many are missing
 */
export function evenly(store, channel, end, n) {
  const begin = end - n + 1;
  if (store.count === 0 || begin < store.tickAt(store.rawFirst)) return null;
  const values = new Float64Array(n).fill(NaN);
  for (let i = store.lower(begin); i < store.count && store.tickAt(i) <= end; i += 1) {
    values[store.tickAt(i) - begin] = store.valueAt(channel, i);
  }
  const missing = fillGaps(values);
  return missing <= MOST_MISSING * n ? { values, missing } : null;
}

/** Straight lines over what is missing; the ends are kept on. Returns how many were missing. */
function fillGaps(values) {
  let missing = 0;
  let known = -1;
  for (let j = 0; j <= values.length; j += 1) {
    if (j < values.length && Number.isNaN(values[j])) {
      missing += 1;
      continue;
    }
    const left = known >= 0 ? values[known] : values[j];
    const right = j < values.length ? values[j] : left;
    for (let k = known + 1; k < j; k += 1) values[k] = left + ((right - left) * (k - known)) / (j - known);
    known = j;
  }
  return missing;
}

/** The greatest power of two that is not above `n`. */
export function powerBelow(n) {
  return 2 ** Math.floor(Math.log2(n));
}
