//! Gain, phase, delay and disk margins by a sweep of the loop gain and bisection of its crossings.
//!
//! Enters: a stable loop. Leaves: margins at the plant's input. Absent: eigenvalues.

use crate::bound::closed_loop_angles;
use crate::feedback::Loop;
use crate::sweep;
use flexbeam_lti::C64;

/// Margins of a sampled loop; infinite where nothing limits them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Factor by which the gain may grow, all else equal.
    pub gain: f64,
    /// Angle by which the phase may lag [rad].
    pub phase_rad: f64,
    /// Delay that may be added [s]: the smallest phase/omega over the crossings of |L| = 1.
    pub delay_s: f64,
    /// 2/||S - T||, the radius of the disk of gains and phases that the loop survives.
    pub disk: f64,
}

/// Lowest frequency of the sweep, as an angle [rad]: below it L is its integrator, large and steady.
const LOWEST: f64 = 1e-8;
/// A root of Im L where |L| is below this is the noise of a rolled-off loop: it would stand for a margin of 1e12.
const SILENT: f64 = 1e-12;
/// A crossing of the real axis is one when |Im L| there is below this part of |L|: a jump through a pole is not.
const REAL: f64 = 1e-6;

/// The margins of a stable loop.
///
/// Numerics: the grid of the count; crossings to rounding by bisection; L at z = -1 (and at z = 1, without an
/// integrator) is real and counts as a crossing.
pub fn margins(L: &Loop<'_>) -> Margins {
    let period_s = L.timing().period_s;
    let at = |angle: f64| L.gain(C64::from_polar(1.0, angle)).0;
    let angles = sweep::angles(&L.open_poles(), 1.0, LOWEST);
    let mut margins = Margins { gain: f64::INFINITY, phase_rad: f64::INFINITY, delay_s: f64::INFINITY, disk: 0.0 };
    for angle in sweep::roots(&angles, |angle| at(angle).norm().ln()) {
        let phase = (-at(angle)).arg().rem_euclid(std::f64::consts::TAU);
        margins.phase_rad = margins.phase_rad.min(phase);
        margins.delay_s = margins.delay_s.min(phase / (angle / period_s));
    }
    let crossings = sweep::roots(&angles, |angle| at(angle).im);
    for angle in crossings.into_iter().chain([LOWEST, std::f64::consts::PI]) {
        let gain = at(angle);
        let factor = -1.0 / gain.re;
        if gain.norm() > SILENT && gain.im.abs() <= REAL * gain.norm() && factor > 1.0 {
            margins.gain = margins.gain.min(factor);
        }
    }
    let difference = |angle: f64| {
        let gain = at(angle);
        ((1.0 - gain) / (1.0 + gain)).norm()
    };
    margins.disk = 2.0 / sweep::supremum(&closed_loop_angles(L, 1.0), 0.0, difference).1;
    margins
}
