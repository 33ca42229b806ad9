// What must not be overlooked. Enters: the state, and sentences that somebody must read. Leaves: a bar below the top bar.

import { PATHS, element, iconButton, write } from "./element.js";

const GOES_ON = "The run goes on without this page. To stop it: the terminal, or the rig's own switch.";

export class Banner {
  /** @param {{root: HTMLElement, retry: () => void}} about */
  constructor({ root, retry }) {
    this.again = element("button", { type: "button", class: "quiet", onclick: () => (this.isRefused ? location.reload() : retry()) });
    this.title = element("strong");
    this.words = element("span");
    this.since = element("span", { class: "since" });
    this.link = element("div", { class: "banner lost", hidden: true },
      element("p", { role: "alert" }, this.title, " ", this.words), this.since,
      this.again);
    this.text = element("p", { role: "alert" });
    this.notice = element("div", { class: "banner notice", hidden: true }, this.text, iconButton("Dismiss", PATHS.cross, () => this.clear()));
    root.append(this.link, this.notice);
  }

  /** Shows a sentence until somebody dismisses it. */
  tell(text) {
    this.notice.hidden = false;
    write(this.text, text);
  }

  /** Nothing is left to be told. */
  clear() {
    this.notice.hidden = true;
  }

  /** Shows the link; called as well twice a second, because the next attempt comes nearer. */
  update({ link, hello, hasEnded }) {
    const isLost = link.stage === "lost" || link.stage === "refused";
    this.link.hidden = !isLost;
    if (!isLost) return;
    this.isRefused = link.stage === "refused";
    write(this.again, this.isRefused ? "Reload page" : "Try now");
    const goesOn = hello !== null && !hasEnded;
    write(this.title, hello === null ? "No connection to flexbeam." : "Connection lost.");
    write(this.words, goesOn ? `${link.why} ${GOES_ON}` : hello === null ? `${link.why} Is the run still going on, at this address?` : link.why);
    const now = performance.now();
    const ago = `${Math.round((now - link.since_ms) / 1000)} s ago`;
    const next = link.retry_ms === null ? "" : link.retry_ms <= now ? "trying now" : `trying again in ${Math.ceil((link.retry_ms - now) / 1000)} s`;
    write(this.since, [ago, next].filter(Boolean).join(", "));
  }
}
