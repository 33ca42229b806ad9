//! The triangular factor R of a tall matrix that arrives a few rows at a time.
//!
//! Enters: chunks of rows. Leaves: R of the QR factorisation of everything that entered.
//! Deliberately absent: Q, which nobody asks for; squared data, which would lose half the digits.

use flexbeam_lti::Mat;

/// Rows of a chunk: 80 columns of it stay in a second-level cache.
pub(crate) const CHUNK_ROWS: usize = 256;
/// Columns that are reflected together.
const PANEL: usize = 8;
/// Reflectors that one pass over a column multiplies.
const TILE: usize = 4;
/// Independent partial sums of a product, so that additions need not wait for each other.
const LANES: usize = 8;

/// Upper triangular R with H = Q R for all rows of H absorbed so far.
///
/// Numerics: Householder reflections in panels of 8 (compact WY), 2 n^2 operations a row, all of them orthogonal: R is the
/// exact factor of a matrix within a few units in the last place of H, column by column.
/// Source: Schreiber and Van Loan 1989 (compact WY); Golub and Van Loan, section 6.5 (appended rows).
pub(crate) struct Triangle {
    /// n x n, upper triangular; the signs of its diagonal are free.
    pub R: Mat,
}

impl Triangle {
    pub fn new(columns: usize) -> Triangle {
        Triangle { R: Mat::zeros(columns, columns) }
    }

    /// Replaces R by the factor of [R; chunk]. The chunk is overwritten.
    pub fn absorb(&mut self, chunk: &mut Mat) {
        assert_eq!(chunk.ncols(), self.R.ncols(), "a chunk has the factor's columns");
        if chunk.nrows() == 0 {
            return;
        }
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the two features were found on this processor in the line above.
            unsafe { reflect_avx2(&mut self.R, chunk) };
            return;
        }
        reflect::<false>(&mut self.R, chunk);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn reflect_avx2(R: &mut Mat, chunk: &mut Mat) {
    reflect::<true>(R, chunk);
}

/// Reflects [R; chunk] onto R, a panel at a time.
#[inline(always)]
fn reflect<const FUSED: bool>(R: &mut Mat, chunk: &mut Mat) {
    let (rows, n) = chunk.shape();
    for first in (0..n).step_by(PANEL) {
        let width = PANEL.min(n - first);
        let (panel, trailing) = chunk.as_mut_slice()[first * rows..].split_at_mut(width * rows);
        let T = panel_reflectors::<FUSED>(R, first, panel, rows);
        for (pair, columns) in trailing.chunks_mut(2 * rows).enumerate() {
            let column = first + width + 2 * pair;
            if columns.len() == 2 * rows {
                let (a, b) = columns.split_at_mut(rows);
                apply_block::<FUSED, 2>(R, first, column, panel, &T, [a, b]);
            } else {
                apply_block::<FUSED, 1>(R, first, column, panel, &T, [columns]);
            }
        }
    }
}

/// Householder vectors of one panel, left in its columns (their unit entry stands in R's row), and the T of I - V T V'.
#[inline(always)]
fn panel_reflectors<const FUSED: bool>(
    R: &mut Mat,
    first: usize,
    panel: &mut [f64],
    rows: usize,
) -> [[f64; PANEL]; PANEL] {
    let mut T = [[0.0; PANEL]; PANEL];
    for p in 0..panel.len() / rows {
        let (before, rest) = panel.split_at_mut(p * rows);
        let (v, after) = rest.split_at_mut(rows);
        let k = first + p;
        let tau = reflector::<FUSED>(&mut R[(k, k)], v);
        for (q, a) in after.chunks_exact_mut(rows).enumerate() {
            let w = tau * (R[(k, k + 1 + q)] + products::<FUSED, 1, 1>([v], [a])[0][0]);
            R[(k, k + 1 + q)] -= w;
            subtract::<FUSED, 1, 1>([v], [a], [[w]]);
        }
        T[p][p] = tau;
        let overlaps: Vec<f64> = before.chunks_exact(rows).map(|u| products::<FUSED, 1, 1>([u], [v])[0][0]).collect();
        for row in 0..p {
            T[row][p] = -tau * (row..p).map(|q| T[row][q] * overlaps[q]).sum::<f64>();
        }
    }
    T
}

/// Turns (diagonal, v) into (beta, 0): returns tau of I - tau [1; v] [1; v]', v overwritten.
#[inline(always)]
fn reflector<const FUSED: bool>(diagonal: &mut f64, v: &mut [f64]) -> f64 {
    let tail = products::<FUSED, 1, 1>([v], [v])[0][0].sqrt();
    if tail == 0.0 {
        return 0.0;
    }
    let alpha = *diagonal;
    let beta = -alpha.hypot(tail).copysign(alpha);
    let pivot = alpha - beta;
    v.iter_mut().for_each(|x| *x /= pivot);
    *diagonal = beta;
    (beta - alpha) / beta
}

/// C columns from `column` on become (I - V T' V') times themselves.
#[inline(always)]
fn apply_block<const FUSED: bool, const C: usize>(
    R: &mut Mat,
    first: usize,
    column: usize,
    panel: &[f64],
    T: &[[f64; PANEL]; PANEL],
    mut columns: [&mut [f64]; C],
) {
    let rows = columns[0].len();
    let width = panel.len() / rows;
    let mut W = [[0.0; PANEL]; C];
    for (tile, vs) in panel.chunks(TILE * rows).enumerate() {
        let read = columns.each_ref().map(|c| &**c);
        if vs.len() == TILE * rows {
            let found = products::<FUSED, TILE, C>(tile_of(vs, rows), read);
            for c in 0..C {
                W[c][tile * TILE..(tile + 1) * TILE].copy_from_slice(&found[c]);
            }
        } else {
            for (p, v) in vs.chunks_exact(rows).enumerate() {
                let found = products::<FUSED, 1, C>([v], read);
                (0..C).for_each(|c| W[c][tile * TILE + p] = found[c][0]);
            }
        }
    }
    for c in 0..C {
        (0..width).for_each(|p| W[c][p] += R[(first + p, column + c)]);
        for p in (0..width).rev() {
            W[c][p] = (0..=p).map(|q| T[q][p] * W[c][q]).sum();
        }
        (0..width).for_each(|p| R[(first + p, column + c)] -= W[c][p]);
    }
    for (tile, vs) in panel.chunks(TILE * rows).enumerate() {
        let write = columns.each_mut().map(|c| &mut **c);
        if vs.len() == TILE * rows {
            let weights = std::array::from_fn(|c| std::array::from_fn(|p| W[c][tile * TILE + p]));
            subtract::<FUSED, TILE, C>(tile_of(vs, rows), write, weights);
        } else {
            for (p, v) in vs.chunks_exact(rows).enumerate() {
                let weights = std::array::from_fn(|c| [W[c][tile * TILE + p]]);
                subtract::<FUSED, 1, C>([v], columns.each_mut().map(|c| &mut **c), weights);
            }
        }
    }
}

#[inline(always)]
fn tile_of(vs: &[f64], rows: usize) -> [&[f64]; TILE] {
    std::array::from_fn(|p| &vs[p * rows..(p + 1) * rows])
}

#[inline(always)]
fn fused<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// v_p' a_c for all pairs.
#[inline(always)]
fn products<const FUSED: bool, const P: usize, const C: usize>(v: [&[f64]; P], a: [&[f64]; C]) -> [[f64; P]; C] {
    let rows = a[0].len();
    let whole = rows - rows % LANES;
    let mut sums = [[[0.0; LANES]; P]; C];
    for k in (0..whole).step_by(LANES) {
        let vk: [&[f64; LANES]; P] = v.map(|x| x[k..].first_chunk().expect("k + LANES <= rows"));
        for c in 0..C {
            let ak: &[f64; LANES] = a[c][k..].first_chunk().expect("k + LANES <= rows");
            for p in 0..P {
                for lane in 0..LANES {
                    sums[c][p][lane] = fused::<FUSED>(vk[p][lane], ak[lane], sums[c][p][lane]);
                }
            }
        }
    }
    std::array::from_fn(|c| {
        std::array::from_fn(|p| {
            let rest: f64 = (whole..rows).map(|k| v[p][k] * a[c][k]).sum();
            sums[c][p].iter().sum::<f64>() + rest
        })
    })
}

/// a_c -= sum_p w_cp v_p.
#[inline(always)]
fn subtract<const FUSED: bool, const P: usize, const C: usize>(v: [&[f64]; P], a: [&mut [f64]; C], w: [[f64; P]; C]) {
    let rows = a[0].len();
    let whole = rows - rows % LANES;
    for k in (0..whole).step_by(LANES) {
        let vk: [&[f64; LANES]; P] = v.map(|x| x[k..].first_chunk().expect("k + LANES <= rows"));
        for c in 0..C {
            let ak: &mut [f64; LANES] = a[c][k..].first_chunk_mut().expect("k + LANES <= rows");
            for p in 0..P {
                for lane in 0..LANES {
                    ak[lane] = fused::<FUSED>(-w[c][p], vk[p][lane], ak[lane]);
                }
            }
        }
    }
    for c in 0..C {
        for k in whole..rows {
            a[c][k] -= (0..P).map(|p| w[c][p] * v[p][k]).sum::<f64>();
        }
    }
}

/// X that minimises |A X - B| column by column: Householder QR, then one triangular solution.
///
/// Assumes: A has full column rank; who calls knows it.
pub(crate) fn least_squares(A: &Mat, B: &Mat) -> Option<Mat> {
    let n = A.ncols();
    let qr = A.clone().qr();
    let mut rotated = B.clone();
    qr.q_tr_mul(&mut rotated);
    qr.r().solve_upper_triangular(&rotated.rows(0, n).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows_of(seed: u64, rows: usize, n: usize) -> Mat {
        let mut state = seed;
        Mat::from_fn(rows, n, |_, _| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 30) as f64 - 1.0
        })
    }

    /// R'R = H'H determines R up to signs, and H'H is computed here directly.
    #[test]
    fn gram_matrix_is_kept_for_every_remainder_of_panel_and_lane() {
        for n in [1, 3, 7, 8, 9, 16, 19, 21, 30] {
            let H = rows_of(7 + n as u64, 601, n);
            let mut triangle = Triangle::new(n);
            for first in (0..601).step_by(97) {
                triangle.absorb(&mut H.rows(first, 97.min(601 - first)).into_owned());
            }
            let gram = H.transpose() * &H;
            let error = (triangle.R.transpose() * &triangle.R - &gram).norm() / gram.norm();
            assert!(error < 1e-14, "n = {n}: {error:e}");
            assert!((0..n).all(|c| (c + 1..n).all(|r| triangle.R[(r, c)] == 0.0)), "n = {n}: not triangular");
        }
    }

    #[test]
    fn both_kernels_agree() {
        let H = rows_of(3, 300, 21);
        let (mut fused, mut plain) = (Triangle::new(21), Mat::zeros(21, 21));
        fused.absorb(&mut H.clone());
        reflect::<false>(&mut plain, &mut H.clone());
        assert!((fused.R - &plain).norm() < 1e-13 * plain.norm());
    }

    /// Column k is 10^-12 of column k-1: squaring would lose the third column altogether.
    #[test]
    fn tiny_columns_keep_their_digits() {
        let mut H = rows_of(11, 400, 4);
        for c in 1..4 {
            let scale = 1e-12f64.powi(c as i32);
            H.column_mut(c).scale_mut(scale);
        }
        let mut scaled = Triangle::new(4);
        scaled.absorb(&mut H.clone());
        let mut plain = Triangle::new(4);
        plain.absorb(&mut rows_of(11, 400, 4));
        for c in 0..4 {
            let scale = 1e-12f64.powi(c as i32);
            for r in 0..=c {
                let error = (scaled.R[(r, c)] / scale - plain.R[(r, c)]).abs() / plain.R.norm();
                assert!(error < 1e-14, "({r},{c}): {error:e}");
            }
        }
    }
}
