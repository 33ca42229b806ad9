// What the page knows of the run. Enters: messages and the link. Leaves: the present state, and in words what this viewer may do.

/** Start of a run that is not armed yet. */
const NOT_YET = "0";

export class RunState {
  constructor() {
    this.link = { stage: "connecting", why: "", since_ms: performance.now(), retry_ms: null };
    this.viewers = [];
    this.in_control = null;
    this.asking = null;
    this.asking_until_ms = 0;
    this.begin();
  }

  /** Forgets the run, for the next one; who is here is told anew only where it changed. */
  begin() {
    this.hello = null;
    this.knobs = new Map();
    this.phase = null;
    this.time_s = NaN;
    this.revision = 0;
    this.values = {};
    this.timing = null;
    this.result = null;
  }

  /** Whether this greeting is of another run than the one that is known. */
  isAnother(hello) {
    return this.hello !== null && this.hello.run.start_unix_ns !== hello.run.start_unix_ns;
  }

  /** Whether the run that is known got as far as its first tick. */
  get wasArmed() {
    return this.hello !== null && this.hello.run.start_unix_ns !== NOT_YET;
  }

  /** Takes a message in. */
  apply(message) {
    this[`_${message.type}`]?.(message);
  }

  _hello(message) {
    this.hello = message;
    this._knobs(message);
  }

  _knobs({ knobs }) {
    this.knobs = new Map(knobs.map((knob) => [knob.key, knob]));
  }

  _state({ phase, time_s, revision, values, timing }) {
    Object.assign(this, { phase, time_s, revision, values, timing });
  }

  _viewers({ viewers, in_control, asking }) {
    this.viewers = toldApart(viewers);
    this.in_control = in_control;
    this.asking = asking && { ...asking, name: this.viewers.find((viewer) => viewer.id === asking.viewer)?.name ?? asking.name };
    if (asking) this.asking_until_ms = performance.now() + asking.seconds_left * 1000;
  }

  _over({ result }) {
    this.result = result;
  }

  /** Whether what is shown is of this moment. */
  get isLive() {
    return this.link.stage === "open";
  }

  get hasToken() {
    return this.hello?.may === "steer";
  }

  get inControl() {
    return this.hello !== null && this.in_control === this.hello.viewer;
  }

  get hasEnded() {
    return this.result !== null || this.link.stage === "over" || this.phase === "stopped" || this.phase === "fault";
  }

  /** Name of the viewer in control; null when nobody is. A seat is kept for a while when its connection is lost. */
  get holder() {
    if (this.in_control === null) return null;
    return this.viewers.find((viewer) => viewer.id === this.in_control)?.name ?? "A viewer that lost its connection";
  }

  /** Why the run cannot be stopped from here; null when it can. */
  get whyNoStop() {
    if (this.link.stage === "over" && this.result === null) return this.link.why;
    if (this.hasEnded) return "The run is over; the rig is at 0 V.";
    if (!this.isLive) return "No connection to the rig.";
    return this.hasToken ? null : whyNoToken(this.hello);
  }

  /** Why nothing can be changed from here; null when it can. */
  get whyLocked() {
    if (this.whyNoStop !== null) return this.whyNoStop;
    if (this.inControl) return null;
    return this.holder === null ? "Nobody is in control. Take control to change settings." : `${this.holder} is in control.`;
  }

  /** Why the run cannot be started from here; null when it can. */
  get whyNoStart() {
    if (this.phase === "configured") return "The rig is being brought to rest.";
    return this.phase === "running" ? "The run is going on." : this.whyLocked;
  }

  /** Name of the run, for a person. */
  get name() {
    return this.hello === null ? "flexbeam" : this.hello.run.project ?? this.hello.run.controller;
  }
}

/** Viewers of the same name get their number behind it. */
function toldApart(viewers) {
  const namesakes = (name) => viewers.filter((viewer) => viewer.name === name).length;
  return viewers.map((viewer) => (namesakes(viewer.name) > 1 ? { ...viewer, name: `${viewer.name} ${viewer.id}`, given: viewer.name } : { ...viewer, given: viewer.name }));
}

function whyNoToken(hello) {
  return hello?.token === "wrong"
    ? "The token is of another run. Open the address that flexbeam printed."
    : "This page has no token: it may look. Open the address that flexbeam printed.";
}
