// A sheet over the page: a dialog that does not lock what is behind it, because Emergency stop must always be within reach.
// Enters: a title and its content. Leaves: focus goes in, Esc closes, focus goes back to where it was.

import { PATHS, element, iconButton } from "./element.js";

let made = 0;

export class Sheet {
  /**
   * Opens a sheet; one that is open closes.
   * @param {{title: string, body: Node[], actions?: Node[], kind?: string, onclose?: () => void}} about
   */
  constructor({ title, body, actions = [], kind = "", onclose = () => {} }) {
    Sheet.open?.close();
    Sheet.open = this;
    made += 1;
    const id = `sheet-${made}`;
    this.onclose = onclose;
    this.before = document.activeElement;
    this.element = element("dialog", { class: `sheet ${kind}`, "aria-labelledby": id },
      element("div", { class: "head" }, element("h2", { id, text: title }), iconButton("Close", PATHS.cross, () => this.close())),
      element("div", { class: "body", tabindex: 0 }, ...body),
      actions.length ? element("div", { class: "foot" }, ...actions) : null);
    this.element.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || event.defaultPrevented) return;
      event.preventDefault();
      this.close();
    });
    const below = document.getElementById("banner").getBoundingClientRect().bottom;
    this.element.style.setProperty("--below", `${Math.round(below)}px`);
    document.getElementById("sheets").append(this.element);
    this.element.show();
  }

  /** Closes it. */
  close() {
    if (!this.element.isConnected) return;
    this.element.remove();
    Sheet.open = null;
    if (this.before?.isConnected) this.before.focus();
    this.onclose();
  }
}
