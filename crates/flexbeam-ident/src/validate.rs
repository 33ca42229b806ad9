//! How well a model says what a recording does: pure simulation, no one-step prediction.
//!
//! Enters: sampled model, recording. Leaves: simulated output and fit in percent.

use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{Mat, StateSpace, Vector};

use crate::{Error, output_map};

/// A model's answer to a recorded input, started from the initial state that suits the recorded output best.
#[derive(Clone, Debug)]
pub struct Validation {
    /// 100 (1 - |y - yhat| / |y - mean y|) of each output; negative infinity when the simulation overflows or the output is
    /// constant and missed.
    pub fit_percent: Vec<f64>,
    /// Initial state by least squares on these samples.
    pub initial_state: Vector,
    /// yhat, outputs x samples.
    pub simulated: Mat,
}

impl Validation {
    /// Mean fit over the outputs.
    pub fn mean_fit_percent(&self) -> f64 {
        self.fit_percent.iter().sum::<f64>() / self.fit_percent.len() as f64
    }
}

/// Simulates `model` over the inputs U from the initial state that suits Y best, and compares with Y.
///
/// Shapes: U m x s, Y l x s.
/// Errors: shapes and time of the simulation ([`flexbeam_lti::Error`]).
/// Source: the fit of the DaISy comparisons, initial state of the validation by least squares.
pub fn validate(model: &StateSpace, U: &Mat, Y: &Mat) -> Result<Validation, Error> {
    let forced = simulate(model, U, &Vector::zeros(model.order()))?;
    let rest = Y - &forced;
    if !rest.iter().all(|x| x.is_finite()) {
        let overflow = vec![f64::NEG_INFINITY; Y.nrows()];
        return Ok(Validation {
            fit_percent: overflow,
            initial_state: Vector::zeros(model.order()),
            simulated: forced,
        });
    }
    let initial_state = output_map::initial_state(&model.A, &model.C, &rest.transpose());
    let simulated = simulate(model, U, &initial_state)?;
    let fit_percent =
        (0..Y.nrows()).map(|p| fit_percent(&Y.row(p).transpose(), &simulated.row(p).transpose())).collect();
    Ok(Validation { fit_percent, initial_state, simulated })
}

/// 100 (1 - |y - yhat| / |y - mean y|).
fn fit_percent(y: &Vector, simulated: &Vector) -> f64 {
    let missed = (y - simulated).norm();
    let moved = y.add_scalar(-y.mean()).norm();
    let fit = if missed == 0.0 { 100.0 } else { 100.0 * (1.0 - missed / moved) };
    if fit.is_nan() { f64::NEG_INFINITY } else { fit }
}
