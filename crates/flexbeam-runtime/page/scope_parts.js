// Small parts that scope cards are built of: buttons with pictures, menus.
// Enters: names and words. Leaves: elements of the page.

import { drawing, element } from "./element.js";

/** Pictures of 20 x 20: strokes only, in the colour of the text. */
const PICTURES = {
  pause: "M7 4.5v11M13 4.5v11",
  play: "M6.5 4.5l9 5.5-9 5.5z",
  cursors: "M6.5 3v14M13.5 3v14M3.5 7.5h3M13.5 12.5h3",
  back: "M9 4.5a5 5 0 1 0 4.5 7M9 4.5L5.8 4M9 4.5L8.4 7.8M16.5 16.5l-3.2-3.2",
  trigger: "M3 14.5h5.5v-9H17M8.5 12l-2-2.5h4z",
  settings: "M3 6h7M14 6h3M3 14h3M10 14h7M12 4v4M8 12v4",
  more: "M5 10h.01M10 10h.01M15 10h.01",
};

/** A picture; its meaning stands on the button. */
export function picture(name) {
  return drawing("svg", { viewBox: "0 0 20 20", "aria-hidden": "true" }, drawing("path", { d: PICTURES[name] }));
}

/** A button with a picture and a name that is read out and shown as a tip. */
export function tool(name, label, onclick, pressed) {
  const button = element(
    "button",
    { type: "button", class: "scope-tool", "aria-label": label, title: label, onclick },
    picture(name),
  );
  if (pressed !== undefined) button.setAttribute("aria-pressed", pressed);
  return button;
}

/** Gives a tool another picture and name. */
export function retool(button, name, label) {
  if (button.getAttribute("aria-label") === label) return;
  button.replaceChildren(picture(name));
  button.setAttribute("aria-label", label);
  button.title = label;
}

/**
 * A button that opens a menu.
 * @param {string} label
 * @param {[string, () => void][]} entries
 */
export function menu(label, entries) {
  const list = element("div", { class: "scope-menu", role: "menu", popover: "auto" });
  const button = tool("more", label, () => list.togglePopover());
  button.setAttribute("aria-haspopup", "menu");
  for (const [text, action] of entries) {
    const chosen = () => {
      list.hidePopover();
      action();
    };
    list.append(element("button", { type: "button", role: "menuitem", text, onclick: chosen }));
  }
  list.addEventListener("toggle", (event) => {
    button.setAttribute("aria-expanded", event.newState === "open");
    if (event.newState === "open") open(button, list);
  });
  list.addEventListener("keydown", (event) => walk(event, list));
  return [button, list];
}

function open(button, list) {
  const at = button.getBoundingClientRect();
  const left = Math.max(8, Math.min(at.right - list.offsetWidth, innerWidth - list.offsetWidth - 8));
  const below = at.bottom + 4;
  const top = below + list.offsetHeight < innerHeight ? below : Math.max(8, at.top - 4 - list.offsetHeight);
  Object.assign(list.style, { left: `${left}px`, top: `${top}px` });
  list.firstElementChild.focus();
}

function walk(event, list) {
  const way = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (!way) return;
  event.preventDefault();
  const all = [...list.children];
  all[(all.indexOf(document.activeElement) + way + all.length) % all.length].focus();
}
