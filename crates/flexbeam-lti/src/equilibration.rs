//! States rescaled by powers of two, so that no number of a realisation is needlessly large or small.

use crate::StateSpace;

/// A rescaling must shrink row plus column norm at least by this factor, or the search would go round in circles.
const WORTHWHILE: f64 = 0.95;

/// T^-1 A T, T^-1 B, C T, D with a diagonal T of powers of two: the same function, without any rounding.
///
/// Returns: a realisation in which each state's row of [A B] and column of [A; C] have nearly equal norms, A's diagonal apart.
/// Source: James, Langou & Lowery 2014 (norm 2, as for eigenvalues), with B and C taken along.
pub fn equilibrated(system: &StateSpace) -> StateSpace {
    let mut G = system.clone();
    while (0..G.order()).filter(|&i| rescale(&mut G, i)).count() > 0 {}
    G
}

/// Rescales state i; whether it was worthwhile.
fn rescale(G: &mut StateSpace, i: usize) -> bool {
    let diagonal = G.A[(i, i)] * G.A[(i, i)];
    let row = (G.A.row(i).norm_squared() - diagonal + G.B.row(i).norm_squared()).max(0.0).sqrt();
    let column = (G.A.column(i).norm_squared() - diagonal + G.C.column(i).norm_squared()).max(0.0).sqrt();
    if !(row > 0.0 && column > 0.0) {
        return false;
    }
    let t = (row / column).sqrt().log2().round().exp2();
    if !(t.is_normal() && row / t + column * t < WORTHWHILE * (row + column)) {
        return false;
    }
    G.A.row_mut(i).unscale_mut(t);
    G.B.row_mut(i).unscale_mut(t);
    G.A.column_mut(i).scale_mut(t);
    G.C.column_mut(i).scale_mut(t);
    true
}
