//! The norm (22) by an adaptive sweep, and whether the bound's image covers the bound.
//!
//! Enters: a loop, alpha_w(w). Leaves: suprema over the base band. Absent: Hamiltonians.

use crate::feedback::Loop;
use crate::sweep::{self, Peak};
use flexbeam_lti::{C64, Zpk};

/// Lowest angle [rad] of a sweep.
const LOWEST: f64 = 1e-8;

/// |alpha_w(jv)| at the angle of z/radius: v = (2/Ts) tan(angle/2).
pub(crate) fn image_magnitude(alpha_w: &Zpk, angle: f64, period_s: f64) -> f64 {
    alpha_w.at(C64::new(0.0, 2.0 / period_s * (angle / 2.0).tan())).norm()
}

/// sup |alpha_w K/(1 + G K)| on the circle |z| = e^(-degree Ts).
///
/// Assumes: no closed-loop pole beyond the circle (a count proves it); without that the figure means nothing.
/// Numerics: grid dense around each pole of plant, controller and loop, halved where the function bends, golden section at each
/// rival peak; relative error 1e-9.
/// Source: DESIGN 6.6.
pub fn bound_norm(L: &Loop<'_>, alpha_w: &Zpk, degree: f64) -> Peak {
    let timing = L.timing();
    let radius = timing.radius(degree);
    let weighted = |angle: f64| {
        let z = C64::from_polar(radius, angle);
        let (G, K) = (L.plant.at(z).0, L.feedback.at(z).0);
        // K/(1 + G K) = 1/(1/K + G): right at a pole of K, too.
        image_magnitude(alpha_w, angle, timing.period_s) / (K.inv() + G).norm()
    };
    let (angle, value) = sweep::supremum(&closed_loop_angles(L, radius), 0.0, weighted);
    Peak { value, omega_rad_s: angle / timing.period_s }
}

/// Angles that are dense at the open-loop poles and at the closed-loop poles near the circle.
pub(crate) fn closed_loop_angles(L: &Loop<'_>, radius: f64) -> Vec<f64> {
    let mut poles = L.open_poles();
    let open = sweep::angles(&poles, radius, LOWEST);
    poles.extend(L.resonances(&open, radius));
    sweep::angles(&poles, radius, LOWEST)
}

/// sup |alpha(jw)|/|alpha_w(jv)| over the base band: at most 1 when the image lies above the bound.
pub fn image_shortfall(alpha: &Zpk, alpha_w: &Zpk, period_s: f64) -> Peak {
    let ratio = |angle: f64| {
        let s = C64::new(0.0, angle / period_s);
        alpha.at(s).norm() / image_magnitude(alpha_w, angle, period_s)
    };
    let corners: Vec<C64> = alpha.zeros.iter().chain(&alpha.poles).map(|s| (s * period_s).exp()).collect();
    let (angle, value) = sweep::supremum(&sweep::angles(&corners, 1.0, LOWEST), 0.0, ratio);
    Peak { value, omega_rad_s: angle / period_s }
}
