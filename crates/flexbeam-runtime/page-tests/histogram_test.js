import { Histogram } from "../page/histogram.js";
import { check, near, random, same } from "./check.js";

/** The bin of a value by search among the bins' ends, not by a logarithm. */
function binOf(value) {
  let k = 0;
  while (k < 79 && value >= 10 ** (-2 + (k + 1) / 10)) k += 1;
  return k;
}

export function countsAreThoseOfBruteForce() {
  const draw = random(9);
  const values = Float32Array.from({ length: 5000 }, () => 10 ** (draw() * 10 - 3));
  const histogram = new Histogram();
  histogram.add(values, 1);
  const needed = new Float64Array(80);
  values.forEach((value) => { needed[binOf(value)] += 1; });
  same([...histogram.counts], [...needed], "counts");
  same(histogram.total, 5000, "total");
}

export function whatIsNoNumberIsLeftOut() {
  const histogram = new Histogram();
  histogram.add(Float32Array.from([NaN, 0, -1, Infinity, 2000]), 1e-3);
  same(histogram.total, 4, "total");
  same([histogram.counts[0], histogram.counts[79]], [2, 1], "nought and below in the first bin, infinity in the last");
}

export function decadesHoldEverything() {
  const histogram = new Histogram();
  same(histogram.decades, null, "nothing counted");
  histogram.add(Float32Array.from([1.5, 12]), 1);
  same(histogram.decades, [0, 2], "1 to 100 microseconds");
}

export function outlineIsAsHighAsTheShare() {
  const histogram = new Histogram();
  histogram.add(Float32Array.from([1.01, 1.01, 1.01, 50]), 1);
  const heights = [...histogram.outline([0, 2], (x) => x, (y) => y * 100).matchAll(/V([\d.]+)H/g)].map((match) => Number(match[1]));
  same(heights.length, 20, "ten bins a decade");
  near(heights[0], 75, 0.05, "first bin");
  check(heights.filter((height) => height > 0).length === 2, "two bins stand");
}
