//! What several tests need: a simulated rig served by a thread, and a loop without a clock.

#![allow(dead_code, reason = "each test file uses a part of it")]

pub mod relay;

use flexbeam_rig::{Measurement, RigParameters, SimulatedRig};
use flexbeam_runtime::back_end::{Answer, BackEnd, LinkFault, Timing};
use flexbeam_runtime::served_rig::{ServeOptions, ServedReport, serve};
use flexbeam_runtime::wire::Wire;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Long enough for a machine that stalls: no test here measures lateness.
pub const PATIENT: Timing = Timing { period_s: 0.001, wait_s: 5.0, hold_s: 30.0 };

pub const NOISE_SEED: u64 = 7;

pub fn rig() -> SimulatedRig {
    SimulatedRig::new(&RigParameters::default(), NOISE_SEED).unwrap()
}

/// A voltage that keeps the beam swinging, through the dead zone and back.
pub fn voltage_v(k: u64) -> f64 {
    let t = k as f64 * 0.001;
    3.0 * (11.0 * t).sin() + 0.7 * (71.0 * t).cos()
}

/// A rig behind a wire, on a thread of its own.
pub struct Serving {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<ServedReport>,
}

impl Serving {
    pub fn start(mut wire: impl Wire + 'static, options: ServeOptions) -> Serving {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || serve(rig(), &mut wire, options, &flag).unwrap());
        Serving { stop, thread }
    }

    /// Ends the thread, and with it the wire.
    pub fn end(self) -> ServedReport {
        self.stop.store(true, Ordering::Release);
        self.thread.join().unwrap()
    }
}

/// As the loop does it: at instant k the voltage of k - 1 goes out, 0 V at first.
pub fn delayed_voltage_v(k: u64) -> f64 {
    k.checked_sub(1).map_or(0.0, voltage_v)
}

/// Exchanges 0 to `count` - 1.
pub fn exchanges(back_end: &mut impl BackEnd, count: u64) -> Vec<Result<Answer, LinkFault>> {
    (0..count).map(|k| back_end.exchange(k, delayed_voltage_v(k))).collect()
}

/// What a rig in this process reads under the same voltages.
pub fn in_process(count: u64) -> Vec<Measurement> {
    let mut rig = rig();
    let one = |k| {
        let measurement = rig.measure();
        rig.apply(delayed_voltage_v(k));
        measurement
    };
    (0..count).map(one).collect()
}

pub fn bits(measurement: Measurement) -> [u64; 2] {
    [measurement.theta_rad.to_bits(), measurement.alpha_rad.to_bits()]
}
