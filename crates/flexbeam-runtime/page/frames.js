// Sample frames. Enters: one binary message of the wire. Leaves: ticks and one column of numbers for each signal.
// The columns are views into the message: nothing is copied. Every browser's machine is little endian, as the wire is.

const MAGIC = 0x31534246;
const HEAD_BYTES = 24;

/**
 * @param {ArrayBuffer} message
 * @returns {{first: number, ticks: Uint32Array, columns: Float32Array[], lost: number}} first: tick of the first row; ticks:
 *   offsets from it; columns: in the order of the signals of `hello`; lost: rows that were lost just before these
 * @throws {Error} when the message is no sample frame, with what was found and what was needed
 */
export function decode(message) {
  if (message.byteLength < HEAD_BYTES) throw new Error(`found a frame of ${message.byteLength} bytes, needed ${HEAD_BYTES} or more`);
  const head = new DataView(message);
  const magic = head.getUint32(0, true);
  if (magic !== MAGIC) throw new Error(`found a frame that begins with ${magic.toString(16)}, needed ${MAGIC.toString(16)}`);
  const [rows, channels] = [head.getUint32(4, true), head.getUint32(16, true)];
  const needed = HEAD_BYTES + 4 * rows * (1 + channels);
  if (message.byteLength !== needed) throw new Error(`found a frame of ${message.byteLength} bytes, needed ${needed} for ${rows} rows of ${channels} signals`);
  const column = (k) => new Float32Array(message, HEAD_BYTES + 4 * rows * (1 + k), rows);
  return {
    first: head.getFloat64(8, true),
    ticks: new Uint32Array(message, HEAD_BYTES, rows),
    columns: Array.from({ length: channels }, (_, k) => column(k)),
    lost: head.getUint32(20, true),
  };
}
