// The connection to the run. Enters: token, name and the newest tick that the page has. Leaves: messages, sample frames, and what
// the link does: connecting, open, lost, over, refused. It comes back by itself and asks for what it missed.
// Absent on purpose: a queue. A request without a connection is answered at once with "not sent", never sent later.

const PROTOCOL = 1;
/** The server says its state four times a second; silence of this length is death [ms]. */
const DEAD_MS = 2000;
/** A check that itself came this late was asleep with its tab: it listens once more before it judges [ms]. */
const ASLEEP_MS = 1000;
const CHECK_MS = 250;
const BACK_OFF_MS = [250, 500, 1000, 2000, 4000];
/** Close code of a run that ended before it was armed. */
const NEVER_BEGAN = 1001;
/** Another run may follow at the same address [ms]. */
const NEXT_RUN_MS = 3000;

/** Close codes in plain words, and whether trying again can help. */
const CLOSED = {
  4001: { why: "The program did not accept this page's greeting.", again: true },
  4002: { why: "This page is of another version than the program. Reload it.", again: false },
  4003: { why: "The program did not understand a message of this page. Reload it.", again: false },
  4004: { why: "The run has as many viewers as it takes. Close another one.", again: true },
  4005: { why: "This device or its network was too slow for the samples.", again: true },
  1009: { why: "The program refused a message of this page as too long.", again: true },
};

/**
 * @typedef {{stage: "connecting"|"open"|"lost"|"over"|"refused", why: string, since_ms: number, retry_ms: number|null}} Link
 *   `since_ms` and `retry_ms` are instants of performance.now()
 */

export class Connection {
  /**
   * @param {{token: string|null, key: string, name: string, newest: () => {after: number|null, run: string|null}, onmessage: (message: Object) => void,
   *   onsamples: (frame: ArrayBuffer) => void, onlink: (link: Link) => void}} about
   */
  constructor(about) {
    Object.assign(this, about);
    this.pending = new Map();
    this.id = 0;
    /** Whether the greeting that came last was the first of its connection: then everything is told anew. */
    this.isNew = true;
    this.attempts = 0;
    this.link = { stage: "connecting", why: "", since_ms: performance.now(), retry_ms: null };
    this.checked_ms = performance.now();
    setInterval(() => this.#check(), CHECK_MS);
    addEventListener("online", () => this.retry());
    document.addEventListener("visibilitychange", () => document.hidden || this.retry());
    this.#open();
  }

  /** Enters anew at once, with another name or token. */
  again() {
    this.#drop("This page entered anew.");
    this.#open();
    // Nothing can be sent before the next greeting.
    if (this.link.stage === "open") this.#become("connecting", "", null);
  }

  /** Does not wait for the next attempt. */
  retry() {
    if (this.link.retry_ms !== null) this.#open();
  }

  /**
   * Sends a request.
   * @param {Object} message without its id
   * @returns {Promise<{ok: boolean, error?: string}>} the run's answer, or why there is none
   */
  request(message) {
    if (this.link.stage !== "open") return Promise.resolve({ ok: false, error: "No connection: nothing was sent." });
    this.id += 1;
    const id = this.id;
    this.socket.send(JSON.stringify({ ...message, id }));
    return new Promise((resolve) => this.pending.set(id, resolve));
  }

  #open() {
    clearTimeout(this.timer);
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/live`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.#enter();
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.#take(JSON.parse(data)) : this.onsamples(data));
    socket.onclose = ({ code }) => this.#closed(code);
    this.socket = socket;
    this.over = false;
    this.hasHello = false;
    this.heard_ms = performance.now();
    this.link.retry_ms = null;
  }

  #enter() {
    const { token, name, key } = this;
    this.socket.send(JSON.stringify({ type: "enter", protocol: PROTOCOL, token, name, key, ...this.newest() }));
  }

  #take(message) {
    if (message.type === "state" || message.type === "hello") this.heard_ms = performance.now();
    if (message.type === "reply") {
      this.pending.get(message.id)?.(message);
      this.pending.delete(message.id);
      return;
    }
    if (message.type === "over") this.over = true;
    if (message.type === "hello") {
      this.isNew = !this.hasHello;
      this.hasHello = true;
      this.#become("open", "", null);
    }
    if (message.type === "state") this.attempts = 0;
    this.onmessage(message);
  }

  #closed(code) {
    this.#drop("The connection was lost before the answer came; the state shows what happened.");
    if (code === NEVER_BEGAN) return this.#become("over", "The run did not begin; the terminal says why.", NEXT_RUN_MS);
    if (this.over || code === 1000) return this.#become("over", "The run is over.", NEXT_RUN_MS);
    const known = CLOSED[code];
    if (known && !known.again) return this.#become("refused", known.why, null);
    if (this.link.stage === "over") return this.#become("over", this.link.why, NEXT_RUN_MS);
    this.#lost(known?.why ?? "The program does not answer.");
  }

  #lost(why) {
    const wait = BACK_OFF_MS[Math.min(this.attempts, BACK_OFF_MS.length - 1)];
    this.attempts += 1;
    this.#become("lost", why, wait);
  }

  /** Forgets the socket, which may take minutes to notice its end, and answers whoever still waits. */
  #drop(why) {
    const socket = this.socket;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.pending.forEach((resolve) => resolve({ ok: false, error: why }));
    this.pending.clear();
  }

  #become(stage, why, wait_ms) {
    const now = performance.now();
    const since_ms = stage === this.link.stage ? this.link.since_ms : now;
    this.link = { stage, why, since_ms, retry_ms: wait_ms === null ? null : now + wait_ms };
    if (wait_ms !== null) this.timer = setTimeout(() => this.#open(), wait_ms);
    this.onlink(this.link);
  }

  #check() {
    const now = performance.now();
    const asleep = now - this.checked_ms > ASLEEP_MS;
    this.checked_ms = now;
    if (asleep) this.heard_ms = Math.max(this.heard_ms, now - DEAD_MS / 2);
    const waits = this.link.retry_ms !== null || this.link.stage === "refused" || this.over;
    if (waits || now - this.heard_ms < DEAD_MS) return;
    this.#drop("The connection was lost before the answer came; the state shows what happened.");
    if (this.link.stage === "over") this.#become("over", this.link.why, NEXT_RUN_MS);
    else this.#lost("The program has said nothing for 2 s.");
  }
}
