//! A viewer that subscribes and never reads: memory stays bounded, the recording is whole, and a viewer that reads gets on.

#[path = "support/viewer.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod viewer;

use flexbeam_files::{Overwrite, RunFile, RunHeader, RunRecording, RunSample};
use flexbeam_runtime::foxglove::{ViewerOptions, Viewers};
use flexbeam_runtime::{RunContext, RunSink, Sample, Sink};
use serde_json::json;
use viewer::{Said, Viewer};

/// Five minutes at 1 kHz: 39 MB on the wire, several times what the system keeps for a connection.
const SAMPLES: u64 = 300_000;

/// What this process holds [bytes].
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    1024 * line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
}

fn tick(said: &Said) -> Option<u64> {
    match said {
        Said::Data { payload, .. } => Some(RunSample::from_cdr(payload).unwrap().tick),
        _ => None,
    }
}

#[test]
fn who_never_reads_costs_a_bounded_queue_and_nobody_else_anything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let header = RunHeader {
        period_s: 1e-3,
        start_unix_ns: 1_764_000_000_000_000_000,
        port: "simulated".into(),
        provenance: Default::default(),
        controller: None,
        excitation: None,
    };
    let file = RunFile::create(&path, Overwrite::SameKind, &header).unwrap();
    let context = RunContext { port: "simulated".into(), period_s: 1e-3 };
    let mut recording = RunSink::new(file, &path, context);
    let viewers = Viewers::open(&"0".parse().unwrap(), ViewerOptions::default()).unwrap();
    let mut sink = viewers.sink(&header);

    let address = viewers.address().to_string();
    let (mut stalled, mut reading) = (Viewer::connect(&address), Viewer::connect(&address));
    for viewer in [&mut stalled, &mut reading] {
        viewer.subscribe(&["/signals"]);
        // Answered after the subscription was made.
        viewer.ask(json!({ "op": "getParameters", "parameterNames": [] }));
    }
    let reader = std::thread::spawn(move || {
        reading.wait_for("the last sample", |said| (tick(said) == Some(SAMPLES - 1)).then_some(()));
    });

    let mut at_first = 0;
    for instant in 0..SAMPLES {
        let sample = Sample { instant, voltage_v: instant as f64, ..Sample::default() };
        recording.sample(&sample).unwrap();
        sink.sample(&sample).unwrap();
        if instant % 500 == 0 {
            recording.flush().unwrap();
        }
        if instant == SAMPLES / 10 {
            at_first = resident();
        }
    }
    let grown = resident().saturating_sub(at_first);
    assert!(grown < 8 << 20, "{grown} bytes more for 35 MB that nobody read");
    reader.join().unwrap();

    // It reads again: first what the system kept, then the newest, and in between a gap.
    let mut seen = Vec::new();
    stalled.wait_for("the last sample", |said| {
        seen.extend(tick(said));
        (seen.last() == Some(&(SAMPLES - 1))).then_some(())
    });
    assert!(seen.windows(2).all(|pair| pair[0] < pair[1]) && (seen.len() as u64) < SAMPLES / 2, "{}", seen.len());
    let gap = seen.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
    assert!(gap > SAMPLES / 2, "{gap}");

    drop((sink, viewers));
    let report = flexbeam_runtime::RunReport {
        cause: flexbeam_runtime::Cause::Over,
        text: "the time is over".into(),
        meter: Default::default(),
        link: Default::default(),
        warnings: vec![],
    };
    recording.finish(&report).unwrap();
    let recorded = RunRecording::read(&path).unwrap().samples;
    assert!((0..SAMPLES).eq(recorded.tick.iter().copied()), "every sample, in order");
}

/// The farewell does not wait for it either.
#[test]
fn a_server_ends_although_a_viewer_never_reads() {
    let viewers = Viewers::open(&"0".parse().unwrap(), ViewerOptions::default()).unwrap();
    let header = RunHeader {
        period_s: 1e-3,
        start_unix_ns: 0,
        port: String::new(),
        provenance: Default::default(),
        controller: None,
        excitation: None,
    };
    let mut sink = viewers.sink(&header);
    let mut stalled = Viewer::connect(&viewers.address().to_string());
    stalled.subscribe(&["/signals"]);
    stalled.ask(json!({ "op": "getParameters", "parameterNames": [] }));
    (0..SAMPLES).for_each(|instant| sink.sample(&Sample { instant, ..Sample::default() }).unwrap());
    let (ended, wait) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        drop(viewers);
        ended.send(()).unwrap();
    });
    wait.recv_timeout(std::time::Duration::from_secs(60)).unwrap();
    drop(stalled);
}
