import { element } from "../page/element.js";
import { RunState } from "../page/state.js";
import { TopBar } from "../page/top_bar.js";
import { same } from "./check.js";

function bar() {
  const acts = [];
  document.head.append(element("link", { rel: "icon" }));
  const root = element("header");
  document.body.replaceChildren(root);
  const act = async (what) => {
    acts.push(what);
    return { ok: true };
  };
  const top = new TopBar({ root, act, tell: () => {}, theme: { choice: "auto" }, help: () => {} });
  const state = new RunState();
  state.link = { stage: "open" };
  state.hello = { may: "steer", run: { controller: "c", project: null, port: "simulated", period_s: 0.001 } };
  state.phase = "running";
  top.update(state);
  return { button: top.emergency, acts };
}

const touch = (button) => button.dispatchEvent(new PointerEvent("pointerdown", { button: 0, bubbles: true }));
const click = (button, detail) => button.dispatchEvent(new MouseEvent("click", { detail, bubbles: true }));

export function aPressIsOneEmergencyStop() {
  const { button, acts } = bar();
  touch(button);
  same(acts, ["emergency"], "at the touch");
  click(button, 1);
  same(acts, ["emergency"], "and not again when it is let go");
  click(button, 0);
  same(acts.length, 2, "by key");
}

/** A finger that slides off makes no click; the key after it is another press. */
export function aTouchThatSlidOffDoesNotSwallowTheNextKey() {
  const { button, acts } = bar();
  touch(button);
  click(button, 0);
  same(acts, ["emergency", "emergency"], "touch, then Enter");
}
