// Who this page is: its token, the key of its tab, its name. Kept where a reload finds them, and nowhere else.

import { ofBrowser, ofTab } from "./shelf.js";

const PREFIX = "flexbeam.";

/** What this tab kept under a name; null: nothing. */
export function kept(name) {
  return ofTab().getItem(PREFIX + name);
}

/** Keeps a text in this tab; null forgets it. */
export function keep(name, text) {
  if (text === null) ofTab().removeItem(PREFIX + name);
  else ofTab().setItem(PREFIX + name, text);
}

/** The token: from the address, which loses it, so that nobody reads it off the screen or passes it on; else the one that was kept. */
export function takeToken() {
  const token = plain(location.hash.slice(1)).trim();
  if (token === "") return kept("token");
  keep("token", token);
  history.replaceState(null, "", location.pathname);
  return token;
}

/** Without its percent signs; one that was copied badly stays as it is, and the run says that it is wrong. */
function plain(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** The key by which the run knows this tab again after a break. */
export function keyOfTab() {
  const key = kept("key") ?? Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  keep("key", key);
  return key;
}

/** The name that was given, or what kind of device this is. */
export function nameOfViewer() {
  const agent = navigator.userAgent;
  const device = [[/iPad|Tablet|Android(?!.*Mobile)/, "tablet"], [/Mobi|iPhone/, "phone"], [/Windows/, "Windows computer"], [/Mac OS/, "Mac"], [/Linux/, "Linux computer"]];
  return ofBrowser().getItem(`${PREFIX}name`) ?? device.find(([pattern]) => pattern.test(agent))?.[1] ?? "browser";
}
