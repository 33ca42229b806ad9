//! The variable-structure law on its way from the command line and the ramp test to files and kernel.

use flexbeam_files as files;
use flexbeam_files::{Law, RigTestResult};
use flexbeam_ident::breakaway::{Breakaway, Thresholds};

use crate::cli;

impl From<cli::Law> for Law {
    fn from(law: cli::Law) -> Law {
        match law {
            cli::Law::None => Law::None,
            cli::Law::Switched => Law::Switched,
            cli::Law::Inverse => Law::Inverse,
        }
    }
}

/// The law in words.
pub fn law_name(law: Law) -> &'static str {
    match law {
        Law::None => "no law",
        Law::Switched => "switched law",
        Law::Inverse => "inverse law",
    }
}

/// What the ramp test found, written over other settings.
pub fn with_thresholds(
    settings: files::Settings,
    law: Law,
    found: &Breakaway,
    thresholds: &Thresholds,
) -> files::Settings {
    files::Settings {
        law: Some(law),
        breakaway_plus_v: Some(found.plus_v),
        breakaway_minus_v: Some(-found.minus_v),
        u_p_plus_v: Some(thresholds.u_p_plus_v),
        u_p_minus_v: Some(thresholds.u_p_minus_v),
        eps_u_v: Some(thresholds.eps_u_v),
        eps_e_rad: Some(thresholds.eps_e_rad),
        ..settings
    }
}

/// What `design --residual-voltage` asks for; the switched law has no such figure.
pub fn residual_v(law: Law, found: &Breakaway, thresholds: &Thresholds) -> Option<f64> {
    (law != Law::Switched).then(|| found.residual_v(thresholds))
}

/// The answer of `rig test`.
pub fn test_result(law: Law, found: &Breakaway, thresholds: &Thresholds, applied_to: Option<String>) -> RigTestResult {
    RigTestResult {
        breakaway_plus_v: found.plus_v,
        breakaway_minus_v: found.minus_v,
        law,
        u_p_plus_v: thresholds.u_p_plus_v,
        u_p_minus_v: thresholds.u_p_minus_v,
        eps_u_v: thresholds.eps_u_v,
        eps_e_rad: thresholds.eps_e_rad,
        residual_voltage_v: residual_v(law, found, thresholds),
        applied_to,
        repeated: None,
        friction: None,
    }
}
