// The bar that never leaves the screen: which run, its phase, its time, the link; Start, Stop and Emergency stop.
// Enters: the state. Leaves: requests to the run, the tab's title and icon.

import { PATHS, attribute, element, iconButton, write } from "./element.js";
import { runTime, withUnit } from "./number.js";

/** Phases in a word, with a mark that does not need its colour. */
const PHASES = {
  configured: { word: "Getting ready", mark: "…" },
  armed: { word: "Armed", mark: "○" },
  running: { word: "Running", mark: "●" },
  stopped: { word: "Stopped", mark: "■" },
  fault: { word: "Fault", mark: "▲" },
  lost: { word: "No connection", mark: "✕" },
  connecting: { word: "Connecting", mark: "…" },
};
const ICON_COLOURS = { configured: "#9aa8b5", armed: "#e2a93b", running: "#56c28c", stopped: "#9aa8b5", fault: "#ef5b5b", lost: "#ef5b5b", connecting: "#9aa8b5" };
/** Two presses of Esc within this time are an emergency stop [ms]. */
const TWICE_MS = 600;

/** The word under which the run stands now. */
export function standing(state) {
  if (state.hasEnded) return state.phase === "fault" || state.result?.cause === "fault" ? "fault" : "stopped";
  if (state.link.stage === "connecting") return "connecting";
  return state.isLive ? state.phase ?? "connecting" : "lost";
}

export class TopBar {
  /**
   * @param {{root: HTMLElement, act: (what: string) => Promise<{ok: boolean, error?: string}>, tell: (text: string) => void,
   *   theme: import("./theme.js").Theme, help: () => void}} about
   */
  constructor({ root, act, tell, theme, help }) {
    Object.assign(this, { act, tell, theme });
    this.name = element("h1", { text: "flexbeam" });
    this.about = element("p", { class: "about" });
    this.mark = element("span", { class: "mark", "aria-hidden": "true" });
    this.word = element("span");
    this.pill = element("p", { class: "pill", role: "status" }, this.mark, this.word);
    this.time = element("span");
    this.clock = element("p", { class: "time" }, element("span", { class: "unseen", text: "Run time " }), this.time);
    this.link = element("p", { class: "link" });
    this.start = element("button", { type: "button", class: "start", text: "Start", onclick: () => this.#press("start", this.start) });
    this.stop = element("button", { type: "button", class: "stop", text: "Stop", onclick: () => this.#press("stop", this.stop) });
    this.emergency = element("button", { type: "button", class: "emergency", "aria-keyshortcuts": "Control+.", text: "Emergency stop" });
    this.themes = iconButton("", PATHS.auto, () => { theme.next(); this.#showTheme(); });
    this.#showTheme();
    this.#armEmergency();
    root.append(
      element("div", { class: "name" }, beam(), element("div", {}, this.name, this.about)),
      this.pill, this.clock, this.link,
      element("div", { class: "tools" }, this.themes, iconButton("Help and keys", PATHS.help, help, { "aria-keyshortcuts": "?" })),
      element("div", { class: "actions", role: "group", "aria-label": "Run" }, this.start, this.stop, this.emergency),
    );
  }

  /** Shows a state. */
  update(state) {
    this.state = state;
    const now = standing(state);
    const run = state.hello?.run;
    write(this.name, state.name);
    write(this.about, run ? [run.project ? run.controller : null, run.port, withUnit(String(run.period_s * 1000), "ms")].filter(Boolean).join(" · ") : "");
    write(this.mark, PHASES[now].mark);
    write(this.word, PHASES[now].word);
    this.pill.dataset.phase = now;
    write(this.time, runTime(state.time_s));
    this.clock.classList.toggle("stale", !state.isLive && !state.hasEnded);
    write(this.link, linkWords(state));
    this.link.dataset.stage = state.link.stage;
    this.#lock(this.start, state.whyNoStart);
    this.#lock(this.stop, state.whyNoStop);
    attribute(this.emergency, "aria-disabled", state.whyNoStop === null ? null : "true");
    attribute(this.emergency, "title", state.whyNoStop ?? "Acts on the first press. Keys: Ctrl+. or Esc twice");
    this.#showTab(now, state.name);
  }

  #lock(button, why) {
    button.disabled = why !== null;
    attribute(button, "title", why);
  }

  async #press(what, button) {
    button.disabled = true;
    const reply = await this.act(what);
    if (!reply.ok) this.tell(`${button.textContent}: ${reply.error}`);
    if (this.state) this.update(this.state);
  }

  /** The emergency stop acts when it is touched, not when it is let go; a click without a touch before it comes from a key. */
  #armEmergency() {
    let touched = false;
    this.emergency.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      touched = true;
      this.#stopNow();
    });
    this.emergency.addEventListener("click", (event) => {
      // A touch that slid off made no click; of a key it is detail 0.
      if (!touched || event.detail === 0) this.#stopNow();
      touched = false;
    });
    let escaped_ms = -Infinity;
    addEventListener("keydown", (event) => {
      if (event.repeat) return;
      if (event.ctrlKey && event.key === ".") return this.#stopNow();
      if (event.key !== "Escape" || event.defaultPrevented) return;
      const twice = event.timeStamp - escaped_ms < TWICE_MS;
      escaped_ms = twice ? -Infinity : event.timeStamp;
      if (twice) this.#stopNow();
    });
  }

  async #stopNow() {
    const why = this.state ? this.state.whyNoStop : "No connection yet.";
    if (why !== null) return this.tell(`Emergency stop did nothing. ${why} To stop a rig that still moves: the terminal, or the rig's own switch.`);
    const reply = await this.act("emergency");
    if (!reply.ok) this.tell(`Emergency stop: ${reply.error} To stop the rig: the terminal, or the rig's own switch.`);
  }

  #showTheme() {
    const { choice } = this.theme;
    this.themes.querySelector("path").setAttribute("d", PATHS[choice]);
    attribute(this.themes, "aria-label", `Theme: ${choice}`);
    attribute(this.themes, "title", `Theme: ${choice}`);
  }

  #showTab(now, name) {
    const title = `${PHASES[now].mark} ${PHASES[now].word} \u2013 ${name}`;
    if (document.title === title) return;
    document.title = title;
    document.querySelector('link[rel="icon"]').href = icon(ICON_COLOURS[now]);
  }
}

function linkWords(state) {
  const { stage } = state.link;
  if (stage === "open") return "Connected";
  return { connecting: "Connecting", lost: "Connection lost", over: "Run over", refused: "Refused" }[stage];
}

/** The beam, bent; the hub takes the text's colour. */
function beam() {
  const made = element("span", { class: "beam", "aria-hidden": "true" });
  return made;
}

function icon(colour) {
  const beamPath = "M8 25 C9 15 14 10 24 7";
  const svg = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><circle cx="16" cy="16" r="15" fill="#10151b"/><path d="${beamPath}" fill="none" stroke="#e6ebf0" stroke-width="3" stroke-linecap="round"/><circle cx="21" cy="21" r="8" fill="${colour}"/></svg>`;
  return `data:image/svg+xml,${encodeURIComponent(svg)}`;
}
