// Numbers as people read them. Enters: SI values and texts. Leaves: texts with a true minus, fixed decimals and units; numbers.

const MINUS = "\u2212";
const THIN = "\u202f";
const NOTHING = "\u2013";
export const INFINITE = "\u221e";

/** A number with fixed decimals; a dash where there is none. No minus before a zero. */
export function fixed(value, decimals) {
  if (value === Infinity) return INFINITE;
  if (!Number.isFinite(value)) return NOTHING;
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

/** A number with its unit: thin space before letters, none before a degree sign. */
export function withUnit(text, unit) {
  if (unit === "" || text === NOTHING) return text;
  return unit === "°" ? text + unit : text + THIN + unit;
}

/** As many digits as tell it from its neighbours: three significant ones. */
export function brief(value) {
  if (!Number.isFinite(value)) return NOTHING;
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(3)))));
  if (size >= 6 || size < -4) return value.toExponential(2).replaceAll("-", MINUS);
  return fixed(value, Math.max(0, Math.min(6, 2 - size)));
}

/** A short time [s] in ns, µs, ms or s, three significant digits. */
export function shortTime(seconds) {
  if (!Number.isFinite(seconds)) return NOTHING;
  const [factor, unit] = [[1, "s"], [1e3, "ms"], [1e6, "µs"], [1e9, "ns"]].find(([f]) => Math.abs(seconds) * f >= 0.9995) ?? [1e9, "ns"];
  return withUnit(brief(seconds * factor), unit);
}

/** A time of a run [s]: 12.3 s, 3:07.4, 1:02:09. */
export function runTime(seconds) {
  if (!Number.isFinite(seconds)) return NOTHING;
  const tenths = Math.floor(seconds * 10 + 1e-6);
  const [hours, minutes, rest] = [Math.floor(tenths / 36000), Math.floor(tenths / 600) % 60, (tenths % 600) / 10];
  const two = (number) => String(number).padStart(2, "0");
  if (hours > 0) return `${hours}:${two(minutes)}:${two(Math.floor(rest))}`;
  return minutes > 0 ? `${minutes}:${rest.toFixed(1).padStart(4, "0")}` : withUnit(rest.toFixed(1), "s");
}

/** A count with thin spaces between thousands. */
export function count(value) {
  return Number.isFinite(value) ? String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, THIN) : NOTHING;
}

/** What a person typed: comma or point, any minus, the unit or not. NaN where it is no number. */
export function typed(text, unit) {
  const bare = text.trim().replaceAll(/[\s\u2009\u202f]/g, "").replace(MINUS, "-").replace(",", ".");
  const number = unit !== "" && bare.endsWith(unit) ? bare.slice(0, -unit.length) : bare;
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(number) ? Number(number) : NaN;
}

/** The round number (1, 2, 5 times a power of ten) at or above a positive one. */
export function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((m) => m * power).find((m) => m >= value * (1 - 1e-9));
}
