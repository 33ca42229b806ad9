//! Minimal realisations: states that no input reaches or no output shows are left out.
//!
//! Enters: a system. Leaves: one of least order. Absent: approximate reduction (see `reduction`).

use crate::compression::{Blur, RowCompression};
use crate::equilibration::equilibrated;
use crate::{Mat, StateSpace, Time};

/// The controllable and observable part: the same function with the least number of states.
///
/// Numerics: orthogonal staircase forms after rescaling, of A - I for a sampled system. A coupling below rounding, relative to the whole, counts as
/// none; a merely weak one stays.
/// Source: Van Dooren 1981.
pub fn minimal(system: &StateSpace) -> StateSpace {
    let controllable = controllable_part(&equilibrated(&about_centre(system, -1.0)));
    about_centre(&transposed(&controllable_part(&transposed(&controllable))), 1.0)
}

/// Where fast sampling gathers all poles.
pub(crate) fn centre(time: Time) -> f64 {
    match time {
        Time::Continuous => 0.0,
        Time::Sampled { .. } => 1.0,
    }
}

/// A + sign * centre * I: a function of z - 1 (the delta operator) and back.
///
/// NUMERICS: beside an identity the rest of e^(A Ts) would be judged, and rounded, as a small perturbation.
pub(crate) fn about_centre(system: &StateSpace, sign: f64) -> StateSpace {
    let mut moved = system.clone();
    for k in 0..moved.order() {
        moved.A[(k, k)] += sign * centre(moved.time);
    }
    moved
}

/// (A', C', B', D').
pub(crate) fn transposed(G: &StateSpace) -> StateSpace {
    StateSpace { A: G.A.transpose(), B: G.C.transpose(), C: G.B.transpose(), D: G.D.transpose(), time: G.time }
}

/// States that the inputs reach, level by level.
fn controllable_part(system: &StateSpace) -> StateSpace {
    let mut G = system.clone();
    let n = G.order();
    let (mut reached, mut level, mut size) = (0, G.B.clone(), G.B.norm());
    let mut blur = Blur::of_rounding(n + G.inputs());
    while reached < n {
        let compression = RowCompression::new(&level, blur.times(size));
        rotate(&mut G, reached, &compression.Q);
        if compression.rank == 0 {
            break;
        }
        blur = blur.after(&compression, size);
        let next = reached + compression.rank;
        level = G.A.view((next, reached), (n - next, compression.rank)).into_owned();
        (reached, size) = (next, G.A.norm());
    }
    let (A, B) = (G.A.view((0, 0), (reached, reached)).into_owned(), G.B.rows(0, reached).into_owned());
    StateSpace { A, B, C: G.C.columns(0, reached).into_owned(), D: G.D, time: G.time }
}

/// New coordinates Q' x for the states from `first` on.
fn rotate(G: &mut StateSpace, first: usize, Q: &Mat) {
    let count = Q.nrows();
    let rows = Q.tr_mul(&G.A.rows(first, count));
    G.A.rows_mut(first, count).copy_from(&rows);
    let columns = G.A.columns(first, count) * Q;
    G.A.columns_mut(first, count).copy_from(&columns);
    let B = Q.tr_mul(&G.B.rows(first, count));
    G.B.rows_mut(first, count).copy_from(&B);
    let C = G.C.columns(first, count) * Q;
    G.C.columns_mut(first, count).copy_from(&C);
}
