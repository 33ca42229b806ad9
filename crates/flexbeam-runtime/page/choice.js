// One word of a few: a law, a shape. Enters: a knob with words and the word in force. Leaves: the word that was chosen.

import { attribute, element, write } from "./element.js";

let made = 0;

export class Choice {
  /** @param {{knob: Object, commit: (word: string) => Promise<{ok: boolean, error?: string}>}} about knob as in hello, with words */
  constructor({ knob, commit }) {
    made += 1;
    const name = `choice-${made}`;
    this.commit = commit;
    this.why_fixed = knob.why_fixed;
    this.waiting = 0;
    this.radios = knob.words.map((word) => element("input", { type: "radio", name, value: word, onchange: () => this.#choose(word) }));
    const segments = this.radios.map((radio) => element("label", {}, radio, element("span", { text: sentence(radio.value) })));
    this.note = element("p", { class: "note", "aria-live": "polite" });
    this.element = element("fieldset", { class: "knob choice" }, element("legend", { text: knob.label }), element("div", { class: "segments" }, ...segments), this.note);
  }

  /** @param {{value: string, why: string|null}} now why: the reason why nothing may be changed */
  update({ value, why }) {
    this.value = value;
    const reason = this.why_fixed ?? why;
    this.element.disabled = reason !== null;
    attribute(this.element, "title", reason);
    if (this.why_fixed !== null) write(this.note, `Fixed: ${this.why_fixed}`);
    if (this.waiting === 0) this.#show();
  }

  #show() {
    this.radios.forEach((radio) => { radio.checked = radio.value === this.value; });
  }

  async #choose(word) {
    this.waiting += 1;
    const reply = await this.commit(word);
    this.waiting -= 1;
    write(this.note, reply.ok ? "" : reply.error);
    this.element.classList.toggle("refused", !reply.ok);
    if (reply.ok) this.value = word;
    if (this.waiting === 0) this.#show();
  }
}

function sentence(word) {
  return word.charAt(0).toUpperCase() + word.slice(1);
}
