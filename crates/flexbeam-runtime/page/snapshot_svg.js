// A drawing context that writes SVG: what plots draw on a canvas, as vectors that stand alone.
// Enters: the calls of a canvas context that plots use, and no others. Leaves: text of an SVG file.

const ANCHORS = { left: "start", center: "middle", right: "end" };
/** From the line that text hangs on to its base line, in heights of the text. */
const DROP = { top: 0.8, middle: 0.35, alphabetic: 0 };

export class SvgContext {
  constructor(width, height) {
    this.width = width;
    this.height = height;
    this.parts = [];
    this.clips = [];
    this.commands = [];
    this.states = [];
    this.dx = 0;
    this.dy = 0;
    this.clipped = null;
    Object.assign(this, {
      fillStyle: "#000",
      strokeStyle: "#000",
      lineWidth: 1,
      lineJoin: "miter",
      lineCap: "butt",
      globalAlpha: 1,
      font: "10px sans-serif",
      textAlign: "left",
      textBaseline: "alphabetic",
    });
    this.ruler = document.createElement("canvas").getContext("2d");
  }

  save() {
    this.states.push([this.dx, this.dy, this.clipped]);
  }

  restore() {
    [this.dx, this.dy, this.clipped] = this.states.pop();
  }

  translate(x, y) {
    this.dx += x;
    this.dy += y;
  }

  beginPath() {
    this.commands = [];
  }

  moveTo(x, y) {
    this.commands.push(`M${this.at(x, y)}`);
  }

  lineTo(x, y) {
    this.commands.push(`L${this.at(x, y)}`);
  }

  /** A whole circle: plots draw no other arcs. */
  arc(x, y, r) {
    const round = short(r);
    this.commands.push(
      `M${this.at(x - r, y)}a${round} ${round} 0 1 0 ${short(2 * r)} 0a${round} ${round} 0 1 0 ${short(-2 * r)} 0`,
    );
  }

  rect(x, y, width, height) {
    this.commands.push(`M${this.at(x, y)}h${short(width)}v${short(height)}h${short(-width)}z`);
  }

  clip() {
    const id = `clip${this.clips.length}`;
    this.clips.push(`<clipPath id="${id}"><path d="${this.commands.join("")}"/></clipPath>`);
    this.clipped = id;
  }

  stroke() {
    const join = this.lineJoin === "miter" ? "" : ` stroke-linejoin="${this.lineJoin}"`;
    const cap = this.lineCap === "butt" ? "" : ` stroke-linecap="${this.lineCap}"`;
    this.path(` fill="none" stroke="${this.strokeStyle}" stroke-width="${short(this.lineWidth)}"${join}${cap}`);
  }

  fill() {
    this.path(` fill="${this.fillStyle}"`);
  }

  /** A path; one that goes on like the one before is joined to it. */
  path(look) {
    if (this.commands.length === 0) return;
    const all = look + this.common();
    const before = this.parts[this.parts.length - 1];
    const d = this.commands.join("");
    if (before?.look === all) {
      const again = before.end === this.commands[0].slice(1);
      before.d.push(again ? this.commands.slice(1).join("") : d);
    } else this.parts.push({ look: all, d: [d] });
    this.parts[this.parts.length - 1].end = this.commands[this.commands.length - 1].slice(1);
  }

  fillRect(x, y, width, height) {
    this.parts.push(
      `<rect x="${short(x + this.dx)}" y="${short(y + this.dy)}" width="${short(width)}" height="${short(height)}" fill="${this.fillStyle}"${this.common()}/>`,
    );
  }

  fillText(text, x, y) {
    const [, weight, size, face] = /^(?:(\d+) )?([\d.]+)px (.*)$/.exec(this.font);
    const base = y + this.dy + DROP[this.textBaseline] * Number(size);
    const named = ` font-family="${escape(face)}" font-size="${size}" font-weight="${weight ?? 400}"`;
    this.parts.push(
      `<text x="${short(x + this.dx)}" y="${short(base)}" text-anchor="${ANCHORS[this.textAlign]}"${named} fill="${this.fillStyle}"${this.common()}>${escape(text)}</text>`,
    );
  }

  measureText(text) {
    this.ruler.font = this.font;
    return this.ruler.measureText(text);
  }

  common() {
    const faint = this.globalAlpha < 1 ? ` opacity="${short(this.globalAlpha)}"` : "";
    return faint + (this.clipped ? ` clip-path="url(#${this.clipped})"` : "");
  }

  at(x, y) {
    return `${short(x + this.dx)} ${short(y + this.dy)}`;
  }

  /** The file. */
  text(title) {
    const body = this.parts.map((part) => (typeof part === "string" ? part : `<path d="${part.d.join("")}"${part.look}/>`));
    const size = `width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}"`;
    const style = "<style>text{font-variant-numeric:tabular-nums}</style>";
    return [
      `<svg xmlns="http://www.w3.org/2000/svg" ${size} role="img">`,
      `<title>${escape(title)}</title>`,
      style,
      `<defs>${this.clips.join("")}</defs>`,
      ...body,
      "</svg>",
      "",
    ].join("\n");
  }
}

/** Hundredths of a pixel. */
function short(value) {
  return String(Math.round(value * 100) / 100);
}

function escape(text) {
  return text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
}
