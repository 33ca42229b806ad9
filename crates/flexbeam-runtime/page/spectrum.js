// Amplitude spectrum of the newest stretch of the signals.
// Enters: raw samples of the span (the newest 2^k of them). Leaves: amplitude over frequency, the greatest one marked.
// Linear or in decibels over one unit; frequency logarithmic or linear. Computed five times a second.

import { drawTag, drawWords, hair, labelsX, placeX } from "./chart_axes.js";
import { Chart, clipped, spot, STROKE } from "./chart_base.js";
import { evenly, powerBelow } from "./chart_stretch.js";
import { decades, decimalsOf, quantity, readingDecimals } from "./chart_ticks.js";
import { Pen } from "./chart_traces.js";
import { ValueAxes } from "./chart_values.js";
import { colourOf, paper } from "./colours.js";
import { Cursors } from "./cursors.js";
import { amplitudes, peak } from "./fft.js";

const EVERY_MS = 200;
/** What decibels show below the greatest amplitude. */
const DEPTH_DB = 100;
/** Fewest and most samples of a spectrum. */
const FEWEST = 64;
const MOST = 2 ** 16;

export class SpectrumChart extends Chart {
  constructor(of) {
    super(of);
    this.values = new ValueAxes(true);
    this.cursors = new Cursors();
    /** Amplitudes in decibels. */
    this.decibels = of.scope.amplitude === "decibels";
    /** Frequency by decades. */
    this.logarithmic = of.scope.frequency !== "linear";
    this.spectra = new Map();
    this.made = "";
  }

  /** Decibels have one axis, whatever they are over. */
  get units() {
    return this.decibels ? ["dB"] : super.units;
  }

  axis(signal) {
    return this.decibels ? 0 : super.axis(signal);
  }

  /** How the axes are, to be saved. */
  get style() {
    return {
      amplitude: this.decibels ? "decibels" : "linear",
      frequency: this.logarithmic ? "logarithmic" : "linear",
    };
  }

  stamp(now_ms) {
    return this.frozen
      ? `frozen ${this.store.epoch}`
      : `${this.store.epoch} ${this.store.count > 0} ${Math.floor(now_ms / EVERY_MS)}`;
  }

  /** Other axes: what was chosen by hand on the old ones is void. */
  restyled() {
    this.view.reset();
    this.values.reset();
    this.cursors.on = false;
  }

  compose(frame, hidden, now_ms) {
    this.begin();
    this.compute(hidden, now_ms);
    const nyquist = 0.5 / this.store.period_s;
    const own = this.logarithmic ? [Math.log10(this.bin_hz), Math.log10(nyquist)] : [0, nyquist];
    if (this.view.x) this.view.x = within(this.view.x, own, this.logarithmic ? 0.02 : 4 * this.bin_hz);
    this.axes = { x: this.view.x ?? own, y: null };
    this.axes.y = this.fitValues(hidden, now_ms, (group) => this.extent(group), this.decibels ? null : this.configured());
    return this;
  }

  /** Spectra of what is shown, once for every picture. */
  compute(hidden, now_ms) {
    const { store } = this;
    const wanted = Math.min(this.scope.span_s / store.period_s, store.last - store.tickAt(store.rawFirst) + 1);
    const n = store.count > 0 ? Math.min(MOST, powerBelow(Math.max(1, wanted))) : 1;
    this.bin_hz = 1 / (Math.max(n, FEWEST) * store.period_s);
    this.n = n;
    const signals = this.shown(hidden);
    const made = `${this.stamp(now_ms)} ${n} ${signals.map((signal) => signal.key)} ${this.newest}`;
    if (made === this.made) return;
    this.made = made;
    this.spectra.clear();
    this.missing = 0;
    for (const signal of n < FEWEST ? [] : signals) this.computeOne(signal);
  }

  computeOne({ key, factor }) {
    const stretch = evenly(this.store, this.store.channels.get(key), this.newest, this.n);
    if (!stretch) return;
    this.missing = Math.max(this.missing, stretch.missing);
    const spectrum = amplitudes(stretch.values).map((value) => value * Math.abs(factor));
    this.spectra.set(key, { spectrum, peak: peak(spectrum) });
  }

  /** Height of an amplitude on the axis. */
  height(amplitude) {
    return this.decibels ? 20 * Math.log10(amplitude) : amplitude;
  }

  extent(group) {
    const all = group.map((signal) => this.spectra.get(signal.key)).filter(Boolean);
    const greatest = all.reduce((most, { spectrum }) => spectrum.reduce((a, b) => Math.max(a, b), most), 0);
    if (!(greatest > 0)) return [NaN, NaN];
    const top = this.height(greatest);
    return this.decibels ? [top - DEPTH_DB, top] : [0, top];
  }

  /** Coordinate of a frequency on the horizontal axis. */
  coordinate(f_hz) {
    return this.logarithmic ? Math.log10(f_hz) : f_hz;
  }

  frequency(coordinate) {
    return this.logarithmic ? 10 ** coordinate : coordinate;
  }

  render(context, frame, hidden) {
    this.drawPaper(context, frame, this.axes.x, this.labels(frame));
    const signals = this.shown(hidden).filter((signal) => this.spectra.has(signal.key));
    if (signals.length === 0) return drawWords(context, frame, paper(), this.lacking());
    clipped(context, frame, () => signals.forEach((signal) => this.drawOne(context, frame, signal)));
    signals.forEach((signal) => this.drawPeak(context, frame, signal, signal === signals[0]));
    if (this.cursors.on) this.drawCursors(context, frame, signals);
    return undefined;
  }

  lacking() {
    if (this.store.count === 0) return "No data yet";
    return this.n < FEWEST ? `A spectrum needs ${FEWEST} samples` : "More than 1 % of the samples are missing";
  }

  labels(frame) {
    if (!this.logarithmic) return labelsX(frame, this.axes.x, "Hz");
    const [low, high] = this.axes.x.map((x) => 10 ** x);
    const labels =
      high / low > 8
        ? decades(low, high).map((f_hz) => ({ at: f_hz, text: quantity(f_hz, decimalsOf(f_hz), "Hz") }))
        : labelsX(frame, [low, high], "Hz");
    return labels.map(({ at, text }) => ({ at: Math.log10(at), text }));
  }

  /** One trace: the greatest and the least amplitude of each pixel. */
  drawOne(context, frame, signal) {
    const { spectrum } = this.spectra.get(signal.key);
    const [low, high] = this.axes.y[this.axis(signal)];
    const y = (value) => ((high - Math.max(this.height(value), low - (high - low))) / (high - low)) * frame.height;
    const x = (bin) => placeX(frame, this.axes.x, this.coordinate(bin * this.bin_hz)) - frame.left;
    context.strokeStyle = colourOf(signal.key);
    context.lineWidth = STROKE * frame.unit;
    context.lineJoin = "round";
    const pen = new Pen(context);
    const [first, last] = this.axes.x.map((end) => this.frequency(end) / this.bin_hz);
    for (let bin = Math.max(1, Math.floor(first)); bin < Math.min(spectrum.length, last + 2);) {
      const column = Math.floor(x(bin));
      let [least, greatest] = [spectrum[bin], spectrum[bin]];
      const begin = bin;
      for (bin += 1; bin < spectrum.length && x(bin) < column + 1; bin += 1) {
        least = Math.min(least, spectrum[bin]);
        greatest = Math.max(greatest, spectrum[bin]);
      }
      if (bin === begin + 1) pen.to(x(begin), y(greatest));
      else [least, greatest].forEach((value) => pen.to(column + 0.5, y(value)));
    }
    pen.finish();
  }

  /** Where a point of a trace stands; null outside the plot. */
  point(frame, signal, f_hz, amplitude) {
    const [low, high] = this.axes.y[this.axis(signal)];
    const x = placeX(frame, this.axes.x, this.coordinate(f_hz));
    const y = frame.top + ((high - this.height(amplitude)) / (high - low)) * frame.height;
    const inside = x >= frame.left && x <= frame.left + frame.width && y >= frame.top && y <= frame.top + frame.height;
    return inside ? { x, y } : null;
  }

  drawPeak(context, frame, signal, named) {
    const found = this.spectra.get(signal.key).peak;
    const at = found && this.point(frame, signal, found.bin * this.bin_hz, found.amplitude);
    if (!at) return;
    spot(context, frame, colourOf(signal.key), at.x, at.y);
    const { f_hz, amplitude } = this.peakOf(signal);
    if (named) drawTag(context, frame, paper(), `${f_hz}  ${amplitude}`, at.x + 74 * frame.unit, at.y, colourOf(signal.key));
  }

  /** The greatest amplitude and its frequency in words. */
  peakOf({ key, unit }) {
    const found = this.spectra.get(key)?.peak;
    return {
      f_hz: quantity(found ? found.bin * this.bin_hz : NaN, 3, "Hz"),
      amplitude: this.amplitudeText(found ? found.amplitude : NaN, unit),
    };
  }

  amplitudeText(amplitude, unit) {
    return this.decibels ? quantity(this.height(amplitude), 1, "dB") : quantity(amplitude, readingDecimals(unit) + 1, unit);
  }

  drawCursors(context, frame, signals) {
    this.cursors.at.forEach((coordinate, k) => {
      const x = placeX(frame, this.axes.x, coordinate);
      if (x < frame.left || x > frame.left + frame.width) return;
      hair(context, frame, paper().ink, [[x, frame.top, x, frame.top + frame.height]]);
      for (const signal of signals) {
        const at = this.point(frame, signal, this.frequency(coordinate), this.amplitudeAt(signal.key, coordinate));
        if (at) spot(context, frame, colourOf(signal.key), at.x, at.y);
      }
      drawTag(context, frame, paper(), "AB"[k], x, frame.top + 9 * frame.unit, paper().ink);
    });
  }

  /** Amplitude of the bin nearest to a place. */
  amplitudeAt(key, coordinate) {
    return this.spectra.get(key)?.spectrum[Math.round(this.frequency(coordinate) / this.bin_hz)] ?? NaN;
  }

  /** Ticks that the spectra are made of: [begin, end). */
  stretchTicks() {
    return { begin: this.newest + 1 - this.n, end: this.newest + 1 };
  }

  /** Peaks, and what the cursors read. */
  table(hidden) {
    if (!this.axes) return null;
    const signals = this.shown(hidden);
    const cursors = this.cursors.on ? this.cursors.at : [];
    const heads = cursors.map((coordinate, k) => `${"AB"[k]}: ${quantity(this.frequency(coordinate), 3, "Hz")}`);
    const rows = signals.map((signal) => {
      const { f_hz, amplitude } = this.peakOf(signal);
      const read = cursors.map((coordinate) => this.amplitudeText(this.amplitudeAt(signal.key, coordinate), signal.unit));
      return { cells: [signal.label, f_hz, amplitude, ...read], colour: colourOf(signal.key) };
    });
    const units = [...new Set(signals.map((signal) => quantity(1, 0, signal.unit)))];
    const over = this.decibels ? `; dB over ${units.join(", ")}` : "";
    const lacking = this.missing > 0 ? `; ${this.missing} missing ones interpolated` : "";
    const note = `${this.n} samples, Hann window, bins of ${quantity(this.bin_hz, 4, "Hz")}${over}${lacking}`;
    return { head: ["Signal", "Peak at", "Amplitude", ...heads], rows, note };
  }
}

/** Ends kept within the axis, and not closer than `least`. */
function within([low, high], [bottom, top], least) {
  const length = Math.min(Math.max(high - low, least), top - bottom);
  const from = Math.min(Math.max((low + high - length) / 2, bottom), top - length);
  return [from, from + length];
}
