// One number that may be changed: entry, slider, limits. Enters: a knob and its value in force (SI). Leaves: new values, at most
// twenty a second while it is dragged and always the last one. The run judges: what it refuses goes back, with its reason.

import { attribute, element, write } from "./element.js";
import { fixed, roundUp, typed, withUnit } from "./number.js";

const EVERY_MS = 50;
/** Where a knob has no end, or one far away, the slider reaches this many times the value. */
const REACH = 4;
/** A slider that reaches so far already is left as it is, so that it does not change under the hand. */
const KEPT = [1.001, 20];
/** The least positive number: a knob that takes every number above zero has it as its low end. */
const LEAST = 5e-324;
/** And at least this many steps of the knob. */
const STEPS = 100;
/** Places at which a dragged slider stops, at least. */
const PLACES = 200;

const isFloor = (low) => low === 0 || low === LEAST;

let made = 0;

export class Slider {
  /**
   * @param {{knob: Object, ends: number[]|undefined, commit: (value: number) => Promise<{ok: boolean, error?: string}>}} about
   *   knob as in hello; ends: narrower ends of the slider (SI); commit: takes SI
   */
  constructor({ knob, ends, commit }) {
    Object.assign(this, { knob, ends, commit });
    this.value = NaN;
    this.waiting = 0;
    this.isDragged = false;
    this.sent_ms = -Infinity;
    this.#build();
  }

  #build() {
    made += 1;
    const { label, unit } = this.knob;
    const name = unit ? `${label} in ${unit}` : label;
    const [id, note] = [`knob-${made}`, `knob-note-${made}`];
    this.entry = element("input", { id, type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", "aria-label": name, "aria-describedby": note, onfocus: () => this.entry.select(), onkeydown: (event) => this.#entryKey(event), onblur: () => this.#enter() });
    this.range = element("input", { type: "range", step: "any", "aria-label": name, "aria-describedby": note, oninput: () => this.#drag(), onchange: () => { this.isDragged = false; this.#show(); }, onkeydown: (event) => this.#rangeKey(event) });
    this.low = element("span");
    this.high = element("span");
    this.note = element("p", { class: "note", id: note, "aria-live": "polite" });
    this.element = element("div", { class: "knob" },
      element("label", { for: id, text: label }),
      element("span", { class: "entry" }, this.entry, element("span", { class: "unit", "aria-hidden": "true", text: unit })),
      this.range,
      element("p", { class: "ends", "aria-hidden": "true" }, this.low, this.high),
      this.note);
  }

  /**
   * Shows the value in force and whether it may be changed.
   * @param {{value: number, why: string|null}} now value in SI; why: the reason why nothing may be changed
   */
  update({ value, why }) {
    const { knob } = this;
    const isLocked = why !== null || knob.why_fixed !== null;
    this.entry.disabled = this.range.disabled = isLocked;
    attribute(this.element, "title", knob.why_fixed ?? why);
    this.element.classList.toggle("fixed", knob.why_fixed !== null);
    if (knob.why_fixed !== null) write(this.note, `Fixed: ${knob.why_fixed}`);
    if (Object.is(value, this.value)) return;
    this.value = value;
    this.#show();
  }

  /** Writes the value in force where nobody is changing it. */
  #show() {
    if (this.isDragged || this.waiting > 0 || this.turn) return;
    const shown = this.value * this.knob.factor;
    this.#stretch(shown);
    this.range.value = shown;
    if (document.activeElement !== this.entry || !this.#isEdited) this.entry.value = this.#text(shown);
    this.#describe(shown);
  }

  get #isEdited() {
    return this.entry.value !== this.written;
  }

  #text(shown) {
    this.written = fixed(shown, this.knob.decimals);
    return this.written;
  }

  #describe(shown) {
    const [low, high] = [Number(this.range.min), Number(this.range.max)];
    attribute(this.range, "aria-valuetext", withUnit(fixed(shown, this.knob.decimals), this.knob.unit));
    this.range.style.setProperty("--share", Math.max(0, Math.min(1, (shown - low) / (high - low))));
    this.range.style.setProperty("--zero", Math.max(0, Math.min(1, -low / (high - low))));
  }

  /** Ends of the slider: the panel's, the knob's, or where those are far, some way around the value: an end that is reached moves on. */
  #stretch(shown) {
    const { factor, decimals, step } = this.knob;
    const [low, high] = this.ends ?? [this.knob.low, this.knob.high];
    const size = Number.isFinite(shown) ? Math.abs(shown) : 10 ** -decimals * PLACES * PLACES;
    const around = roundUp(Math.max(size * REACH, 10 ** -decimals * PLACES, step * factor * STEPS));
    const isFar = high === null || (this.ends === undefined && isFloor(low) && size > 0 && around * REACH < high * factor);
    const isKept = this.isFar && this.top >= size * KEPT[0] && this.top <= Math.max(size * KEPT[1], around);
    const top = !isFar ? high * factor : isKept ? this.top : around;
    const bottom = low === null ? -top : low === LEAST ? 10 ** -decimals : low * factor;
    Object.assign(this, { isFar, top });
    this.range.min = bottom;
    this.range.max = top;
    this.step = Math.max(10 ** -decimals, roundUp((top - bottom) / PLACES / 2.5));
    write(this.low, this.#end(bottom, low === null));
    write(this.high, this.#end(top, isFar));
  }

  #end(shown, isOpen) {
    const plain = Number(shown.toFixed(this.knob.decimals));
    return withUnit(fixed(plain, String(Math.abs(plain)).split(".")[1]?.length ?? 0), this.knob.unit) + (isOpen ? " …" : "");
  }

  #drag() {
    this.isDragged = true;
    const raw = Number(this.range.value);
    const [low, high] = [Number(this.range.min), Number(this.range.max)];
    const even = Math.round(raw / this.step) * this.step;
    this.#wish(raw === low || raw === high ? raw : Math.max(low, Math.min(high, even)));
  }

  /** Shows a wished value (shown unit) and sends it, now or when its turn comes. */
  #wish(shown) {
    const { decimals } = this.knob;
    this.entry.value = this.#text(shown);
    this.#describe(shown);
    const isEnd = shown === Number(this.range.min) || shown === Number(this.range.max);
    this.wished = isEnd ? shown : Number(shown.toFixed(decimals));
    if (this.turn) return;
    const wait = Math.max(0, this.sent_ms + EVERY_MS - performance.now());
    this.turn = setTimeout(() => this.#send(), wait);
  }

  async #send() {
    this.turn = null;
    this.sent_ms = performance.now();
    this.waiting += 1;
    const value = this.#si(this.wished);
    const reply = await this.commit(value);
    this.waiting -= 1;
    // The state that says so may come after the reply: until then the value before it must not come back.
    if (reply.ok) this.value = value;
    write(this.note, reply.ok ? "" : reply.error);
    this.element.classList.toggle("refused", !reply.ok);
    if (!reply.ok) this.isDragged = false;
    this.#show();
  }

  /** An end of the slider is the knob's own end, to the last bit. */
  #si(shown) {
    const { factor } = this.knob;
    const ends = (this.ends ?? [this.knob.low, this.knob.high]).filter((end) => end !== null);
    return ends.find((end) => end * factor === shown) ?? shown / factor;
  }

  #rangeKey(event) {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (way === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const { step, factor, decimals } = this.knob;
    const whole = (step ?? this.step / factor) * factor;
    const size = event.shiftKey ? Math.max(whole / 10, 10 ** -decimals) : whole;
    const [low, high] = [Number(this.range.min), Number(this.range.max)];
    const next = Math.max(low, Math.min(high, typed(this.entry.value, "") + way * size));
    this.range.value = next;
    this.#wish(next);
  }

  #entryKey(event) {
    if (event.key === "Enter") this.#enter();
    if (event.key === "Escape" && this.#isEdited) {
      event.preventDefault();
      this.entry.value = this.written;
      this.entry.select();
    }
  }

  /** What was typed goes out as it was typed, to the last digit. */
  #enter() {
    if (!this.#isEdited) return;
    const { unit, decimals } = this.knob;
    const number = typed(this.entry.value, unit);
    if (Number.isNaN(number)) {
      write(this.note, `found “${this.entry.value.trim()}”, needed a number${unit ? ` in ${unit}` : ""}`);
      this.element.classList.add("refused");
      this.entry.value = this.written;
      return;
    }
    this.entry.value = this.#text(number);
    this.wished = number;
    clearTimeout(this.turn);
    this.#send();
  }
}
