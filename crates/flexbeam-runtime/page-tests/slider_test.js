import { Slider } from "../page/slider.js";
import { check, near, same } from "./check.js";

const DEGREES = 180 / Math.PI;
const KNOB = { key: "reference.amplitude_rad", label: "Amplitude", group: "Reference", unit: "°", factor: DEGREES, low: -Math.PI, high: Math.PI, step: 0.5 / DEGREES, decimals: 2, words: null, why_fixed: null };
const wait = (ms) => new Promise((done) => setTimeout(done, ms));

/** A slider at a value, in the page, with a run that answers after `delay_ms`. */
function sliderAt(value, { knob = KNOB, answer = () => ({ ok: true }), delay_ms = 0, ends } = {}) {
  const sent = [];
  const commit = async (si) => {
    sent.push([performance.now(), si]);
    await wait(delay_ms);
    const reply = answer(si);
    if (reply.ok) slider.update({ value: si, why: null });
    return reply;
  };
  const slider = new Slider({ knob, ends, commit });
  document.body.replaceChildren(slider.element);
  slider.update({ value, why: null });
  return { slider, sent, values: () => sent.map(([, si]) => si) };
}

function drag(slider, shown) {
  slider.range.value = shown;
  slider.range.dispatchEvent(new Event("input"));
}

function type(slider, text, key = "Enter") {
  slider.entry.focus();
  slider.entry.value = text;
  slider.entry.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
}

export async function aDragSendsAtMostTwentyASecondAndAlwaysTheLast() {
  const { slider, sent } = sliderAt(0);
  const began = performance.now();
  let shown = 0;
  while (performance.now() - began < 1000) {
    shown += 0.5;
    drag(slider, shown);
    await wait(4);
  }
  slider.range.dispatchEvent(new Event("change"));
  await wait(120);
  check(sent.length <= 22 && sent.length >= 10, `${sent.length} in a second`);
  const gaps = sent.slice(1).map(([at], k) => at - sent[k][0]);
  check(Math.min(...gaps) > 45, `two within ${Math.min(...gaps)} ms`);
  near(sent.at(-1)[1] * DEGREES, Number(slider.entry.value), 1e-9, "the last one");
}

export async function aRefusedValueGoesBackWithTheReason() {
  const { slider, values } = sliderAt(0.5, { answer: () => ({ ok: false, error: "found 99, needed less" }) });
  const before = slider.entry.value;
  type(slider, "99");
  await wait(20);
  near(values()[0] * DEGREES, 99, 1e-9, "sent");
  same([slider.entry.value, slider.note.textContent], [before, "found 99, needed less"], "entry and note");
  near(Number(slider.range.value), 0.5 * DEGREES, 1e-6, "slider");
}

export async function nothingMovesBackUnderTheHand() {
  const { slider } = sliderAt(0, { delay_ms: 80 });
  drag(slider, 10);
  await wait(60);
  drag(slider, 20);
  slider.update({ value: 10 / DEGREES, why: null });
  near(Number(slider.range.value), 20, 1e-9, "while it is dragged");
  slider.range.dispatchEvent(new Event("change"));
  await wait(300);
  near(Number(slider.range.value), 20, 1e-9, "at the end");
}

/** Steps of a slider by its keys. */
function press(slider, times) {
  for (let k = 0; k < times; k += 1) slider.range.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", cancelable: true }));
}

export async function aStateBeforeTheLastSendingTakesNoStepBack() {
  const { slider, values } = sliderAt(0);
  press(slider, 1);
  await wait(25);
  press(slider, 1);
  slider.update({ value: 0.5 / DEGREES, why: null });
  slider.update({ value: 0.25 / DEGREES, why: null });
  near(Number(slider.entry.value), 1, 1e-9, "shown");
  press(slider, 1);
  await wait(120);
  near(values().at(-1) * DEGREES, 1.5, 1e-9, "three steps of half a degree");
}

export async function aReplyBeforeItsStateTakesNoStepBack() {
  let told;
  const slider = new Slider({ knob: KNOB, commit: async (si) => (told = { ok: true, si }) });
  document.body.replaceChildren(slider.element);
  slider.update({ value: 0, why: null });
  press(slider, 1);
  await wait(80);
  near(Number(slider.entry.value), 0.5, 1e-9, "after the reply");
  press(slider, 1);
  await wait(80);
  near(told.si * DEGREES, 1, 1e-9, "two steps of half a degree");
}

export async function whatIsTypedIsSentToTheLastDigit() {
  const { slider, values } = sliderAt(0);
  type(slider, "12,3456");
  await wait(20);
  near(values()[0] * DEGREES, 12.3456, 1e-12, "sent");
}

export async function escGivesAnEntryUp() {
  const { slider, values } = sliderAt(0.5);
  const before = slider.entry.value;
  type(slider, "77", "Escape");
  slider.entry.blur();
  await wait(20);
  same([slider.entry.value, values()], [before, []], "nothing was sent");
}

export async function whatIsNoNumberIsNotSent() {
  const { slider, values } = sliderAt(0.5);
  type(slider, "fast");
  await wait(20);
  same(values(), [], "sent");
  check(slider.note.textContent.includes("“fast”") && slider.note.textContent.includes("°"), slider.note.textContent);
}

export async function theEndIsTheKnobsOwnEndToTheLastBit() {
  const { slider, values } = sliderAt(0);
  drag(slider, slider.range.max);
  await wait(80);
  same(values().at(-1), Math.PI, "upper end");
}

export function endsFollowTheValueWhereTheKnobHasNone() {
  const period = { ...KNOB, label: "Period", unit: "s", factor: 1, low: 5e-324, high: null, step: 0.1, decimals: 2 };
  const { slider } = sliderAt(4, { knob: period });
  const ends = () => [Number(slider.range.min), Number(slider.range.max)];
  same(ends(), [0.01, 20], "at 4 s");
  slider.update({ value: 19.9, why: null });
  same(ends(), [0.01, 20], "just below the end");
  slider.update({ value: 20, why: null });
  same(ends(), [0.01, 100], "an end that is reached moves on");
}

export function aFarEndComesNear() {
  const eps = { ...KNOB, unit: "V", factor: 1, low: 0, high: 10, step: 0.0005, decimals: 4 };
  const { slider } = sliderAt(0.01, { knob: eps });
  near(Number(slider.range.max), 0.05, 1e-9, "at 0.01 V of 10 V");
  same(sliderAt(0.01, { knob: eps, ends: [0, 1] }).slider.range.max, "1", "the panel's own ends come first");
}

export function anInfiniteLimitIsShownAsSuch() {
  const { slider } = sliderAt(Infinity, { knob: { ...KNOB, low: 0, high: null } });
  same(slider.entry.value, "∞", "entry");
  check(Number(slider.range.max) > 0 && Number.isFinite(Number(slider.range.max)), slider.range.max);
}

export function whatIsFixedSaysWhy() {
  const { slider } = sliderAt(0, { knob: { ...KNOB, why_fixed: "found at homing" } });
  same([slider.entry.disabled, slider.range.disabled, slider.note.textContent], [true, true, "Fixed: found at homing"], "fixed");
}
