// What tests say, and signals to test with.

/** Fails with what was found and what was needed. */
export function check(holds, words) {
  if (!holds) throw new Error(words);
}

/** Equal, NaN to NaN. */
export function same(found, needed, words) {
  const [a, b] = [JSON.stringify(found), JSON.stringify(needed)];
  if (a !== b && !Object.is(found, needed)) throw new Error(`${words}: found ${a}, needed ${b}`);
}

export function near(found, needed, within, words) {
  if (!(Math.abs(found - needed) <= within)) throw new Error(`${words}: found ${found}, needed ${needed} within ${within}`);
}

/** Random numbers from a seed, in [0, 1). */
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

export const SIGNALS = [
  { key: "psi_rad", label: "Tip angle", symbol: "psi", unit: "\u00b0", factor: 180 / Math.PI, kind: "line" },
  { key: "voltage_v", label: "Voltage", symbol: "v", unit: "V", factor: 1, kind: "line" },
];

/** A frame of rows [tick, value, value, ...]. */
export function frameOf(rows, lost = 0) {
  const first = rows[0][0];
  return {
    first,
    lost,
    ticks: Uint32Array.from(rows, (row) => row[0] - first),
    columns: rows[0].slice(1).map((_, c) => Float32Array.from(rows, (row) => row[c + 1])),
  };
}

/** Waits until the page has laid out a card. */
export async function laidOut(card) {
  for (let k = 0; k < 500 && card.size.width === 0; k += 1) await new Promise((done) => setTimeout(done, 10));
  check(card.size.width > 0, "the card was not laid out within 5 s");
}
