//! The flexible link's own coordinates, x = [theta alpha theta' alpha'], and the four numbers of (18).
//!
//! Enters: a continuous model with theta and alpha among its outputs. Leaves: the same model in (18)'s pattern.
//! Deliberately absent: stiffness and inertias, which need the motor's constants and belong to the rig.

use flexbeam_lti::{C64, Mat, StateSpace, Time, Vector};
use flexbeam_rig::{Lumped, Output};

use crate::Error;
use crate::singular::left_singular;

/// [C; CA] whose rows, scaled to length one, have a smaller reciprocal condition than this carries no digits of a state.
const LEAST_CONDITION: f64 = 1e-13;

/// A model in the coordinates [theta alpha theta' alpha'].
#[derive(Clone, Debug)]
pub struct PhysicalForm {
    /// First output theta, second alpha. A's first two rows are (18)'s by construction; its other entries and B are whatever
    /// the data say, without any pattern forced on them.
    pub model: StateSpace,
    /// The entries read off: k1 = A(3,2), k2 = -A(4,2), c = -A(3,3), b = B(3).
    pub parameters: Lumped,
}

/// x_physical = T x with T = [C; CA]: T A T^-1 and T B.
///
/// Shapes: `model` continuous, one input, order 4; `theta` and `alpha` name two of its outputs (from 0).
/// Assumes: both outputs in rad.
/// Errors: [`Error::NotTheFlexibleLink`], [`Error::Unobservable`], [`Error::Linear`] for a sampled model.
/// Numerics: T is equilibrated, then one LU; T^-1 is never formed.
/// Source: DESIGN section 5; (18) for the pattern.
pub fn physical_form(model: &StateSpace, theta: usize, alpha: usize) -> Result<PhysicalForm, Error> {
    let (n, m, l) = (model.order(), model.inputs(), model.outputs());
    if n != 4 || m != 1 || theta >= l || alpha >= l || theta == alpha {
        return Err(Error::NotTheFlexibleLink { inputs: m, outputs: l, order: n });
    }
    if model.time != Time::Continuous {
        let what = "physical coordinates";
        return Err(flexbeam_lti::Error::WrongTime { what, found: model.time, needed: "continuous time" }.into());
    }
    let C = model.C.select_rows(&[theta, alpha]);
    let CA = &C * &model.A;
    let CAA = &CA * &model.A;
    let lower = over(&CAA, &stacked(&C, &CA))?; // CAA = lower [C; CA]
    let mut A = Mat::zeros(4, 4);
    A.view_mut((0, 2), (2, 2)).fill_with_identity();
    A.rows_mut(2, 2).copy_from(&lower);
    let B = stacked(&(&C * &model.B), &(&CA * &model.B));
    let D = model.D.select_rows(&[theta, alpha]);
    let parameters = Lumped { k1: A[(2, 1)], k2: -A[(3, 1)], c: -A[(2, 2)], b: B[2] };
    let model = StateSpace::new(A, B, Mat::identity(2, 4), D, Time::Continuous)?;
    Ok(PhysicalForm { model, parameters })
}

/// k1, k2, c, b from the poles of a model and the size of its response: a start for a fit, where [`physical_form`] needs both theta
/// and alpha.
///
/// Delta = s^3 + c s^2 + k2 s + c (k2 - k1) has the poles without the integrator; b scales the response at the poles' distances.
/// Shapes: `model` continuous, one input, outputs made of `outputs` in order; 4 states where one of them sees theta, 3 otherwise.
/// Assumes: the pole nearest zero is the integrator's.
/// Errors: [`Error::NotTheFlexibleLink`], [`Error::Linear`] for a sampled model.
pub fn lumped_from_poles(model: &StateSpace, outputs: &[Output]) -> Result<Lumped, Error> {
    let unit = Lumped { b: 1.0, ..Lumped::PAPER }.state_space(outputs)?;
    let integrates = unit.C.column(0).amax() > 0.0;
    let (n, m, l) = (model.order(), model.inputs(), model.outputs());
    if m != 1 || l != outputs.len() || n != 3 + usize::from(integrates) {
        return Err(Error::NotTheFlexibleLink { inputs: m, outputs: l, order: n });
    }
    if model.time != Time::Continuous {
        let what = "physical parameters";
        return Err(flexbeam_lti::Error::WrongTime { what, found: model.time, needed: "continuous time" }.into());
    }
    let mut poles = model.poles();
    poles.sort_by(|p, q| q.norm().total_cmp(&p.norm()));
    let [p, q, r] = [poles[0], poles[1], poles[2]];
    let (c, k2, last) = (-(p + q + r).re, (p * q + q * r + r * p).re, -(p * q * r).re);
    let shape = Lumped { k1: k2 - last / c, k2, c, b: 1.0 };
    let unit = shape.state_space(outputs)?;
    let (mut products, mut squares) = (0.0, 0.0);
    for omega in [p, q, r].map(|pole| C64::new(0.0, pole.norm())) {
        for (found, unit) in model.at(omega).iter().zip(unit.at(omega).iter()) {
            products += (unit.conj() * found).re / unit.norm_sqr();
            squares += 1.0;
        }
    }
    Ok(Lumped { b: products / squares, ..shape })
}

/// X with X T = M, T square.
fn over(M: &Mat, T: &Mat) -> Result<Mat, Error> {
    let rows: Vec<f64> = T.row_iter().map(|r| r.norm()).collect();
    let scaled = Mat::from_fn(4, 4, |r, c| T[(r, c)] / rows[r]);
    let columns: Vec<f64> = scaled.column_iter().map(|c| c.norm()).collect();
    let scaled = Mat::from_fn(4, 4, |r, c| scaled[(r, c)] / columns[c]);
    let singular = left_singular(&scaled).0;
    let reciprocal = singular[3] / singular[0];
    if !(reciprocal > LEAST_CONDITION) {
        return Err(Error::Unobservable { reciprocal });
    }
    // X diag(rows) scaled = M / diag(columns).
    let right = Mat::from_fn(4, M.nrows(), |c, r| M[(r, c)] / columns[c]);
    let solution = scaled.transpose().lu().solve(&right).ok_or(Error::Unobservable { reciprocal })?;
    Ok(Mat::from_fn(M.nrows(), 4, |r, c| solution[(c, r)] / rows[c]))
}

fn stacked(top: &Mat, bottom: &Mat) -> Mat {
    let mut both = Mat::zeros(top.nrows() + bottom.nrows(), top.ncols());
    both.rows_mut(0, top.nrows()).copy_from(top);
    both.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    both
}

/// State [theta alpha theta' alpha'] of (18)'s coordinates from the state of `model`.
pub fn physical_state(model: &StateSpace, theta: usize, alpha: usize, x: &Vector) -> Vector {
    let C = model.C.select_rows(&[theta, alpha]);
    stacked(&C, &(&C * &model.A)) * x
}
