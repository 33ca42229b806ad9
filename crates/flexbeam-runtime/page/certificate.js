// The certificate in short. Enters: hello. Leaves: a verdict and its figures.

import { element } from "./element.js";
import { INFINITE, brief, withUnit } from "./number.js";

/** Fills the card; `certificate` as in hello, null where the controller has none. */
export function showCertificate(root, certificate) {
  root.replaceChildren(element("h2", { text: "Certificate" }), ...(certificate ? held(certificate) : [element("p", { class: "why", text: "This controller carries no certificate." })]));
}

function held({ holds, figures }) {
  const verdict = element("p", { class: `verdict ${holds ? "good" : "bad"}` },
    element("span", { class: "mark", "aria-hidden": "true", text: holds ? "✓" : "✕" }),
    element("span", { text: holds ? "Holds" : "Does not hold: the run is unverified" }));
  const rows = figures.map(({ label, value, unit, note }) => element("tr", {},
    element("th", { scope: "row" }, label, note ? element("small", { text: note }) : null),
    element("td", { text: value === null ? INFINITE : withUnit(brief(value), unit) })));
  return [verdict, element("table", { class: "figures" }, element("tbody", {}, ...rows))];
}
