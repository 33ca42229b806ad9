import { Connection } from "../page/connection.js";
import { check, same } from "./check.js";

/** Stands for the browser's: opens at once, keeps what was sent. */
class Socket {
  static made = [];

  constructor(url) {
    Object.assign(this, { url, sent: [], isOpen: false, isClosed: false });
    Socket.made.push(this);
    queueMicrotask(() => {
      this.isOpen = true;
      this.onopen?.();
    });
  }

  send(text) {
    if (!this.isOpen) throw new DOMException("Still in CONNECTING state", "InvalidStateError");
    this.sent.push(JSON.parse(text));
  }

  close() {
    this.isClosed = true;
  }

  say(message) {
    this.onmessage?.({ data: JSON.stringify(message) });
  }

  end(code) {
    this.onclose?.({ code });
  }
}
globalThis.WebSocket = Socket;

const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const STATE = { type: "state", phase: "running" };

async function connected(more = {}) {
  Socket.made.length = 0;
  const links = [];
  const connection = new Connection({ token: "T", key: "K", name: "laptop", newest: () => ({ after: null }), onmessage: () => {}, onsamples: () => {}, onlink: ({ stage }) => links.push(stage), ...more });
  await wait(0);
  const [socket] = Socket.made;
  socket.say({ type: "hello" });
  socket.say(STATE);
  return { connection, socket, links };
}

export async function theFirstMessageSaysWhoComes() {
  const { socket, connection } = await connected({ newest: () => ({ after: 41, run: "17" }) });
  same(socket.sent, [{ type: "enter", protocol: 1, token: "T", name: "laptop", key: "K", after: 41, run: "17" }], "enter");
  check(socket.url.startsWith("ws://") && socket.url.endsWith("/live"), socket.url);
  same(connection.link.stage, "open", "stage");
}

export async function everyConnectionTellsEverythingAnewOnce() {
  const { connection, socket } = await connected();
  same(connection.isNew, true, "first greeting");
  socket.say({ type: "hello" });
  same(connection.isNew, false, "once more when the run is armed");
  connection.again();
  await wait(0);
  Socket.made.at(-1).say({ type: "hello" });
  same(connection.isNew, true, "first greeting of the next connection");
}

export async function answersFindTheirQuestions() {
  const { socket, connection } = await connected();
  const [first, second] = [connection.request({ type: "take" }), connection.request({ type: "release" })];
  const [, one, two] = socket.sent;
  socket.say({ type: "reply", id: two.id, ok: false, error: "no" });
  socket.say({ type: "reply", id: one.id, ok: true });
  same([(await first).ok, (await second).error], [true, "no"], "answers");
}

export async function nothingIsSentLater() {
  const { socket, connection } = await connected();
  const pending = connection.request({ type: "take" });
  socket.end(1006);
  check((await pending).error.includes("lost before the answer"), "pending");
  const reply = await connection.request({ type: "do", request: { do: "emergency" } });
  same([reply.ok, reply.error], [false, "No connection: nothing was sent."], "while lost");
  await wait(400);
  same(Socket.made.length, 2, "one more attempt");
  same(Socket.made[1].sent.map(({ type }) => type), ["enter"], "only the greeting goes out");
}

export async function silenceOfTwoSecondsIsDeath() {
  const { connection, socket, links } = await connected();
  await wait(1500);
  same(connection.link.stage, "open", "after 1.5 s");
  await wait(1200);
  same([connection.link.stage, socket.isClosed], ["lost", true], "after 2.7 s");
  same(links, ["open", "lost"], "told once each");
}

export async function aStateKeepsItAlive() {
  const { connection, socket } = await connected();
  for (let k = 0; k < 6; k += 1) {
    await wait(500);
    socket.say(STATE);
  }
  same(connection.link.stage, "open", "after 3 s of states");
}

export async function codesDecideWhetherToTryAgain() {
  for (const [code, stage, again] of [[4002, "refused", false], [4003, "refused", false], [4004, "lost", true], [4005, "lost", true], [1006, "lost", true], [1000, "over", true], [1001, "over", true]]) {
    const { connection, socket } = await connected();
    socket.end(code);
    same([connection.link.stage, connection.link.retry_ms !== null], [stage, again], `code ${code}`);
    check(connection.link.why.length > 10, `code ${code} has no words`);
    clearTimeout(connection.timer);
  }
}

export async function theRunIsOverOnlyOnce() {
  const { connection, socket } = await connected();
  socket.say({ type: "over", result: {} });
  socket.end(1006);
  same(connection.link.stage, "over", "a broken end after `over`");
  connection.retry();
  await wait(0);
  Socket.made.at(-1).end(1006);
  same(connection.link.stage, "over", "nobody there: still over");
  clearTimeout(connection.timer);
}

export async function attemptsComeLessOften() {
  const { connection, socket } = await connected();
  socket.end(1006);
  const waits = [];
  for (let k = 0; k < 6; k += 1) {
    waits.push(Math.round(connection.link.retry_ms - performance.now()));
    connection.retry();
    Socket.made.at(-1).end(1006);
  }
  clearTimeout(connection.timer);
  same(waits.map((ms) => Math.round(ms / 250) * 250), [250, 500, 1000, 2000, 4000, 4000], "waits");
}

/** A browser's socket throws while it connects: an emergency stop must be told that it was not sent. */
export async function whileItEntersAnewNothingIsSent() {
  const { connection, links } = await connected();
  connection.again();
  const reply = await connection.request({ type: "do", request: { do: "emergency" } });
  same([reply.ok, reply.error], [false, "No connection: nothing was sent."], "before it is open");
  same(connection.link.stage, "connecting", "stage");
  await wait(0);
  Socket.made.at(-1).say({ type: "hello" });
  same(links, ["open", "connecting", "open"], "told");
}
