// A scope as a file: picture (PNG, SVG) or samples (CSV).
// Enters: a scope card as one sees it. Leaves: a file, offered for download.

import { font, frameOf, hair } from "./chart_axes.js";
import { colourOf, dashed, paper } from "./colours.js";
import { csv } from "./snapshot_csv.js";
import { SvgContext } from "./snapshot_svg.js";

/** Heights [CSS pixels]. */
const HEAD = 40;
const LEGEND = 26;
const ROW = 22;
const SIDE = 14;

/**
 * What a picture is made of.
 * @typedef {object} Sight
 * @property {object} chart
 * @property {Set<string>} hidden
 * @property {string} title
 * @property {string} stamp date, time and run time
 * @property {number} width of the plot [CSS pixels]
 * @property {number} height of the plot [CSS pixels]
 * @property {number} now_ms time of the frame
 */

/** Draws a sight; returns nothing. `unit`: pixels of a CSS pixel. */
function draw(context, sight, unit, vector) {
  const { chart, hidden } = sight;
  const signals = chart.shown(hidden);
  const size = sizeOf(sight);
  context.fillStyle = paper().card;
  context.fillRect(0, 0, size.width * unit, size.height * unit);
  drawHead(context, sight, unit);
  const legend = legendOf(context, signals, size.width, unit);
  legend.forEach((entry) => drawEntry(context, entry, unit));
  const top = Math.round((HEAD + LEGEND * size.lines) * unit);
  context.save();
  context.translate(0, top);
  const frame = frameOf(Math.round(sight.width * unit), Math.round(sight.height * unit), unit, chart.axisCount);
  chart.compose(frame, hidden, sight.now_ms);
  chart.render(context, frame, hidden, vector);
  context.restore();
  drawTable(context, chart.table(hidden), top + sight.height * unit, size.width * unit, unit);
}

/** Size of the whole picture [CSS pixels]. */
function sizeOf({ chart, hidden, width, height }) {
  const table = chart.table(hidden);
  const rows = table ? table.rows.length + 1 + (table.note ? 1 : 0) : 0;
  const signals = chart.shown(hidden);
  const ruler = document.createElement("canvas").getContext("2d");
  const lines = 1 + legendOf(ruler, signals, width, 1).reduce((most, entry) => Math.max(most, entry.line), 0);
  return {
    width: Math.round(width),
    height: Math.round(HEAD + LEGEND * lines + height + rows * ROW + (rows > 0 ? 10 : 0)),
    lines,
  };
}

function drawHead(context, { title, stamp, width }, unit) {
  context.textBaseline = "middle";
  context.font = font(unit, 15, 600);
  context.fillStyle = paper().ink;
  context.textAlign = "left";
  context.fillText(title, SIDE * unit, (HEAD / 2 + 2) * unit);
  const taken = context.measureText(title).width;
  context.font = font(unit, 11.5);
  context.fillStyle = paper().soft;
  context.textAlign = "right";
  const room = width * unit - taken - 3 * SIDE * unit;
  const words = context.measureText(stamp).width <= room ? stamp : stamp.split(", ")[0];
  context.fillText(words, (width - SIDE) * unit, (HEAD / 2 + 2) * unit);
}

/** Where each name of the legend stands. */
function legendOf(context, signals, width, unit) {
  context.font = font(unit, 12.5);
  let [x, line] = [SIDE, 0];
  return signals.map((signal) => {
    const wide = 24 + context.measureText(signal.label).width / unit + 20;
    if (x + wide > width && x > SIDE) [x, line] = [SIDE, line + 1];
    const entry = { signal, x, line };
    x += wide;
    return entry;
  });
}

function drawEntry(context, { signal, x, line }, unit) {
  const y = HEAD + LEGEND * line + LEGEND / 2 - 2;
  context.fillStyle = colourOf(signal.key);
  const dashes = dashed(signal.key)
    ? [
        [0, 6],
        [10, 6],
      ]
    : [[0, 16]];
  for (const [from, wide] of dashes) context.fillRect((x + from) * unit, (y - 1.5) * unit, wide * unit, 3 * unit);
  context.font = font(unit, 12.5);
  context.fillStyle = paper().ink;
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.fillText(signal.label, (x + 24) * unit, y * unit);
}

/** The readings, in even columns from the right. */
function drawTable(context, table, top, width, unit) {
  if (!table) return;
  const column = Math.min(130 * unit, (width - 150 * unit) / (table.head.length - 1));
  const lines = [{ cells: table.head, head: true }, ...table.rows];
  lines.forEach(({ cells, colour, head }, k) => {
    const y = top + (k + 0.5) * ROW * unit;
    if (k > 0)
      hair(context, { unit }, paper().line, [[SIDE * unit, y - (ROW / 2) * unit, width - SIDE * unit, y - (ROW / 2) * unit]]);
    if (colour) {
      context.fillStyle = colour;
      context.fillRect(SIDE * unit, y - 7 * unit, 3 * unit, 14 * unit);
    }
    context.font = font(unit, 12);
    context.fillStyle = head ? paper().soft : paper().ink;
    cells.forEach((text, c) => {
      context.textAlign = c === 0 ? "left" : "right";
      context.fillText(text, c === 0 ? (SIDE + 9) * unit : width - SIDE * unit - column * (cells.length - 1 - c), y);
    });
  });
  context.fillStyle = paper().soft;
  context.textAlign = "right";
  if (table.note) context.fillText(table.note, width - SIDE * unit, top + (lines.length + 0.5) * ROW * unit);
}

/** @returns {Promise<Blob>} what one sees, in the pixels of the screen */
export function png(sight, unit) {
  const size = sizeOf(sight);
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(size.width * unit);
  canvas.height = Math.round(size.height * unit);
  draw(canvas.getContext("2d"), sight, unit, false);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

/** @returns {string} the same picture as vectors */
export function svg(sight) {
  const size = sizeOf(sight);
  const context = new SvgContext(size.width, size.height);
  draw(context, sight, 1, true);
  return context.text(`${sight.title}, ${sight.stamp}`);
}

/** Offers a file. */
export function offer(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The browser has taken hold of it by the next turn.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Name of a file: the title in plain letters, and when. */
export function fileName(title, when, extension) {
  const plain =
    title
      .normalize("NFKD")
      .replace(/[^a-zA-Z0-9]+/g, "-")
      .replace(/^-+|-+$/g, "")
      .toLowerCase() || "scope";
  const two = (n) => String(n).padStart(2, "0");
  const day = `${when.getFullYear()}-${two(when.getMonth() + 1)}-${two(when.getDate())}`;
  return `${plain}_${day}_${two(when.getHours())}${two(when.getMinutes())}${two(when.getSeconds())}.${extension}`;
}

/**
 * Takes a snapshot of a sight and offers it.
 * @param {"png"|"svg"|"csv"} kind
 */
export async function takeSnapshot(kind, sight, when, unit) {
  const name = fileName(sight.title, when, kind);
  if (kind === "png") return offer(name, await png(sight, unit));
  if (kind === "svg") return offer(name, new Blob([svg(sight)], { type: "image/svg+xml" }));
  const { begin, end } = sight.chart.stretchTicks();
  const keys = sight.chart.signals.filter((signal) => !sight.hidden.has(signal.key)).map((signal) => signal.key);
  return offer(name, new Blob([csv(sight.chart.store, keys, begin, end)], { type: "text/csv" }));
}
