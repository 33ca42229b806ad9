//! Lagged correlations in plain f64, and whether they are good enough.
//!
//! Enters: a whole record in memory. Leaves: its Gram matrix when rounding provably drowns in the record's own noise, else nothing.
//! Deliberately absent: records that arrive in chunks; a second look would need the first again.

use flexbeam_lti::Mat;

use super::channels::Channels;
use super::gram::{Ends, Gram};
use super::kernel::PIECE;
use super::record::Sums;
use super::rounding::exponent;
use crate::double::{Double, power_of_two};
use crate::lanes::{Kernel, LANES, Lanes, on_widest};
use crate::shares::each;

/// Pieces whose sums one thread adds up; fixed, so that the order of additions is.
const PIECES: usize = 32;
/// Rounding of one entry of the scaled Gram matrix, at most: 2^7 fused products a lane and the additions of eight lanes, each half a
/// unit in the last place of the sum of magnitudes. What follows is added in double-double.
const ROUNDING: f64 = 140.0 * 0.5 * f64::EPSILON;
/// Products for each cube of the number of rows, below which the verdict would cost more than plain sums save.
const WORTH: usize = 4;
/// Samples that foretell the verdict.
const PROBE: usize = 1 << 15;
/// Part of a Gram matrix's own sampling fluctuation that its rounding may have.
const PART: f64 = 1e-2;

/// The Gram matrix of a record; None when rounding could be told from noise, or the record is not finite, or too short to be worth it.
///
/// Numerics: let R be the matrix of the rows less their means, scaled by the lengths of the rows themselves, L L' its factor, n its rows. Whatever offsets are put back later, the matrix
/// is R plus something positive, so that what R stands, it stands. Rounding makes it L (I + W) L' with |W| <= n rounding / lambda, lambda the least
/// eigenvalue of R. The record's finite length does the same: the Gram matrix of j independent columns is L0 (I + F) L0' with |F| about 2 sqrt(n / j), and
/// never below sqrt(1 / j). What |W| <= PART sqrt(1 / j) changes is at most a hundredth of what another record of the same length would have changed. Without noise lambda
/// is zero, and the answer is None.
pub(crate) fn fast_gram(channels: &Channels, i: usize, threads: usize) -> Option<Gram> {
    let (s, n) = (channels.samples(), 2 * i * channels.count());
    // The verdict costs as much as the sums of some records, and a stretch of the record foretells it.
    let worth = s * n * channels.count() >= WORTH * n.pow(3);
    let promising = || s <= 4 * PROBE || plain_gram(&channels.part(0..PROBE), s, i, threads).is_some();
    if worth && promising() { plain_gram(channels, s, i, threads) } else { None }
}

/// As [`fast_gram`], judged as if there were `length` samples.
fn plain_gram(channels: &Channels, length: usize, i: usize, threads: usize) -> Option<Gram> {
    let (c, s, lags) = (channels.count(), channels.samples(), 2 * i);
    let columns = (s + 1).saturating_sub(lags);
    if columns < lags {
        return None;
    }
    let offset: Vec<f64> = (0..c).map(|a| channels.standing(a, PIECE.min(s))).collect();
    let largest = each(0..c, threads, |a| channels.largest(a, 0..s, offset[a]));
    if !largest.iter().all(|x| x.is_finite()) {
        return None;
    }
    let exponents: Vec<i32> = largest.iter().map(|x| exponent(*x)).collect();
    let record = Scaled { channels, offset: &offset, exponents: &exponents };
    let middle = record.middle(lags, columns, threads);
    let ends = Ends { head: record.part(0..2 * (lags - 1)), tail: record.part(columns..s) };
    let gram = Gram::of_record(i, s, offset.clone(), exponents.clone(), middle, ends);
    drowns(&gram, length).then_some(gram)
}

/// |W| <= PART sqrt(1 / j) for j columns, as many as samples or fewer, with the least eigenvalue of R bounded from below by 1 / |L^-1|^2.
fn drowns(gram: &Gram, length: usize) -> bool {
    let n = 2 * gram.i * gram.channels();
    let lengths: Vec<f64> = (0..n).map(|r| gram.product(r, r).value().sqrt()).collect();
    let share = Double::new(gram.columns as f64).reciprocal();
    let centred = |r: usize, q: usize| gram.product(r, q) - gram.sum(r) * gram.sum(q) * share;
    let scaled = |r: usize, q: usize| centred(r, q).value() / (lengths[r] * lengths[q]);
    let Some(cholesky) = Mat::from_fn(n, n, scaled).cholesky() else { return false };
    let Some(inverse) = cholesky.l().solve_lower_triangular(&Mat::identity(n, n)) else { return false };
    // The factor's own rounding, and the conversion's, come on top of the sums'.
    let rounding = n as f64 * (ROUNDING + n as f64 * f64::EPSILON);
    let least = inverse.norm_squared().recip() - rounding;
    rounding <= PART * least / (length as f64).sqrt()
}

/// Samples less the offset, in units of the exponents.
struct Scaled<'a> {
    channels: &'a Channels<'a>,
    offset: &'a [f64],
    exponents: &'a [i32],
}

impl Scaled<'_> {
    fn copy(&self, a: usize, first: usize, target: &mut [f64]) {
        self.channels.copy(a, first, self.offset[a], target);
        let down = power_of_two((-self.exponents[a]).clamp(-1022, 1023));
        target.iter_mut().for_each(|x| *x *= down);
    }

    fn part(&self, range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
        let mut found = vec![vec![0.0; range.len()]; self.exponents.len()];
        found.iter_mut().enumerate().for_each(|(a, z)| self.copy(a, range.start, z));
        found
    }

    /// Sums over the left samples `lags - 1..columns`.
    fn middle(&self, lags: usize, columns: usize, threads: usize) -> Sums<Double> {
        let (c, first) = (self.exponents.len(), lags - 1);
        let pieces = (columns - first).div_ceil(PIECE);
        let groups = each(0..pieces.div_ceil(PIECES), threads, |group| {
            let mut sums = Sums::zero(c, lags);
            let mut room = Room::new(c, lags);
            for piece in group * PIECES..pieces.min((group + 1) * PIECES) {
                let start = first + piece * PIECE;
                self.add_piece(start, PIECE.min(columns - start), &mut room, &mut sums);
            }
            sums
        });
        let mut all = Sums::zero(c, lags);
        for group in &groups {
            all.products.iter_mut().zip(&group.products).for_each(|(a, b)| *a += *b);
            all.firsts.iter_mut().zip(&group.firsts).for_each(|(a, b)| *a += *b);
        }
        all
    }

    fn add_piece(&self, first: usize, count: usize, room: &mut Room, sums: &mut Sums<Double>) {
        let (c, lags, long) = (self.exponents.len(), room.lags, PIECE + room.lags);
        let padded = count.next_multiple_of(LANES);
        for a in 0..c {
            let window = &mut room.window[a * long..(a + 1) * long];
            window.fill(0.0);
            self.copy(a, first, &mut window[..count + lags - 1]);
            room.left[a * PIECE..][..count].copy_from_slice(&window[..count]);
            room.left[a * PIECE..][count..padded].fill(0.0);
            sums.firsts[a] += Double::new(window[..count].iter().sum());
        }
        for b in 0..c {
            let right = &room.window[b * long..(b + 1) * long];
            for (pair, left) in room.left.chunks(2 * PIECE).enumerate() {
                on_widest(Lagged { left, padded, right, lags, found: &mut room.found });
                for (a, found) in room.found.chunks_exact(lags).take(left.len() / PIECE).enumerate() {
                    for (d, product) in found.iter().enumerate() {
                        sums.products[(d * c + 2 * pair + a) * c + b] += Double::new(*product);
                    }
                }
            }
        }
    }
}

/// Room for one piece.
struct Room {
    lags: usize,
    /// Channel after channel: a piece, and the lags that follow it.
    window: Vec<f64>,
    /// Channel after channel: a piece, then zeros.
    left: Vec<f64>,
    found: Vec<f64>,
}

impl Room {
    fn new(c: usize, lags: usize) -> Room {
        Room { lags, window: vec![0.0; c * (PIECE + lags)], left: vec![0.0; c * PIECE], found: vec![0.0; 2 * lags] }
    }
}

/// found\[a lags + d\] = sum over k of left\[a\]\[k\] right\[k + d\] for one or two left channels.
struct Lagged<'a, 'b> {
    left: &'a [f64],
    padded: usize,
    right: &'a [f64],
    lags: usize,
    found: &'b mut [f64],
}

impl Kernel for Lagged<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let mut d = 0;
        while d < self.lags {
            let wide = if self.lags - d >= L::TILE { L::TILE } else { 1 };
            match (self.left.len() > PIECE, wide) {
                (true, 4) => self.tile::<L, 2, 4>(d),
                (true, 3) => self.tile::<L, 2, 3>(d),
                (true, _) => self.tile::<L, 2, 1>(d),
                (false, 4) => self.tile::<L, 1, 4>(d),
                (false, 3) => self.tile::<L, 1, 3>(d),
                (false, _) => self.tile::<L, 1, 1>(d),
            }
            d += wide;
        }
    }
}

impl Lagged<'_, '_> {
    /// D lags of A left channels.
    #[inline(always)]
    fn tile<L: Lanes, const A: usize, const D: usize>(&mut self, d: usize) {
        let mut sums = [[L::splat(0.0); D]; A];
        let right = &self.right[d..];
        let mut k = 0;
        while k < self.padded {
            let mut x = [L::splat(0.0); A];
            for (a, x) in x.iter_mut().enumerate() {
                *x = L::load(&self.left[a * PIECE + k..]);
            }
            for n in 0..D {
                let y = L::load(&right[k + n..]);
                for a in 0..A {
                    sums[a][n] = x[a].times_plus(y, sums[a][n]);
                }
            }
            k += LANES;
        }
        for (a, sums) in sums.iter().enumerate() {
            for (n, sum) in sums.iter().enumerate() {
                self.found[a * self.lags + d + n] = sum.total();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::Record;
    use crate::excitation::white_gaussian;

    /// y(k) = 1.8 y(k-1) - 0.9 y(k-2) + u(k-1), with noise of this part of its rms.
    fn record(samples: usize, noise: f64) -> Mat {
        let (u, e) = (white_gaussian(samples, 1.0, 9.0, 1), white_gaussian(samples, 1.0, 9.0, 2));
        let mut y = vec![0.0; samples];
        (2..samples).for_each(|k| y[k] = 1.8 * y[k - 1] - 0.9 * y[k - 2] + u[k - 1]);
        let rms = (y.iter().map(|x| x * x).sum::<f64>() / samples as f64).sqrt();
        Mat::from_fn(samples, 2, |k, c| if c == 0 { u[k] } else { y[k] + noise * rms * e[k] })
    }

    fn exact(data: &Mat, i: usize) -> Gram {
        let mut record = Record::new(data.ncols(), i);
        record.absorb(&Channels::of_columns(data), 1).unwrap();
        record.finish()
    }

    /// Each entry is within the bound that the criterion reckons with, and threads change no bit.
    #[test]
    fn entries_keep_the_promised_digits() {
        for samples in [6000, 180_000] {
            let data = record(samples, 1e-2).insert_column(1, 0.3);
            let data =
                Mat::from_fn(samples, 3, |k, c| if c == 1 { 1e3 + data[(k, 0)] * data[(k, 2)] } else { data[(k, c)] });
            let zero = [0.0; 3];
            let fast = fast_gram(&Channels::of_columns(&data), 4, 1).unwrap().about(&zero);
            let shared = fast_gram(&Channels::of_columns(&data), 4, 3).unwrap().about(&zero);
            let wanted = exact(&data, 4).about(&zero);
            let value = |gram: &Gram, r: usize, q: usize| {
                gram.product(r, q).shifted(gram.exponents()[r % 3] + gram.exponents()[q % 3])
            };
            for r in 0..24 {
                for q in 0..24 {
                    let size = (value(&wanted, r, r).hi * value(&wanted, q, q).hi).sqrt();
                    let error = (value(&fast, r, q) - value(&wanted, r, q)).value().abs() / size;
                    assert!(error < ROUNDING, "{samples} samples, ({r},{q}): {error:e}");
                    assert_eq!(fast.product(r, q), shared.product(r, q));
                }
            }
        }
    }

    /// Noise of a percent or a thousandth drowns the rounding; less, none, or an offset that dwarfs the signal, do not.
    #[test]
    fn only_noise_lets_plain_sums_pass() {
        let passes = |data: &Mat| fast_gram(&Channels::of_columns(data), 10, 1).is_some();
        assert!(passes(&record(20_000, 1e-2)));
        assert!(passes(&record(20_000, 1e-3)));
        for noise in [1e-6, 1e-9, 0.0] {
            assert!(!passes(&record(20_000, noise)), "noise {noise:e}");
        }
        let mut twin = record(20_000, 1e-2).insert_column(2, 0.0);
        let column = twin.column(0) * 3.0;
        twin.set_column(2, &column);
        assert!(!passes(&twin), "an input twice");
        let mut bad = record(20_000, 1e-2);
        bad[7] = f64::NAN;
        assert!(!passes(&bad));
        assert!(!passes(&record(1000, 1e-2)), "too short");
    }

    #[test]
    fn every_kind_of_lanes_with_fused_products_has_the_same_bits() {
        let (left, right) = (white_gaussian(2 * PIECE, 1.0, 9.0, 3), white_gaussian(PIECE + 40, 1.0, 9.0, 4));
        #[derive(Clone)]
        struct Job<'a>(&'a [f64], &'a [f64]);
        impl Kernel for Job<'_> {
            type Output = Vec<f64>;
            #[inline(always)]
            fn run<L: Lanes>(self) -> Vec<f64> {
                let mut found = vec![0.0; 2 * 41];
                Lagged { left: self.0, padded: PIECE, right: self.1, lags: 41, found: &mut found }.run::<L>();
                found
            }
        }
        let all = crate::lanes::tests::on_each(Job(&left, &right));
        for (name, found) in &all[1..] {
            assert_eq!(found, &all[1].1, "{name}");
        }
        let missed = all[0].1.iter().zip(&all.last().unwrap().1).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(missed < 1e-10, "{missed:e}");
    }
}
