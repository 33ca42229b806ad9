import { decode } from "../page/frames.js";
import { check, same } from "./check.js";

/** A message as the wire describes it, written byte by byte. */
function message({ magic = 0x31534246, first, ticks, columns, lost = 0, more = 0 }) {
  const [n, m] = [ticks.length, columns.length];
  const buffer = new ArrayBuffer(24 + 4 * n * (1 + m) + more);
  const view = new DataView(buffer);
  view.setUint32(0, magic, true);
  view.setUint32(4, n, true);
  view.setFloat64(8, first, true);
  view.setUint32(16, m, true);
  view.setUint32(20, lost, true);
  ticks.forEach((tick, k) => view.setUint32(24 + 4 * k, tick, true));
  columns.forEach((column, c) => column.forEach((value, k) => view.setFloat32(24 + 4 * n * (1 + c) + 4 * k, value, true)));
  return buffer;
}

function refusal(buffer) {
  try {
    decode(buffer);
  } catch (error) {
    return error.message;
  }
  throw new Error("needed a refusal, found none");
}

export function everyNumberComesBack() {
  const first = 2 ** 52 + 1;
  const frame = decode(message({ first, ticks: [0, 1, 5], columns: [[1, NaN, -3.5], [0.25, 4, 1e-7]], lost: 7 }));
  same([frame.first, frame.lost, [...frame.ticks]], [first, 7, [0, 1, 5]], "head and ticks");
  same(frame.columns.map((column) => [...column]), [[1, NaN, -3.5], [0.25, 4, Math.fround(1e-7)]], "columns");
}

export function nothingIsCopied() {
  const buffer = message({ first: 0, ticks: [0], columns: [[1], [2]] });
  const { ticks, columns } = decode(buffer);
  check([ticks, ...columns].every((part) => part.buffer === buffer), "needed views into the message");
}

export function whatIsNoFrameIsRefusedWithNumbers() {
  check(refusal(new ArrayBuffer(3)).includes("found a frame of 3 bytes"), "too short");
  check(refusal(message({ magic: 0x31534247, first: 0, ticks: [], columns: [] })).includes("31534247"), "another magic");
  const long = refusal(message({ first: 0, ticks: [0], columns: [[1]], more: 4 }));
  check(long.includes("36 bytes") && long.includes("needed 32"), long);
}
