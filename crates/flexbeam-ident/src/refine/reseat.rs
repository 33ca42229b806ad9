//! Another place for a pole that does nothing where it stands.
//!
//! Enters: the end of a descent. Leaves: a point from which to descend again, its idlest mode moved to where the residuals ask
//! for one. Deliberately absent: chance; gains K, whose poles are the predictor's.

use flexbeam_lti::schur::ordered_schur;
use flexbeam_lti::simulation::simulate;
use flexbeam_lti::sylvester::sylvester;
use flexbeam_lti::{C64, Mat, StateSpace, Time, Vector};

use super::local::{Point, Structure};
use super::sensitivity::Record;

/// A mode is idle when leaving it out raises the squares by less than this part of them.
const IDLE: f64 = 0.05;
/// Damping ratios of the pairs that are tried.
const DAMPING: [f64; 4] = [0.003, 0.03, 0.2, 0.6];

/// A mode apart from the rest: A2 = diag(mode, rest).
struct Apart {
    point: Point,
    /// Rows of the mode.
    size: usize,
    /// Weighted output of the mode alone, l x s.
    answer: Mat,
}

/// The point with its idlest mode elsewhere; None where no mode is idle or none can be told apart.
///
/// Every mode's output is simulated alone, and the one whose absence costs least is taken out. Modes on a grid of poles, each
/// driven by one input, are fitted to what is then left, and the best takes its place.
pub(super) fn reseated(
    point: &Point,
    record: &Record,
    structure: Structure,
    weight: &Mat,
    settled: bool,
) -> Option<Point> {
    let integrators = structure.integrators;
    if point.K.is_some() {
        return None;
    }
    let left = weight * (&record.Y - output(point, &record.W)?);
    let idlest = modes(point, integrators)
        .into_iter()
        .filter_map(|mode| apart(point, integrators, mode, record, weight))
        .min_by(|a, b| (&left + &a.answer).norm().total_cmp(&(&left + &b.answer).norm()))?;
    let without = &left + &idlest.answer;
    if settled && without.norm_squared() > (1.0 + IDLE) * left.norm_squared() {
        return None;
    }
    placed(&idlest, structure, record, weight, &without)
}

fn system(point: &Point) -> Option<StateSpace> {
    let Point { A, B, C, D, .. } = point.clone();
    StateSpace::new(A, B, C, D, Time::Sampled { period_s: 1.0 }).ok()
}

fn output(point: &Point, U: &Mat) -> Option<Mat> {
    simulate(&system(point)?, U, &point.initial_state).ok().filter(|Y| Y.iter().all(|y| y.is_finite()))
}

/// Real poles and upper ones of pairs, known integrators apart.
fn modes(point: &Point, integrators: usize) -> Vec<C64> {
    let poles = flexbeam_lti::schur::spectrum(&rest(point, integrators)).unwrap_or_default();
    poles.into_iter().filter(|z| z.im >= 0.0).collect()
}

fn rest(point: &Point, q: usize) -> Mat {
    let n = point.A.nrows();
    point.A.view((q, q), (n - q, n - q)).into_owned()
}

fn apart(point: &Point, q: usize, mode: C64, record: &Record, weight: &Mat) -> Option<Apart> {
    let A2 = rest(point, q);
    let form = ordered_schur(&A2, |z| (z - mode).norm() <= 1e-9 * (1.0 + mode.norm())).ok()?;
    let (size, n2) = (form.leading, A2.nrows());
    if size == 0 {
        return None;
    }
    let block = |r: usize, c: usize, rows: usize, columns: usize| form.T.view((r, c), (rows, columns)).into_owned();
    let (own, others) = (block(0, 0, size, size), block(size, size, n2 - size, n2 - size));
    let X = sylvester(&own, &-&others, &-block(0, size, size, n2 - size)).ok()?;
    // x2 = Q [I X; 0 I] xi.
    let mut S = Mat::identity(n2, n2);
    S.view_mut((0, size), (size, n2 - size)).copy_from(&X);
    let T = &form.Q * S;
    let mut inverse = Mat::identity(n2, n2);
    inverse.view_mut((0, size), (size, n2 - size)).copy_from(&-X);
    let inverse = inverse * form.Q.transpose();
    let mut moved = point.clone();
    let mut A = Mat::zeros(n2, n2);
    A.view_mut((0, 0), (size, size)).copy_from(&own);
    A.view_mut((size, size), others.shape()).copy_from(&others);
    moved.A.view_mut((q, q), (n2, n2)).copy_from(&A);
    let (B, C) = (&inverse * point.B.rows(q, n2), point.C.columns(q, n2) * T);
    moved.B.rows_mut(q, n2).copy_from(&B);
    moved.C.columns_mut(q, n2).copy_from(&C);
    let x = inverse * point.initial_state.rows(q, n2);
    moved.initial_state.rows_mut(q, n2).copy_from(&x);
    let alone = Point {
        A: own,
        B: moved.B.rows(q, size).into_owned(),
        C: moved.C.columns(q, size).into_owned(),
        D: Mat::zeros(point.D.nrows(), point.D.ncols()),
        K: None,
        initial_state: moved.initial_state.rows(q, size).into_owned(),
    };
    let answer = weight * output(&alone, &record.W)?;
    Some(Apart { point: moved, size, answer })
}

/// The mode of the grid that explains most of `without`, in the place of the one that was taken out.
fn placed(apart: &Apart, structure: Structure, record: &Record, weight: &Mat, without: &Mat) -> Option<Point> {
    let (q, size, s) = (structure.integrators, apart.size, record.W.ncols());
    let inputs = record.W.nrows() - usize::from(structure.offset);
    let mut best: Option<(f64, Mat, usize, Mat)> = None;
    for A in grid(size, s) {
        for c in 0..inputs {
            let X = states(&A, &record.W, c);
            let gram = &X * X.transpose();
            let Some(gain) = gram.cholesky().map(|gram| gram.solve(&(&X * without.transpose())).transpose()) else {
                continue;
            };
            let explained = (&gain * &X).norm_squared();
            if best.as_ref().is_none_or(|best| explained > best.0) {
                best = Some((explained, A.clone(), c, gain));
            }
        }
    }
    let (_, A, input, gain) = best?;
    let C = weight.clone().lu().solve(&gain)?;
    let mut point = apart.point.clone();
    point.A.view_mut((q, q), (size, size)).copy_from(&A);
    point.B.rows_mut(q, size).fill(0.0);
    point.B[(q, input)] = 1.0;
    point.C.columns_mut(q, size).copy_from(&C);
    point.initial_state.rows_mut(q, size).fill(0.0);
    Some(point)
}

/// x(k+1) = A x + e_1 u_c from rest.
fn states(A: &Mat, U: &Mat, c: usize) -> Mat {
    let size = A.nrows();
    let mut X = Mat::zeros(size, U.ncols());
    let mut x = Vector::zeros(size);
    for k in 0..U.ncols() {
        X.set_column(k, &x);
        x = A * &x;
        x[0] += U[(c, k)];
    }
    X
}

/// Time constants from a sample to a quarter of the record, a factor of two apart; pairs of such periods, at four dampings.
fn grid(size: usize, samples: usize) -> Vec<Mat> {
    let slow = |k: i32| 0.5f64.powi(k);
    let most = ((samples as f64 / 4.0).log2().floor() as i32).max(1);
    if size == 1 {
        let decaying = (0..most).map(|k| 1.0 - slow(k));
        return decaying.chain([-0.5, -0.9]).map(|pole| Mat::from_element(1, 1, pole)).collect();
    }
    let angles = (0..2 * most).map(|k| std::f64::consts::PI * 0.9 * 0.5f64.powf(f64::from(k) / 2.0));
    let pairs = angles.flat_map(|angle| DAMPING.map(|zeta| C64::from_polar((-zeta * angle).exp(), angle)));
    pairs.map(|z| Mat::from_row_slice(2, 2, &[z.re, z.im, -z.im, z.re])).collect()
}
