//! Whether the tip follows the reference model, and whether stated poles are those of the loop.
//!
//! Enters: a loop, stated poles. Leaves: suprema of mismatches on the unit circle. Absent: eigenvalues of the loop.

use crate::feedback::Loop;
use crate::sweep::{self, Peak};
use flexbeam_lti::C64;

/// A mismatch below this is rounding.
const NOISE: f64 = 1e-9;
/// Lowest angle [rad] of a sweep.
const LOWEST: f64 = 1e-7;

/// sup |G T/(1 + G K) - M| on the unit circle: by how much the tip (filtered, as the controller sees it) departs from the
/// reference model in the nominal loop.
///
/// Source: (24), y = N T v = M v.
pub fn matching_error(L: &Loop<'_>) -> Peak {
    let mismatch = |angle: f64| {
        let z = C64::from_polar(1.0, angle);
        let (G, K) = (L.plant.at(z).0, L.feedback.at(z).0);
        let (T, M) = L.feedback.from_reference(z);
        (T / (G.inv() + K) - M).norm()
    };
    let mut poles = L.open_poles();
    poles.extend(&L.feedback.prefilter_poles);
    peak(L, sweep::supremum(&sweep::angles(&poles, 1.0, LOWEST), NOISE, mismatch))
}

/// sup |1 - prod (z - stated pole)/prod (z - open-loop pole)/(1 + L)| on the unit circle.
///
/// The closed-loop poles are the zeros of 1 + L, and its poles are the open-loop ones, so the quotient is 1 everywhere for the right
/// poles, however close together they lie. Where the two numbers differ the shorter list is filled with poles at z = 0: a minimal
/// realisation has lost the period of delay that the filter's zero takes away, another one has kept it.
/// Assumes: no open-loop pole on the circle but at z = 1.
pub fn pole_mismatch(L: &Loop<'_>, stated: &[C64]) -> Peak {
    let open = L.open_poles();
    let hidden = open.len() as i32 - stated.len() as i32;
    let both = stated.len().max(open.len());
    let mismatch = |angle: f64| {
        let z = C64::from_polar(1.0, angle);
        let factor = |poles: &[C64], k: usize| poles.get(k).map_or(C64::ONE, |p| z - p);
        let quotient = (0..both).fold(z.powi(hidden), |x, k| x * factor(stated, k) / factor(&open, k));
        (quotient / (L.gain(z).0 + 1.0) - 1.0).norm()
    };
    let mut near = open.clone();
    near.extend_from_slice(stated);
    peak(L, sweep::supremum(&sweep::angles(&near, 1.0, LOWEST_FOR_POLES), NOISE, mismatch))
}

/// Lowest angle of the comparison of poles: below it an integrator's pole, known to rounding only, would decide.
const LOWEST_FOR_POLES: f64 = 1e-5;

fn peak(L: &Loop<'_>, (angle, value): (f64, f64)) -> Peak {
    Peak { value, omega_rad_s: angle / L.timing().period_s }
}
