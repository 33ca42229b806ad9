//! Simulated time around the kernel's tick.

use crate::{Measurement, SimulatedRig};
use flexbeam_kernel::{Commanded, Controller, Fault, Measured, Settings, State, tick};
use flexbeam_lti::{Mat, Signals};
use std::collections::VecDeque;

/// A closed-loop run, one entry a tick. Entry k belongs to the instant k Ts, at which the sensors were read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosedLoopRecord {
    /// Sample period [s].
    pub period_s: f64,
    /// Time [s].
    pub time_s: Vec<f64>,
    /// Reference as asked for [rad].
    pub reference_rad: Vec<f64>,
    /// Reference after the smooth step [rad].
    pub smoothed_rad: Vec<f64>,
    /// Voltage that the tick commands [V]; it reaches the rig after the computing delay.
    pub voltage_v: Vec<f64>,
    /// The controller's u, before the variable-structure law [V].
    pub u_v: Vec<f64>,
    /// Hub angle as counted [rad].
    pub theta_measured_rad: Vec<f64>,
    /// Deflection angle as read from the gauge [rad].
    pub alpha_measured_rad: Vec<f64>,
    /// True hub angle [rad].
    pub theta_rad: Vec<f64>,
    /// True deflection angle [rad].
    pub alpha_rad: Vec<f64>,
    /// True tip angle [rad].
    pub psi_rad: Vec<f64>,
    /// Output of the reference model [rad].
    pub y_model_rad: Vec<f64>,
    /// Why the kernel holds the voltage at zero, if it does.
    pub fault: Vec<Fault>,
}

/// Runs the kernel's tick on the rig, from where the rig stands and with the controller at rest.
///
/// At instant k: measure, tick, apply. The voltage of tick k acts during period k + d, with d the rig's
/// `computing_delay_periods`; before the first one arrives the rig gets 0 V.
///
/// Returns: `samples` entries; a fault does not end the run, the kernel holds 0 V from then on.
/// Assumes: settings and controller were made for the rig's sample period.
pub fn closed_loop(
    rig: &mut SimulatedRig,
    settings: &Settings,
    controller: &Controller<'_>,
    mut reference_rad: impl FnMut(f64) -> f64,
    samples: usize,
) -> ClosedLoopRecord {
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = State::new(controller, &mut memory).expect("the memory has the controller's length");
    let mut on_its_way: VecDeque<f64> = vec![0.0; rig.parameters().computing_delay_periods].into();
    let mut record = ClosedLoopRecord::with_capacity(rig.parameters().period_s, samples);
    for k in 0..samples {
        let time_s = k as f64 * record.period_s;
        let reference_rad = reference_rad(time_s);
        let Measurement { theta_rad, alpha_rad } = rig.measure();
        let measured = Measured { reference_rad, theta_rad, alpha_rad };
        let commanded = tick(settings, controller, &mut state, measured);
        record.push(time_s, &measured, &commanded, rig);
        on_its_way.push_back(commanded.voltage_v);
        rig.apply(on_its_way.pop_front().expect("a voltage has just been put in"));
    }
    record
}

impl ClosedLoopRecord {
    fn with_capacity(period_s: f64, samples: usize) -> ClosedLoopRecord {
        let column = || Vec::with_capacity(samples);
        ClosedLoopRecord {
            period_s,
            time_s: column(),
            reference_rad: column(),
            smoothed_rad: column(),
            voltage_v: column(),
            u_v: column(),
            theta_measured_rad: column(),
            alpha_measured_rad: column(),
            theta_rad: column(),
            alpha_rad: column(),
            psi_rad: column(),
            y_model_rad: column(),
            fault: Vec::with_capacity(samples),
        }
    }

    fn push(&mut self, time_s: f64, measured: &Measured, commanded: &Commanded, rig: &SimulatedRig) {
        let truth = rig.truth();
        self.time_s.push(time_s);
        self.reference_rad.push(measured.reference_rad);
        self.smoothed_rad.push(commanded.reference_rad);
        self.voltage_v.push(commanded.voltage_v);
        self.u_v.push(commanded.u_v);
        self.theta_measured_rad.push(measured.theta_rad);
        self.alpha_measured_rad.push(measured.alpha_rad);
        self.theta_rad.push(truth.theta_rad);
        self.alpha_rad.push(truth.alpha_rad);
        self.psi_rad.push(truth.psi_rad());
        self.y_model_rad.push(commanded.y_model_rad);
        self.fault.push(commanded.fault);
    }

    /// Number of ticks.
    pub fn samples(&self) -> usize {
        self.time_s.len()
    }

    /// Time [s] and kind of the first fault.
    pub fn first_fault(&self) -> Option<(f64, Fault)> {
        let k = self.fault.iter().position(|&fault| fault != Fault::None)?;
        Some((self.time_s[k], self.fault[k]))
    }

    /// All columns but time and fault, named as the fields are.
    pub fn signals(&self) -> Signals {
        let columns: [(&str, &str, &[f64]); 10] = [
            ("reference_rad", "rad", &self.reference_rad),
            ("smoothed_rad", "rad", &self.smoothed_rad),
            ("voltage_v", "v", &self.voltage_v),
            ("u_v", "v", &self.u_v),
            ("theta_measured_rad", "rad", &self.theta_measured_rad),
            ("alpha_measured_rad", "rad", &self.alpha_measured_rad),
            ("theta_rad", "rad", &self.theta_rad),
            ("alpha_rad", "rad", &self.alpha_rad),
            ("psi_rad", "rad", &self.psi_rad),
            ("y_model_rad", "rad", &self.y_model_rad),
        ];
        let names = columns.iter().map(|column| column.0.to_string()).collect();
        let units = columns.iter().map(|column| column.1.to_string()).collect();
        let data = Mat::from_fn(columns.len(), self.samples(), |channel, k| columns[channel].2[k]);
        Signals::new(names, units, self.period_s, data).expect("a name and a unit for each column")
    }
}
