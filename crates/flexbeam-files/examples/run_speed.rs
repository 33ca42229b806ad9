//! Seconds that a run of ten minutes at 1 kHz takes to write and to read.
//!
//! `cargo run --release -p flexbeam-files --example run_speed`

use flexbeam_files::{Layout, Provenance, Recording, RunHeader, RunPhase, RunRecording, RunSample, RunWriter};
use std::io::Cursor;
use std::path::Path;
use std::time::Instant;

/// Ticks of the run, and from one flush to the next.
const TICKS: u64 = 600_000;
const FLUSH: u64 = 1000;

fn main() {
    let header = RunHeader {
        period_s: 1e-3,
        start_unix_ns: 1_700_000_000_000_000_000,
        port: "sim".into(),
        provenance: Provenance::default(),
        controller: None,
        excitation: None,
    };
    let samples: Vec<RunSample> = (0..TICKS).map(sample).collect();
    let start = Instant::now();
    let mut slowest_s: f64 = 0.0;
    let mut writer = RunWriter::new(Cursor::new(Vec::new()), &header).expect("memory takes it");
    for sample in &samples {
        writer.sample(sample).expect("memory takes it");
        if (sample.tick + 1) % FLUSH == 0 {
            let before = Instant::now();
            writer.flush().expect("memory takes it");
            slowest_s = slowest_s.max(before.elapsed().as_secs_f64());
        }
    }
    let bytes = writer.finish(&()).expect("memory takes it").into_inner();
    let write_s = start.elapsed().as_secs_f64();
    let bytes_per_sample = bytes.len() as f64 / TICKS as f64;
    println!("write: {write_s:.3} s, {:.1} MB, {bytes_per_sample:.1} bytes a sample", bytes.len() as f64 / 1e6);
    println!("       slowest flush {:.2} ms, {:.2} us a sample", 1e3 * slowest_s, 1e6 * write_s / TICKS as f64);
    let start = Instant::now();
    let read = RunRecording::parse(&bytes, Path::new("memory.mcap")).expect("what was written");
    let same = samples.iter().enumerate().all(|(k, sample)| read.samples.get(k).as_ref() == Some(sample));
    println!("read:  {:.3} s, the same numbers: {same}", start.elapsed().as_secs_f64());
    let start = Instant::now();
    let recording = Recording::parse(&bytes, Path::new("memory.mcap"), &Layout::default()).expect("what was written");
    println!("as signals: {:.3} s, {} samples", start.elapsed().as_secs_f64(), recording.signals.samples());
}

/// A tip that swings and settles every two seconds, with an encoder of 4096 counts and noise on the gauge.
fn sample(tick: u64) -> RunSample {
    let t = (tick % 2000) as f64 * 1e-3;
    let swing = (-3.0 * t).exp() * (20.0 * t).cos();
    let noise = 2e-4 * ((tick as f64 * 12.9898).sin() * 43758.5453).fract();
    let count = std::f64::consts::TAU / 4096.0;
    RunSample {
        tick,
        voltage_v: 5.0 * swing,
        commanded_v: 4.9 * swing,
        u_v: 4.8 * swing,
        reference_rad: 0.5,
        smoothed_rad: 0.5 * (t * 5.0).min(1.0),
        theta_rad: ((0.5 - 0.5 * swing) / count).round() * count,
        alpha_rad: 0.1 * swing + noise,
        psi_rad: 0.5 - 0.4 * swing + noise,
        y_model_rad: 0.5 - 0.41 * swing,
        error_rad: noise - 0.01 * swing,
        lateness_ns: 3000 + (tick * 7919 % 4000) as u32,
        execution_ns: 1500 + (tick * 104_729 % 700) as u32,
        settings: 0,
        phase: RunPhase::Running as u8,
        fault: 0,
        stale: 0,
    }
}
