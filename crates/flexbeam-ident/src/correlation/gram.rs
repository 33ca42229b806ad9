//! H H' of block Hankel matrices, from lagged correlations and the ends of the records.
//!
//! Enters: sums over the middle of a record, its first and last samples. Leaves: a Gram matrix in double-double; Gram matrices of other
//! experiments, or of overlapping shards of one record, add. Deliberately absent: triangular factors.

use super::record::Sums;
use super::rounding::exponent;
use crate::double::Double;

/// First 4i - 2 and last 2i - 1 samples of a record, channel by channel.
pub(super) struct Ends {
    pub head: Vec<Vec<f64>>,
    pub tail: Vec<Vec<f64>>,
}

/// H H' with H = [z(p + k)], block rows p = 0..2i-1, columns k, z the channels less `offset` in units of 2^exponent.
///
/// Row (p, a), channel a in block row p, stands at p c + a.
#[derive(Clone)]
pub(crate) struct Gram {
    /// Block rows i.
    pub i: usize,
    /// Columns of H, all records together.
    pub columns: usize,
    /// Samples, all records together.
    pub samples: usize,
    offset: Vec<f64>,
    exponents: Vec<i32>,
    /// 2ic square, symmetric.
    products: Vec<Double>,
    /// H times a column of ones.
    sums: Vec<Double>,
    /// Sum and sum of squares of each channel over all samples.
    moments: Vec<[Double; 2]>,
}

impl Gram {
    /// Block (p, p + d) is the middle's sum of lag d, plus what comes before it and after it: only sums of products, no differences. A row's diagonal
    /// entry is a sum of squares, so no entry loses more than its own rows' lengths allow.
    pub(super) fn of_record(
        i: usize,
        samples: usize,
        offset: Vec<f64>,
        exponents: Vec<i32>,
        middle: Sums<Double>,
        ends: Ends,
    ) -> Gram {
        let c = exponents.len();
        let columns = (samples + 1).saturating_sub(2 * i);
        let mut gram = Gram {
            i,
            columns,
            samples,
            offset,
            exponents,
            products: vec![Double::ZERO; (2 * i * c).pow(2)],
            sums: vec![Double::ZERO; 2 * i * c],
            moments: vec![[Double::ZERO; 2]; c],
        };
        let reach = 2 * i - 1;
        if columns < reach {
            gram.add_short(&ends.head);
            return gram;
        }
        for d in 0..2 * i {
            for a in 0..c {
                for b in 0..c {
                    let product = |z: &[Vec<f64>], k: usize| Double::product(z[a][k], z[b][k + d]);
                    let middle = middle.products[(d * c + a) * c + b];
                    gram.set_diagonal((a, b, d), middle, |k| product(&ends.head, k), |k| product(&ends.tail, k));
                }
            }
        }
        gram.sums_and_moments(&middle, &ends);
        gram
    }

    /// Blocks (p, p + d) for all p, entry (a, b), from the sum over the middle and single products before and after it.
    fn set_diagonal(
        &mut self,
        (a, b, d): (usize, usize, usize),
        middle: Double,
        before: impl Fn(usize) -> Double,
        after: impl Fn(usize) -> Double,
    ) {
        let (c, reach, most) = (self.exponents.len(), 2 * self.i - 1, 2 * self.i - d);
        let n = 2 * self.i * c;
        // Row p takes the samples p..2i-1 before the middle and the first p after it.
        let mut late = Double::ZERO;
        let mut lates = Vec::with_capacity(most);
        for p in 0..most {
            lates.push(late);
            if p + 1 < most {
                late += after(p);
            }
        }
        let mut early = Double::ZERO;
        for k in (most..reach).rev() {
            early += before(k);
        }
        for p in (0..most).rev() {
            if p < reach {
                early += before(p);
            }
            let sum = middle + (early + lates[p]);
            let (row, column) = (p * c + a, (p + d) * c + b);
            self.products[row * n + column] = sum;
            self.products[column * n + row] = sum;
        }
    }

    fn sums_and_moments(&mut self, middle: &Sums<Double>, ends: &Ends) {
        let (c, reach) = (self.exponents.len(), 2 * self.i - 1);
        let total = |terms: &mut dyn Iterator<Item = Double>| terms.fold(Double::ZERO, |sum, x| sum + x);
        for a in 0..c {
            let (head, tail) = (&ends.head[a][..reach], &ends.tail[a]);
            for p in 0..2 * self.i {
                let ends = total(&mut head[p.min(reach)..].iter().chain(&tail[..p]).map(|x| Double::new(*x)));
                self.sums[p * c + a] = middle.firsts[a] + ends;
            }
            let all = || head.iter().chain(tail);
            let square = total(&mut all().map(|x| Double::product(*x, *x)));
            self.moments[a] =
                [middle.firsts[a] + total(&mut all().map(|x| Double::new(*x))), middle.products[a * c + a] + square];
        }
    }

    /// A record too short to have a middle: every product by itself.
    fn add_short(&mut self, z: &[Vec<f64>]) {
        let c = z.len();
        let n = self.sums.len();
        for row in 0..n {
            let left = &z[row % c][(row / c).min(z[0].len())..];
            let left = &left[..self.columns.min(left.len())];
            self.sums[row] = left.iter().fold(Double::ZERO, |sum, x| sum + Double::new(*x));
            for column in 0..=row {
                let right = &z[column % c][(column / c).min(z[0].len())..];
                let products = left.iter().zip(right).map(|(x, y)| Double::product(*x, *y));
                let sum = products.fold(Double::ZERO, |sum, x| sum + x);
                self.products[row * n + column] = sum;
                self.products[column * n + row] = sum;
            }
        }
        for (moments, z) in self.moments.iter_mut().zip(z) {
            z.iter().for_each(|x| *moments = [moments[0] + Double::new(*x), moments[1] + Double::product(*x, *x)]);
        }
    }

    /// The Gram matrix of the channels less other offsets: (z - o)(z - o)' is linear in what is known.
    pub fn about(&self, offset: &[f64]) -> Gram {
        let differences: Vec<(f64, f64)> =
            self.offset.iter().zip(offset).map(|(old, new)| crate::double::two_sum(*old, -new)).collect();
        if differences.iter().all(|d| d.0 == 0.0) {
            return self.clone();
        }
        let exponents: Vec<i32> = self.exponents.iter().zip(&differences).map(|(e, d)| exponent(d.0).max(*e)).collect();
        let mut gram = self.in_units(&exponents);
        let c = exponents.len();
        let shift: Vec<Double> =
            differences.iter().zip(&exponents).map(|(d, e)| Double { hi: d.0, lo: d.1 }.shifted(-e)).collect();
        let n = gram.sums.len();
        let count = Double::new(self.columns as f64);
        for row in 0..n {
            for column in 0..n {
                let (r, q) = (shift[row % c], shift[column % c]);
                gram.products[row * n + column] += gram.sums[row] * q + r * gram.sums[column] + count * (r * q);
            }
        }
        (0..n).for_each(|row| gram.sums[row] += count * shift[row % c]);
        let count = Double::new(self.samples as f64);
        for (moments, d) in gram.moments.iter_mut().zip(&shift) {
            let twice = moments[0] + moments[0] + count * *d;
            *moments = [moments[0] + count * *d, moments[1] + *d * twice];
        }
        gram.offset = offset.to_vec();
        gram
    }

    /// The same matrix with exponents that are at least the present ones.
    fn in_units(&self, exponents: &[i32]) -> Gram {
        let c = exponents.len();
        let down: Vec<i32> = self.exponents.iter().zip(exponents).map(|(old, new)| old - new).collect();
        let n = self.sums.len();
        let mut gram = Gram { exponents: exponents.to_vec(), ..self.clone() };
        if down.iter().all(|d| *d == 0) {
            return gram;
        }
        for row in 0..n {
            for column in 0..n {
                let entry = &mut gram.products[row * n + column];
                *entry = entry.shifted(down[row % c]).shifted(down[column % c]);
            }
            gram.sums[row] = gram.sums[row].shifted(down[row % c]);
        }
        for (moments, d) in gram.moments.iter_mut().zip(&down) {
            *moments = [moments[0].shifted(*d), moments[1].shifted(*d).shifted(*d)];
        }
        gram
    }

    /// Adds the columns of another experiment, or of the shard that follows with 2i - 1 samples in common.
    ///
    /// Assumes: the same channels and block rows.
    pub fn add(&mut self, other: &Gram) {
        assert_eq!((self.i, self.offset.len()), (other.i, other.offset.len()), "block rows and channels");
        if other.columns == 0 {
            return;
        }
        if self.columns == 0 {
            *self = other.clone();
            return;
        }
        let other = other.about(&self.offset);
        let exponents: Vec<i32> = self.exponents.iter().zip(&other.exponents).map(|(a, b)| *a.max(b)).collect();
        let other = other.in_units(&exponents);
        *self = self.in_units(&exponents);
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| *a += *b);
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += *b);
        for (a, b) in self.moments.iter_mut().zip(&other.moments) {
            *a = [a[0] + b[0], a[1] + b[1]];
        }
        self.columns += other.columns;
        self.samples += other.samples;
    }

    /// Channels.
    pub fn channels(&self) -> usize {
        self.exponents.len()
    }

    /// Powers of two that the channels are counted in.
    pub fn exponents(&self) -> &[i32] {
        &self.exponents
    }

    /// H(row) H(column)'.
    pub fn product(&self, row: usize, column: usize) -> Double {
        self.products[row * self.sums.len() + column]
    }

    /// H(row) times ones.
    pub fn sum(&self, row: usize) -> Double {
        self.sums[row]
    }

    /// Mean of each channel over all samples.
    pub fn means(&self) -> Vec<f64> {
        let mean = |a: usize| {
            let sum = self.moments[a][0] * Double::new(self.samples as f64).reciprocal();
            (sum.shifted(self.exponents[a]) + Double::new(self.offset[a])).value()
        };
        (0..self.channels()).map(mean).collect()
    }

    /// Root mean square of each channel less the offset, in units of 2^exponent.
    pub fn rms(&self) -> Vec<f64> {
        self.moments.iter().map(|m| (m[1].value().max(0.0) / self.samples as f64).sqrt()).collect()
    }
}
