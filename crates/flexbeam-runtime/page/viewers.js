// Who watches and who steers. Enters: the state. Leaves: take, ask, give, release; another name or token of this viewer.

import { attribute, element, write } from "./element.js";
import { keep } from "./identity.js";

export class Viewers {
  /**
   * @param {{control: HTMLElement, list: HTMLElement, sheets: HTMLElement, announcer: HTMLElement, request: (message: Object) => Promise<Object>, tell: (text: string) => void,
   *   rename: (name: string) => void, token: (token: string) => void}} about
   */
  constructor(about) {
    Object.assign(this, about);
    this.rows = element("ul", { class: "viewers" });
    this.why = element("p", { class: "why" });
    this.button = element("button", { type: "button", class: "main", onclick: () => this.#press() });
    this.name = element("input", { type: "text", maxlength: 24, autocomplete: "off", spellcheck: "false" });
    this.token_entry = element("input", { type: "text", autocomplete: "off", spellcheck: "false" });
    this.rename_form = form("Name of this viewer", this.name, "Rename", () => this.rename(this.name.value.trim()));
    this.token_form = form("Token", this.token_entry, "Enter", () => this.token(this.token_entry.value.trim()));
    this.control.append(this.why, this.button, this.token_form);
    this.list.append(element("h2", { text: "Who is here" }), this.rows, this.rename_form);
    this.ask = element("div", { class: "asking", role: "alertdialog", "aria-labelledby": "asking-words", hidden: true });
    this.words = element("p", { id: "asking-words" });
    this.left = element("p", { class: "left" });
    this.share = element("span", { class: "share", "aria-hidden": "true" });
    this.ask.append(this.words, this.left, this.share, element("div", { class: "pair" },
      element("button", { type: "button", class: "quiet", text: "Keep control", onclick: () => this.#give(false) }),
      element("button", { type: "button", class: "main", text: "Give control", onclick: () => this.#give(true) })));
    this.sheets.append(this.ask);
  }

  /** Shows a state; called as well twice a second, because time runs out. */
  update(state) {
    this.state = state;
    const { hello, viewers, in_control: holder, asking } = state;
    const me = hello?.viewer;
    const rows = viewers.map((viewer) => row(viewer, viewer.id === me, viewer.id === holder));
    const shown = JSON.stringify([viewers, holder, me]);
    if (shown !== this.shown) this.rows.replaceChildren(...rows);
    this.shown = shown;
    const seconds = asking ? Math.max(0, Math.ceil((state.asking_until_ms - performance.now()) / 1000)) : 0;
    this.#showMe(state, seconds);
    this.#showAsking(state, seconds);
    const name = viewers.find((viewer) => viewer.id === me)?.given;
    if (name && document.activeElement !== this.name) this.name.value = name;
  }

  #showMe(state, seconds) {
    const [words, label] = standing(state, seconds);
    write(this.why, words);
    write(this.button, label ?? "");
    this.button.hidden = label === null;
    attribute(this.button, "class", state.inControl ? "quiet" : "main");
    this.token_form.hidden = state.hello === null || state.hasToken || state.hasEnded;
  }

  #showAsking(state, seconds) {
    const wanted = state.isLive && state.inControl && state.asking !== null;
    const appears = wanted && this.ask.hidden;
    this.ask.hidden = !wanted;
    if (!wanted) return;
    write(this.words, `${state.asking.name} asks for control.`);
    write(this.left, `Without an answer it passes over in ${seconds} s.`);
    this.share.style.setProperty("--share", seconds / 15);
    if (appears) write(this.announcer, `${this.words.textContent} ${this.left.textContent}`);
  }

  async #press() {
    const type = this.state.inControl ? "release" : "take";
    keep("released", type === "release" ? "yes" : null);
    const reply = await this.request({ type });
    if (!reply.ok) this.tell(reply.error);
  }

  async #give(yes) {
    const reply = await this.request({ type: "give", to: this.state.asking.viewer, yes });
    if (!reply.ok) this.tell(reply.error);
  }
}

/** Where this viewer stands, and what it may do about it. */
function standing(state, seconds) {
  const { hello, asking, holder } = state;
  if (state.hasEnded) return ["The run is over.", null];
  if (hello === null || !state.isLive) return ["No connection.", null];
  if (!state.hasToken) return [`${state.whyNoStop} Or enter it here.`, null];
  if (state.inControl) return ["You are in control.", "Release control"];
  if (asking?.viewer === hello.viewer) return [`Asked ${holder ?? "the holder"} for control. Without an answer it is yours in ${seconds} s.`, null];
  if (holder === null) return ["Nobody is in control.", "Take control"];
  return asking ? [`${holder} is in control; ${asking.name} has asked.`, null] : [`${holder} is in control.`, "Ask for control"];
}

function row(viewer, isMe, isHolder) {
  const badge = (text, kind) => element("span", { class: `badge ${kind}`, text });
  return element("li", {}, element("span", { class: "who", text: viewer.name }), isMe ? badge("you", "me") : null,
    isHolder ? badge("in control", "holder") : viewer.may === "look" ? badge("looks", "looks") : null);
}

function form(label, input, action, onsubmit) {
  const send = (event) => {
    event.preventDefault();
    if (input.value.trim() !== "") onsubmit();
    input.blur();
  };
  return element("form", { class: "line", onsubmit: send }, element("label", {}, element("span", { text: label }), input), element("button", { type: "submit", class: "quiet", text: action }));
}
