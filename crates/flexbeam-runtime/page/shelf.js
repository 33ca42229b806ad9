// What the browser keeps for the page. Where it keeps nothing, because its cookies are blocked, it throws at the mere look:
// then the page remembers for itself, until it is loaded again.

class Memory extends Map {
  getItem(name) {
    return this.get(name) ?? null;
  }

  setItem(name, text) {
    this.set(name, text);
  }

  removeItem(name) {
    this.delete(name);
  }
}

const memories = { localStorage: new Memory(), sessionStorage: new Memory() };

function shelf(name) {
  try {
    return window[name] ?? memories[name];
  } catch {
    return memories[name];
  }
}

/** What stays in this tab. */
export const ofTab = () => shelf("sessionStorage");

/** What stays in this browser. */
export const ofBrowser = () => shelf("localStorage");
