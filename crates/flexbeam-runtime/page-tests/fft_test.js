import { amplitudes, peak, transform } from "../page/fft.js";
import { evenly, powerBelow } from "../page/chart_stretch.js";
import { Store } from "../page/store.js";
import { check, frameOf, near, random, same, SIGNALS } from "./check.js";

export function agreesWithTheSum() {
  for (const n of [1, 2, 8, 64]) {
    const draw = random(n);
    const [re, im] = [Float64Array.from({ length: n }, draw), Float64Array.from({ length: n }, draw)];
    const [x, y] = [re.slice(), im.slice()];
    transform(re, im);
    for (let k = 0; k < n; k += 1) {
      let [a, b] = [0, 0];
      for (let j = 0; j < n; j += 1) {
        const phase = (-2 * Math.PI * j * k) / n;
        a += x[j] * Math.cos(phase) - y[j] * Math.sin(phase);
        b += x[j] * Math.sin(phase) + y[j] * Math.cos(phase);
      }
      near(Math.hypot(re[k] - a, im[k] - b), 0, 1e-12 * n, `n ${n}, bin ${k}`);
    }
  }
}

export function keepsEnergy() {
  const n = 2 ** 14;
  const draw = random(1);
  const re = Float64Array.from({ length: n }, () => draw() - 0.5);
  const im = new Float64Array(n);
  const before = re.reduce((sum, value) => sum + value * value, 0);
  transform(re, im);
  const after = re.reduce((sum, value, k) => sum + value * value + im[k] * im[k], 0) / n;
  near(after / before, 1, 1e-12, "Parseval");
}

export function otherLengthsAreRefused() {
  let refused = 0;
  for (const n of [0, 3, 12]) {
    try {
      transform(new Float64Array(n), new Float64Array(n));
    } catch {
      refused += 1;
    }
  }
  same(refused, 3, "refused");
}

const sine = (n, bin, amplitude, phase, mean = 0) =>
  Float64Array.from({ length: n }, (_, j) => mean + amplitude * Math.cos((2 * Math.PI * bin * j) / n + phase));

export function sineShowsItsAmplitude() {
  for (const bin of [3, 50, 511]) {
    const spectrum = amplitudes(sine(1024, bin, 0.7, 0.3, 12));
    near(spectrum[bin], 0.7, 1e-12, `bin ${bin}`);
    near(spectrum[bin + (bin < 500 ? 20 : -20)], 0, 1e-12, "far from it");
    near(spectrum[0], bin === 3 ? 0 : 0, 1e-12, "the mean is gone");
  }
}

export function peakIsFoundBetweenBins() {
  let worst = 0;
  for (let step = 0; step <= 20; step += 1) {
    const bin = 60 + step / 20;
    const found = peak(amplitudes(sine(4096, bin, 2.5, step)));
    near(found.bin, bin, 2e-4, "bin");
    near(found.amplitude, 2.5, 2.5 * 2e-4, "amplitude");
    worst = Math.max(worst, Math.abs(found.amplitude / 2.5 - 1));
  }
  same(peak(amplitudes(new Float64Array(64))), null, "nothing");
  return `amplitude off by at most ${worst.toExponential(1)}`;
}

export function gapsAreFilledByLinesAndCounted() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const rows = Array.from({ length: 1000 }, (_, k) => [k, k, 0]).filter(([tick]) => tick !== 700 && tick !== 701);
  rows[900][1] = NaN;
  store.push(frameOf(rows));
  const { values, missing } = evenly(store, 0, 999, 512);
  same(missing, 3, "missing");
  check(
    values.every((value, j) => value === 488 + j),
    `found ${values.find((value, j) => value !== 488 + j)} where a line was needed`,
  );
}

export function tooManyGapsAreNoSpectrum() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(frameOf(Array.from({ length: 1000 }, (_, k) => [k, k, 0]).filter(([tick]) => tick % 50 !== 0)));
  same(evenly(store, 0, 999, 512), null, "2 % missing");
  same(evenly(store, 0, 999, 2048), null, "not so many samples");
  same(powerBelow(1000), 512, "power of two");
}
