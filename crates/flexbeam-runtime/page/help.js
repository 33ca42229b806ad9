// The help sheet: keys, and what this page is.

import { element } from "./element.js";
import { Sheet } from "./sheet.js";

const KEYS = [
  ["Run", [["Ctrl", "."], "Emergency stop, from anywhere"], [["Esc", "Esc"], "Emergency stop: twice within 0.6 s"]],
  ["Page", [["?"], "This sheet"], [["P"], "Pause all scopes, or let them go on"], [["Tab"], "Next control"], [["Esc"], "Close a sheet, give up an entry"]],
  ["Setting", [["←", "→"], "One step"], [["Shift", "←", "→"], "A tenth of a step"], [["Page ↑", "Page ↓"], "Ten steps"], [["Enter"], "Take what is typed"]],
  ["Scope, when it has the focus", [["←", "→"], "Earlier, later"], [["+", "−"], "Zoom"], [["Space"], "Pause"], [["C"], "Cursors"], [["T"], "Trigger"], [["Z"], "Zoom back"]],
];

/** Opens the sheet. */
export function openHelp(hello) {
  const groups = KEYS.map(([title, ...rows]) => element("section", {}, element("h3", { text: title }),
    element("dl", { class: "keys" }, ...rows.map(([keys, words]) => element("div", {},
      element("dt", {}, ...keys.map((key) => element("kbd", { text: key }))), element("dd", { text: words }))))));
  const about = element("p", { class: "hint", text: `The keys of one letter do nothing while a text is being typed. Start and Stop have no key. Start, settings and Save need control; Stop and Emergency stop need only the token.${hello ? ` flexbeam ${hello.version}.` : ""}` });
  return new Sheet({ title: "Help", kind: "wide", body: [element("div", { class: "columns" }, ...groups), about] });
}
