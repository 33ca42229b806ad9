//! What the view shows, as plain numbers and words. Deliberately absent: where it stands on the screen.

use flexbeam_runtime::{Live, Phase, Sample, SeenTiming, Shape};

use super::panel::{Panel, Setting};
use super::strip::Strip;

/// An angle's bar has this much room beyond the reference.
const ROOM: f64 = 1.2;
/// The smallest end of an angle's bar [rad]; a degree.
const SMALLEST_RAD: f64 = 0.0175;

/// Everything that one picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The controller's file.
    pub controller: String,
    /// The rig.
    pub port: String,
    /// Where the scope is.
    pub scope: Option<String>,
    /// Sample period [s].
    pub period_s: f64,
    /// Where the run stands.
    pub phase: Phase,
    /// The newest sample; nothing before the first.
    pub reading: Option<Reading>,
    /// Where the bars end.
    pub ends: Ends,
    /// Names and values of the settings in force.
    pub settings: Vec<(&'static str, String)>,
    /// Which one Left and Right change.
    pub selected: usize,
    /// How the clock was kept.
    pub timing: SeenTiming,
    /// The last seconds.
    pub strip: Strip,
    /// When [s] and what, oldest first.
    pub events: Vec<(f64, String)>,
}

/// One sample, as a person reads it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Since the run was armed [s].
    pub time_s: f64,
    /// Reference [rad].
    pub reference_rad: f64,
    /// Tip angle [rad].
    pub psi_rad: f64,
    /// Hub angle, zero and scale applied [rad].
    pub theta_rad: f64,
    /// Deflection angle, likewise [rad].
    pub alpha_rad: f64,
    /// Distance of the tip from the reference model [rad].
    pub error_rad: f64,
    /// What the controller asks for, before the law [V].
    pub u_v: f64,
    /// Voltage at the motor [V].
    pub voltage_v: f64,
    /// Whether no fresh measurement came.
    pub stale: bool,
}

/// Where the bars end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// Of reference, tip, hub and error [rad].
    pub angle_rad: f64,
    /// The limit of the deflection [rad].
    pub deflection_rad: f64,
    /// The limit of the voltage [V].
    pub voltage_v: f64,
}

impl Reading {
    /// The sample under the settings in force.
    pub fn of(sample: &Sample, live: &Live, period_s: f64) -> Reading {
        let (theta, alpha) = (&live.settings.theta, &live.settings.alpha);
        Reading {
            time_s: sample.instant as f64 * period_s,
            reference_rad: sample.reference_rad,
            psi_rad: sample.tip_rad(theta, alpha),
            theta_rad: theta.scaled(sample.measured.theta_rad),
            alpha_rad: alpha.scaled(sample.measured.alpha_rad),
            error_rad: sample.commanded.error_rad,
            u_v: sample.commanded.u_v,
            voltage_v: sample.voltage_v,
            stale: sample.stale,
        }
    }
}

impl Ends {
    /// From the reference and the limits in force.
    pub fn of(live: &Live) -> Ends {
        let (reference, settings) = (&live.reference, &live.settings);
        let wave = if reference.shape == Shape::File { reference.peak() } else { 1.0 };
        let reach_rad = reference.offset_rad.abs() + wave * reference.amplitude_rad.abs();
        Ends {
            angle_rad: (ROOM * reach_rad).min(settings.theta_limit_rad).max(SMALLEST_RAD),
            deflection_rad: settings.deflection_limit_rad,
            voltage_v: settings.voltage_limit_v,
        }
    }
}

/// Names and values of the settings, and which one is selected.
pub fn settings(live: &Live, panel: &Panel, period_s: f64) -> (Vec<(&'static str, String)>, usize) {
    let texts = Setting::ALL.iter().map(|setting| (setting.name(), setting.text(live, period_s))).collect();
    (texts, Setting::ALL.iter().position(|setting| *setting == panel.selected()).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flexbeam_kernel as kernel;
    use flexbeam_kernel::Channel;
    use flexbeam_rig::Measurement;
    use flexbeam_runtime::Reference;

    fn live(reference: Reference) -> Live {
        let theta = Channel { offset_rad: 0.5, ..Channel::default() };
        let alpha = Channel { scale: 2.0, offset_rad: 0.1, ..Channel::default() };
        let settings = kernel::Settings { theta, alpha, theta_limit_rad: 3.0, ..kernel::Settings::default() };
        Live { revision: 0, settings, reference }
    }

    #[test]
    fn the_tip_is_the_kernel_s_while_it_runs_and_the_sum_before() {
        let commanded = kernel::Commanded { y_rad: 0.7, ..kernel::Commanded::default() };
        let measured = Measurement { theta_rad: 0.75, alpha_rad: 0.2 };
        let sample = Sample { instant: 1500, phase: Phase::Armed, measured, commanded, ..Sample::default() };
        let live = live(Reference::default());
        let armed = Reading::of(&sample, &live, 0.001);
        assert_eq!((armed.time_s, armed.theta_rad, armed.alpha_rad), (1.5, 0.25, 0.2));
        assert_eq!(armed.psi_rad, 0.45);
        assert_eq!(Reading::of(&Sample { phase: Phase::Running, ..sample }, &live, 0.001).psi_rad, 0.7);
    }

    #[test]
    fn bars_reach_beyond_the_reference_and_never_beyond_the_limit() {
        let of = |reference| Ends::of(&live(reference)).angle_rad;
        let step = Reference { amplitude_rad: -0.4, offset_rad: 0.4, ..Reference::default() };
        assert!((of(step.clone()) - 0.96).abs() < 1e-12);
        assert_eq!(of(Reference { amplitude_rad: 9.0, ..step.clone() }), 3.0);
        assert_eq!(of(Reference::default()), SMALLEST_RAD);
        let file =
            Reference { shape: Shape::File, amplitude_rad: 2.0, samples: [0.1, -0.2].into(), ..Reference::default() };
        assert!((of(file) - 0.48).abs() < 1e-12);
    }
}
