import { ScopeCard } from "../page/scope_card.js";
import { Store } from "../page/store.js";
import { check, frameOf, laidOut, near, same, SIGNALS } from "./check.js";

const SCOPE = { title: "Tip", kind: "time", signals: ["psi_rad", "voltage_v"], span_s: 2 };
const DEG = 180 / Math.PI;
let now_ms = 1000;

/** Rows [begin, end) of a wave of half a hertz. */
const rows = (begin, end) =>
  Array.from({ length: end - begin }, (_, k) => [begin + k, 0.26 * Math.sin(((begin + k) * Math.PI) / 1000), 3]);

async function cardOf(scope = SCOPE, ticks = 8000) {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  if (ticks > 0) store.push(frameOf(rows(0, ticks)));
  const saved = [];
  const card = new ScopeCard({
    store,
    signals: SIGNALS,
    scope,
    period_s: 0.001,
    onchange: (c) => saved.push(c.scope),
    onremove: (c) => c.destroy(),
    onmove() {},
  });
  card.element.style.cssText = "width: 900px; height: 460px";
  document.body.replaceChildren(card.element);
  await laidOut(card);
  frame(card);
  return { card, store, saved };
}

/** One animation frame, far enough from the last for the numbers to follow. */
function frame(card, after_ms = 120) {
  now_ms += after_ms;
  card.draw(now_ms);
}

const press = (card, key, more = {}) =>
  card.plot.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));

/** A pointer at shares of the plot. */
function point(card, type, x, y, more = {}) {
  const box = card.plot.getBoundingClientRect();
  const { left, top, width, height, unit } = card.frame;
  const at = { clientX: box.left + (left + x * width) / unit, clientY: box.top + (top + (1 - y) * height) / unit };
  card.plot.setPointerCapture = () => {};
  card.plot.dispatchEvent(
    new PointerEvent(type, { pointerId: 1, pointerType: "mouse", button: 0, bubbles: true, ...at, ...more }),
  );
}

export async function rollsBehindTheNewestAndThenStandsStill() {
  const { card, store } = await cardOf();
  near(card.chart.anchor, store.last, 1, "right end");
  store.push(frameOf(rows(8000, 8030)));
  frame(card, 16);
  check(card.chart.anchor > 7999 && card.chart.anchor < store.last, `found the right end at ${card.chart.anchor}`);
  for (let k = 0; k < 200; k += 1) frame(card, 16);
  check(card.chart.anchor <= store.last, "never ahead of the data");
  const [begin, end] = card.chart.axes.x;
  near(end - begin, 2000, 3, "span");
}

export async function rollingIsEven() {
  const { card, store } = await cardOf();
  const steps = [];
  let [before, tick] = [card.chart.anchor, 8000];
  for (let k = 0; k < 300; k += 1) {
    // Two frames of samples for three of the screen, each a little late or early.
    const due = 8000 + Math.floor(k * 16.7) + (k % 5) * 4;
    if (k % 2 === 0 && due > tick) {
      store.push(frameOf(rows(tick, due)));
      tick = due;
    }
    frame(card, 16.7);
    if (k > 100) steps.push(card.chart.anchor - before);
    before = card.chart.anchor;
  }
  check(
    Math.min(...steps) > 10 && Math.max(...steps) < 24,
    `found steps of ${Math.min(...steps)} to ${Math.max(...steps)} ticks, needed about 16.7`,
  );
}

export async function pausedPlotStandsStillWhileTheStoreGoesOn() {
  const { card, store } = await cardOf();
  card.pause(true);
  const before = card.chart.anchor;
  store.push(frameOf(rows(8000, 12_000)));
  frame(card);
  same(card.chart.anchor, before, "anchor");
  same(card.chart.newest, 7999, "newest that is shown");
  card.pause(false);
  frame(card);
  near(card.chart.anchor, 11_999, 1, "goes on at the newest");
}

export async function emptyAndClearedStoresAreDrawn() {
  for (const kind of ["time", "xy", "spectrum"]) {
    const { card, store } = await cardOf({ ...SCOPE, kind }, 0);
    store.push(frameOf(rows(0, 500)));
    frame(card, 400);
    store.clear();
    frame(card, 400);
    store.push(frameOf(rows(0, 3000)));
    frame(card, 400);
    check(
      card.chart.axes.x.every(Number.isFinite) && card.chart.axes.y.flat().every(Number.isFinite),
      `${kind}: found ${JSON.stringify(card.chart.axes)}`,
    );
  }
}

export async function triggerStandsAtTheCrossing() {
  const trigger = { signal: "psi_rad", edge: "rising", level: 0.13, mode: "normal", before: 0.25 };
  const { card, saved } = await cardOf({ ...SCOPE, span_s: 1, trigger });
  near(card.chart.anchor % 2000, 1000 / 6, 0.1, "crossing at asin(1/2)");
  near(card.chart.axes.x[0], -250, 2, "a quarter before");
  near(card.chart.levelAt(card.frame, card.chart.levelY(card.frame)), 0.13, 1e-9, "level of the mark");
  const share = 1 - (card.chart.levelY(card.frame) - card.frame.top) / card.frame.height;
  point(card, "pointerdown", 0.01, share);
  point(card, "pointermove", 0.01, share + 0.1);
  same(saved.length, 0, "not saved while it moves");
  point(card, "pointerup", 0.01, share + 0.1);
  same(saved.length, 1, "saved when let go");
  const [low, high] = card.chart.axes.y[0];
  near(saved[0].trigger.level, 0.13 + (0.1 * (high - low)) / DEG, 1e-3, "level");
}

export async function wheelBoxAndPanChooseTheView() {
  const { card } = await cardOf();
  card.plot.dispatchEvent(new WheelEvent("wheel", { deltaY: -400, cancelable: true, clientX: 400, clientY: 200 }));
  frame(card);
  const [low, high] = card.chart.axes.x;
  near(high - low, 2000 * Math.exp(-0.72), 5, "closer");
  same([card.paused, Math.abs(high) < 2], [false, true], "still rolling at its right end");
  card.plot.dispatchEvent(new MouseEvent("dblclick"));
  frame(card);
  near(card.chart.axes.x[1] - card.chart.axes.x[0], 2000, 3, "back");
  const before = structuredClone(card.chart.axes);
  point(card, "pointerdown", 0.25, 0.5);
  point(card, "pointermove", 0.5, 0.75);
  point(card, "pointerup", 0.5, 0.75);
  frame(card);
  same(card.paused, true, "a box stops the roll");
  near(card.chart.axes.x[0], before.x[0] + 500, 3, "left");
  near(card.chart.axes.x[1], before.x[0] + 1000, 3, "right");
  const [bottom, top] = before.y[0];
  near(card.chart.axes.y[0][1], bottom + 0.75 * (top - bottom), 0.3, "top");
  const left = card.chart.axes.x[0];
  point(card, "pointerdown", 0.5, 0.5, { altKey: true });
  point(card, "pointermove", 0.6, 0.5, { altKey: true });
  point(card, "pointerup", 0.6, 0.5, { altKey: true });
  frame(card);
  near(card.chart.axes.x[0], left - 50, 3, "pan");
}

export async function keysDoWhatTheMouseDoes() {
  const { card } = await cardOf();
  press(card, " ");
  same(card.paused, true, "space pauses");
  press(card, "c");
  frame(card);
  same([card.chart.cursors.on, card.readings.element.hidden], [true, false], "c shows cursors and readings");
  const [a] = card.chart.cursors.at;
  press(card, "ArrowRight");
  check(card.chart.cursors.at[0] > a, "an arrow moves cursor A");
  press(card, "c");
  press(card, "+");
  frame(card);
  check(card.chart.axes.x[1] - card.chart.axes.x[0] < 1700, "plus zooms");
  press(card, "z");
  press(card, "t");
  same(card.scope.trigger.signal, "psi_rad", "t sets a trigger");
  press(card, "t");
  same("trigger" in card.scope, false, "and takes it away");
}

export async function cursorTableReadsTheSignals() {
  const { card } = await cardOf();
  card.pause(true);
  card.toggleCursors();
  card.chart.cursors.at = [5500 - card.chart.anchor, 7500 - card.chart.anchor];
  frame(card);
  const text = [...card.readings.rows.rows].map((row) => [...row.cells].map((cell) => cell.textContent));
  same(text[0], ["Time", "5.5000\u2009s", "7.5000\u2009s", "2.0000\u2009s"], "times");
  same(text[1], ["Tip angle", "\u221214.90\u00b0", "\u221214.90\u00b0", "0.00\u00b0"], "angles");
  same(card.readings.note.textContent, "1/\u0394t = 0.500\u2009Hz", "frequency");
}

export async function hiddenSignalsAreNeitherDrawnNorFitted() {
  const { card } = await cardOf();
  const right = card.chart.axes.y[1];
  card.legend.element.children[0].click();
  frame(card);
  same(card.hidden.has("psi_rad"), true, "hidden");
  same(card.chart.looks(card.frame, card.hidden).length, 1, "traces");
  same(card.chart.axes.y.length, 2, "axes stay");
  check(right[0] <= 3 && right[1] >= 3, `found ${right}`);
}

export async function unknownSignalsAndThirdUnitsAreNamed() {
  const { card } = await cardOf({ ...SCOPE, signals: ["gone_rad", "psi_rad"] });
  same(card.gone.textContent, "This run has no gone_rad.", "gone");
  same(card.scope.signals, ["gone_rad", "psi_rad"], "but kept");
}

export async function spectrumFindsTheWave() {
  const { card } = await cardOf({ ...SCOPE, kind: "spectrum", span_s: 8 });
  const { f_hz, amplitude } = card.chart.peakOf(SIGNALS[0]);
  near(parseFloat(f_hz), 0.5, 0.01, "frequency");
  near(parseFloat(amplitude), 0.26 * DEG, 0.2, "amplitude");
}

export async function axesOfASpectrumAreSaved() {
  const { card, saved } = await cardOf({ ...SCOPE, kind: "spectrum", span_s: 8 });
  const words = () => [...card.bar.element.querySelectorAll(".scope-word")];
  words().forEach((word) => word.click());
  same([card.scope.amplitude, card.scope.frequency], ["decibels", "linear"], "of the card");
  same([saved.at(-1).amplitude, saved.at(-1).frequency], ["decibels", "linear"], "told");
  const again = (await cardOf(card.scope)).card;
  same([again.chart.decibels, again.chart.logarithmic], [true, false], "of a card made of it");
}

/** One plot that cannot be drawn must not stop the others, nor the page. */
export async function aPlotThatFailsIsAloneWithIt() {
  const { Layout } = await import("../page/layout.js");
  const drawn = [];
  const failing = { draw() { throw new RangeError("no such thing"); }, fail: (error) => drawn.push(error.message) };
  Layout.prototype.draw.call({ scopeCards: [failing, { draw: (now) => drawn.push(now) }] }, 5);
  same(drawn, ["no such thing", 5], "drawn");
}
