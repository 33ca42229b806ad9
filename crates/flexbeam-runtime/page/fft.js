// Discrete Fourier transform of a power of two of real samples, and the amplitude spectrum made of it.
// Enters: samples in SI. Leaves: amplitudes in SI: a sine of amplitude A in the middle of a bin shows A.

const twiddles = new Map();

function twiddle(n) {
  if (!twiddles.has(n)) {
    const half = n / 2;
    const [cosine, sine] = [new Float64Array(half), new Float64Array(half)];
    for (let k = 0; k < half; k += 1) {
      cosine[k] = Math.cos((2 * Math.PI * k) / n);
      sine[k] = -Math.sin((2 * Math.PI * k) / n);
    }
    twiddles.set(n, { cosine, sine });
  }
  return twiddles.get(n);
}

/**
 * X[k] = sum x[j] exp(-2 pi i j k / n), in place.
 * @param {Float64Array} re
 * @param {Float64Array} im of the same length, a power of two
 */
export function transform(re, im) {
  const n = re.length;
  if (n !== im.length || n < 1 || (n & (n - 1)) !== 0) throw new RangeError(`found ${n} samples, needed a power of two`);
  reverseBits(re, im);
  const { cosine, sine } = twiddle(n);
  for (let size = 2; size <= n; size *= 2) {
    const half = size / 2;
    const step = n / size;
    for (let start = 0; start < n; start += size) {
      for (let j = 0; j < half; j += 1) {
        const [a, b] = [start + j, start + j + half];
        const [c, s] = [cosine[j * step], sine[j * step]];
        const real = re[b] * c - im[b] * s;
        const imaginary = re[b] * s + im[b] * c;
        re[b] = re[a] - real;
        im[b] = im[a] - imaginary;
        re[a] += real;
        im[a] += imaginary;
      }
    }
  }
}

function reverseBits(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i += 1) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i >= j) continue;
    [re[i], re[j]] = [re[j], re[i]];
    [im[i], im[j]] = [im[j], im[i]];
  }
}

/**
 * Amplitude spectrum: mean removed, Hann window, divided by the sum of the window.
 * @param {Float64Array} samples a power of two of them, at least 4; not changed
 * @returns {Float64Array} amplitudes of the bins 0 .. n/2; bin k is at k / (n * period)
 */
export function amplitudes(samples) {
  const n = samples.length;
  const mean = samples.reduce((sum, value) => sum + value, 0) / n;
  const re = new Float64Array(n);
  const im = new Float64Array(n);
  // The sum of a periodic Hann window is n/2; half of a sine's amplitude is at the negative frequency.
  for (let j = 0; j < n; j += 1) re[j] = (samples[j] - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * j) / n));
  transform(re, im);
  const out = new Float64Array(n / 2 + 1);
  for (let k = 0; k <= n / 2; k += 1) out[k] = Math.hypot(re[k], im[k]) * (4 / n);
  // These two bins have no negative counterpart.
  out[0] /= 2;
  out[n / 2] /= 2;
  return out;
}

/**
 * The greatest bin above zero frequency, refined by the two beside it.
 * Numerics: the ratio of neighbours under a Hann window gives frequency and amplitude of a lone sine exactly but for
 * leakage of its mirror; bins beside it must belong to the same sine.
 * @returns {{bin: number, amplitude: number}|null} bin with a fraction; null when all are zero
 */
export function peak(spectrum) {
  let k = 1;
  for (let j = 2; j < spectrum.length - 1; j += 1) if (spectrum[j] > spectrum[k]) k = j;
  if (!(spectrum[k] > 0) || k + 1 >= spectrum.length) return null;
  const right = spectrum[k + 1] > spectrum[k - 1];
  const ratio = (right ? spectrum[k + 1] : spectrum[k - 1]) / spectrum[k];
  const off = Math.max(0, Math.min(0.5, (2 * ratio - 1) / (ratio + 1)));
  // Spectrum of the Hann window `off` bins away from its middle, relative to the middle.
  const droop = off === 0 ? 1 : Math.sin(Math.PI * off) / (Math.PI * off * (1 - off * off));
  return { bin: k + (right ? off : -off), amplitude: spectrum[k] / droop };
}
