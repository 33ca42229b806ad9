//! The closed loop built explicitly: its poles, its norm (22), its static gain.

use flexbeam_lti::norm::hinf_norm;
use flexbeam_lti::{C64, Mat, StateSpace, Time, connections, sampling};

use crate::margins::{Margins, margins};
use crate::{Error, Uncertainty};

/// Figures of one loop, continuous or sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopFigures {
    /// sup |alpha W| on the line Re s = -beta, W = K/(1 + G K): (22). Infinite when the loop is not stable to that degree.
    pub bound_norm: f64,
    /// -max Re of the closed-loop poles [1/s]; sampled: -max ln|z|/Ts.
    pub stability_degree: f64,
    /// Poles of the loop; sampled: in the z-plane.
    pub poles: Vec<C64>,
    /// K(0) [V/rad].
    pub stiffness: f64,
    /// Margins at the plant's input.
    pub margins: Margins,
}

impl LoopFigures {
    /// Figures of plant and controller, u = -K y.
    ///
    /// `alpha` is the bound in the half-plane in which the norm is taken: alpha(s), or its image in the w-plane.
    pub fn of(plant: &StateSpace, K: &StateSpace, beta: f64, alpha: &Uncertainty) -> Result<LoopFigures, Error> {
        let W = control_sensitivity(plant, K)?;
        let poles = W.poles();
        let stability_degree = degree(&poles, W.time);
        let bound_norm = if stability_degree > beta { weighted_norm(&W.shifted(beta), alpha)? } else { f64::INFINITY };
        Ok(LoopFigures { bound_norm, stability_degree, poles, stiffness: static_gain(K), margins: margins(plant, K)? })
    }
}

/// W = K/(1 + G K), the transfer function from a measurement error to the voltage, for a strictly proper G.
fn control_sensitivity(G: &StateSpace, K: &StateSpace) -> Result<StateSpace, Error> {
    Ok(connections::feedback(K, G)?)
}

fn weighted_norm(W: &StateSpace, alpha: &Uncertainty) -> Result<f64, Error> {
    let half_plane = match W.time {
        Time::Continuous => W.clone(),
        Time::Sampled { .. } => sampling::to_w(W)?,
    };
    let weight = alpha.zpk().to_state_space(Time::Continuous)?;
    Ok(hinf_norm(&connections::series(&half_plane, &weight)?)?.norm)
}

/// Distance of the poles to the boundary of stability, in 1/s.
pub(crate) fn degree(poles: &[C64], time: Time) -> f64 {
    let worst = |value: fn(&C64) -> f64| poles.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
    match time {
        Time::Continuous => -worst(|p| p.re),
        Time::Sampled { period_s } => -worst(|z| z.norm()).ln() / period_s,
    }
}

/// K at s = 0 or z = 1; infinite when K has a pole there to working precision: integral action.
fn static_gain(K: &StateSpace) -> f64 {
    let n = K.order();
    if n == 0 {
        return K.D[(0, 0)];
    }
    let dynamics = match K.time {
        Time::Continuous => -&K.A,
        Time::Sampled { .. } => Mat::identity(n, n) - &K.A,
    };
    let singular = dynamics.clone().svd(false, false).singular_values;
    if !(singular.min() > INTEGRATING * singular.max()) {
        return f64::INFINITY;
    }
    dynamics.lu().solve(&K.B).map_or(f64::INFINITY, |X| (&K.C * X + &K.D)[(0, 0)])
}

/// A controller whose smallest singular value at s = 0 lies below this part of the largest integrates: rounding leaves 1e-16
/// to 1e-12, the slowest pole that anybody would wait for some 1e-6.
const INTEGRATING: f64 = 1e-10;
