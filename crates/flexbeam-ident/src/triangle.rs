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
/// Partial sums of a product that one instruction adds.
const LANES: usize = 8;

/// Coefficients of one panel's reflectors.
type Block = [[f64; PANEL]; PANEL];

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
///
/// Loops, not closures, here and in all that follows: a closure is compiled without the processor's features.
#[inline(always)]
fn reflect<const FUSED: bool>(R: &mut Mat, chunk: &mut Mat) {
    let (rows, n) = chunk.shape();
    for first in (0..n).step_by(PANEL) {
        let width = PANEL.min(n - first);
        let (panel, trailing) = chunk.as_mut_slice()[first * rows..].split_at_mut(width * rows);
        let T = panel_reflectors::<FUSED>(R, first, panel, rows);
        for (k, column) in trailing.chunks_exact_mut(rows).enumerate() {
            let mut top = R.column_mut(first + width + k);
            reflect_column::<FUSED>(&mut top.as_mut_slice()[first..first + width], column, panel, &T);
        }
    }
}

/// Householder vectors of one panel, left in its columns (their unit entry stands in R's row), and the T of I - V T V'.
#[inline(always)]
fn panel_reflectors<const FUSED: bool>(R: &mut Mat, first: usize, panel: &mut [f64], rows: usize) -> Block {
    let mut T = [[0.0; PANEL]; PANEL];
    for p in 0..panel.len() / rows {
        let (before, rest) = panel.split_at_mut(p * rows);
        let (v, after) = rest.split_at_mut(rows);
        let k = first + p;
        let tau = reflector::<FUSED>(&mut R[(k, k)], v);
        for (q, a) in after.chunks_exact_mut(rows).enumerate() {
            let w = tau * (R[(k, k + 1 + q)] + products::<FUSED, 1>([v], a)[0]);
            R[(k, k + 1 + q)] -= w;
            subtract::<FUSED, 1>([v], [w], a);
        }
        let mut overlaps = [0.0; PANEL];
        for (q, u) in before.chunks_exact(rows).enumerate() {
            overlaps[q] = products::<FUSED, 1>([u], v)[0];
        }
        T[p][p] = tau;
        for row in T.iter_mut().take(p) {
            let mut sum = 0.0;
            for q in 0..p {
                sum += row[q] * overlaps[q];
            }
            row[p] = -tau * sum;
        }
    }
    T
}

/// Turns (diagonal, v) into (beta, 0): returns tau of I - tau [1; v] [1; v]', v overwritten.
#[inline(always)]
fn reflector<const FUSED: bool>(diagonal: &mut f64, v: &mut [f64]) -> f64 {
    let tail = products::<FUSED, 1>([v], v)[0].sqrt();
    if tail == 0.0 {
        return 0.0;
    }
    let alpha = *diagonal;
    let beta = -alpha.hypot(tail).copysign(alpha);
    let pivot = alpha - beta;
    for x in v.iter_mut() {
        *x /= pivot;
    }
    *diagonal = beta;
    (beta - alpha) / beta
}

/// [top; column] becomes (I - V T' V') times itself.
#[inline(always)]
fn reflect_column<const FUSED: bool>(top: &mut [f64], column: &mut [f64], panel: &[f64], T: &Block) {
    let rows = column.len();
    let mut W = [0.0; PANEL];
    for (tile, vs) in panel.chunks(TILE * rows).enumerate() {
        let at = tile * TILE;
        if vs.len() == TILE * rows {
            W[at..at + TILE].copy_from_slice(&products::<FUSED, TILE>(tile_of(vs, rows), column));
        } else {
            for (p, v) in vs.chunks_exact(rows).enumerate() {
                W[at + p] = products::<FUSED, 1>([v], column)[0];
            }
        }
    }
    reflect_top(top, T, &mut W);
    for (tile, vs) in panel.chunks(TILE * rows).enumerate() {
        let at = tile * TILE;
        if vs.len() == TILE * rows {
            let weights = [W[at], W[at + 1], W[at + 2], W[at + 3]];
            subtract::<FUSED, TILE>(tile_of(vs, rows), weights, column);
        } else {
            for (p, v) in vs.chunks_exact(rows).enumerate() {
                subtract::<FUSED, 1>([v], [W[at + p]], column);
            }
        }
    }
}

/// W = T' V' [R; chunk] from its lower part, and R's rows of the panel less W.
#[inline(always)]
fn reflect_top(top: &mut [f64], T: &Block, W: &mut [f64; PANEL]) {
    for (w, r) in W.iter_mut().zip(top.iter()) {
        *w += r;
    }
    for p in (0..top.len()).rev() {
        let mut sum = 0.0;
        for q in 0..=p {
            sum += T[q][p] * W[q];
        }
        W[p] = sum;
    }
    for (r, w) in top.iter_mut().zip(W.iter()) {
        *r -= w;
    }
}

/// The columns of one tile.
#[inline(always)]
fn tile_of(vs: &[f64], rows: usize) -> [&[f64]; TILE] {
    [&vs[..rows], &vs[rows..2 * rows], &vs[2 * rows..3 * rows], &vs[3 * rows..4 * rows]]
}

#[inline(always)]
fn fused<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// v_p' a for all p.
#[inline(always)]
fn products<const FUSED: bool, const P: usize>(v: [&[f64]; P], a: &[f64]) -> [f64; P] {
    let whole = a.len() - a.len() % LANES;
    let mut sums = [[0.0; LANES]; P];
    let mut k = 0;
    while k < whole {
        let ak = lanes(a, k);
        for p in 0..P {
            sums[p] = plus_product::<FUSED>(sums[p], lanes(v[p], k), ak);
        }
        k += LANES;
    }
    let mut found = [0.0; P];
    for p in 0..P {
        for x in sums[p] {
            found[p] += x;
        }
        for k in whole..a.len() {
            found[p] += v[p][k] * a[k];
        }
    }
    found
}

/// a -= sum_p w_p v_p.
#[inline(always)]
fn subtract<const FUSED: bool, const P: usize>(v: [&[f64]; P], w: [f64; P], a: &mut [f64]) {
    let whole = a.len() - a.len() % LANES;
    let mut k = 0;
    while k < whole {
        let mut ak = lanes(a, k);
        for p in 0..P {
            ak = plus_product::<FUSED>(ak, lanes(v[p], k), [-w[p]; LANES]);
        }
        a[k..k + LANES].copy_from_slice(&ak);
        k += LANES;
    }
    for k in whole..a.len() {
        for p in 0..P {
            a[k] -= w[p] * v[p][k];
        }
    }
}

/// sum + a b, lane by lane.
#[inline(always)]
fn plus_product<const FUSED: bool>(mut sum: [f64; LANES], a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
    for lane in 0..LANES {
        sum[lane] = fused::<FUSED>(a[lane], b[lane], sum[lane]);
    }
    sum
}

#[inline(always)]
fn lanes(column: &[f64], k: usize) -> [f64; LANES] {
    *column[k..].first_chunk().expect("k + LANES <= rows")
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
