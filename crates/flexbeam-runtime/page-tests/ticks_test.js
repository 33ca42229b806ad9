import { decades, marks, number, quantity, stepAbove } from "../page/chart_ticks.js";
import { AutoRange, fit, fitBeside } from "../page/chart_range.js";
import { calm } from "../page/chart_values.js";
import { check, near, random, same } from "./check.js";

export function stepsAre125() {
  const given = [0.03, 0.05, 0.051, 1, 1.2, 2, 4.9, 5.1, 700];
  same(given.map(stepAbove), [0.05, 0.05, 0.1, 1, 2, 2, 5, 10, 1000], "steps");
}

export function marksAreMultiplesWithinTheEnds() {
  const draw = random(4);
  for (let k = 0; k < 500; k += 1) {
    const low = (draw() - 0.5) * 10 ** Math.floor(draw() * 8 - 4);
    const high = low + draw() * 10 ** Math.floor(draw() * 8 - 4) + 1e-6;
    const { at, step, decimals } = marks(low, high, 8);
    check(at.length <= 9 && at.length >= 1, `${low} to ${high}: ${at.length} marks`);
    for (const value of at) {
      near(value / step, Math.round(value / step), 1e-6, "multiple of the step");
      check(value >= low - step * 1e-5 && value <= high + step * 1e-5, `${value} lies outside ${low} to ${high}`);
    }
    same(new Set(at.map((value) => number(value, decimals))).size, at.length, "labels differ");
  }
}

export function numbersHaveATrueMinusAndFixedDecimals() {
  same([number(-1.5, 2), number(-0.001, 2), number(NaN, 1), number(3, 1)], ["\u22121.50", "0.00", "\u2013", "3.0"], "numbers");
  same(
    [quantity(5, 0, "V"), quantity(5, 0, "\u00b0"), quantity(5, 0, ""), quantity(NaN, 0, "V")],
    ["5\u2009V", "5\u00b0", "5", "\u2013"],
    "quantities",
  );
}

export function decadesAre125() {
  same(
    decades(0.1, 30),
    [0.1, 0.2, 0.5, 1, 2, 5, 10, 20].map((x) => Number(x.toPrecision(12))),
    "few decades",
  );
  same(decades(0.05, 500).length, 4, "many decades: powers of ten alone");
}

export function endsCoverTheDataOnTheStep() {
  const draw = random(6);
  for (let k = 0; k < 300; k += 1) {
    const low = (draw() - 0.5) * 10 ** Math.floor(draw() * 6 - 3);
    const high = low + draw() * 10 ** Math.floor(draw() * 6 - 3);
    const ends = fit(low, high);
    check(ends.low < low && ends.high > high, `${low} to ${high}: found ${ends.low} to ${ends.high}`);
    check(
      ends.high - ends.low <= 2 * Math.max(high - low, Math.abs(high) * 0.05),
      `${low} to ${high}: ${ends.low} to ${ends.high} is too long`,
    );
    const left = fit(-draw(), draw() * 3);
    const right = fitBeside(low, high, left);
    same(Math.round((right.high - right.low) / right.step), Math.round((left.high - left.low) / left.step), "divisions");
    check(right.low <= low && right.high >= high, `beside: ${low} to ${high}: found ${right.low} to ${right.high}`);
  }
}

export function noughtIsSharedWhereItFits() {
  const left = fit(-15, 15);
  const right = fitBeside(-4, 4.5, left);
  near(-right.low / right.step, -left.low / left.step, 1e-9, "divisions below nought");
}

export function amplitudesStandOnNought() {
  same(fit(0, 17.9, true).low, 0, "ground");
}

export function rangeGrowsAtOnceAndShrinksLate() {
  const range = new AutoRange();
  const first = range.update([-1, 1], 0);
  same(range.update([-0.8, 0.9], 100), first, "a little less");
  const grown = range.update([-3, 1], 120);
  check(grown.low < -3, "grows at once");
  same(range.update([-0.2, 0.2], 200), grown, "not yet");
  same(range.update([-0.2, 0.2], 1500), grown, "still not");
  check(range.update([-0.2, 0.2], 2000).low > -1, "shrinks at last");
  const kept = range.update([-0.2, 0.2], 2100);
  for (let k = 0; k < 200; k += 1) same(range.update([-0.2 - 0.01 * Math.sin(k), 0.2], 2100 + 50 * k), kept, "does not jitter");
}

/** A range that no double can divide has no marks, rather than none of the page's pictures. */
export function endsThatAreTooCloseHaveNoMarks() {
  for (const [low, high] of [[8589934.0, 8589934.0 + 1e-9], [1e6, 1e6 + 1e-10], [0.1, 0.1], [NaN, NaN]]) {
    const { at, decimals } = marks(low, high, 5);
    check(at.length <= 20, `${at.length} marks between ${low} and ${high}`);
    at.forEach((value) => number(value, decimals));
  }
  const { at, decimals } = marks(-1e-300, 1e-300, 5);
  at.forEach((value) => number(value, decimals));
}

export function noiseAtRestIsNotBlownUp() {
  same(calm([-0.02, 0.02], "°"), [-0.25, 0.25], "a resting angle");
  same(calm([-20, 20], "°"), [-20, 20], "a moving one");
  same(calm([0, 1e-6], "µs"), [0, 1e-6], "a unit without a rule");
  check(calm([NaN, NaN], "°").every(Number.isNaN), "nothing stays nothing");
}
