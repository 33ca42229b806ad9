import { Store } from "../page/store.js";
import { Trigger } from "../page/trigger.js";
import { frameOf, near, same, SIGNALS } from "./check.js";

const WANTED = { signal: "psi_rad", edge: "rising", level: 0.25, mode: "auto", before: 0.1 };

function storeOf(values, first = 0) {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  if (values.length > 0) store.push(frameOf(values.map((value, k) => [first + k, value, 0])));
  return store;
}

/** Sine of period 100 ticks. */
const sine = (n) => Array.from({ length: n }, (_, k) => Math.sin((2 * Math.PI * k) / 100));

export function crossingIsBetweenSamples() {
  const store = storeOf([0, 0, 1, 1, 1]);
  near(new Trigger(WANTED).update(store, 10), 1.25, 1e-12, "rising");
  near(new Trigger({ ...WANTED, edge: "falling" }).update(storeOf([1, 1, 0, 0]), 10), 1.75, 1e-12, "falling");
  const at = new Trigger({ ...WANTED, level: 0.5 }).update(storeOf(sine(60)), 1000);
  // A chord between samples lies off a sine by its curvature: (pi/100)^2 / (2 cos 30) of a sample at most.
  near(at, 100 / 12, 5e-3, "sine through a half at a twelfth of its period");
}

export function eachEdgeHasItsOwnCrossings() {
  const values = sine(130);
  near(new Trigger({ ...WANTED, level: 0, edge: "rising" }).update(storeOf(values), 20), 100, 1e-5, "rising");
  near(new Trigger({ ...WANTED, level: 0, edge: "falling" }).update(storeOf(values), 20), 50, 1e-5, "falling");
  near(new Trigger({ ...WANTED, level: 0, edge: "either" }).update(storeOf(values), 20), 100, 1e-5, "either");
}

export function nextCrossingWaitsUntilTheLastIsShown() {
  // Crossings at about 4, 104, 204, ...; 0.9 of 150 ticks are shown after one.
  const at = new Trigger(WANTED).update(storeOf(sine(350)), 150);
  near(at, 200 + (Math.asin(0.25) / (2 * Math.PI)) * 100, 0.01, "every other one");
}

export function framesMakeNoDifference() {
  const values = sine(1000);
  const whole = new Trigger(WANTED).update(storeOf(values), 90);
  const store = storeOf([]);
  const trigger = new Trigger(WANTED);
  for (let k = 0; k < values.length; k += 7) {
    store.push(frameOf(values.slice(k, k + 7).map((value, j) => [k + j, value, 0])));
    trigger.update(store, 90);
  }
  same(trigger.at, whole, "crossing");
}

export function singleKeepsTheFirstUntilArmed() {
  const store = storeOf(sine(250));
  const trigger = new Trigger({ ...WANTED, mode: "single" });
  const first = trigger.update(store, 20);
  near(first, 4.02, 0.01, "first");
  same(trigger.state, "held", "state");
  trigger.arm(store);
  same([trigger.update(store, 20), trigger.state], [NaN, "armed"], "armed");
  store.push(
    frameOf(
      sine(420)
        .slice(250)
        .map((value, k) => [250 + k, value, 0]),
    ),
  );
  near(trigger.update(store, 20), 304.02, 0.01, "next");
}

export function modesDifferWithoutACrossing() {
  const store = storeOf(Array(500).fill(0));
  const rolls = (mode) => {
    const trigger = new Trigger({ ...WANTED, mode });
    trigger.update(store, 100);
    return trigger.rolls(store.last, 100);
  };
  same(["auto", "normal", "single"].map(rolls), [true, false, false], "rolls");
}

export function autoRollsAgainWhenNothingCrosses() {
  const store = storeOf([0, 1, ...Array(100).fill(1)]);
  const trigger = new Trigger(WANTED);
  trigger.update(store, 80);
  same(trigger.rolls(store.last, 80), false, "soon after");
  store.push(frameOf(Array.from({ length: 200 }, (_, k) => [102 + k, 1, 0])));
  trigger.update(store, 80);
  same(trigger.rolls(store.last, 80), true, "long after");
}

export function nothingCrossesInAGap() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(
    frameOf([
      [0, 0, 0],
      [1, 0, 0],
      [9, 1, 0],
      [10, 1, 0],
    ]),
  );
  same(new Trigger(WANTED).update(store, 4), NaN, "gap");
  same(new Trigger(WANTED).update(storeOf([0, NaN, 1]), 4), NaN, "NaN");
}

export function noiseAroundTheLevelIsOneCrossing() {
  // Falls slowly through the level with a ripple that rises through it again and again.
  const values = Array.from({ length: 400 }, (_, k) => 1 - k / 200 + 0.03 * (k % 2));
  same(new Trigger({ ...WANTED, level: 0 }, 0.05).update(storeOf(values), 4), NaN, "with noise allowed for");
  same(Number.isNaN(new Trigger({ ...WANTED, level: 0 }).update(storeOf(values), 4)), false, "without");
}

export function anotherRunBeginsAnew() {
  const store = storeOf([0, 1, 1]);
  const trigger = new Trigger({ ...WANTED, mode: "single" });
  trigger.update(store, 4);
  store.clear();
  store.push(
    frameOf([
      [0, 0, 0],
      [1, 0, 0],
    ]),
  );
  same(trigger.update(store, 4), NaN, "after clear");
}
