// Elements of the page. Enters: a tag, its attributes, its children. Leaves: the element.
// Absent on purpose: HTML in strings, and style attributes, which the page's policy forbids.

const SVG = "http://www.w3.org/2000/svg";

/**
 * An HTML element. `text` becomes its text, `on*` listeners, `style` a table of properties; true and false are attributes that
 * stand or do not; null leaves an attribute out.
 * @param {string} tag
 * @param {Object<string, any>} [attributes]
 * @param {...(Node|string|null)} children
 */
export function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** An SVG element, by the same rules. */
export function drawing(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") made.textContent = value;
    else if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "style") Object.entries(value).forEach(([key, one]) => made.style.setProperty(key, one));
    else attribute(made, name, value);
  }
  made.append(...children.filter((child) => child !== null));
  return made;
}

/** Sets, keeps or takes away an attribute. */
export function attribute(of, name, value) {
  const wanted = value === true ? "" : value;
  if (value === null || value === false || value === undefined) of.removeAttribute(name);
  else if (of.getAttribute(name) !== String(wanted)) of.setAttribute(name, wanted);
}

/** Writes a text only where it differs, so that nothing is laid out anew, read aloud again or deselected. */
export function write(into, text) {
  if (into.textContent !== text) into.textContent = text;
}

/** A button with a picture of a few strokes on a grid of 16, and a label for those who do not see it. */
export function iconButton(label, path, onclick, attributes = {}) {
  const picture = drawing("svg", { viewBox: "0 0 16 16", width: 16, height: 16, "aria-hidden": "true" },
    drawing("path", { d: path, fill: "none", stroke: "currentColor", "stroke-width": 1.6, "stroke-linecap": "round", "stroke-linejoin": "round" }));
  return element("button", { type: "button", class: "icon", "aria-label": label, title: label, onclick, ...attributes }, picture);
}

/** Pictures of icon buttons. */
export const PATHS = {
  plus: "M8 3v10M3 8h10",
  up: "M4 10l4-4 4 4",
  down: "M4 6l4 4 4-4",
  cross: "M4 4l8 8M12 4l-8 8",
  edit: "M3 13l.6-2.8L10.8 3a1.2 1.2 0 0 1 1.7 0l.5.5a1.2 1.2 0 0 1 0 1.7L5.8 12.4z",
  help: "M5.6 6a2.4 2.4 0 1 1 3.4 2.2c-.7.4-1 .8-1 1.6M8 12.4v.1",
  auto: "M8 2.5a5.5 5.5 0 1 0 0 11zM8 2.5a5.5 5.5 0 0 1 0 11",
  light: "M8 5.2a2.8 2.8 0 1 0 0 5.6 2.8 2.8 0 0 0 0-5.6M8 1.5v1.2M8 13.3v1.2M1.5 8h1.2M13.3 8h1.2M3.4 3.4l.9.9M11.7 11.7l.9.9M3.4 12.6l.9-.9M11.7 4.3l.9-.9",
  dark: "M13 9.6A5.6 5.6 0 0 1 6.4 3 5.6 5.6 0 1 0 13 9.6z",
};
