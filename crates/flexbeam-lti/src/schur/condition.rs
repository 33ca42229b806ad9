use super::spectrum;
use crate::{C64, CMat, Error, Mat};

/// Rounding of the Schur form, in units of eps times the norm: an eigenvalue is known no better than this times its condition.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Farther off a line than this, relative to the norm, no eigenvalue of multiplicity up to four has been moved by rounding: eps^(1/4).
const FAR: f64 = 1.2e-4;

/// Eigenvalues of A, and the first that may lie on a line by its own condition.
///
/// Takes the distance of an eigenvalue from the line. A is taken as balanced.
pub(crate) fn spectrum_off_line(A: &Mat, distance: impl Fn(C64) -> f64) -> Result<(Vec<C64>, Option<C64>), Error> {
    let size = A.norm();
    let eigenvalues = spectrum(A)?;
    let may_lie_on_line = |p: &&C64| {
        let d = distance(**p);
        d <= FAR * size && (d <= ROUNDING * size || d <= ROUNDING * size * condition(A, **p))
    };
    let found = eigenvalues.iter().find(may_lie_on_line).copied();
    Ok((eigenvalues, found))
}

/// 1/|y* x| for unit left and right eigenvectors y and x, each by two steps of inverse iteration.
fn condition(A: &Mat, lambda: C64) -> f64 {
    let n = A.nrows();
    // Off the eigenvalue by its own rounding, so that the factor exists.
    let near = lambda + C64::new(f64::EPSILON * A.norm(), 0.0);
    let pencil = A.map(C64::from) - CMat::from_diagonal_element(n, n, near);
    let start = CMat::from_fn(n, 1, |k, _| C64::new(1.0, 0.5 * (k as f64).cos()));
    let direction = |M: CMat| {
        let lu = M.lu();
        let once = lu.solve(&start)?.normalize();
        Some(lu.solve(&once)?.normalize())
    };
    match (direction(pencil.clone()), direction(pencil.adjoint())) {
        (Some(x), Some(y)) => 1.0 / y.dotc(&x).norm(),
        _ => f64::INFINITY,
    }
}
