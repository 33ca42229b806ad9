// Raw samples of a stretch as CSV.
// Enters: a store, signals and ticks. Leaves: text as other tools of flexbeam read it: SI, names with units.

/**
 * @param {import("./store.js").Store} store
 * @param {string[]} keys
 * @param {number} begin first tick
 * @param {number} end first tick that is not wanted
 * @returns {string} `time_s,psi_rad,...`, one row for each sample; its first line is a comment when raw samples do not
 *   reach back to `begin`
 */
export function csv(store, keys, begin, end) {
  const lines = [];
  const channels = keys.map((key) => store.channels.get(key));
  const old = store.count > 0 ? store.tickAt(store.rawFirst) : NaN;
  // What the store has never held is not missing.
  if (store.rawFirst > 0 && begin < old) {
    lines.push(
      `# raw samples reach back to ${time(old, store)} s only; the plot begins at ${time(Math.max(begin, store.first), store)} s`,
    );
  }
  lines.push(["time_s", ...keys].join(","));
  const last = store.count > 0 ? store.findRaw(end) : 0;
  for (let i = store.count > 0 ? store.findRaw(begin) : 0; i < last; i += 1) {
    const values = channels.map((channel) => single(store.valueAt(channel, i)));
    lines.push([time(store.tickAt(i), store), ...values].join(","));
  }
  lines.push("");
  return lines.join("\n");
}

/** Shortest text that gives a float of 32 bits again. */
export function single(value) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "NaN" : value > 0 ? "inf" : "-inf";
  for (let digits = 6; digits < 9; digits += 1) {
    const near = Number(value.toPrecision(digits));
    if (Math.fround(near) === value) return String(near);
  }
  return String(Number(value.toPrecision(9)));
}

/** NUMERICS: 15 digits, so that the product shows no rounding of its own. */
function time(tick, store) {
  return String(Number((tick * store.period_s).toPrecision(15)));
}
