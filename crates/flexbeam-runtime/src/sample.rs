//! What the loop says of one tick.

use crate::cause::RunFault;
use crate::lifecycle::Phase;
use flexbeam_kernel::{Channel, Commanded};
use flexbeam_rig::Measurement;

/// One tick, as it goes to the recorder and to every view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Periods since the run was armed; a gap is a missed tick.
    pub instant: u64,
    /// Where the run stands.
    pub phase: Phase,
    /// Voltage that acts from this instant on [V]; the tick before computed it.
    pub voltage_v: f64,
    /// The reference, before it is smoothed [rad].
    pub reference_rad: f64,
    /// The sensors; of the last good instant where `stale`.
    pub measured: Measurement,
    /// Whether no fresh measurement came.
    pub stale: bool,
    /// The kernel's answer; its voltage acts from the next instant on.
    pub commanded: Commanded,
    /// From the deadline to the awakening [ns].
    pub lateness_ns: u64,
    /// From the awakening to the end of the tick [ns].
    pub execution_ns: u64,
    /// Revision of the settings in force.
    pub revision: u32,
    /// What ended the run, on its last sample.
    pub fault: Option<RunFault>,
}

impl Sample {
    /// Real-time: yes. The tip angle [rad], for who looks: the kernel computes it while the controller runs only; before, it is the
    /// sum of the two angles from their zeroes.
    pub fn tip_rad(&self, theta: &Channel, alpha: &Channel) -> f64 {
        match self.phase {
            Phase::Running => self.commanded.y_rad,
            _ => theta.scaled(self.measured.theta_rad) + alpha.scaled(self.measured.alpha_rad),
        }
    }
}

impl Default for Sample {
    fn default() -> Sample {
        Sample {
            instant: 0,
            phase: Phase::Configured,
            voltage_v: 0.0,
            reference_rad: 0.0,
            measured: Measurement { theta_rad: 0.0, alpha_rad: 0.0 },
            stale: true,
            commanded: Commanded::default(),
            lateness_ns: 0,
            execution_ns: 0,
            revision: 0,
            fault: None,
        }
    }
}
