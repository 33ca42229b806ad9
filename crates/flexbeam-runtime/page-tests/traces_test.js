import { drawColumns, TraceLayer } from "../page/chart_traces.js";
import { Store } from "../page/store.js";
import { check, frameOf, random, same, SIGNALS } from "./check.js";

const [WIDTH, HEIGHT] = [300, 200];
const LOOK = { channel: 0, colour: "#ffffff", dashed: false, y: (value) => HEIGHT / 2 - 80 * value };

/** A noisy wave with spikes and steps, without its samples `skip`. */
function wave(n, skip = () => false) {
  const draw = random(11);
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const value = (k) => 0.5 * Math.sin(k / 90) + 0.15 * (draw() - 0.5) + (k % 611 === 0 ? 0.4 : 0) + (k % 1000 > 500 ? 0.2 : -0.2);
  const rows = Array.from({ length: n }, (_, k) => [k, value(k), 0]).filter(([k]) => !skip(k));
  store.push(frameOf(rows));
  return { store, rows };
}

function canvasOf(width = WIDTH) {
  return Object.assign(document.createElement("canvas"), { width, height: HEIGHT }).getContext("2d", {
    willReadFrequently: true,
  });
}

/** First and last painted row of every column; null where nothing is painted. */
function painted(context) {
  const { data, width, height } = context.getImageData(0, 0, context.canvas.width, HEIGHT);
  return Array.from({ length: width }, (_, x) => {
    const rows = Array.from({ length: height }, (_, y) => y).filter((y) => data[4 * (y * width + x) + 3] > 96);
    return rows.length > 0 ? [rows[0], rows[rows.length - 1]] : null;
  });
}

/** Rows that a line of one pixel through the samples of a column must paint: at least and at most. */
function demanded(rows, origin, width, column) {
  const inside = rows.filter(([tick]) => tick >= origin + column * width && tick < origin + (column + 1) * width);
  const y = inside.map((row) => LOOK.y(Math.fround(row[1])));
  return y.length > 0 ? [Math.min(...y), Math.max(...y)] : null;
}

export function everyColumnShowsItsExtremes() {
  const { store, rows } = wave(9000);
  for (const width of [4, 9.7, 29]) {
    const context = canvasOf();
    drawColumns(context, store, { origin: 0, width }, [LOOK], 1, 0, WIDTH, (k) => k);
    painted(context).forEach((found, k) => {
      const needed = demanded(rows, 0, width, k);
      const at = `${width} samples a column, column ${k}: found rows ${found}, needed ${needed}`;
      check(found && found[0] <= needed[0] + 1 && found[1] >= needed[1] - 1.5, at);
    });
  }
}

export function noColumnShowsMoreThanItsNeighbourhood() {
  const { store, rows } = wave(9000);
  const context = canvasOf();
  drawColumns(context, store, { origin: 0, width: 20 }, [LOOK], 1, 0, WIDTH, (k) => k);
  painted(context).forEach((found, k) => {
    const around = [k - 1, k, k + 1].map((column) => demanded(rows, 0, 20, column)).filter(Boolean);
    const [top, bottom] = [Math.min(...around.map((r) => r[0])), Math.max(...around.map((r) => r[1]))];
    check(found[0] >= top - 2 && found[1] <= bottom + 2, `column ${k}: found rows ${found}, needed within ${[top, bottom]}`);
  });
}

export function gapsStayEmpty() {
  for (const width of [0.5, 5]) {
    const [from, to] = [100 * width, 140 * width];
    const { store } = wave(2000, (k) => k > from && k < to);
    const context = canvasOf();
    drawColumns(context, store, { origin: 0, width }, [LOOK], 1.75, 0, WIDTH, (k) => k);
    const found = painted(context);
    same(
      found.slice(103, 137).every((rows) => rows === null),
      true,
      `${width} samples a column: nothing in the gap`,
    );
    same(found.slice(0, 98).concat(found.slice(143)).every(Boolean), true, `${width} samples a column: all else is there`);
  }
}

export function dashesLeaveOutFlatPartsOnly() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(frameOf(Array.from({ length: 3000 }, (_, k) => [k, k % 1000 < 500 ? -0.5 : 0.5, 0])));
  for (const shift of [0, 3, 5.5, 10, 17]) {
    const context = canvasOf();
    drawColumns(context, store, { origin: shift, width: 10 }, [{ ...LOOK, dashed: true }], 1.5, 0, 290, (k) => k);
    const found = painted(context).slice(0, 290);
    const steps = found.filter((rows) => rows && rows[1] - rows[0] > 40).length;
    check(
      steps >= 5 && steps <= 10,
      `shift ${shift}: found ${steps} columns with an upright line, needed one or two for each of 5 steps`,
    );
    check(found.filter((rows) => rows === null).length > 40, `shift ${shift}: found no dashes`);
  }
}

export function stripsMakeTheSamePictureAsOneStroke() {
  const { store } = wave(9000);
  const looks = [LOOK, { ...LOOK, dashed: true, colour: "#ff0000", y: (value) => HEIGHT / 2 + 60 * value }];
  for (const width of [0.4, 12]) {
    const scale = { origin: 0, width };
    const draw = (target, a, b, x) => drawColumns(target, store, scale, looks, 1.75, a - 2, b + 2, x);
    const layer = new TraceLayer();
    // Forward past the ring's end in uneven steps, and back.
    const way = [0, 3, 7, 40, 130, 133, 350, 351, 349, 340, 200, 420];
    for (const first of way) layer.update("key", first, first + WIDTH - 9, WIDTH, HEIGHT, draw);
    const context = canvasOf();
    layer.show(context, 0, 0);
    const whole = canvasOf();
    draw(whole, 420, 420 + WIDTH, (k) => k - 420);
    const [a, b] = [context, whole].map((c) => c.getImageData(0, 0, WIDTH, HEIGHT).data);
    let off = 0;
    for (let i = 3; i < a.length; i += 4) off += Math.abs(a[i] - b[i]) > 80 ? 1 : 0;
    check(off < 0.002 * WIDTH * HEIGHT, `${width} samples a column: ${off} pixels differ`);
  }
}

export function samplesThatComeLaterAreDrawnToo() {
  const { rows } = wave(3000);
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const scale = { origin: 0, width: 9.7 };
  const draw = (target, a, b, x) => drawColumns(target, store, scale, [LOOK], 1.75, a - 2, b + 2, x);
  const layer = new TraceLayer();
  for (let k = 0; k < rows.length; k += 33) {
    store.push(frameOf(rows.slice(k, k + 33)));
    layer.update("key", 0, Math.floor(store.last / scale.width) - 4, WIDTH, HEIGHT, draw);
  }
  const [context, whole] = [canvasOf(), canvasOf()];
  layer.show(context, 0, 0);
  draw(whole, 0, WIDTH, (k) => k);
  const [a, b] = [context, whole].map(painted);
  // A stroke that begins elsewhere may smooth its edges into the next row.
  const like = (one, other) =>
    one === other || (one && other && Math.abs(one[0] - other[0]) <= 1 && Math.abs(one[1] - other[1]) <= 1);
  const off = a.flatMap((rowsOf, k) => (like(rowsOf, b[k]) ? [] : [`${k}: ${rowsOf} and ${b[k]}`]));
  same(off, [], "columns that differ");
}
