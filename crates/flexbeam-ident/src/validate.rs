//! How well a model says what a recording does: pure simulation, no one-step prediction.
//!
//! Enters: sampled model, recording. Leaves: simulated output and fit in percent.

use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{Mat, StateSpace, Vector};

use crate::correlation::Channels;
use crate::modal::{Free, Problem};
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
    let Some(initial_state) = initial_state(model, U, Y)? else {
        let forced = simulate(model, U, &Vector::zeros(model.order()))?;
        let overflow = vec![f64::NEG_INFINITY; Y.nrows()];
        return Ok(Validation {
            fit_percent: overflow,
            initial_state: Vector::zeros(model.order()),
            simulated: forced,
        });
    };
    let simulated = simulate(model, U, &initial_state)?;
    let fit_percent =
        (0..Y.nrows()).map(|p| fit_percent(&Y.row(p).transpose(), &simulated.row(p).transpose())).collect();
    Ok(Validation { fit_percent, initial_state, simulated })
}

/// None when the simulation overflows.
fn initial_state(model: &StateSpace, U: &Mat, Y: &Mat) -> Result<Option<Vector>, Error> {
    let channels = Channels::of_rows(U).beside(Channels::of_rows(Y));
    let (count, l) = (channels.count(), Y.nrows());
    let problem = Problem {
        A: &model.A,
        C: &model.C,
        B: model.B.clone(),
        D: model.D.clone(),
        offset: Vector::zeros(l),
        channels,
        mean: &vec![0.0; count],
        scale: &vec![1.0; count],
        threads: 1,
    };
    if let Some(fit) = problem.solve(Free { B: false, D: false, offset: false }) {
        return Ok(Some(fit.initial_state));
    }
    let rest = Y - simulate(model, U, &Vector::zeros(model.order()))?;
    let finite = rest.iter().all(|x| x.is_finite());
    Ok(finite.then(|| output_map::initial_state(&model.A, &model.C, &rest.transpose())))
}

/// 100 (1 - |y - yhat| / |y - mean y|) from the squares of both lengths.
pub(crate) fn fit_from_squares(missed: f64, moved: f64) -> f64 {
    let fit = if missed == 0.0 { 100.0 } else { 100.0 * (1.0 - (missed / moved).sqrt()) };
    if fit.is_nan() { f64::NEG_INFINITY } else { fit }
}

/// 100 (1 - |y - yhat| / |y - mean y|).
fn fit_percent(y: &Vector, simulated: &Vector) -> f64 {
    fit_from_squares((y - simulated).norm_squared(), y.add_scalar(-y.mean()).norm_squared())
}

#[cfg(test)]
mod tests {
    use flexbeam_lti::Time;

    use super::*;

    fn first_order(pole: f64) -> StateSpace {
        let one = |x: f64| Mat::from_element(1, 1, x);
        StateSpace::new(one(pole), one(1.0), one(1.0), one(0.0), Time::Sampled { period_s: 1.0 }).unwrap()
    }

    #[test]
    fn fit_is_a_hundred_for_the_output_and_zero_for_its_mean() {
        let y = Vector::from_column_slice(&[1.0, 2.0, 4.0, 5.0]);
        assert_eq!(fit_percent(&y, &y), 100.0);
        assert_eq!(fit_percent(&y, &Vector::from_element(4, 3.0)), 0.0);
        // |y - yhat| = 1, |y - mean| = sqrt 10.
        let near = Vector::from_column_slice(&[1.0, 2.0, 4.0, 6.0]);
        assert!((fit_percent(&y, &near) - 100.0 * (1.0 - 0.1f64.sqrt())).abs() < 1e-12);
    }

    /// y(0) = 8 decays by half a sample without input.
    #[test]
    fn initial_state_comes_from_the_validating_samples() {
        let Y = Mat::from_fn(1, 20, |_, k| 8.0 * 0.5f64.powi(k as i32));
        let found = validate(&first_order(0.5), &Mat::zeros(1, 20), &Y).unwrap();
        assert!((found.initial_state[0] - 8.0).abs() < 1e-13);
        assert!((found.mean_fit_percent() - 100.0).abs() < 1e-11);
    }

    #[test]
    fn a_simulation_that_overflows_has_no_fit() {
        let U = Mat::from_element(1, 4000, 1.0);
        let found = validate(&first_order(1.5), &U, &Mat::from_fn(1, 4000, |_, k| (k as f64).sin())).unwrap();
        assert_eq!(found.fit_percent, [f64::NEG_INFINITY]);
    }
}
