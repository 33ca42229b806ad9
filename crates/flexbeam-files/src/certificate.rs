//! Certificates: what was proven of a controller's loop.

use crate::document::Document;
use crate::extended::Extended;
use crate::misfit::Misfit;
use crate::model::out_of_range;
use crate::provenance::Provenance;
use serde::{Deserialize, Serialize};

/// The table `certificate` of a controller, or a file of its own (`flexbeam.certificate/1`).
///
/// Source: DESIGN section 6.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Number of states of the controller.
    pub controller_order: usize,
    /// Residual voltage of the variable-structure law for which the stiffness was chosen [V].
    pub v_res_v: Option<f64>,
    /// v_res/K(0), the largest stationary error of the sampled loop [rad].
    pub stationary_error_rad: Option<f64>,
    /// Degree of the prefilter T's own poles [1/s], where it is not bound by the design's.
    pub prefilter_degree: Option<f64>,
    /// The loop of the continuous controller.
    pub continuous: LoopFigures,
    /// The loop that runs: sampled, with its exact delay.
    pub sampled: LoopFigures,
    /// Where it came from, in a file of its own.
    pub provenance: Option<Provenance>,
}

/// Figures of one loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopFigures {
    /// Largest perturbation, in units of the uncertainty, that some controller survives; infinite when nothing is
    /// unstable in the shifted plane.
    pub robust_radius: Extended,
    /// Norm (22); at most 1 when this controller survives the whole uncertainty.
    pub bound_norm: f64,
    /// Distance of the closed-loop poles to the boundary of stability [1/s]: -max Re s, or -max ln|z|/Ts.
    pub stability_degree: f64,
    /// Poles of the closed loop as pairs [re, im]: in the s-plane [1/s], of the sampled loop in the z-plane.
    pub closed_loop_poles: Vec<[f64; 2]>,
    /// K(0) [V/rad]; infinite with integral action.
    pub stiffness: Extended,
    /// Factor by which the gain may grow.
    pub gain_margin: Extended,
    /// Angle by which the phase may lag [rad].
    pub phase_margin_rad: Extended,
    /// Delay that may be added [s].
    pub delay_margin_s: Extended,
    /// Radius of the disk of gain and phase changes that the loop survives, 2/||S - T||.
    pub disk_margin: Extended,
}

impl Certificate {
    /// Errors: [`Fault::Range`](crate::Fault::Range).
    pub(crate) fn check_figures(&self) -> Result<(), Misfit> {
        for (name, figures) in [("continuous", &self.continuous), ("sampled", &self.sampled)] {
            let negative = [("robust_radius", figures.robust_radius.0), ("bound_norm", figures.bound_norm)];
            if let Some((key, found)) = negative.into_iter().find(|(_, x)| *x < 0.0) {
                return Err(out_of_range(key, found, "zero or a positive number").under(name));
            }
        }
        Ok(())
    }
}

impl Document for Certificate {
    const SCHEMA: &'static str = "flexbeam.certificate/1";
    const HEAD: &'static str = "flexbeam certificate: figures of a controller's loop, recomputed. SI units.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    fn check(&self) -> Result<(), Misfit> {
        self.check_figures()
    }
}
