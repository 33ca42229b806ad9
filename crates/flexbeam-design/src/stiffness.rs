//! Spending the level on stiffness: a prescribed K(0) as one more interpolation condition.
//!
//! With the integrator's pole at p, W = (s - p) h(s), G = k/(s - p) + g0 + .., the feedback's static gain is
//! K = -h(p) / (k h'(p) + g0 h(p)) and h(p) = 1/k, so K fixes h'(p), and with it F'(p). K = infinity is integral action.
//!
//! Source: DESIGN 6.2.

use flexbeam_lti::C64;

use crate::half_plane::HalfPlane;
use crate::interpolation::{Interpolant, Interpolation};
use crate::radius::{conditions, regular_slope, residue};
use crate::{Error, Uncertainty};

/// What the feedback is asked to do against a constant disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stiffness {
    /// Nothing: the smallest norm (22), the softest loop.
    Optimal,
    /// At least this static gain K(0) [V/rad].
    AtLeast(f64),
    /// Exactly this static gain K(0) [V/rad].
    Exactly(f64),
    /// Integral action, K(0) infinite.
    Integral,
}

impl Stiffness {
    /// The gain that keeps the error of a residual voltage within an angle: K(0) = v_res / angle.
    ///
    /// Default of the command line: 0.15 degree.
    pub fn needed(residual_voltage_v: f64, angle_rad: f64) -> Stiffness {
        Stiffness::AtLeast(residual_voltage_v / angle_rad)
    }

    /// The gain as a number; `None` when nothing is asked.
    pub fn requested(self) -> Option<f64> {
        match self {
            Stiffness::Optimal => None,
            Stiffness::AtLeast(k) | Stiffness::Exactly(k) => Some(k),
            Stiffness::Integral => Some(f64::INFINITY),
        }
    }
}

/// An integrator's pole may be off by this much of beta: identified models carry it where the data put it.
const INTEGRATOR_WITHIN: f64 = 0.05;

/// The interpolation conditions with the derivative that gives the static gain K(0) = `stiffness` [V/rad].
///
/// Errors: [`Error::NoIntegrator`] when no pole lies at s = 0.
pub(crate) fn conditions_with_stiffness(
    plant: &HalfPlane,
    alpha: &Uncertainty,
    stiffness: f64,
) -> Result<Interpolation, Error> {
    let (index, p) = integrator(plant, stiffness)?;
    let k = residue(&plant.zpk, p);
    let g0_over_k = regular_slope(&plant.zpk, p);
    // h'/h = -(1/K + g0)/k, the sign of K being that of k: negative feedback.
    let compliance = C64::from(k.re.signum() / stiffness);
    let slope_h = -compliance / k - g0_over_k;
    let slope = slope_h + alpha.zpk().logarithmic_derivative(p) - blaschke_slope(plant, p);
    let plain = conditions(plant, alpha)?;
    let value = plain.value(index) * slope;
    Ok(plain.with_derivative(index, value.re))
}

/// d/ds of log(B_p(s)/(s - p)) at p.
fn blaschke_slope(plant: &HalfPlane, p: C64) -> C64 {
    let points = plant.unstable_poles();
    let mirrored: C64 = points.iter().map(|q| (p + q.conj()).inv()).sum();
    let other: C64 = points.iter().filter(|q| **q != p).map(|q| (p - q).inv()).sum();
    other - mirrored
}

/// The interpolation point of the integrator among the unstable poles.
pub(crate) fn integrator(plant: &HalfPlane, requested: f64) -> Result<(usize, C64), Error> {
    let expected = C64::from(plant.integrator_point());
    let points = plant.unstable_poles();
    let nearest =
        (0..points.len()).min_by(|a, b| (points[*a] - expected).norm().total_cmp(&(points[*b] - expected).norm()));
    match nearest {
        Some(k) if (points[k] - expected).norm() <= INTEGRATOR_WITHIN * plant.beta && points[k].im == 0.0 => {
            Ok((k, points[k]))
        }
        found => {
            let nearest = found.map_or(f64::NAN, |k| points[k].re - plant.beta);
            Err(Error::NoIntegrator { requested, nearest })
        }
    }
}

/// K(0) of the loop that an interpolant gives [V/rad]: the derivative condition read backwards.
pub(crate) fn stiffness_of(
    plant: &HalfPlane,
    alpha: &Uncertainty,
    interpolant: &Interpolant,
    requested: f64,
) -> Result<f64, Error> {
    let (_, p) = integrator(plant, requested)?;
    let k = residue(&plant.zpk, p);
    let slope_f = interpolant.function.logarithmic_derivative(p);
    let slope_h = slope_f - alpha.zpk().logarithmic_derivative(p) + blaschke_slope(plant, p);
    let compliance = -(slope_h + regular_slope(&plant.zpk, p)) * k;
    Ok(k.re.signum() / compliance.re)
}
