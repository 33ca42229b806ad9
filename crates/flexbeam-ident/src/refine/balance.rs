//! Coordinates in which no state is faint: balanced over the record's horizon, each block of A by itself.
//!
//! Enters: a model in block form. Leaves: the same model, in coordinates in which a short step is short in every direction.

use flexbeam_lti::Mat;

use super::local::Point;

/// Growth of A^k at which the horizon ends.
const MOST_GROWTH: f64 = 1e6;
/// Gramians are raised by this part of their size: a faint state is not blown up beyond its inverse.
const FAINT: f64 = 1e-12;

/// The point in balanced coordinates; as it is where the gramians cannot be factored.
///
/// Source: Moore 1981, over a finite horizon; McKelvey and Helmersson 1999 for balanced local coordinates.
pub(crate) fn balanced(point: &Point, integrators: usize, samples: usize) -> Point {
    let (n, q) = (point.A.nrows(), integrators);
    let mut balanced = point.clone();
    // The unit diagonal of the first block is kept by a change of scale alone.
    for (first, width) in (0..q).map(|k| (k, 1)).chain((n > q).then_some((q, n - q))) {
        if let Some((T, inverse)) = balancing(&balanced, first, width, samples) {
            balanced = in_coordinates(&balanced, first, &T, &inverse);
        }
    }
    balanced
}

/// T and T^-1 of one block.
fn balancing(point: &Point, first: usize, width: usize, samples: usize) -> Option<(Mat, Mat)> {
    let A = point.A.view((first, first), (width, width)).into_owned();
    let mut drive = point.B.rows(first, width).into_owned();
    if let Some(K) = &point.K {
        let m = drive.ncols();
        drive = drive.resize_horizontally(m + K.ncols(), 0.0);
        drive.columns_mut(m, K.ncols()).copy_from(&K.rows(first, width));
    }
    let seen = point.C.columns(first, width).transpose();
    let reached = raised(horizon_gramian(&A, &drive, samples))?;
    let observed = raised(horizon_gramian(&A.transpose(), &seen, samples))?;
    let factor = reached.cholesky()?.l();
    let eigen = (factor.transpose() * observed * &factor).symmetric_eigen();
    let scale: Vec<f64> = eigen.eigenvalues.iter().map(|e| e.max(0.0).sqrt().sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return None;
    }
    // T = L V S^-1/2, T^-1 = S^1/2 V' L^-1.
    let scaled = |M: &Mat, by: &dyn Fn(f64) -> f64| Mat::from_fn(width, width, |r, c| M[(r, c)] * by(scale[c]));
    let T = &factor * scaled(&eigen.eigenvectors, &|s| 1.0 / s);
    let inverse = factor.tr_solve_lower_triangular(&scaled(&eigen.eigenvectors, &|s| s))?.transpose();
    Some((T, inverse))
}

/// Sum of A^k b b' A'^k over the horizon, by doubling.
fn horizon_gramian(A: &Mat, b: &Mat, samples: usize) -> Mat {
    let mut gramian = b * b.transpose();
    let mut power = A.clone();
    let mut horizon = 1;
    while horizon < samples && power.amax() < MOST_GROWTH {
        gramian += &power * &gramian * power.transpose();
        power = &power * &power;
        horizon *= 2;
    }
    gramian
}

fn raised(gramian: Mat) -> Option<Mat> {
    let size = gramian.trace();
    let n = gramian.nrows();
    (size > 0.0 && size.is_finite())
        .then(|| (&gramian + gramian.transpose()) * 0.5 + Mat::identity(n, n) * (FAINT * size))
}

/// x = T xi on one block.
fn in_coordinates(point: &Point, first: usize, T: &Mat, inverse: &Mat) -> Point {
    let mut moved = point.clone();
    let width = T.nrows();
    let rows = |M: &mut Mat| {
        let changed = inverse * M.rows(first, width);
        M.rows_mut(first, width).copy_from(&changed);
    };
    rows(&mut moved.A);
    rows(&mut moved.B);
    moved.K.iter_mut().for_each(rows);
    for M in [&mut moved.A, &mut moved.C] {
        let changed = M.columns(first, width) * T;
        M.columns_mut(first, width).copy_from(&changed);
    }
    if width == 1 {
        // A change of scale leaves the eigenvalue alone, to the last bit.
        moved.A[(first, first)] = point.A[(first, first)];
    }
    let x = inverse * moved.initial_state.rows(first, width);
    moved.initial_state.rows_mut(first, width).copy_from(&x);
    moved
}
