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
        Comparison::AtMost | Comparison::AtLeast if MISMATCHES.contains(&figure.figure) => found <= WITHIN,
        Comparison::AtMost | Comparison::AtLeast => false,
        Comparison::Equal | Comparison::EqualInverse | Comparison::EqualOrSmall => {
            (found - claimed).abs() <= WITHIN * claimed.abs()
        }
    }
}

/// Relative distances from what is claimed, which are 0 but for rounding.
const MISMATCHES: [&str; 2] = ["closed_loop_poles", "matching_error"];
