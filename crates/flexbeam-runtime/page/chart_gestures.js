// Hands on a plot: mouse, fingers, keys.
// Enters: events of the plot's element. Leaves: calls to the plot's view, cursors and trigger level.
// Wheel: time; shift and wheel: values. Drag: box; middle button, Alt, or one finger sideways: pan. Two fingers: both.

/** Distance at which a mark is caught [CSS pixels]. */
const REACH = { mouse: 8, pen: 12, touch: 24 };
/** A press that moves less than this is no drag [CSS pixels]. */
const STILL = 5;
/** Zoom of one notch of the wheel. */
const NOTCH = 0.0018;
/** Share that an arrow key moves. */
const STEP = 0.1;
const ZOOM = 1.25;

/**
 * @typedef {object} Host what a plot's card offers
 * @property {object} chart
 * @property {import("./chart_axes.js").Frame} frame
 * @property {(yes: boolean) => void} pause
 * @property {() => void} changed draw again
 * @property {(level: number, done: boolean) => void} level
 * @property {() => void} back
 * @property {(name: string) => boolean} key a key that the card knows
 */

export class Gestures {
  /**
   * @param {HTMLElement} element the plot
   * @param {Host} host
   */
  constructor(element, host) {
    this.element = element;
    this.host = host;
    this.fingers = new Map();
    this.drag = null;
    this.active = 0;
    this.box = document.createElement("div");
    this.box.className = "scope-box";
    this.box.hidden = true;
    element.append(this.box);
    element.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    element.addEventListener("pointerdown", (event) => this.down(event));
    element.addEventListener("pointermove", (event) => this.move(event));
    element.addEventListener("pointerup", (event) => this.up(event));
    element.addEventListener("pointercancel", (event) => this.cancel(event));
    element.addEventListener("dblclick", () => host.back());
    element.addEventListener("keydown", (event) => this.key(event));
  }

  /** Where an event is: pixels of the canvas, and shares of the plot from the left and from below. */
  place(event) {
    const { frame } = this.host;
    const box = this.element.getBoundingClientRect();
    const [px, py] = [(event.clientX - box.left) * frame.unit, (event.clientY - box.top) * frame.unit];
    return { px, py, x: (px - frame.left) / frame.width, y: 1 - (py - frame.top) / frame.height };
  }

  wheel(event) {
    event.preventDefault();
    const { chart } = this.host;
    if (!chart.axes) return;
    const lines = event.deltaMode === 1 ? 24 : 1;
    const factor = Math.exp((event.deltaY || event.deltaX) * lines * NOTCH);
    const at = this.place(event);
    if (event.shiftKey) chart.view.zoomY(chart.axes, factor, clamp(at.y));
    else chart.view.zoomX(chart.axes, factor, chart.movesAway ? 1 : clamp(at.x));
    this.host.changed();
  }

  down(event) {
    if (!this.host.chart.axes || (event.button !== 0 && event.button !== 1)) return;
    const at = this.place(event);
    this.element.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, at);
    if (event.button === 1) event.preventDefault();
    if (this.fingers.size === 2) this.drag = { kind: "pinch" };
    else if (this.fingers.size === 1) this.drag = { ...this.grab(event, at), from: at, moved: false };
    if (this.drag?.kind === "level") this.moveLevel(at, false);
  }

  /** What a press takes hold of. */
  grab(event, at) {
    const { chart, frame } = this.host;
    const reach = REACH[event.pointerType] ?? REACH.mouse;
    const [low, high] = chart.axes.x;
    const place = low + at.x * (high - low);
    const cursor = chart.cursors?.near(place, ((reach * frame.unit) / frame.width) * (high - low)) ?? -1;
    if (cursor >= 0) {
      this.active = cursor;
      return { kind: "cursor" };
    }
    const level = chart.levelY?.(frame) ?? NaN;
    const atEdge = at.px < frame.left + 2 * reach * frame.unit || at.px > frame.left + frame.width - 2 * reach * frame.unit;
    if (Math.abs(at.py - level) < reach * frame.unit && (atEdge || event.pointerType === "mouse")) return { kind: "level" };
    return { kind: event.button === 1 || event.altKey || event.pointerType === "touch" ? "pan" : "box" };
  }

  move(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before || !this.drag) return;
    const at = this.place(event);
    this.fingers.set(event.pointerId, at);
    const { from, kind } = this.drag;
    if (kind === "pinch") return this.pinch(event.pointerId, before, at);
    const far = Math.hypot(at.px - from.px, at.py - from.py) > STILL * this.host.frame.unit;
    if (!this.drag.moved && !far) return undefined;
    this.drag.moved = true;
    if (kind === "cursor") return this.moveCursor(at);
    if (kind === "level") return this.moveLevel(at, false);
    if (kind === "pan") return this.pan(before.x - at.x, event.pointerType === "touch" ? 0 : before.y - at.y);
    return this.showBox(from, at);
  }

  up(event) {
    const at = this.place(event);
    const drag = this.drag;
    this.fingers.delete(event.pointerId);
    this.drag = null;
    this.box.hidden = true;
    if (drag?.kind === "level") this.moveLevel(at, true);
    if (drag?.kind === "box" && drag.moved) this.takeBox(drag.from, at);
  }

  cancel(event) {
    this.fingers.delete(event.pointerId);
    this.drag = null;
    this.box.hidden = true;
  }

  /** Two fingers: their middle pans, their distance zooms, each direction by itself. */
  pinch(id, before, at) {
    const other = [...this.fingers].find(([key]) => key !== id)?.[1];
    if (!other) return;
    const { chart } = this.host;
    const wide = [Math.abs(before.x - other.x), Math.abs(at.x - other.x)];
    const high = [Math.abs(before.y - other.y), Math.abs(at.y - other.y)];
    this.leave();
    if (Math.min(...wide) > 0.08) chart.view.zoomX(chart.axes, wide[0] / wide[1], (at.x + other.x) / 2);
    else if (Math.min(...high) > 0.08) chart.view.zoomY(chart.axes, high[0] / high[1], (at.y + other.y) / 2);
    chart.view.pan({ ...chart.axes, x: chart.view.x ?? chart.axes.x }, (before.x - at.x) / 2, 0);
    this.host.changed();
  }

  /** A rolling plot must stand still before its time axis is moved by hand. */
  leave() {
    if (this.host.chart.movesAway) this.host.pause(true);
  }

  pan(right, up) {
    const { chart } = this.host;
    if (right !== 0) this.leave();
    chart.view.pan(chart.axes, right, up);
    this.host.changed();
  }

  moveCursor(at) {
    const { chart } = this.host;
    const [low, high] = chart.axes.x;
    chart.cursors.at[this.active] = low + clamp(at.x) * (high - low);
    this.host.changed();
  }

  moveLevel(at, done) {
    const { chart, frame } = this.host;
    chart.held = !done;
    const inside = Math.min(Math.max(at.py, frame.top), frame.top + frame.height);
    this.host.level(chart.levelAt(frame, inside), done);
  }

  showBox(from, at) {
    const { frame } = this.host;
    const css = (x, y) => [
      (frame.left + clamp(x) * frame.width) / frame.unit,
      (frame.top + (1 - clamp(y)) * frame.height) / frame.unit,
    ];
    const [x0, y0] = css(Math.min(from.x, at.x), Math.max(from.y, at.y));
    const [x1, y1] = css(Math.max(from.x, at.x), Math.min(from.y, at.y));
    Object.assign(this.box.style, { left: `${x0}px`, top: `${y0}px`, width: `${x1 - x0}px`, height: `${y1 - y0}px` });
    this.box.hidden = false;
  }

  /** A box that is flat one way zooms the other way only. */
  takeBox(from, at) {
    const { chart, frame } = this.host;
    const [a, b] = [from, at].map((p) => ({ x: clamp(p.x), y: clamp(p.y) }));
    const flat = 10 * frame.unit;
    const wide = Math.abs(a.x - b.x) * frame.width > flat;
    const high = Math.abs(a.y - b.y) * frame.height > flat;
    if (!wide && !high) return;
    if (wide) this.leave();
    const kept = { x: chart.view.x, y: [...chart.view.y] };
    chart.view.box(chart.axes, a, b);
    if (!wide) chart.view.x = kept.x;
    if (!high) chart.view.y = kept.y;
    this.host.changed();
  }

  key(event) {
    if (event.target !== this.element || event.ctrlKey || event.metaKey || event.altKey) return;
    const moved = this.host.chart.axes && (this.arrow(event) || this.zoomKey(event));
    if (moved || this.host.key(event.key)) event.preventDefault();
  }

  arrow({ key, shiftKey }) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key];
    if (!way) return false;
    const step = STEP * (shiftKey ? 0.1 : 1);
    const { chart } = this.host;
    if (chart.cursors?.on && way[0] !== 0) this.nudge(way[0] * step * 0.2);
    else this.pan(way[0] * step, way[1] * step);
    return true;
  }

  nudge(share) {
    const { chart } = this.host;
    const [low, high] = chart.axes.x;
    const place = (chart.cursors.at[this.active] - low) / (high - low);
    this.moveCursor({ x: place + share });
  }

  zoomKey({ key, shiftKey }) {
    const { chart } = this.host;
    if (key === "a" || key === "b") {
      this.active = key === "a" ? 0 : 1;
      return chart.cursors?.on ?? false;
    }
    const factor = { "+": 1 / ZOOM, "=": 1 / ZOOM, "-": ZOOM, _: ZOOM, "*": 1 / ZOOM }[key];
    if (!factor) return false;
    if (shiftKey) chart.view.zoomY(chart.axes, factor, 0.5);
    else chart.view.zoomX(chart.axes, factor, chart.movesAway ? 1 : 0.5);
    this.host.changed();
    return true;
  }
}

function clamp(share) {
  return Math.min(1, Math.max(0, share));
}
