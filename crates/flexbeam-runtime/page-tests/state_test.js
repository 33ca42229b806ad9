import { RunState } from "../page/state.js";
import { check, same } from "./check.js";

const hello = (more = {}) => ({ type: "hello", viewer: 3, may: "steer", token: "good", run: { controller: "controller.toml", project: null, start_unix_ns: "17" }, knobs: [], ...more });
const viewers = (in_control, asking = null) => ({ type: "viewers", viewers: [{ id: 3, name: "laptop" }, { id: 5, name: "tablet" }], in_control, asking });

function stateOf(...messages) {
  const state = new RunState();
  state.link = { stage: "open", why: "", since_ms: 0, retry_ms: null };
  messages.forEach((message) => state.apply(message));
  return state;
}

const running = { type: "state", phase: "running", time_s: 1, revision: 0, values: {}, timing: null };

export function onlyTheViewerInControlChangesAnything() {
  same(stateOf(hello(), running, viewers(3)).whyLocked, null, "in control");
  same(stateOf(hello(), running, viewers(5)).whyLocked, "tablet is in control.", "another one is");
  check(stateOf(hello(), running, viewers(null)).whyLocked.startsWith("Nobody"), "nobody is");
  check(stateOf(hello(), running, viewers(9)).whyLocked.includes("lost its connection"), "a seat that is kept");
}

export function stopNeedsTheTokenAlone() {
  same(stateOf(hello(), running, viewers(5)).whyNoStop, null, "with the token");
  check(stateOf(hello({ may: "look", token: "none" }), running).whyNoStop.includes("no token"), "without");
  check(stateOf(hello({ may: "look", token: "wrong" }), running).whyNoStop.includes("another run"), "with a wrong one");
}

export function nothingWorksWithoutAConnection() {
  const state = stateOf(hello(), running, viewers(3));
  state.link = { ...state.link, stage: "lost" };
  same([state.isLive, state.whyNoStop === null, state.whyNoStart === null], [false, false, false], "lost");
}

export function anEndIsAnEnd() {
  for (const phase of ["stopped", "fault"]) {
    const state = stateOf(hello(), { ...running, phase }, viewers(3));
    check(state.hasEnded && state.whyNoStop.includes("0 V") && state.whyLocked !== null, phase);
  }
  const over = stateOf(hello(), running, { type: "over", result: { cause: "asked" } });
  check(over.hasEnded, "over");
}

export function startIsForARunThatIsArmed() {
  const start = (phase) => stateOf(hello(), { ...running, phase }, viewers(3)).whyNoStart;
  same([start("armed"), start("running") === null, start("configured") === null], [null, false, false], "phases");
}

export function anotherRunIsKnownByItsStart() {
  const state = stateOf(hello());
  const other = hello();
  other.run = { ...other.run, start_unix_ns: "18" };
  same([state.isAnother(hello()), state.isAnother(other), new RunState().isAnother(other)], [false, true, false], "another run");
  const early = hello();
  early.run = { ...early.run, start_unix_ns: "0" };
  same([stateOf(early).wasArmed, state.wasArmed], [false, true], "armed");
}

export function namesakesAreToldApart() {
  const state = stateOf(hello(), { type: "viewers", viewers: [{ id: 3, name: "phone" }, { id: 5, name: "phone" }, { id: 6, name: "laptop" }], in_control: 5, asking: { viewer: 3, name: "phone", seconds_left: 9 } });
  same(state.viewers.map(({ name }) => name), ["phone 3", "phone 5", "laptop"], "names");
  same([state.holder, state.asking.name], ["phone 5", "phone 3"], "holder and asker");
}
