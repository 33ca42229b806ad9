//! Zeros of systems with any number of inputs and outputs, without a polynomial.
//!
//! Enters: a system. Leaves: the points where its rank drops. Absent: zeros at infinity and their orders.

use crate::blocks::{beside, stack};
use crate::compression::{Blur, RowCompression};
use crate::equilibration::equilibrated;
use crate::generalised::generalised_eigenvalues;
use crate::minimal::{about_centre, centre, minimal, transposed};
use crate::{C64, Error, StateSpace};

/// Rounds of input and output scaling; the second finds only what the first has spoilt.
const SCALING_ROUNDS: usize = 2;

/// Points where G(s) drops below its normal rank: the invariant zeros of the minimal realisation.
///
/// Returns: finite zeros with their multiplicity, real or in exact conjugate pairs; none for G = 0.
/// Errors: [`Error::NotConverged`].
/// Numerics: as [`invariant_zeros`], after [`minimal`].
/// Source: MacFarlane & Karcanias 1976 for the notion.
///
/// DESIGN section 2: V -> psi of the flexible link has no finite zeros, V -> alpha one at s = 0.
///
/// ```
/// use flexbeam_lti::{Mat, StateSpace, Time, zeros::transmission_zeros};
///
/// let (k1, k2, c, b) = (1060.8, 1465.2, 57.7, 107.39);
/// let A = Mat::from_row_slice(4, 4, &[0., 0., 1., 0., 0., 0., 0., 1., 0., k1, -c, 0., 0., -k2, c, 0.]);
/// let B = Mat::from_column_slice(4, 1, &[0., 0., b, -b]);
/// let seen_by = |C: &[f64]| {
///     StateSpace::new(A.clone(), B.clone(), Mat::from_row_slice(1, 4, C), Mat::zeros(1, 1), Time::Continuous).unwrap()
/// };
/// assert!(transmission_zeros(&seen_by(&[1., 1., 0., 0.])).unwrap().is_empty());
/// let alpha = transmission_zeros(&seen_by(&[0., 1., 0., 0.])).unwrap();
/// assert!(alpha.len() == 1 && alpha[0].norm() < 1e-12);
/// ```
pub fn transmission_zeros(system: &StateSpace) -> Result<Vec<C64>, Error> {
    let least = minimal(system);
    // The given coordinates are worth keeping: their exact zeros and small numbers are what high relative degrees rest on.
    if least.order() == system.order() { invariant_zeros(system) } else { invariant_zeros(&least) }
}

/// Points where [A - s I, B; C, D] drops below its normal rank: transmission zeros, and hidden modes.
///
/// Returns: as [`transmission_zeros`]; for one input and one output they are the roots of det(s I - A) G(s).
/// Errors: [`Error::NotConverged`].
/// Numerics: states, inputs and outputs scaled by powers of two, z - 1 in place of z, orthogonal reduction to a regular D, then the QZ
/// algorithm; O((n + m + l)^3). Ranks are decided relative to the scaled system matrix: a relative degree that
/// cancellation has blurred to rounding shows as zeros of very large modulus.
/// Source: Emami-Naeini & Van Dooren 1982.
pub fn invariant_zeros(system: &StateSpace) -> Result<Vec<C64>, Error> {
    let core = regular_core(system);
    let (n, r) = (core.order(), core.inputs());
    // [C D] W = [0 R]; on the first n columns of W the pencil [A B] - s [I 0] is square and regular.
    let columns = RowCompression::new(&beside(&core.C, &core.D).transpose(), 0.0).Q;
    let W = columns.columns(r, n);
    let (A, E) = (beside(&core.A, &core.B) * W, W.rows(0, n).into_owned());
    Ok(generalised_eigenvalues(&A, &E)?.iter().filter_map(|e| e.finite()).map(|z| z + centre(system.time)).collect())
}

/// Rank of G(s) at all but finitely many points.
pub fn normal_rank(system: &StateSpace) -> usize {
    regular_core(system).inputs()
}

/// A system with square regular D and the same zeros; for a sampled one, less 1.
fn regular_core(system: &StateSpace) -> StateSpace {
    let scaled = scaled(system);
    let size = beside(&stack(&scaled.A, &scaled.C), &stack(&scaled.B, &scaled.D));
    let (blur, size) = (Blur::of_rounding(size.nrows() + size.ncols()), size.norm());
    let (rows, blur) = with_independent_rows(scaled, blur, size);
    transposed(&with_independent_rows(transposed(&rows), blur, size).0)
}

/// States equilibrated, time unchanged, inputs and outputs as large as A: zeros do not depend on any of these units.
fn scaled(system: &StateSpace) -> StateSpace {
    let mut G = about_centre(system, -1.0);
    for _ in 0..SCALING_ROUNDS {
        let size = G.A.norm();
        scale_inputs(&mut G, size);
        G = transposed(&G);
        scale_inputs(&mut G, size);
        G = equilibrated(&transposed(&G));
    }
    G
}

fn scale_inputs(G: &mut StateSpace, size: f64) {
    for j in 0..G.inputs() {
        let ratio = G.B.column(j).norm().hypot(G.D.column(j).norm()) / size;
        let scale = if ratio.is_normal() { ratio.log2().round().exp2() } else { 1.0 };
        G.B.column_mut(j).unscale_mut(scale);
        G.D.column_mut(j).unscale_mut(scale);
    }
}

/// The largest subsystem whose output can be held at zero, as a system with a D of independent rows.
fn with_independent_rows(mut G: StateSpace, mut blur: Blur, size: f64) -> (StateSpace, Blur) {
    loop {
        // Q' D = [D1; 0], Q' C = [C1; C2]: the outputs C2 x stay at zero.
        let outputs = RowCompression::new(&G.D, blur.times(size));
        blur = blur.after(&outputs, size);
        let (n, free) = (G.order(), G.outputs() - outputs.rank);
        let (C, D) = (outputs.Q.tr_mul(&G.C), outputs.Q.tr_mul(&G.D).rows(0, outputs.rank).into_owned());
        let (C1, C2) = (C.rows(0, outputs.rank).into_owned(), C.rows(outputs.rank, free).into_owned());
        let states = RowCompression::new(&C2.transpose(), blur.times(size));
        blur = blur.after(&states, size);
        let V = &states.Q;
        let (dead, left) = (states.rank, n - states.rank);
        if dead == 0 {
            return (StateSpace { C: C1, D, ..G }, blur);
        }
        // In the coordinates V' x the first `dead` states are zero, and so are their derivatives: new outputs.
        let (A, B) = (V.tr_mul(&G.A) * V.columns(dead, left), V.tr_mul(&G.B));
        G = StateSpace {
            A: A.rows(dead, left).into_owned(),
            B: B.rows(dead, left).into_owned(),
            C: stack(&(C1 * V.columns(dead, left)), &A.rows(0, dead).into_owned()),
            D: stack(&D, &B.rows(0, dead).into_owned()),
            time: G.time,
        };
    }
}
