//! From the extended observability matrix or the state sequences to the system matrices.
//!
//! Enters: weighted directions, triangular factor, order. Leaves: A, C, or all of A, B, C, D by the paper's (15)-(17).
//! Deliberately absent: the choice of the order.

use flexbeam_lti::Mat;

use crate::hankel::factor::Factor;
use crate::projection::{Directions, oblique};
use crate::triangle::least_squares;

/// Gamma_i = W1^-1 U1 S1^{1/2}, li x n, equation (15).
pub(crate) fn gamma(directions: &Directions, n: usize) -> Mat {
    let mut gamma = directions.left.columns(0, n).into_owned();
    for k in 0..n {
        gamma.column_mut(k).scale_mut(directions.singular_values[k].sqrt());
    }
    gamma
}

/// A and C from the shift structure (12): Gamma without its first l rows is Gamma without its last l rows times A.
///
/// Returns None when Gamma without its last block row lacks rank n.
pub(crate) fn shift(gamma: &Mat, l: usize) -> Option<(Mat, Mat)> {
    let tall = gamma.nrows() - l;
    let A = least_squares(&gamma.rows(0, tall).into_owned(), &gamma.rows(l, tall).into_owned())?;
    Some((A, gamma.rows(0, l).into_owned()))
}

/// [C; C A; ..] of that many block rows.
pub(crate) fn observability(A: &Mat, C: &Mat, rows: usize) -> Mat {
    let l = C.nrows();
    let mut gamma = Mat::zeros(rows * l, A.nrows());
    let mut next = C.clone();
    for k in 0..rows {
        gamma.rows_mut(k * l, l).copy_from(&next);
        next *= A;
    }
    gamma
}

/// A, B, C, D by least squares on two state sequences, equations (16) and (17).
///
/// The sequences are coordinates in the orthonormal rows of Q, so (17)'s least squares over j columns is one over 2i(m + l).
/// Source: the paper, deterministic algorithm 2 of Van Overschee and De Moor 1996. Exact without noise only.
pub(crate) fn state_sequences(factor: &Factor, gamma: &Mat) -> Option<[Mat; 4]> {
    let (i, l, m, n) = (factor.i, factor.l, factor.m, gamma.ncols());
    let shorter = gamma.rows(0, (i - 1) * l).into_owned();
    let X_i = least_squares(gamma, &oblique(factor, i))?; // (16)
    let X_next = least_squares(&shorter, &oblique(factor, i + 1))?;
    let U_i = factor.L.select_rows(&factor.inputs(i..i + 1));
    let Y_i = factor.L.select_rows(&factor.outputs(i..i + 1));
    let left = stacked(&X_next, &Y_i).transpose();
    let right = stacked(&X_i, &U_i).transpose();
    let system = least_squares(&right, &left)?.transpose(); // (17)
    let block = |r: usize, c: usize, rows: usize, columns: usize| system.view((r, c), (rows, columns)).into_owned();
    Some([block(0, 0, n, n), block(0, n, n, m), block(n, 0, l, n), block(n, n, l, m)])
}

fn stacked(top: &Mat, bottom: &Mat) -> Mat {
    let mut both = Mat::zeros(top.nrows() + bottom.nrows(), top.ncols());
    both.rows_mut(0, top.nrows()).copy_from(top);
    both.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    both
}

#[cfg(test)]
mod tests {
    use flexbeam_lti::{C64, StateSpace, Time, sylvester::discrete_lyapunov};

    use super::*;
    use crate::identify::Weighting;
    use crate::projection::directions;

    fn wanted() -> StateSpace {
        let A = Mat::from_row_slice(2, 2, &[0.9, 0.3, -0.3, 0.7]);
        let (B, C, D) =
            (Mat::from_column_slice(2, 1, &[1.0, -0.5]), Mat::from_row_slice(1, 2, &[1.0, 0.4]), Mat::zeros(1, 1));
        StateSpace::new(A, B, C, D, Time::Sampled { period_s: 1.0 }).unwrap()
    }

    /// The factor that infinitely many samples would give, for u(t) = e(t) + g e(t-1), e and the output's noise white.
    ///
    /// [u; y] is the output of a system driven by [e; noise]; its covariances R(k) fill H H'/j, and L is a Cholesky factor.
    fn exact_factor(i: usize, g: f64) -> Factor {
        let StateSpace { A, B, C, D, .. } = wanted();
        let noise = 1.0;
        let mut F = Mat::zeros(3, 3);
        F.view_mut((0, 0), (2, 2)).copy_from(&A);
        F.view_mut((0, 2), (2, 1)).copy_from(&(&B * g));
        let G = Mat::from_row_slice(3, 2, &[B[0], 0.0, B[1], 0.0, 1.0, 0.0]);
        let H = Mat::from_row_slice(2, 3, &[0.0, 0.0, g, C[0], C[1], D[0] * g]);
        let J = Mat::from_row_slice(2, 2, &[1.0, 0.0, D[0], noise]);
        let P = discrete_lyapunov(&F, &(&G * G.transpose())).unwrap();
        let mut R = vec![&H * &P * H.transpose() + &J * J.transpose()];
        let mut past = &F * &P * H.transpose() + &G * J.transpose();
        for _ in 1..2 * i {
            R.push(&H * &past);
            past = &F * past;
        }
        let mut factor = Factor { L: Mat::zeros(4 * i, 4 * i), i, m: 1, l: 1 };
        let rows = [factor.inputs(0..2 * i), factor.outputs(0..2 * i)];
        for (a, p) in (0..2).flat_map(|a| (0..2 * i).map(move |p| (a, p))) {
            for (b, q) in (0..2).flat_map(|b| (0..2 * i).map(move |q| (b, q))) {
                factor.L[(rows[a][p], rows[b][q])] = if p >= q { R[p - q][(a, b)] } else { R[q - p][(b, a)] };
            }
        }
        factor.L = factor.L.cholesky().expect("a covariance").unpack();
        factor
    }

    /// Largest |G - G0| / |G0| on the unit circle.
    fn response_error([A, B, C, D]: [Mat; 4]) -> f64 {
        let found = StateSpace::new(A, B, C, D, Time::Sampled { period_s: 1.0 }).unwrap();
        let at = |k: i32| C64::from_polar(1.0, std::f64::consts::PI * f64::from(k) / 50.0);
        let error = |k: i32| {
            let (G, G0) = (found.at(at(k))[(0, 0)], wanted().at(at(k))[(0, 0)]);
            (G - G0).norm() / G0.norm()
        };
        (0..=50).map(error).fold(0.0, f64::max)
    }

    /// Noise as strong as the input, exact covariances: what is left is bias. DESIGN section 5.
    #[test]
    fn shift_is_unbiased_and_state_sequences_are_biased_for_coloured_inputs() {
        let poles = |A: &Mat| (A.trace(), A.determinant());
        let (trace, determinant) = poles(&wanted().A);
        let mut bias = Vec::new();
        for (i, g) in [(3, 0.0), (10, 0.0), (3, 0.8), (10, 0.8)] {
            let factor = exact_factor(i, g);
            for weighting in [Weighting::N4sid, Weighting::Moesp, Weighting::Cva] {
                let (A, _) = shift(&gamma(&directions(&factor, weighting), 2), 1).unwrap();
                let found = poles(&A);
                let error = (found.0 - trace).abs().max((found.1 - determinant).abs());
                assert!(error < 1e-10, "{weighting:?}, i = {i}, g = {g}: {error:e}");
            }
            let gamma = gamma(&directions(&factor, Weighting::N4sid), 2);
            bias.push(response_error(state_sequences(&factor, &gamma).unwrap()));
        }
        println!("state sequences: white {:.1e} {:.1e}, coloured {:.1e} {:.1e}", bias[0], bias[1], bias[2], bias[3]);
        assert!(bias[0] < 1e-10 && bias[1] < 1e-10, "white input: {bias:?}");
        assert!(bias[2] > 1e-3 && bias[3] < bias[2] / 10.0, "coloured input: {bias:?}");
    }
}
