// Scopes and panels of the page. Enters: the screen of the project, what this tab changed and did not save. Leaves: cards in their
// places, and the screen as it stands now.

import { PATHS, attribute, element, iconButton, write } from "./element.js";
import { keep, kept } from "./identity.js";
import { Panel } from "./panel.js";
import { editPanel } from "./panel_sheet.js";
import { ScopeCard } from "./scope_card.js";

const NEW_SCOPE = { title: "Scope", kind: "time", signals: ["reference_rad", "psi_rad"], span_s: 10 };
/** One column of panels: all but the first are folded. */
const NARROW = "(max-width: 639px)";

export class Layout {
  /**
   * @param {{scopes: HTMLElement, panels: HTMLElement, hello: Object, store: import("./store.js").Store, state: Object,
   *   commit: Function, request: Function, tell: (text: string) => void}} about
   */
  constructor(about) {
    Object.assign(this, about);
    const { project, controller } = this.hello.run;
    this.place = `screen:${project ?? controller}`;
    this.saved = this.hello.screen;
    this.saved_revision = this.#savedRevision();
    const own = kept(this.place);
    this.cards = element("div", { class: "cards" });
    this.column = element("div", { class: "column" });
    this.scopes.replaceChildren(this.#bar(), this.cards);
    this.panels.replaceChildren(this.column, element("div", { class: "add" }, element("button", { type: "button", class: "quiet", text: "Add panel", onclick: () => this.#addPanel() })));
    this.#lay(own ? JSON.parse(own) : this.saved);
  }

  /** Revision of the settings that this tab saved last in this run; a run begins with those of its project. */
  #savedRevision() {
    const [start, revision] = JSON.parse(kept("saved") ?? "[]");
    return start === this.hello.run.start_unix_ns ? revision : 0;
  }

  #bar() {
    this.pauseAll = element("button", { type: "button", class: "quiet", text: "Pause all", "aria-pressed": "false", "aria-keyshortcuts": "p", onclick: () => this.togglePause() });
    this.unsaved = element("span", { class: "unsaved", role: "status" });
    this.back = element("button", { type: "button", class: "quiet", text: "Undo layout", onclick: () => this.#revert() });
    this.save = element("button", { type: "button", class: "save", onclick: () => this.#save() }, "Save", element("span", { class: "long", text: " to project" }));
    return element("header", { class: "bar" }, element("h2", { text: "Scopes" }), element("a", { class: "jump", href: "#side", text: "Settings" }), this.pauseAll,
      element("button", { type: "button", class: "quiet", text: "Add scope", onclick: () => this.#addScope() }),
      element("span", { class: "gap" }), this.unsaved, this.back, this.save);
  }

  #lay(screen) {
    this.scopeCards?.forEach((card) => card.destroy());
    this.scopeCards = screen.scope.map((scope) => this.#scope(scope));
    const narrow = matchMedia(NARROW).matches;
    this.panelCards = screen.panel.map((panel, k) => this.#panel(panel, !narrow || k === 0));
    this.#place();
  }

  #scope(scope) {
    const { store, hello } = this;
    const card = new ScopeCard({
      store, signals: hello.signals, scope: structuredClone(scope), period_s: hello.run.period_s,
      onchange: () => this.#changed(),
      onremove: () => this.#remove(this.scopeCards, card),
      onmove: (_, way) => this.#move(this.scopeCards, card, way),
    });
    return card;
  }

  #panel(panel, isOpen) {
    const made = new Panel({
      panel: structuredClone(panel), knobs: this.state.knobs, isOpen, commit: this.commit,
      onedit: (one) => this.#edit(one),
      onmove: (one, way) => this.#move(this.panelCards, one, way),
    });
    made.update(this.state);
    return made;
  }

  /** Puts the cards into their order; those that stand right are not touched and keep what they show. */
  #place() {
    for (const [into, cards] of [[this.cards, this.scopeCards], [this.column, this.panelCards]]) {
      const wanted = cards.map((card) => card.element);
      [...into.children].filter((child) => !wanted.includes(child)).forEach((child) => child.remove());
      wanted.forEach((child, k) => into.children[k] === child || into.insertBefore(child, into.children[k] ?? null));
    }
    this.#showSaved();
  }

  #changed() {
    keep(this.place, this.isChanged ? JSON.stringify(this.screen) : null);
    this.#showSaved();
  }

  #remove(cards, card) {
    cards.splice(cards.indexOf(card), 1);
    card.destroy?.();
    this.#place();
    this.#changed();
  }

  #move(cards, card, way) {
    const at = cards.indexOf(card);
    const to = Math.max(0, Math.min(cards.length - 1, at + way));
    cards.splice(to, 0, ...cards.splice(at, 1));
    const held = document.activeElement;
    this.#place();
    if (card.element.contains(held)) held.focus();
    card.element.scrollIntoView({ block: "nearest" });
    this.#changed();
  }

  #addScope() {
    const known = NEW_SCOPE.signals.filter((key) => this.hello.signals.some((signal) => signal.key === key));
    const card = this.#scope({ ...NEW_SCOPE, title: `Scope ${this.scopeCards.length + 1}`, signals: known });
    this.scopeCards.push(card);
    this.#place();
    this.#changed();
    card.element.scrollIntoView({ block: "nearest" });
  }

  #addPanel() {
    const panel = { title: `Panel ${this.panelCards.length + 1}`, settings: [] };
    editPanel({ panel, knobs: this.state.knobs, isNew: true, ondone: (next) => {
      this.panelCards.push(this.#panel(next, true));
      this.#place();
      this.#changed();
    } });
  }

  #edit(card) {
    editPanel({ panel: card.panel, knobs: this.state.knobs, isNew: false,
      ondone: (next) => {
        card.show(next, this.state.knobs);
        this.#changed();
      },
      onremove: () => this.#remove(this.panelCards, card) });
  }

  #revert() {
    keep(this.place, null);
    this.#lay(this.saved);
  }

  async #save() {
    const screen = this.screen;
    const { revision } = this.state;
    const reply = await this.request({ type: "save", screen });
    if (!reply.ok) return this.tell(`Save to project: ${reply.error}`);
    this.saved = screen;
    this.saved_revision = revision;
    keep("saved", JSON.stringify([this.hello.run.start_unix_ns, revision]));
    this.#changed();
  }

  /** The screen as it stands, to be saved. */
  get screen() {
    return { scope: this.scopeCards.map((card) => card.scope), panel: this.panelCards.map((card) => card.panel) };
  }

  /** Whether scopes and panels differ from those of the project. */
  get isChanged() {
    return canonical(this.screen) !== canonical(this.saved);
  }

  /** Shows what may be saved, and the settings in the panels. */
  update(state) {
    this.state = state;
    this.panelCards.forEach((card) => card.update(state));
    this.#showSaved();
  }

  #showSaved() {
    const { run } = this.hello;
    const changed = this.isChanged;
    const settings = this.state.revision > this.saved_revision;
    const what = [changed ? "layout" : null, settings ? "settings" : null].filter(Boolean).join(" and ");
    const why = run.can_save ? this.state.isLive ? this.state.inControl ? null : this.state.whyLocked ?? "Take control first." : "No connection."
      : "This run has no project to save to. Begin one with flexbeam new.";
    this.back.hidden = !changed;
    write(this.unsaved, what && run.can_save ? `Unsaved ${what}` : run.can_save ? "" : "No project");
    attribute(this.unsaved, "title", run.can_save ? null : why);
    this.save.disabled = why !== null || what === "";
    this.save.classList.toggle("due", !this.save.disabled);
    attribute(this.save, "title", why ?? (what === "" ? "All is saved." : `Saves ${what} into the project`));
  }

  /** Holds every scope, or lets every scope go on. */
  togglePause() {
    const isPaused = !this.scopeCards.every((card) => card.paused);
    this.scopeCards.forEach((card) => card.pause(isPaused));
    attribute(this.pauseAll, "aria-pressed", String(isPaused));
    write(this.pauseAll, isPaused ? "Go on" : "Pause all");
  }

  /** One animation frame; a plot that fails is alone with it. */
  draw(now_ms) {
    this.scopeCards.forEach((card) => {
      try {
        card.draw(now_ms);
      } catch (error) {
        card.fail(error);
      }
    });
  }

  /** After the theme changed. */
  refresh() {
    this.scopeCards.forEach((card) => card.refresh());
  }

  /** Takes all away, before another run. */
  destroy() {
    this.scopeCards.forEach((card) => card.destroy());
    this.scopes.replaceChildren();
    this.panels.replaceChildren();
  }
}

/** The same text for the same screen, whatever the order of its keys. */
function canonical(value) {
  return JSON.stringify(value, (_, one) => {
    if (one === null || typeof one !== "object" || Array.isArray(one)) return one;
    const present = Object.keys(one).filter((key) => one[key] !== undefined && one[key] !== null).sort();
    return Object.fromEntries(present.map((key) => [key, one[key]]));
  });
}
