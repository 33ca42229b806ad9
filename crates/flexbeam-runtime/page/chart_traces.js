// Traces of signals over time, one column of extremes per pixel.
// Enters: a store, a time scale and value scales. Leaves: strokes on a canvas context (or one that writes SVG).
// Dense signals: first, least, greatest and last sample of every column, which is what a line through all samples
// would cover. Sparse ones: the line itself, with dots when samples stand far apart.

/** Columns with fewer samples than this are drawn sample by sample. */
const DENSE = 1.5;
/** Samples get dots when they stand further apart than this many times the stroke. */
const DOTTED = 6;
/** Segments stroked at once. NUMERICS: software rasters slow down with the square of a path's edges. */
const BATCH = 128;
/** A column that is lower than this is a point [pixels]; one that is higher than this is an upright edge. */
const FLAT = 0.6;
const EDGE = 24;
/** A step between columns that is higher than this is drawn whatever the dashes say [pixels]. */
const JUMP = 4;
/** How far a point may lie from the line that leaves it out [pixels]. */
const CLOSE = 0.12;
/** Dashes: this many strokes' widths on and off. */
const DASH_ON = 5;
const DASH_OFF = 3;

/**
 * @typedef {object} Look what one trace looks like
 * @property {number} channel in the store
 * @property {string} colour
 * @property {boolean} dashed
 * @property {(value: number) => number} y value [SI] to pixel
 */

/**
 * A path that is stroked in batches. Points that the straight line past them passes within `CLOSE` are left out: the
 * slopes that pass all of them so are a cone, which narrows with every point.
 */
export class Pen {
  constructor(context) {
    this.context = context;
    this.n = 0;
    this.lift();
    context.beginPath();
  }

  /** The next point begins a new line. */
  lift() {
    this.emit();
    this.x = NaN;
    this.y = NaN;
    this.pending = false;
  }

  to(x, y) {
    if (Number.isNaN(this.x)) this.context.moveTo(x, y);
    else {
      const slope = (y - this.y0) / (x - this.x0);
      const along = this.pending && x > this.x && slope >= this.least && slope <= this.most;
      if (!along) this.emit();
    }
    if (!this.pending) this.start();
    const run = x - this.x0;
    if (run > 0) {
      this.least = Math.max(this.least, (y - CLOSE - this.y0) / run);
      this.most = Math.min(this.most, (y + CLOSE - this.y0) / run);
    } else this.most = -Infinity;
    this.pending = !Number.isNaN(this.x);
    this.x = x;
    this.y = y;
  }

  /** A cone from where the pen is. */
  start() {
    this.x0 = this.x;
    this.y0 = this.y;
    this.least = -Infinity;
    this.most = Infinity;
  }

  /** Draws to the point that is held back. */
  emit() {
    if (!this.pending) return;
    this.pending = false;
    this.context.lineTo(this.x, this.y);
    this.n += 1;
    if (this.n < BATCH) return;
    this.context.stroke();
    this.context.beginPath();
    this.context.moveTo(this.x, this.y);
    this.n = 0;
  }

  /** A stroke of no length is not drawn by every raster: a hair's breadth is. */
  dot() {
    this.context.lineTo(this.x + 0.01, this.y);
  }

  finish() {
    this.emit();
    this.context.stroke();
  }
}

/**
 * Draws columns [a, b) of all traces.
 * @param {CanvasRenderingContext2D} context pixels of the context are columns
 * @param {{origin: number, width: number}} scale tick of the left end of column 0, ticks in a column
 * @param {Look[]} looks the last is on top
 * @param {number} stroke width of a trace [pixels]
 * @param {(column: number) => number} x left end of a column [pixels]
 */
export function drawColumns(context, store, scale, looks, stroke, a, b, x) {
  if (store.count === 0) return;
  const columns = store.columns(scale.origin, scale.width, a, b - a);
  context.lineWidth = stroke;
  context.lineJoin = "round";
  context.lineCap = "round";
  const sparse = columns.from[0] >= store.rawFirst && scale.width < DENSE;
  for (const look of looks) {
    context.strokeStyle = look.colour;
    context.fillStyle = look.colour;
    const on = look.dashed ? dashes(stroke) : null;
    if (sparse) drawSparse(context, store, scale, look, stroke, columns.from[0], columns.to[b - a - 1], x, on);
    else drawDense(context, store, scale, look, columns, a, x, on);
  }
}

/** Columns of a dashed trace in which the pen is down: fixed to the columns, so that dashes move with the data. */
function dashes(stroke) {
  const on = Math.round(DASH_ON * stroke);
  const all = on + Math.round(DASH_OFF * stroke);
  return (column) => ((Math.floor(column) % all) + all) % all < on;
}

function drawDense(context, store, scale, look, columns, a, x, on) {
  const pen = new Pen(context);
  const { channel, y } = look;
  const ends = [NaN, NaN];
  const rawFirst = store.rawFirst;
  let before = null;
  for (let k = 0; k < columns.from.length; k += 1) {
    const from = columns.from[k];
    const to = columns.to[k];
    if (to <= from) continue;
    store.extremes(channel, from, to, ends);
    if (Number.isNaN(ends[0])) {
      pen.lift();
      before = null;
      continue;
    }
    if (before && from > before.from && store.gapBefore(from)) {
      pen.lift();
      before = null;
    }
    const left = x(a + k);
    const known = from >= rawFirst;
    const middle = y((ends[0] + ends[1]) / 2);
    const column = {
      from,
      x: left + 0.5,
      bottom: y(ends[0]),
      top: y(ends[1]),
      first: known ? y(store.valueAt(channel, from)) : middle,
      last: known ? y(store.valueAt(channel, to - 1)) : middle,
      x_first: known ? x((store.tickAt(from) - scale.origin) / scale.width) : left + 0.5,
      x_last: known ? x((store.tickAt(to - 1) - scale.origin) / scale.width) : left + 0.5,
      down: !on || on(a + k),
    };
    if (on && before && Math.abs(column.first - before.last) > JUMP) drawJump(pen, before, column);
    drawColumn(pen, column, before);
    before = column;
  }
  pen.finish();
}

/** A step between two columns: no dash leaves it out. */
function drawJump(pen, before, column) {
  if (Number.isNaN(pen.x)) pen.to(before.x_last, before.last);
  pen.to(column.x_first, column.first);
}

/** Through a column: its extremes in its middle, its first and last sample where they are. */
function drawColumn(pen, { x, bottom, top, first, last, x_first, x_last, down }, before) {
  const height = Math.abs(top - bottom);
  if (height < FLAT && !down) return pen.lift();
  const alone = Number.isNaN(pen.x);
  if (Number.isNaN(first)) pen.lift();
  const rising = first === bottom && last === top;
  const monotone = rising || (first === top && last === bottom);
  if (monotone && height < EDGE) {
    if (alone || height > FLAT) pen.to(x_first, first);
    pen.to(x_last, last);
    return alone ? pen.dot() : undefined;
  }
  if (height < FLAT && !Number.isNaN(last)) {
    pen.to(x, alone ? first : (top + bottom) / 2);
    return alone ? pen.dot() : undefined;
  }
  // Columns that overlap cover where the line goes from one to the other: an upright stroke each is the same picture.
  if (!alone && before && before.top <= bottom && top <= before.bottom) {
    // Which end comes first is told by the samples, not by the pen: strips that begin elsewhere must draw the same.
    const fromTop = Math.abs(first - top) < Math.abs(first - bottom);
    pen.to(x, fromTop ? top : bottom);
    pen.to(x, fromTop ? bottom : top);
    return Number.isNaN(last) ? pen.lift() : undefined;
  }
  if (!Number.isNaN(first)) pen.to(monotone ? x : x_first, first);
  // The extreme that is further from the last sample comes first: fewer strokes over one another.
  const upFirst = Math.abs(top - last) > Math.abs(bottom - last);
  const [one, two] = upFirst ? [top, bottom] : [bottom, top];
  if (one !== first) pen.to(x, one);
  pen.to(x, two);
  if (Number.isNaN(last)) return pen.lift();
  return pen.to(monotone ? x : x_last, last);
}

function drawSparse(context, store, scale, look, stroke, from, to, x, on) {
  const pen = new Pen(context);
  const at = (index) => x((store.tickAt(index) - scale.origin) / scale.width);
  // One sample more at either end: the line leads in and out.
  const begin = Math.max(store.rawFirst, from - 1);
  const end = Math.min(store.count, to + 1);
  for (let i = begin; i < end; i += 1) {
    const value = store.valueAt(look.channel, i);
    if (Number.isNaN(value)) {
      pen.lift();
      continue;
    }
    if (i === begin || store.gapBefore(i)) pen.lift();
    if (on && !Number.isNaN(pen.x)) dashTo(pen, at(i), look.y(value), on, x);
    else pen.to(at(i), look.y(value));
  }
  pen.finish();
  if (scale.width * DOTTED * stroke < 1) dots(context, store, look, stroke, begin, end, at);
}

/** A straight stretch, column by column. */
function dashTo(pen, x, y, on, origin) {
  const [x0, y0] = [pen.x, pen.y];
  const steep = Math.abs(y - y0) > 2 * Math.abs(x - x0);
  const shift = origin(0);
  for (let next = Math.floor(x0) + 1; next < x && !steep; next += 1) {
    const there = y0 + ((next - x0) / (x - x0)) * (y - y0);
    if (!on(next - 1 - shift)) pen.lift();
    pen.to(next, there);
  }
  pen.to(x, y);
}

function dots(context, store, look, stroke, begin, end, at) {
  context.beginPath();
  for (let i = begin; i < end; i += 1) {
    const value = store.valueAt(look.channel, i);
    if (Number.isNaN(value)) continue;
    const [x, y] = [at(i), look.y(value)];
    context.moveTo(x + 1.6 * stroke, y);
    context.arc(x, y, 1.6 * stroke, 0, 2 * Math.PI);
  }
  context.fill();
}

/** Traces that were drawn already: a ring of columns, of which only new ones are drawn. */
export class TraceLayer {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.context = this.canvas.getContext("2d");
    this.key = "";
    this.begin = 0;
    this.end = 0;
  }

  /**
   * Brings columns [first, first + width of the canvas) up to date.
   * @param {string} key changes whenever what is drawn already is void
   * @param {number} complete first column that may still change (it holds the newest sample)
   */
  update(key, first, complete, width, height, draw) {
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.key = "";
    }
    const last = first + width;
    if (key !== this.key || first >= this.end || last <= this.begin) this.begin = this.end = first;
    this.key = key;
    if (first < this.begin) {
      this.strip(first, this.begin, draw);
      this.begin = first;
      this.end = Math.min(this.end, last);
    }
    if (this.end < last) {
      this.strip(this.end, last, draw);
      this.end = last;
    }
    this.begin = Math.max(this.begin, this.end - width);
    // Columns from the newest sample on are drawn again next time.
    this.end = Math.max(this.begin, Math.min(this.end, complete));
    this.drawn = { first, width };
  }

  /** Draws columns [a, b), in two pieces where the ring begins anew. */
  strip(a, b, draw) {
    const { width, height } = this.canvas;
    for (let from = a; from < b;) {
      const slot = ((from % width) + width) % width;
      const to = Math.min(b, from - slot + width);
      this.context.save();
      this.context.beginPath();
      this.context.rect(slot, 0, to - from, height);
      this.context.clip();
      this.context.clearRect(slot, 0, to - from, height);
      const shift = slot - from;
      draw(this.context, from, to, (column) => column + shift);
      this.context.restore();
      from = to;
    }
  }

  /** Copies the columns to their place on another canvas. */
  show(context, left, top) {
    const { width, height } = this.canvas;
    const slot = ((this.drawn.first % width) + width) % width;
    context.drawImage(this.canvas, slot, 0, width - slot, height, left, top, width - slot, height);
    if (slot > 0) context.drawImage(this.canvas, 0, 0, slot, height, left + width - slot, top, slot, height);
  }
}
