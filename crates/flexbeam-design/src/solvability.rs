//! Whether (22) has a solution, and if not, by how much it fails and what would help.

use flexbeam_lti::StateSpace;

use crate::half_plane::HalfPlane;
use crate::radius::robust_radius;
use crate::stiffness::conditions_with_stiffness;
use crate::synthesis::{expect_positive, strictly_proper};
use crate::{Error, Uncertainty};

/// The answer to "is there a controller with this stability degree against this uncertainty?".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solvability {
    /// Largest perturbation in units of alpha that some controller survives; `None` when nothing is unstable after the shift.
    pub robust_radius: Option<f64>,
}

impl Solvability {
    /// (22) has a solution.
    pub fn is_solvable(&self) -> bool {
        self.robust_radius.is_none_or(|radius| radius >= 1.0)
    }
}

/// Why there is no controller.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unsolvable {
    /// The radius is below one.
    #[error(
        "(22) has no solution: the robust radius is {radius:.6}, so the smallest reachable ||S_w|| is {:.6}, {:.1} % too large{}\nhint: it becomes solvable when alpha is scaled by {:.6} or less{}",
        1.0 / radius, 100.0 * (1.0 / radius - 1.0), sampled(.period_s), floor(*.radius, 1e6), smaller_beta(.largest_beta)
    )]
    Radius {
        /// The robust radius found.
        radius: f64,
        /// The largest beta below the one asked for at which the radius is one, where there is one.
        largest_beta: Option<f64>,
        /// Sample period of the loop that failed [s]; `None` for the continuous one.
        period_s: Option<f64>,
    },
    /// The stiffness does not fit into the level.
    #[error(
        "(22) has no solution with a stiffness of {requested_v_per_rad:.4} V/rad: the smallest ||S_w|| is {level:.6}, {:.1} % too large\nhint: {:.3} V/rad is the nearest that fits below one; a smaller beta or alpha leaves room for more",
        100.0 * (level - 1.0), rounded_inside(*.nearest_v_per_rad, *.requested_v_per_rad)
    )]
    Stiffness {
        /// K(0) asked for [V/rad].
        requested_v_per_rad: f64,
        /// Level that it takes.
        level: f64,
        /// The nearest K(0) that level one permits [V/rad].
        nearest_v_per_rad: f64,
    },
}

fn sampled(period_s: &Option<f64>) -> String {
    period_s.map_or_else(String::new, |period_s| format!(" (sampled at {period_s} s)"))
}

/// Rounded towards what is true: a hint that is followed to its last digit must help.
fn floor(x: f64, per_unit: f64) -> f64 {
    (x * per_unit).floor() / per_unit
}

/// Three decimals, rounded away from what was asked for.
fn rounded_inside(nearest: f64, requested: f64) -> f64 {
    if nearest <= requested { floor(nearest, 1e3) } else { -floor(-nearest, 1e3) }
}

fn smaller_beta(largest_beta: &Option<f64>) -> String {
    largest_beta.map_or_else(String::new, |beta| format!(", or when beta is lowered to {:.4}", floor(beta, 1e4)))
}

/// The radius of a continuous plant, and with it whether (22) is solvable.
pub fn solvability(plant: &StateSpace, beta: f64, alpha: &Uncertainty) -> Result<Solvability, Error> {
    expect_positive("stability degree beta [1/s]", beta, true)?;
    Ok(Solvability { robust_radius: robust_radius(&HalfPlane::new(&strictly_proper(plant)?, beta)?, alpha)? })
}

/// The largest beta below `beta` with radius one, by bisection; alpha stays the same function of the shifted variable.
///
/// The radius falls with beta between two poles and jumps up at none, so the sign change is unique. A beta at which the
/// question is ill-posed (a pole on the line) counts as not solvable.
pub(crate) fn largest_beta(plant: &StateSpace, beta: f64, alpha: &Uncertainty) -> Option<f64> {
    let solvable = |beta: f64| solvability(plant, beta, alpha).is_ok_and(|answer| answer.is_solvable());
    let (mut low, mut high) = (beta * SMALLEST_BETA, beta);
    if !solvable(low) {
        return None;
    }
    while high - low > BISECTED * beta {
        let middle = 0.5 * (low + high);
        if solvable(middle) { low = middle } else { high = middle }
    }
    Some(low)
}

/// Below this part of the beta asked for, a design would no longer be what was asked for.
const SMALLEST_BETA: f64 = 1e-3;

/// The stiffness nearest to the one asked for that level one permits, from the softest loop's on, which fits.
pub(crate) fn nearest_stiffness(
    plant: &HalfPlane,
    alpha: &Uncertainty,
    softest: f64,
    requested: f64,
) -> Result<f64, Error> {
    let fits = |compliance: f64| -> Result<bool, Error> {
        Ok(conditions_with_stiffness(plant, alpha, 1.0 / compliance)?.optimal()?.norm < 1.0)
    };
    let (mut out, mut inside) = (1.0 / requested, 1.0 / softest);
    while (out - inside).abs() > BISECTED * inside.abs() {
        let middle = 0.5 * (out + inside);
        if fits(middle)? { inside = middle } else { out = middle }
    }
    Ok(1.0 / inside)
}

/// Bisections end here, relative: a digit more than the messages print.
const BISECTED: f64 = 1e-7;
