// Dark and light. Enters: the choice of a person, kept in this browser. Leaves: `data-theme` on <html>.

import { ofBrowser } from "./shelf.js";

const KEPT = "flexbeam.theme";
/** In the order in which the button takes them. */
export const THEMES = ["auto", "light", "dark"];

export class Theme {
  /** @param {() => void} onchange after the colours changed */
  constructor(onchange) {
    const kept = ofBrowser().getItem(KEPT);
    this.choice = THEMES.includes(kept) ? kept : "auto";
    this.onchange = onchange;
    this.system = matchMedia("(prefers-color-scheme: light)");
    this.system.addEventListener("change", () => this.#apply());
    this.#apply();
  }

  /** The next of auto, light, dark. */
  next() {
    this.choice = THEMES[(THEMES.indexOf(this.choice) + 1) % THEMES.length];
    ofBrowser().setItem(KEPT, this.choice);
    this.#apply();
  }

  #apply() {
    const light = this.choice === "light" || (this.choice === "auto" && this.system.matches);
    document.documentElement.dataset.theme = light ? "light" : "dark";
    const paper = getComputedStyle(document.documentElement).getPropertyValue("--paper").trim();
    document.querySelector('meta[name="theme-color"]').setAttribute("content", paper);
    this.onchange();
  }
}
