// The run's log. Enters: events as they come. Leaves: a list, the newest on top, and each new one read aloud once.

import { element, write } from "./element.js";
import { runTime } from "./number.js";

/** Events that are kept; the recording has all of them. */
const MOST = 500;
/** For so long after a greeting events are those of the past, which nobody wants read aloud [ms]. */
const PAST_MS = 1000;
const MARKS = { armed: "○", started: "●", stopped: "■", fault: "▲", warning: "!", override: "✎", control: "✎", lost: "…" };

export class Events {
  /** @param {{root: HTMLElement, announcer: HTMLElement}} about */
  constructor({ root, announcer }) {
    this.announcer = announcer;
    this.list = element("ol", { class: "log", tabindex: 0, "aria-label": "Events, the newest first" });
    root.replaceChildren(element("h2", { text: "Events" }), this.list);
  }

  /** All of them are told again by every connection. */
  clear() {
    this.list.replaceChildren();
    this.quiet_until_ms = performance.now() + PAST_MS;
  }

  /** Adds one. */
  add({ time_s, kind, text }) {
    const [first, ...rest] = text.split("\n");
    this.list.prepend(element("li", { class: kind },
      element("span", { class: "mark", "aria-hidden": "true", text: MARKS[kind] ?? "·" }),
      element("time", { text: runTime(time_s) }),
      element("p", {}, first, ...rest.map((line) => element("small", { text: line })))));
    while (this.list.children.length > MOST) this.list.lastChild.remove();
    if (performance.now() > this.quiet_until_ms) write(this.announcer, text);
  }
}
