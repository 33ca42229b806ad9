// Marks of an axis and the numbers that stand at them.
// Enters: the ends of an axis. Leaves: steps of 1, 2 or 5 times a power of ten, and text with a true minus.

const THIN = "\u2009";
const MINUS = "\u2212";
/** Marks of an axis at most. */
const MOST = 12;
/** Decimals at most: a browser writes no more. */
const MOST_DECIMALS = 100;

/**
 * Least step of 1, 2, 5 times a power of ten that is not below `least`.
 * @param {number} least positive
 */
export function stepAbove(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  for (const factor of [1, 2, 5]) {
    // NUMERICS: 1e-9 forgives the rounding of the power of ten.
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

/** Decimals that tell neighbours of a step apart. */
export function decimalsOf(step) {
  return Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
}

/**
 * Marks within [low, high].
 * @param {number} wanted how many at most, but two or more
 * @returns {{step: number, decimals: number, at: number[]}}
 */
export function marks(low, high, wanted) {
  const step = stepAbove((high - low) / Math.max(1, wanted));
  const at = multiples(low, high, step);
  // One mark alone tells no scale.
  return at.length < 2 && wanted < MOST ? marks(low, high, wanted + 1) : { step, decimals: decimalsOf(step), at };
}

function multiples(low, high, step) {
  // NUMERICS: a step that no number between the ends can tell would never arrive.
  if (!(low + step > low && high - step < high)) return [];
  const at = [];
  // NUMERICS: multiples of the step, so that no rounding adds up; the ends count although they are rounded.
  const last = Math.floor(high / step + 1e-6);
  for (let k = Math.ceil(low / step - 1e-6); k <= last; k += 1) at.push(k === 0 ? 0 : k * step);
  return at;
}

/** Marks of a logarithmic axis, 1-2-5 in each decade, or the decades alone when there are many. */
export function decades(low, high) {
  const at = [];
  const factors = high / low > 3e3 ? [1] : [1, 2, 5];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power += 1) {
    for (const factor of factors) {
      const value = factor * 10 ** power;
      if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) at.push(value);
    }
  }
  return at;
}

/** A number with fixed decimals and a true minus; an en dash when there is none. */
export function number(value, decimals) {
  if (!Number.isFinite(value)) return "\u2013";
  const text = Math.abs(value).toFixed(Math.min(decimals, MOST_DECIMALS));
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

/** A number with its unit: a thin space between them, none before a degree sign. */
export function quantity(value, decimals, unit) {
  const text = number(value, decimals);
  if (!unit || !Number.isFinite(value)) return text;
  return unit === "\u00b0" ? text + unit : text + THIN + unit;
}

/** Decimals for the readings of a unit: fixed, so that nothing jumps. */
export function readingDecimals(unit) {
  return unit === "\u00b5s" ? 1 : unit === "V" ? 3 : unit === "" ? 0 : 2;
}

/** A time with as many decimals as the period can tell. */
export function seconds(value, decimals) {
  return quantity(value, decimals, "s");
}
