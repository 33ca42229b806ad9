import { brief, count, fixed, roundUp, runTime, shortTime, typed, withUnit } from "../page/number.js";
import { same } from "./check.js";

export function decimalsAreFixedAndTheMinusIsTrue() {
  same([fixed(-1.5, 2), fixed(-0.001, 2), fixed(30, 2), fixed(NaN, 2), fixed(Infinity, 2)], ["−1.50", "0.00", "30.00", "–", "∞"], "fixed");
  same([withUnit("5", "V"), withUnit("5", "°"), withUnit("5", "")], ["5\u202fV", "5°", "5"], "units");
}

export function threeFiguresAreEnough() {
  same([0.07091, 2.314, 38.24, 1234.5, 0, 1.234e-7].map(brief), ["0.0709", "2.31", "38.2", "1235", "0", "1.23e−7"], "brief");
  same([2.5e-6, 9.9996e-7, 0.0213, 1.5, 0].map(shortTime), ["2.50\u202fµs", "1.00\u202fµs", "21.3\u202fms", "1.50\u202fs", "0\u202fns"], "short times");
  same([0, 12.34, 187.46, 3729.9].map(runTime), ["0.0\u202fs", "12.3\u202fs", "3:07.4", "1:02:09"], "times of a run");
  same([0, 999, 1234567].map(count), ["0", "999", "1\u202f234\u202f567"], "counts");
}

export function peopleMayTypeAsTheyLike() {
  const texts = ["45.5", "45,5", " −45.5 ", "-45.5°", "1e-3", ".5", "+2"];
  same(texts.map((text) => typed(text, "°")), [45.5, 45.5, -45.5, -45.5, 0.001, 0.5, 2], "numbers");
  same(["", "abc", "1 2,3,4", "1V", "--1", "Infinity"].map((text) => typed(text, "°")), [NaN, NaN, NaN, NaN, NaN, NaN], "no numbers");
  same(typed("0.3 V", "V"), 0.3, "with its unit");
}

export function roundNumbersLieAtOrAbove() {
  same([0.04, 0.05, 1.2, 16, 100].map(roundUp).map((x) => Number(x.toPrecision(6))), [0.05, 0.05, 2, 20, 100], "round up");
}
