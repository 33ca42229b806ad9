//! The matrix exponential less the identity: e^M - I, with small entries accurate relative to themselves.
//!
//! Enters: a square matrix. Leaves: e^M - I. Absent: sampling itself (module `sampling`).

use crate::Mat;

/// Norm to which M is halved before the series: no term is then larger than M itself.
const SERIES_NORM: f64 = 0.5;

/// Terms of the series. 14 reach the last bit of M's own entries at [`SERIES_NORM`]; 18 also that of entries which begin
/// with the eighth power (the end of a chain of eight integrators).
const TERMS: usize = 18;

/// e^M - I.
///
/// Shapes: M n x n.
/// Returns: NaN or infinite entries when e^M overflows.
/// Numerics: Taylor series of M / 2^s, s squarings as (I + E)^2 - I = 2 E + E E, after balancing by powers of two. The
/// identity is never added, so an entry of size 1e-9 (a position's response to a voltage within a millisecond) keeps
/// its digits, which a solver's normwise error of 1e-16 would not leave it. Exact zeros of a block triangular M stay.
/// 18 + s products.
/// Source: Higham 2008, *Functions of Matrices*, 10.3. Differs: the series of e^M - I instead of a Pade quotient.
pub fn exponential_minus_identity(M: &Mat) -> Mat {
    let mut scaled = M.clone();
    if !M.iter().all(|x| x.is_finite()) {
        return Mat::from_element(M.nrows(), M.ncols(), f64::NAN);
    }
    let d = nalgebra::linalg::balancing::balance_parlett_reinsch(&mut scaled);
    let halvings = halvings(norm_1(&scaled));
    scaled *= 0.5_f64.powi(halvings);
    let mut E = series(&scaled);
    for _ in 0..halvings {
        E = &E * 2.0 + &E * &E;
    }
    nalgebra::linalg::balancing::unbalance(&mut E, &d);
    E
}

/// e^M.
///
/// Shapes: M n x n. Numerics: as [`exponential_minus_identity`].
pub fn exponential(M: &Mat) -> Mat {
    exponential_minus_identity(M) + Mat::identity(M.nrows(), M.nrows())
}

fn halvings(norm: f64) -> i32 {
    if norm <= SERIES_NORM { 0 } else { (norm / SERIES_NORM).log2().ceil() as i32 }
}

/// M + M^2/2! + M^3/3! + .. by Horner: M (I + M/2 (I + M/3 (..))).
fn series(M: &Mat) -> Mat {
    let mut E = M / TERMS as f64;
    for k in (1..TERMS).rev() {
        E = M * &E / k as f64 + M / k as f64;
    }
    E
}

fn norm_1(M: &Mat) -> f64 {
    M.column_iter().map(|c| c.lp_norm(1)).fold(0.0, f64::max)
}
