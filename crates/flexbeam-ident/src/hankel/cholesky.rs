//! The triangular factor of a Gram matrix in double-double.
//!
//! Enters: a symmetric matrix, positive semidefinite up to rounding. Leaves: L with L L' equal to it, in f64.
//! Deliberately absent: pivoting; who calls has an order of rows that means something.

use flexbeam_lti::Mat;

use crate::double::{Double, product, sum};

/// A pivot below this part of its diagonal is rounding: products of integers leave 2^-104 for each doubling of the signal and for each row, a
/// few hundred rows 1e-29. Data without noise, themselves rounded to 53 bits, leave 1e-32.
const NO_PIVOT: f64 = 1e-27;

/// L with G = L L', lower triangular; a row that depends on those above it has a column of zeros.
///
/// Shapes: `entry(r, c)` for c <= r < n; returns n x n.
/// Numerics: rows are brought to lengths between 1 and 2 by powers of two, then n^3 / 6 fused products in double-double, column by column. Relative error of L:
/// n 2^-102 over the smallest pivot that is kept, then one rounding to f64. The same bits on every processor.
/// Source: Higham 2002, section 10.3 (semidefinite Cholesky).
pub(crate) fn cholesky(n: usize, entry: impl Fn(usize, usize) -> Double) -> Mat {
    let lengths: Vec<i32> = (0..n).map(|r| half_exponent(entry(r, r).hi)).collect();
    let mut columns = Columns { n, hi: vec![0.0; n * n], lo: vec![0.0; n * n] };
    for c in 0..n {
        for r in c..n {
            let x = entry(r, c).shifted(-lengths[r]).shifted(-lengths[c]);
            (columns.hi[c * n + r], columns.lo[c * n + r]) = (x.hi, x.lo);
        }
    }
    columns.factorise();
    Mat::from_fn(n, n, |r, c| if r < c { 0.0 } else { columns.at(r, c).shifted(lengths[r]).value() })
}

/// e with 1 <= x 2^-2e < 4; 0 for x = 0.
fn half_exponent(x: f64) -> i32 {
    if x > 0.0 { (((x.to_bits() >> 52) as i32) - 1023).div_euclid(2) } else { 0 }
}

/// Lower triangle, column after column, high and low parts apart.
struct Columns {
    n: usize,
    hi: Vec<f64>,
    lo: Vec<f64>,
}

impl Columns {
    fn at(&self, r: usize, c: usize) -> Double {
        Double { hi: self.hi[c * self.n + r], lo: self.lo[c * self.n + r] }
    }

    fn factorise(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the feature was found on this processor in the line above.
            unsafe { factorise_avx512(self) };
            return;
        } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the two features were found on this processor in the line above.
            unsafe { factorise_avx2(self) };
            return;
        }
        factorise::<false>(self);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn factorise_avx512(L: &mut Columns) {
    factorise::<true>(L);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn factorise_avx2(L: &mut Columns) {
    factorise::<true>(L);
}

#[inline(always)]
fn factorise<const FUSED: bool>(L: &mut Columns) {
    let n = L.n;
    for c in 0..n {
        let (hi_before, hi) = L.hi.split_at_mut(c * n);
        let (lo_before, lo) = L.lo.split_at_mut(c * n);
        let (hi, lo) = (&mut hi[c..n], &mut lo[c..n]);
        let diagonal = hi[0];
        for k in 0..c {
            let rows = k * n + c..(k + 1) * n;
            subtract::<FUSED>(hi, lo, &hi_before[rows.clone()], &lo_before[rows]);
        }
        let pivot = Double { hi: hi[0], lo: lo[0] };
        if !(pivot.hi > NO_PIVOT * diagonal) {
            hi.fill(0.0);
            lo.fill(0.0);
            continue;
        }
        let by = pivot.sqrt().reciprocal();
        for (h, l) in hi.iter_mut().zip(lo.iter_mut()) {
            (*h, *l) = product::<FUSED>((*h, *l), (by.hi, by.lo));
        }
    }
}

/// x -= b(0) b.
#[inline(always)]
fn subtract<const FUSED: bool>(hi: &mut [f64], lo: &mut [f64], b_hi: &[f64], b_lo: &[f64]) {
    let by = (-b_hi[0], -b_lo[0]);
    if by.0 == 0.0 {
        return;
    }
    let n = hi.len();
    let (lo, b_hi, b_lo) = (&mut lo[..n], &b_hi[..n], &b_lo[..n]);
    for r in 0..n {
        (hi[r], lo[r]) = sum((hi[r], lo[r]), product::<FUSED>((b_hi[r], b_lo[r]), by));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integers: their Gram matrix is exact.
    fn integers(n: usize, width: usize) -> Vec<Vec<i64>> {
        let mut state = 9u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 24) as i64 - (1 << 39)
        };
        (0..n).map(|_| (0..width).map(|_| next()).collect()).collect()
    }

    fn gram(rows: &[Vec<i64>]) -> impl Fn(usize, usize) -> Double {
        |r, c| {
            let products = rows[r].iter().zip(&rows[c]).map(|(x, y)| i128::from(*x) * i128::from(*y));
            Double::from_integer(products.sum())
        }
    }

    #[test]
    fn factor_is_that_of_a_dense_qr() {
        let rows = integers(19, 50);
        let L = cholesky(19, gram(&rows));
        let H = Mat::from_fn(50, 19, |k, r| rows[r][k] as f64);
        let mut R = H.qr().unpack_r();
        (0..19).for_each(|k| {
            let sign = R[(k, k)].signum();
            R.row_mut(k).scale_mut(sign);
        });
        assert!((L - R.transpose()).norm() < 1e-14 * R.norm());
    }

    /// Squaring in f64 would lose a row that differs from another by 1e-9; a row that repeats others has no column.
    #[test]
    fn nearly_and_exactly_dependent_rows() {
        let mut rows = integers(4, 60);
        rows[3] = rows[0].iter().zip(&rows[2]).map(|(a, b)| a / 2 * 2 - b).collect();
        rows[0].iter_mut().for_each(|a| *a = *a / 2 * 2);
        rows[1] = rows[0].clone();
        rows[1][7] += 3000;
        let L = cholesky(4, gram(&rows));
        // What row 1 has beside row 0: 3000 in place 7, less its part along row 0.
        let square: f64 = rows[0].iter().map(|x| (*x as f64).powi(2)).sum();
        let wanted = 3000.0 * (1.0 - (rows[0][7] as f64).powi(2) / square).sqrt();
        assert!((L[(1, 1)] / wanted - 1.0).abs() < 1e-9, "{} for {wanted}", L[(1, 1)]);
        assert_eq!(L[(3, 3)], 0.0);
    }

    #[test]
    fn fused_and_plain_kernels_have_the_same_bits() {
        let rows = integers(21, 40);
        let entry = gram(&rows);
        let columns = || {
            let of = |part: fn(Double) -> f64| {
                (0..441).map(|k| part(entry(k % 21, k / 21).scaled(2f64.powi(-85)))).collect()
            };
            Columns { n: 21, hi: of(|x| x.hi), lo: of(|x| x.lo) }
        };
        let (mut fused, mut plain) = (columns(), columns());
        fused.factorise();
        factorise::<false>(&mut plain);
        assert_eq!((fused.hi, fused.lo), (plain.hi, plain.lo));
    }

    #[test]
    fn scales_are_taken_out_and_put_back() {
        let rows = integers(3, 30);
        let plain = cholesky(3, gram(&rows));
        let entry = gram(&rows);
        let powers = [-120, 3, 90];
        let scaled = cholesky(3, |r, c| entry(r, c).shifted(powers[r] + powers[c]));
        for r in 0..3 {
            for c in 0..=r {
                assert_eq!(scaled[(r, c)], plain[(r, c)] * 2f64.powi(powers[r]));
            }
        }
        assert_eq!(cholesky(2, |_, _| Double::ZERO), Mat::zeros(2, 2));
    }
}
