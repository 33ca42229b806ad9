//! The projections of equation (13) and their weights, all from the triangular factor.
//!
//! Enters: [`Factor`]. Leaves: singular values and directions of the weighted projection, oblique projections in the
//! coordinates of Q. Deliberately absent: a matrix of width j.

use flexbeam_lti::Mat;

use crate::hankel::factor::Factor;
use crate::identify::Weighting;
use crate::singular::{basic_solution, left_singular, pivoted};

/// A direction of the past that is weaker than this, relative to the strongest, is rounding: noise-free data make [U_p; Y_p]
/// singular, with about 1e-14 in place of zero.
const PAST_RANK: f64 = 1e-12;

/// Left part of the weighted projection's singular value decomposition, unweighted again: W1^-1 U.
pub(crate) struct Directions {
    /// All singular values, descending.
    pub singular_values: Vec<f64>,
    /// li x rank: column k belongs to singular value k.
    pub left: Mat,
}

/// W1 O_i W2 = U S V', equation (14), with W1^-1 U.
///
/// | weighting | W1 | W2 |
/// |---|---|---|
/// | N4SID | I | I |
/// | MOESP | I | projection orthogonal to U_f |
/// | CVA | (Y_f Pi Y_f')^(-1/2) | projection orthogonal to U_f |
///
/// Source: Van Overschee and De Moor 1996, table 4.1.
pub(crate) fn directions(factor: &Factor, weighting: Weighting) -> Directions {
    let (i, m, l) = (factor.i, factor.m, factor.l);
    let past = i * (m + l);
    let L32 = factor.L.view((i * m + past, i * m), (i * l, past));
    match weighting {
        Weighting::N4sid => left_directions(&oblique(factor, i)),
        Weighting::Moesp => left_directions(&L32.into_owned()),
        Weighting::Cva => {
            // [L32 L33] is Y_f orthogonal to U_f. With its transpose Q R, R' is a root of Y_f Pi Y_f' and Q' = W1 [L32 L33].
            let Y_f = factor.L.view((i * m + past, i * m), (i * l, past + i * l));
            let (Q, R) = pivoted(&Y_f.transpose(), PAST_RANK);
            let correlated = left_directions(&Q.rows(0, past).transpose());
            Directions { left: R.transpose() * correlated.left, ..correlated }
        }
    }
}

fn left_directions(M: &Mat) -> Directions {
    let (singular_values, left) = left_singular(M);
    Directions { singular_values, left }
}

/// O = Y_f /_{U_f} W_p in the coordinates of Q, with `past` block rows in W_p, equation (13).
///
/// Shapes: l(2i - past) x 2i(m + l). The paper's O_i has past = i, its O_{i-1} past = i + 1.
pub(crate) fn oblique(factor: &Factor, past: usize) -> Mat {
    let all = 2 * factor.i;
    let U_f = factor.inputs(past..all);
    let W_p = [factor.inputs(0..past), factor.outputs(0..past)].concat();
    let Y_f = factor.outputs(past..all);
    let rows = [U_f.clone(), W_p.clone(), Y_f.clone()].concat();
    let H = factor.L.select_rows(&rows);
    let L = H.transpose().qr().unpack_r().transpose();
    let (a, b) = (U_f.len(), W_p.len());
    let L22 = L.view((a, a), (b, b)).into_owned();
    let L32 = L.view((a + b, a), (Y_f.len(), b)).into_owned();
    // K L22 = L32, transposed.
    let K = basic_solution(&L22.transpose(), &L32.transpose(), PAST_RANK).transpose();
    K * factor.L.select_rows(&W_p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hankel::factor::tests::{hankel, noise, stacked};

    const SAMPLES: usize = 400;
    const I: usize = 3;
    const J: usize = SAMPLES - 2 * I + 1;

    /// A - A B'(B B')^-1 B: rows of A orthogonal to those of B.
    fn without(A: &Mat, B: &Mat) -> Mat {
        let gram = B * B.transpose();
        A - A * B.transpose() * gram.cholesky().expect("independent rows").solve(B)
    }

    /// (13) as printed, width j: Y_f /_{U_f} W_p = (Y_f Pi)(W_p Pi)' [(W_p Pi)(W_p Pi)']^-1 W_p.
    fn printed(U: &Mat, Y: &Mat, past: usize) -> Mat {
        let U_f = hankel(U, past..2 * I, J);
        let Y_f = without(&hankel(Y, past..2 * I, J), &U_f);
        let W_p = stacked(&[hankel(U, 0..past, J), hankel(Y, 0..past, J)]);
        let W = without(&W_p, &U_f);
        let gram = &W * W.transpose();
        Y_f * W.transpose() * gram.cholesky().expect("independent rows").solve(&W_p)
    }

    #[test]
    fn oblique_projections_are_the_printed_ones() {
        let (U, Y) = noise(SAMPLES);
        let factor = Factor::new(&U, &Y, I, false);
        let rows = [factor.inputs(I..2 * I), factor.inputs(0..I), factor.outputs(0..2 * I)].concat();
        let H = stacked(&[hankel(&U, 0..2 * I, J), hankel(&Y, 0..2 * I, J)]);
        // Order of H's rows here: inputs 0..2i, outputs 0..2i. L's: as `rows` says.
        let natural = [factor.inputs(0..2 * I), factor.outputs(0..2 * I)].concat();
        let mut ordered = H.clone();
        natural.iter().enumerate().for_each(|(k, &row)| ordered.set_row(row, &H.row(k)));
        assert_eq!(rows, (0..rows.len()).collect::<Vec<_>>());
        let Q = factor.L.solve_lower_triangular(&ordered).unwrap();
        for past in [I, I + 1] {
            let wanted = printed(&U, &Y, past);
            let error = (oblique(&factor, past) * &Q - &wanted).norm() / wanted.norm();
            assert!(error < 1e-12, "past {past}: {error:e}");
        }
    }

    /// W1 O W2 formed in full with symmetric square roots by eigenvalues: the same singular values, the same ranges.
    #[test]
    fn weighted_singular_values_are_those_of_the_printed_matrices() {
        let (U, Y) = noise(SAMPLES);
        let factor = Factor::new(&U, &Y, I, false);
        let U_f = hankel(&U, I..2 * I, J);
        let O = printed(&U, &Y, I);
        let orthogonal = without(&O, &U_f);
        let Y_f = without(&hankel(&Y, I..2 * I, J), &U_f);
        let eigen = (&Y_f * Y_f.transpose()).symmetric_eigen();
        let root = |power: f64| {
            let D = Mat::from_diagonal(&eigen.eigenvalues.map(|x| x.powf(power)));
            &eigen.eigenvectors * D * eigen.eigenvectors.transpose()
        };
        let n = I * 3;
        let cases = [
            (Weighting::N4sid, O.clone(), Mat::identity(n, n)),
            (Weighting::Moesp, orthogonal.clone(), Mat::identity(n, n)),
            (Weighting::Cva, root(-0.5) * orthogonal, root(0.5)),
        ];
        for (weighting, weighted, unweight) in cases {
            let found = directions(&factor, weighting);
            let (S, left) = left_singular(&weighted);
            let left = unweight * left;
            for k in 0..n {
                assert!((found.singular_values[k] - S[k]).abs() < 1e-12 * S[0], "{weighting:?}, value {k}");
                let (a, b) = (found.left.column(k), left.column(k));
                let error = (a - b).norm().min((a + b).norm()) / b.norm();
                assert!(error < 1e-9, "{weighting:?}, direction {k}: {error:e}");
            }
        }
    }
}
