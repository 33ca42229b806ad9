import { between, Cursors, readings, valueAt } from "../page/cursors.js";
import { Store } from "../page/store.js";
import { check, frameOf, near, same, SIGNALS } from "./check.js";

function line(n) {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  for (let tick = 0; tick < n; tick += 4096) {
    const length = Math.min(4096, n - tick);
    store.push(frameOf(Array.from({ length }, (_, k) => [tick + k, tick + k, -2 * (tick + k)])));
  }
  return store;
}

export function readingsAreOfTheNearestSample() {
  const store = line(100);
  same(
    readings(store, ["psi_rad", "voltage_v"], 10.4, 49.6),
    [
      { key: "psi_rad", a: 10, b: 50, difference: 40 },
      { key: "voltage_v", a: -20, b: -100, difference: -80 },
    ],
    "readings",
  );
}

export function nothingIsReadInAGap() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(
    frameOf([
      [0, 1, 1],
      [1, 2, 2],
      [9, 3, 3],
    ]),
  );
  same(
    [1.4, 4, 8.6, 40, -3].map((tick) => valueAt(store, 0, tick)).map((v) => (Number.isNaN(v) ? "none" : v)),
    [2, "none", 3, "none", "none"],
    "values",
  );
}

export function oldReadingsAreOfTheBlock() {
  const store = line(2 ** 17 + 50_000);
  near(valueAt(store, 0, 20_000), 20_000, 16, "middle of the block's extremes");
}

export function timesAndFrequencies() {
  same(between(1000, 1250, 0.001), { time_s: 0.25, frequency_hz: 4 }, "quarter of a second");
  same(between(1250, 1000, 0.001), { time_s: -0.25, frequency_hz: 4 }, "backwards");
  same(Number.isNaN(between(7, 7, 0.001).frequency_hz), true, "together");
}

export function cursorsComeIntoSight() {
  const cursors = new Cursors();
  same(cursors.near(0, 1e9), -1, "hidden ones are not caught");
  cursors.toggle([-900, 0]);
  same([cursors.on, cursors.at], [true, [-600, -300]], "thirds");
  same([cursors.near(-590, 20), cursors.near(-310, 20), cursors.near(-450, 20)], [0, 1, -1], "caught");
  cursors.toggle([-900, 0]);
  cursors.toggle([-100, 0]);
  check(
    cursors.at.every((x) => x > -100 && x < 0),
    `found ${cursors.at}, needed them in sight`,
  );
}
