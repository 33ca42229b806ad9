// The paper of a plot: where it stands, its grid, and the numbers along it.
// Enters: ends of the axes. Leaves: strokes and text on a canvas context (or one that writes SVG).

import { quantity, marks } from "./chart_ticks.js";

/** One text face for page, picture and SVG: named, never embedded. */
const FACE = '"Inter", "Segoe UI", system-ui, "Helvetica Neue", "DejaVu Sans", sans-serif';

/** Sizes in CSS pixels. */
const TEXT = 11.5;
const ROOM = { left: 54, right: 14, axis: 48, top: 14, bottom: 26 };
const BETWEEN_X = 72;
const BETWEEN_Y = 28;

/**
 * Where the plot stands on its canvas [device pixels].
 * @typedef {{left: number, top: number, width: number, height: number, unit: number}} Frame unit: pixels of a CSS pixel
 */

/** @returns {Frame} */
export function frameOf(width, height, unit, axes) {
  const left = Math.round(ROOM.left * unit);
  const right = Math.round((axes > 1 ? ROOM.axis : ROOM.right) * unit);
  const top = Math.round(ROOM.top * unit);
  const bottom = Math.round(ROOM.bottom * unit);
  return { left, top, width: Math.max(8, width - left - right), height: Math.max(8, height - top - bottom), unit };
}

export function font(unit, size = TEXT, weight = 400) {
  return `${weight} ${Math.round(size * unit * 10) / 10}px ${FACE}`;
}

/** Lines of one device pixel's grid, crisp. */
export function hair(context, frame, colour, lines) {
  context.strokeStyle = colour;
  context.lineWidth = Math.max(1, Math.round(frame.unit));
  context.lineCap = "butt";
  const half = context.lineWidth % 2 ? 0.5 : 0;
  context.beginPath();
  for (const [x0, y0, x1, y1] of lines) {
    context.moveTo(Math.round(x0) + (x0 === x1 ? half : 0), Math.round(y0) + (y0 === y1 ? half : 0));
    context.lineTo(Math.round(x1) + (x0 === x1 ? half : 0), Math.round(y1) + (y0 === y1 ? half : 0));
  }
  context.stroke();
}

/** Pixel of a coordinate on the horizontal axis. */
export function placeX(frame, [low, high], value) {
  return frame.left + ((value - low) / (high - low)) * frame.width;
}

/** Pixel of a value on a vertical axis. */
export function placeY(frame, [low, high], value) {
  return frame.top + ((high - value) / (high - low)) * frame.height;
}

/**
 * Marks of the horizontal axis with their lines.
 * @param {{at: number, text: string}[]} labels
 */
export function drawX(context, frame, paper, ends, labels) {
  const bottom = frame.top + frame.height;
  const at = labels.map((label) => placeX(frame, ends, label.at));
  hair(
    context,
    frame,
    paper.grid,
    at.map((x) => [x, frame.top, x, bottom]),
  );
  context.fillStyle = paper.soft;
  context.font = font(frame.unit);
  context.textBaseline = "top";
  context.textAlign = "center";
  labels.forEach((label, k) => context.fillText(label.text, at[k], bottom + 8 * frame.unit));
}

/**
 * One vertical axis.
 * @param {{unit: string, ends: [number, number], step: number|null, colour: string}} axis step: of an axis that was fitted
 * @param {number} side 0 left (with the grid), 1 right
 */
export function drawY(context, frame, paper, axis, side) {
  const { step, at, decimals } = marksOf(frame, axis);
  const right = frame.left + frame.width;
  const y = at.map((value) => placeY(frame, axis.ends, value));
  if (side === 0)
    hair(
      context,
      frame,
      paper.grid,
      y.map((row) => [frame.left, row, right, row]),
    );
  else
    hair(
      context,
      frame,
      paper.line,
      y.map((row) => [right, row, right + 4 * frame.unit, row]),
    );
  const zero = at.indexOf(0);
  if (side === 0 && zero >= 0) hair(context, frame, paper.line, [[frame.left, y[zero], right, y[zero]]]);
  context.fillStyle = axis.colour;
  context.font = font(frame.unit);
  context.textBaseline = "middle";
  context.textAlign = side === 0 ? "right" : "left";
  const x = side === 0 ? frame.left - 7 * frame.unit : right + 8 * frame.unit;
  at.forEach((value, k) => context.fillText(quantity(value, decimals, axis.unit), x, y[k]));
  return step;
}

function marksOf(frame, { ends, step }) {
  const wanted = Math.max(2, Math.min(8, Math.floor(frame.height / (BETWEEN_Y * frame.unit))));
  if (!step) return marks(ends[0], ends[1], wanted);
  const many = Math.round((ends[1] - ends[0]) / step);
  return marks(ends[0], ends[1], many <= wanted ? many : wanted);
}

/** Marks of an axis of numbers, for `drawX`. */
export function labelsX(frame, [low, high], unit) {
  const { at, decimals } = marks(low, high, Math.max(2, Math.floor(frame.width / (BETWEEN_X * frame.unit))));
  return at.map((value) => ({ at: value, text: quantity(value, decimals, unit) }));
}

/** The line around the plot. */
export function drawBorder(context, frame, paper) {
  const { left, top } = frame;
  const [right, bottom] = [left + frame.width, top + frame.height];
  hair(context, frame, paper.line, [
    [left, top, left, bottom],
    [left, bottom, right, bottom],
    [right, top, right, bottom],
    [left, top, right, top],
  ]);
}

/** Words in the middle of an empty plot. */
export function drawWords(context, frame, paper, text) {
  context.fillStyle = paper.soft;
  context.font = font(frame.unit, 13);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, frame.left + frame.width / 2, frame.top + frame.height / 2);
}

/** A small label on its own ground, kept within the plot. */
export function drawTag(context, frame, paper, text, x, y, colour) {
  context.font = font(frame.unit, 11.5, 500);
  const wide = context.measureText(text).width + 10 * frame.unit;
  const high = 18 * frame.unit;
  const left = Math.min(Math.max(x - wide / 2, frame.left), frame.left + frame.width - wide);
  const top = Math.min(Math.max(y - high / 2, frame.top), frame.top + frame.height - high);
  context.fillStyle = paper.card;
  context.fillRect(left, top, wide, high);
  hair(context, frame, colour, [
    [left, top, left + wide, top],
    [left, top + high, left + wide, top + high],
    [left, top, left, top + high],
    [left + wide, top, left + wide, top + high],
  ]);
  context.fillStyle = paper.ink;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, left + wide / 2, top + high / 2);
}
