// The page: takes its token, keeps the connection, hands every message to the part that shows it, and draws.

import { Banner } from "./banner.js";
import { showCertificate } from "./certificate.js";
import { themeChanged } from "./colours.js";
import { Connection } from "./connection.js";
import { element } from "./element.js";
import { Events } from "./events.js";
import { decode } from "./frames.js";
import { FrameTimes } from "./frame_times.js";
import { openHelp } from "./help.js";
import { Lateness } from "./lateness.js";
import { Layout } from "./layout.js";
import { Readouts } from "./readouts.js";
import { openResult } from "./result.js";
import { Sheet } from "./sheet.js";
import { ofBrowser } from "./shelf.js";
import { RunState } from "./state.js";
import { Store } from "./store.js";
import { Theme } from "./theme.js";
import { TopBar } from "./top_bar.js";
import { Viewers } from "./viewers.js";
import { keep, kept, keyOfTab, nameOfViewer, takeToken } from "./identity.js";

const place = (id) => document.getElementById(id);
const state = new RunState();
const frames = new FrameTimes();
const facts = Object.fromEntries(["certificate", "lateness", "here", "events"].map((name) => [name, element("section", { class: `card ${name}` })]));
/** What belongs to one run: store, layout, readouts, lateness. */
let shown = null;

const banner = new Banner({ root: place("banner"), retry: () => connection.retry() });
const tell = (text) => banner.tell(text);
const request = (message) => connection.request(message);
const theme = new Theme(() => refresh());
const top = new TopBar({ root: place("top"), act: (what) => request({ type: "do", request: { do: what } }), tell, theme, help });
const viewers = new Viewers({ control: place("control"), list: facts.here, sheets: place("sheets"), announcer: place("announcer"), request, tell, rename, token: enterToken });
const events = new Events({ root: facts.events, announcer: place("announcer") });
place("facts").append(...Object.values(facts));
const connection = new Connection({
  token: takeToken(), key: keyOfTab(), name: nameOfViewer(), newest,
  onmessage: take, onsamples: takeSamples,
  onlink: (link) => { state.link = link; update(); },
});

function take(message) {
  if (message.type === "hello" && state.isAnother(message)) forget();
  state.apply(message);
  if (message.type === "hello") greet(message);
  if (message.type === "event") events.add(message);
  if (message.type === "viewers") takeFreeSeat();
  if (message.type === "over") end(message.result);
  update();
}

/** What was told about the run has no meaning any more; how it ended has. */
function end(result) {
  banner.clear();
  openResult(result);
}

/** What the page has already, and of which run; the rest is sent again. */
function newest() {
  const after = shown?.store.last;
  return Number.isFinite(after) ? { after, run: state.hello.run.start_unix_ns } : { after: null };
}

/** Another run, or one that was not armed yet: nothing of the last one stays. */
function forget() {
  if (state.wasArmed) {
    Sheet.open?.close();
    tell("Another run began at this address.");
  }
  state.begin();
  shown.layout.destroy();
  shown = null;
}

/** A first greeting builds the page; later ones of the same run only go on. */
function greet(hello) {
  if (connection.isNew) events.clear();
  if (shown !== null) return;
  const { signals, certificate, run } = hello;
  const store = new Store({ signals, period_s: run.period_s });
  window.flexbeam.store = store;
  const commit = (key, value) => request({ type: "set", values: { [key]: value } });
  shown = {
    store,
    readouts: new Readouts({ root: place("readouts"), signals }),
    lateness: new Lateness({ root: facts.lateness, signals }),
    layout: new Layout({ scopes: place("scopes"), panels: place("panels"), hello, store, state, request, tell, commit }),
  };
  showCertificate(facts.certificate, certificate);
  mayTake = kept("released") === null;
}

/** Whoever opens the page with the token wants to steer: a seat that is free is taken, once, unless it was released before. */
let mayTake = false;
function takeFreeSeat() {
  if (mayTake && state.hasToken && !state.hasEnded && state.in_control === null) request({ type: "take" });
  mayTake = false;
}

function takeSamples(message) {
  try {
    const frame = decode(message);
    shown.store.push(frame);
    shown.lateness.take(frame);
  } catch (error) {
    tell(`A frame of samples was not understood: ${error.message}. Reload the page.`);
  }
}

function update() {
  top.update(state);
  banner.update(state);
  viewers.update(state);
  shown?.lateness.update(state);
  shown?.layout.update(state);
}

function refresh() {
  themeChanged();
  if (shown) [shown.layout, shown.readouts, shown.lateness].forEach((part) => part.refresh());
}

function rename(name) {
  connection.name = name;
  ofBrowser().setItem("flexbeam.name", name);
  connection.again();
}

function enterToken(token) {
  keep("token", token);
  connection.token = token;
  mayTake = true;
  connection.again();
}

function help() {
  openHelp(state.hello);
}

function draw(now_ms) {
  // Before all else: an error in one picture is not to be the end of all.
  requestAnimationFrame(draw);
  const began = performance.now();
  if (shown) drawRun(shown, now_ms);
  frames.add(performance.now() - began);
}

function drawRun({ store, layout, readouts, lateness }, now_ms) {
  layout.draw(now_ms);
  readouts.draw(now_ms, store, state.isLive && !state.hasEnded);
  lateness.draw(now_ms);
}

addEventListener("keydown", (event) => {
  const isTyped = event.target.matches?.("input:not([type=range]):not([type=radio]):not([type=checkbox]), textarea, select");
  if (isTyped || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "?") help();
  if (event.key === "p") shown?.layout.togglePause();
});
addEventListener("hashchange", () => {
  const token = takeToken();
  if (token !== connection.token) enterToken(token);
});
setInterval(() => { banner.update(state); viewers.update(state); }, 500);

window.flexbeam = { frames, store: null, connection };
update();
requestAnimationFrame(draw);
