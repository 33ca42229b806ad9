// Which signals of a scope stand on which axis.
// Enters: signals as in `hello`, in the order of the scope. Leaves: up to two vertical axes, one for each unit.

/**
 * @typedef {object} Signal as in `hello`: shown = value [SI] * factor
 * @property {string} key
 * @property {string} label
 * @property {string} symbol
 * @property {string} unit
 * @property {number} factor
 * @property {"line"|"flag"} kind
 */

/**
 * The signals of a scope that the run has, and the names of those that it has not.
 * @param {Signal[]} all
 * @param {string[]} keys
 */
export function pick(all, keys) {
  const found = keys.map((key) => all.find((signal) => signal.key === key));
  return { signals: found.filter(Boolean), gone: keys.filter((_, k) => !found[k]) };
}

/** Units in the order of their first signal: the axes. More than two cannot be drawn. */
export function unitsOf(signals) {
  return [...new Set(signals.map((signal) => signal.unit))];
}

/** Index of the axis of a signal: 0 left, 1 right, 2 and above: none. */
export function axisOf(signals, signal) {
  return unitsOf(signals).indexOf(signal.unit);
}

/** Extremes over several signals, as shown; NaN when there is no sample. */
export function extentShown(store, signals, begin, end) {
  let low = Infinity;
  let high = -Infinity;
  for (const signal of signals) {
    const [least, greatest] = store.extent(store.channels.get(signal.key), begin, end);
    if (least * signal.factor < low) low = least * signal.factor;
    if (greatest * signal.factor > high) high = greatest * signal.factor;
  }
  return low <= high ? [low, high] : [NaN, NaN];
}
