//! What rounding to f32 leaves of a certificate.

use flexbeam_codegen::rounded;
use flexbeam_files::{Controller, Extended, LoopFigures};
use flexbeam_kernel::Settings;
use flexbeam_verify::{Comparison, Verified};

use crate::Failure;
use crate::verify::{Parts, sentence};

/// How far a claimed figure may move by rounding. Limits (the norm of (22), poles beyond beta, the prefilter's and the saturated
/// controller's stability) must hold as they are.
pub(super) const WITHIN: f64 = 0.01;

/// The sampled loop's figures with every number of the controller and its filters rounded to f32, and a sentence for each that no
/// longer holds.
///
/// Errors: numbers that f32 cannot hold; a file that makes no system.
pub(super) fn figures(
    file: &Controller,
    settings: &Settings,
    tried: &str,
) -> Result<(LoopFigures, Vec<String>), Failure> {
    let (rounded, _) = rounded(file, settings).map_err(Failure::while_trying(tried))?;
    let parts = Parts::of(&rounded)?;
    let found = parts.figures(&rounded).map_err(Failure::while_trying("recompute the certificate in f32"))?;
    let lost = found.iter().filter(|figure| !holds(figure)).map(sentence).collect();
    let of = |name: &str| found.iter().find(|f| f.figure == name).map_or(f64::NAN, |f| f.recomputed);
    let figures = LoopFigures {
        robust_radius: Extended(of("sampled.robust_radius")),
        bound_norm: of("sampled.bound_norm"),
        stability_degree: of("sampled.stability_degree"),
        closed_loop_poles: Vec::new(),
        stiffness: Extended(of("stiffness")),
        gain_margin: Extended(of("gain_margin")),
        phase_margin_rad: Extended(of("phase_margin_rad")),
        delay_margin_s: Extended(of("delay_margin_s")),
        disk_margin: Extended(of("disk_margin")),
    };
    Ok((figures, lost))
}

/// A limit must be kept; a mismatch and a figure may move by [`WITHIN`].
fn holds(figure: &Verified) -> bool {
    if figure.agrees {
        return true;
    }
    let (claimed, found) = (figure.claimed, figure.recomputed);
    match figure.comparison {
        Comparison::AtMost | Comparison::AtLeast => MISMATCHES.contains(&figure.figure) && found <= WITHIN,
        Comparison::Equal => claimed.is_finite() && (found - claimed).abs() <= WITHIN * claimed.abs(),
        Comparison::EqualInverse => {
            (found.recip() - claimed.recip()).abs() <= WITHIN * claimed.recip().abs().max(SMALL_RAD_PER_V)
        }
        Comparison::EqualOrSmall => (found - claimed).abs() <= WITHIN * claimed.abs().max(SMALL_RAD),
    }
}

/// Relative distances from what is claimed, which are 0 but for rounding.
const MISMATCHES: [&str; 2] = ["closed_loop_poles", "matching_error"];

/// Below this 1/K(0) counts as none: an integrator may become a stiffness of 10^4 V/rad.
const SMALL_RAD_PER_V: f64 = 0.01;

/// Below this a stationary error counts as none: a hundredth of it is a hundred and fiftieth of an encoder's count.
const SMALL_RAD: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(name: &'static str, claimed: f64, found: f64, comparison: Comparison) -> Verified {
        Verified::new(name, claimed, found, comparison, (1e-9, "a test"))
    }

    #[test]
    fn figures_may_move_by_a_percent_and_limits_by_nothing() {
        use Comparison::{AtLeast, AtMost, Equal, EqualInverse, EqualOrSmall};
        let infinite = f64::INFINITY;
        for (name, claimed, found, comparison, kept) in [
            ("gain_margin", 4.0, 4.039, Equal, true),
            ("gain_margin", 4.0, 4.041, Equal, false),
            ("gain_margin", infinite, 8.0, Equal, false),
            ("gain_margin", infinite, infinite, Equal, true),
            ("gain_margin", 4.0, f64::NAN, Equal, false),
            ("stiffness", infinite, 2e4, EqualInverse, true),
            ("stiffness", infinite, 3.0, EqualInverse, false),
            ("stiffness", 5.0, 5.1, EqualInverse, false),
            ("stationary_error_rad", 0.0, 9e-6, EqualOrSmall, true),
            ("stationary_error_rad", 0.0, 2e-5, EqualOrSmall, false),
            ("bound_norm_limit", 1.0, 1.001, AtMost, false),
            ("poles_beyond_beta", 0.0, 1.0, AtMost, false),
            ("poles_beyond_beta", 0.0, f64::NAN, AtMost, false),
            ("saturated_degree", 0.0, -1e-6, AtLeast, false),
            ("closed_loop_poles", 0.0, 0.009, AtMost, true),
            ("matching_error", 0.0, 0.011, AtMost, false),
        ] {
            assert_eq!(holds(&figure(name, claimed, found, comparison)), kept, "{name}: {claimed}, {found}");
        }
    }
}
