import { keep, kept, keyOfTab, nameOfViewer, takeToken } from "../page/identity.js";
import { check, same } from "./check.js";

export function theTokenLeavesTheAddress() {
  keep("token", null);
  history.replaceState(null, "", "#abc%20");
  same([takeToken(), location.hash, kept("token")], ["abc", "", "abc"], "token");
  same(takeToken(), "abc", "after a reload");
}

/** Whoever copied the address badly gets a page that says so, and none that stays empty. */
export function aSpoiltAddressIsAWrongToken() {
  keep("token", null);
  history.replaceState(null, "", "#abc%");
  same([takeToken(), location.hash], ["abc%", ""], "token");
}

/** A browser that keeps nothing (its cookies are blocked) throws at the mere look. */
export function aBrowserThatKeepsNothingStillHasAPage() {
  const blocked = { get: () => { throw new DOMException("Access is denied", "SecurityError"); }, configurable: true };
  const own = ["sessionStorage", "localStorage"].map((name) => [name, Object.getOwnPropertyDescriptor(window, name)]);
  own.forEach(([name]) => Object.defineProperty(window, name, blocked));
  try {
    history.replaceState(null, "", "#xyz");
    same([takeToken(), kept("nothing"), takeToken()], ["xyz", null, "xyz"], "token");
    same(keyOfTab(), keyOfTab(), "key");
    check(nameOfViewer().length > 0, "name");
    keep("token", null);
    same(kept("token"), null, "forgotten");
  } finally {
    own.forEach(([name, descriptor]) => Object.defineProperty(window, name, descriptor));
  }
}
