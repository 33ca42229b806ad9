//! Runs as the real-time loop would record them, made of `closed_loop` on the simulated rig.

use std::path::Path;

use flexbeam_files::{
    Law, LiveSettings, Overwrite, Parent, Provenance, RunEvent, RunFile, RunHeader, RunPhase, RunReference, RunSample,
    RunShape, Settings,
};
use flexbeam_kernel as kernel;
use flexbeam_rig::{ClosedLoopRecord, Link, RigParameters, SimulatedRig, closed_loop};

/// u = 2 (v - y), y_model = v, of order 0.
const PROPORTIONAL: [f64; 4] = [2.0, 1.0, -2.0, 0.0];

/// Ticks from one flush to the next.
pub const FLUSH: u64 = 250;

/// The linear lumped rig under a proportional controller, its reference without pattern, held for five ticks.
pub fn linear_loop(samples: usize) -> ClosedLoopRecord {
    let parameters = RigParameters { link: Link::Lumped, ..RigParameters::default().linear() };
    let mut rig = SimulatedRig::new(&parameters, 1).expect("the paper's rig");
    let controller = kernel::Controller::new(0, &PROPORTIONAL).expect("four coefficients");
    let levels = super::pseudorandom(samples / 5 + 1);
    let reference = |time_s: f64| levels[(time_s / parameters.period_s / 5.0 + 1e-6) as usize];
    let settings = kernel::Settings { law: kernel::Law::None, ..kernel::Settings::default() };
    closed_loop(&mut rig, &settings, &controller, reference, samples)
}

/// What the loop knows at tick k. The voltage of a tick acts one period later.
fn sample(record: &ClosedLoopRecord, k: usize) -> RunSample {
    RunSample {
        tick: k as u64,
        voltage_v: k.checked_sub(1).map_or(0.0, |before| record.voltage_v[before]),
        commanded_v: record.voltage_v[k],
        u_v: record.u_v[k],
        reference_rad: record.reference_rad[k],
        smoothed_rad: record.smoothed_rad[k],
        theta_rad: record.theta_measured_rad[k],
        alpha_rad: record.alpha_measured_rad[k],
        psi_rad: record.psi_rad[k],
        y_model_rad: record.y_model_rad[k],
        error_rad: record.y_model_rad[k] - record.psi_rad[k],
        lateness_ns: 2500 + (k as u32 * 7919) % 4000,
        execution_ns: 1500 + (k as u32 * 3571) % 700,
        settings: u32::from(k > 300),
        phase: RunPhase::Running as u8,
        ..RunSample::default()
    }
}

pub fn samples(record: &ClosedLoopRecord) -> Vec<RunSample> {
    (0..record.samples()).map(|k| sample(record, k)).collect()
}

/// A run of these samples at `path`, made of the files at `parents`; the first one is the controller.
pub fn write_run(path: &Path, period_s: f64, samples: &[RunSample], parents: &[&Path]) {
    let header = RunHeader {
        period_s,
        start_unix_ns: 1_764_180_000_000_000_000,
        port: "sim".into(),
        provenance: Provenance {
            tool: "flexbeam test".into(),
            command: Some("flexbeam run controller.toml".into()),
            time: None,
            parents: parents.iter().map(|parent| Parent::of(parent, path).expect("a parent")).collect(),
        },
        controller: parents.first().map(|path| std::fs::read(path).expect("a controller")),
        excitation: None,
    };
    let mut file = RunFile::create(path, Overwrite::SameKind, &header).expect("a free name");
    let event = |tick: u64, kind: &str, text: &str| RunEvent {
        tick,
        time_s: header.time_s(tick),
        kind: kind.into(),
        text: text.into(),
    };
    file.event(&event(0, "started", "by the test")).expect("written");
    for sample in samples {
        if sample.tick == 0 || sample.tick == 301 {
            file.settings(&live(sample)).expect("written");
        }
        file.sample(sample).expect("written");
        if (sample.tick + 1).is_multiple_of(FLUSH) {
            file.flush().expect("flushed");
        }
    }
    let end = samples.last().map_or(0, |sample| sample.tick);
    file.event(&event(end, "stopped", "after all of it")).expect("written");
    file.finish(&serde_json::json!({ "samples": samples.len() })).expect("renamed");
}

fn live(sample: &RunSample) -> LiveSettings {
    let settings = Settings {
        law: Some(Law::None),
        voltage_limit_v: Some(10.0 - f64::from(sample.settings)),
        ..Settings::default()
    };
    let reference = RunReference { shape: RunShape::Square, amplitude_rad: 1.0, period_s: 0.005, offset_rad: 0.0 };
    LiveSettings { revision: sample.settings, tick: sample.tick, settings, reference }
}
