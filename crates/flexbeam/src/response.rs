//! One step on the simulated rig: the record, its figures, its metrics.

use std::path::Path;

use flexbeam_files::{Law, SimulateResult};
use flexbeam_kernel as kernel;
use flexbeam_lti::C64;
use flexbeam_report::{Figure, Panel, Series};
use flexbeam_rig::{ClosedLoopRecord, Link, RigParameters, SimulatedRig, StepMetrics, closed_loop};

use flexbeam_runtime::kernel_words;

use crate::Failure;
use crate::rig_file::rig_parameters;

/// A step response with its figures.
pub struct Response {
    /// Every tick.
    pub record: ClosedLoopRecord,
    /// Settling time and the rest.
    pub metrics: StepMetrics,
}

/// The reference rests at zero for this long before it steps [s].
pub const REST_S: f64 = 0.1;

/// A step of the tip angle on the rig, from rest.
pub fn step_response(
    rig: &RigParameters,
    settings: &kernel::Settings,
    controller: &kernel::Controller<'_>,
    step_rad: f64,
    duration_s: f64,
    seed: u64,
) -> Result<Response, Failure> {
    let tried = "simulate the step";
    let mut rig = SimulatedRig::new(rig, seed).map_err(Failure::while_trying(tried))?;
    let samples = ((duration_s + REST_S) / rig.parameters().period_s).round() as usize;
    let reference = |time_s: f64| if time_s < REST_S { 0.0 } else { step_rad };
    let record = closed_loop(&mut rig, settings, controller, reference, samples);
    let metrics = StepMetrics::of(&record).map_err(Failure::while_trying(tried))?;
    Ok(Response { record, metrics })
}

/// A rig and a controller with different clocks.
#[derive(Debug, thiserror::Error)]
#[error(
    "the rig samples at {rig_s} s and the controller was designed for {controller_s} s\nhint: set period_s = {controller_s} in the rig file"
)]
struct Clocks {
    rig_s: f64,
    controller_s: f64,
}

/// The rig of a file, or the paper's, for a controller with this period.
///
/// Errors: those of [`rig_parameters`]; a rig file with a period of its own.
pub fn rig_at(file: Option<&Path>, period_s: f64) -> Result<RigParameters, Failure> {
    let mut rig = rig_parameters(file)?;
    if file.is_none() {
        rig.period_s = period_s;
    }
    if (rig.period_s / period_s - 1.0).abs() > SAME_PERIOD {
        let clocks = Clocks { rig_s: rig.period_s, controller_s: period_s };
        return Err(Failure::while_trying("run the controller on the rig")(clocks));
    }
    Ok(rig)
}

/// Periods count as equal within this, relative: rounding of a text file.
const SAME_PERIOD: f64 = 1e-9;

/// The rig without all that is not linear, on the lumped beam: what the design had before its eyes.
pub fn linear_rig(rig: &RigParameters) -> RigParameters {
    RigParameters { link: Link::Lumped, ..rig.linear() }
}

/// The kernel's limits stopped the rig.
#[derive(Debug, thiserror::Error)]
#[error("the rig was stopped after {time_s:.3} s: {}", kernel_words(*.fault))]
pub struct Stopped {
    time_s: f64,
    fault: kernel::Fault,
}

impl Response {
    /// Why the rig was stopped, if it was.
    pub fn stopped(&self) -> Option<Stopped> {
        self.record.first_fault().map(|(time_s, fault)| Stopped { time_s, fault })
    }

    /// The answer of `simulate`.
    pub fn result(&self, law: Law, seed: u64, files: Vec<String>) -> SimulateResult {
        let m = &self.metrics;
        SimulateResult {
            step_rad: m.step_rad,
            law,
            seed,
            settling_time_s: m.settling_time_s,
            overshoot_percent: m.overshoot_percent,
            stationary_error_rad: m.stationary_error_rad,
            residual_vibration_rad: m.residual_vibration_rad,
            peak_voltage_v: m.peak_voltage_v,
            limit_cycle: m.limit_cycle,
            fault: self.stopped().map(|stopped| stopped.to_string()),
            files,
        }
    }

    /// Reference, tip and hub angle; deflection; voltage.
    pub fn figure(&self, title: &str) -> Figure {
        let (t, r) = (&self.record.time_s, &self.record);
        Figure::new(title, "Time [s]")
            .size(800.0, 640.0)
            .panel(
                Panel::new("Angle [deg]")
                    .share(1.6)
                    .line("reference", t, &degrees(&r.smoothed_rad))
                    .line("tip ψ", t, &degrees(&r.psi_rad))
                    .line("hub θ", t, &degrees(&r.theta_rad)),
            )
            .panel(Panel::new("Deflection α [deg]").with(Series::line("deflection α", t, &degrees(&r.alpha_rad))))
            .panel(
                Panel::new("Voltage [V]")
                    .with(Series::step("controller u", t, &r.u_v))
                    .with(Series::step("motor V", t, &r.voltage_v).width(0.8)),
            )
    }
}

/// Radians to degrees, for the face.
pub fn degrees(radians: &[f64]) -> Vec<f64> {
    radians.iter().map(|x| x.to_degrees()).collect()
}

/// Phase in degrees without jumps, starting between -180 and 180.
pub fn unwrapped_deg(G: &[C64]) -> Vec<f64> {
    let mut phases: Vec<f64> = G.iter().map(|g| g.arg().to_degrees()).collect();
    for k in 1..phases.len() {
        phases[k] -= 360.0 * ((phases[k] - phases[k - 1]) / 360.0).round();
    }
    phases
}
