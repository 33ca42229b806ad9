import { Events } from "../page/events.js";
import { same } from "./check.js";

const wait = (ms) => new Promise((done) => setTimeout(done, ms));

function eventsInThePage() {
  const [root, announcer] = [document.createElement("section"), document.createElement("p")];
  document.body.replaceChildren(root, announcer);
  const events = new Events({ root, announcer });
  events.clear();
  return { events, root, announcer };
}

export function theNewestStandsOnTopAndTheListIsBounded() {
  const { events, root } = eventsInThePage();
  for (let k = 0; k < 2000; k += 1) events.add({ tick: k, time_s: k, kind: "warning", text: `event ${k}` });
  const rows = root.querySelectorAll("li");
  same([rows.length, rows[0].querySelector("p").textContent], [500, "event 1999"], "the newest 500");
}

export async function onlyWhatIsNewIsReadAloud() {
  const { events, announcer } = eventsInThePage();
  events.add({ tick: 0, time_s: 0, kind: "armed", text: "long ago" });
  same(announcer.textContent, "", "the past");
  await wait(1050);
  events.add({ tick: 9, time_s: 0.009, kind: "fault", text: "now" });
  same(announcer.textContent, "now", "the present");
}

export function whatAnEventSaysIsTextAndNothingElse() {
  const { events, root } = eventsInThePage();
  events.add({ tick: 0, time_s: 0, kind: "control", text: "viewer <b>x</b>\nhint: none" });
  same([root.querySelectorAll("b").length, root.querySelector("li p").textContent], [0, "viewer <b>x</b>hint: none"], "no markup");
}
