// The sheet in which a panel is made: title, settings, ends of the sliders. Enters: a panel and the knobs. Leaves: the panel as wished.

import { element, write } from "./element.js";
import { fixed, typed } from "./number.js";
import { Sheet } from "./sheet.js";

/**
 * Opens the sheet.
 * @param {{panel: Object, knobs: Map<string, Object>, isNew: boolean, ondone: (panel: Object) => void, onremove?: () => void}} about
 */
export function editPanel({ panel, knobs, isNew, ondone, onremove }) {
  const title = element("input", { type: "text", value: panel.title, maxlength: 40, "aria-label": "Title of the panel" });
  const rows = [...knobs.values()].map((knob) => row(knob, panel));
  const groups = [...new Set(rows.map((one) => one.knob.group))].map((group) => element("fieldset", { class: "group" },
    element("legend", { text: group }), ...rows.filter((one) => one.knob.group === group).map((one) => one.element)));
  const wrong = element("p", { class: "note", role: "alert" });
  const done = () => {
    const chosen = rows.filter((one) => one.check.checked);
    const bad = chosen.find((one) => one.ends() === "wrong");
    if (bad) return write(wrong, `${bad.knob.label}: needed two numbers, the lower one first, or nothing`);
    const order = [...panel.settings.filter((key) => chosen.some((one) => one.knob.key === key)), ...chosen.map((one) => one.knob.key)];
    const ranges = Object.fromEntries(chosen.filter((one) => one.ends() !== null).map((one) => [one.knob.key, one.ends()]));
    const next = { title: title.value.trim() || "Panel", settings: [...new Set(order)], ...(Object.keys(ranges).length ? { ranges } : {}) };
    sheet.close();
    ondone(next);
  };
  const remove = isNew ? null : element("button", { type: "button", class: "quiet bad", text: "Remove panel", onclick: () => { sheet.close(); onremove(); } });
  const form = element("form", { onsubmit: (event) => { event.preventDefault(); done(); } },
    element("label", { class: "field" }, element("span", { text: "Title" }), title),
    element("p", { class: "hint", text: "Settings of this panel. Two numbers make the slider narrower than the setting's own limits." }),
    ...groups, wrong, element("button", { type: "submit", class: "unseen", tabindex: -1, "aria-hidden": "true" }));
  const sheet = new Sheet({ title: isNew ? "Add panel" : "Edit panel", kind: "wide", body: [form],
    actions: [remove, element("span", { class: "gap" }), element("button", { type: "button", class: "quiet", text: "Cancel", onclick: () => sheet.close() }),
      element("button", { type: "button", class: "main", text: isNew ? "Add panel" : "Done", onclick: done })].filter(Boolean) });
  title.select();
}

function row(knob, panel) {
  const { key, label, unit, factor, decimals } = knob;
  const check = element("input", { type: "checkbox", checked: panel.settings.includes(key) });
  const kept = panel.ranges?.[key];
  const end = (k, words) => element("input", { type: "text", inputmode: "decimal", "aria-label": `${label}: ${words} of the slider${unit ? ` in ${unit}` : ""}`, placeholder: words, value: kept ? fixed(kept[k] * factor, decimals) : "" });
  const inputs = knob.words || knob.why_fixed ? [] : [end(0, "from"), end(1, "to")];
  const ends = () => {
    const texts = inputs.map((input) => input.value.trim());
    if (texts.every((text) => text === "")) return null;
    const [low, high] = texts.map((text) => typed(text, unit) / factor);
    return low < high ? [low, high] : "wrong";
  };
  const made = element("div", { class: "pick" },
    element("label", {}, check, element("span", { text: label }), element("code", { text: key })),
    inputs.length ? element("span", { class: "pair" }, ...inputs, element("span", { class: "unit", text: unit })) : null);
  return { knob, check, ends, element: made };
}
