//! `flexbeam run --foxglove`: the real program, a viewer on a real socket.

mod support;
#[path = "../../flexbeam-runtime/tests/support/viewer.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod viewer;

use flexbeam_files::{RunRecording, RunSample};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use support::Bench;
use viewer::{Said, Viewer};

/// A bench with a controller for the paper's rig.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.done("record --linear --duration 2");
    bench.done("identify recording.csv --order 4");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
    bench
}

/// A run that viewers look at; it is ended with the value.
struct Run {
    child: Child,
    said: BufReader<ChildStderr>,
    address: String,
}

impl Run {
    fn start(bench: &Bench, options: &str) -> Run {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        let line = format!("run controller.toml --hold 60 --max-angle-deg 1e6 --plain --json {options}");
        program.args(line.split_whitespace()).current_dir(bench.path(""));
        let mut child = program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("viewers connect to ws://").unwrap_or_else(|| panic!("{line}"));
        Run { address: address.into(), child, said }
    }

    /// What it answers, and what it said besides.
    fn end(mut self) -> (Value, String) {
        let (mut out, mut err) = (String::new(), String::new());
        self.said.read_to_string(&mut err).unwrap();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        assert!(self.child.wait().unwrap().success(), "{err}");
        (serde_json::from_str(&out).unwrap(), err)
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Messages on the first topic until the connection ends.
fn until_the_end(viewer: &mut Viewer) -> Vec<(u64, Vec<u8>)> {
    let mut signals = Vec::new();
    loop {
        match viewer.next() {
            Said::Data { log_time_ns, payload, .. } => signals.push((log_time_ns, payload)),
            Said::Closed => return signals,
            Said::Text(_) => {}
        }
    }
}

/// One viewer reads, one never does; the recording is whole, and holds what the first one saw.
#[test]
fn a_run_is_seen_as_it_is_recorded() {
    let bench = bench();
    let run = Run::start(&bench, "--duration 2 --foxglove 0");
    assert!(run.address.starts_with("127.0.0.1:") && !run.address.ends_with(":0"), "{}", run.address);
    let (mut viewer, mut stalled) = (Viewer::connect(&run.address), Viewer::connect(&run.address));
    viewer.subscribe(&["/signals"]);
    stalled.subscribe(&["/signals", "/events", "/settings"]);
    let signals = until_the_end(&mut viewer);
    let (answer, _) = run.end();
    let recorded = RunRecording::read(&bench.path("run.mcap")).unwrap();
    assert_eq!((&answer["unrecorded"], &answer["cause"]), (&json!(0), &json!("over")));
    assert_eq!(answer["ticks"], recorded.samples.samples());
    let first = RunSample::from_cdr(&signals[0].1).unwrap().tick;
    let rows = (0..recorded.samples.samples()).map(|k| recorded.samples.get(k).unwrap());
    let wanted: Vec<_> = rows
        .filter(|sample| sample.tick >= first)
        .map(|sample| (recorded.header.log_time_ns(sample.tick), sample.to_cdr().to_vec()))
        .collect();
    assert!(signals == wanted, "{} of {} samples", signals.len(), wanted.len());
    assert!(signals.len() > 200, "{}", signals.len());
}

#[test]
fn settings_are_changed_only_with_foxglove_set_and_the_recording_says_so() {
    let bench = bench();
    for (options, changed) in [("", false), ("--foxglove-set", true)] {
        let run = Run::start(&bench, &format!("--duration 1.5 --foxglove localhost:0 --force {options}"));
        let mut viewer = Viewer::connect(&run.address);
        viewer.subscribe(&["/signals"]);
        viewer.wait_for("a sample", |said| matches!(said, Said::Data { .. }).then_some(()));
        let before = viewer.ask(json!({ "op": "getParameters", "parameterNames": ["eps_u_v"] }))[0]["value"].clone();
        let found = viewer.set("eps_u_v", json!(0.0123));
        assert_eq!(found, if changed { json!(0.0123) } else { before });
        until_the_end(&mut viewer);
        run.end();
        let recorded = RunRecording::read(&bench.path("run.mcap")).unwrap();
        assert_eq!(recorded.settings.last().unwrap().settings.eps_u_v == Some(0.0123), changed);
        let is = |kind: &str, text: &str| recorded.events.iter().any(|e| e.kind == kind && e.text.contains(text));
        assert_eq!(is("override", "--foxglove-set"), changed);
        assert_eq!(is("warning", "a viewer's change was refused"), !changed);
    }
}

/// A rate that thins the topic, but never what turns the run takes.
#[test]
fn a_rate_thins_the_signals() {
    let bench = bench();
    let run = Run::start(&bench, "--duration 1.5 --foxglove 0 --foxglove-rate 50");
    let mut viewer = Viewer::connect(&run.address);
    viewer.subscribe(&["/signals"]);
    let ticks: Vec<u64> =
        until_the_end(&mut viewer).iter().map(|(_, bytes)| RunSample::from_cdr(bytes).unwrap().tick).collect();
    run.end();
    let recorded = RunRecording::read(&bench.path("run.mcap")).unwrap();
    assert_eq!(ticks.last(), recorded.samples.tick.last(), "the end is seen");
    let most = recorded.samples.tick.last().unwrap() / 20 + 3;
    assert!((10..=most).contains(&(ticks.len() as u64)), "{} of at most {most}", ticks.len());
}

#[test]
fn what_makes_no_sense_is_said_before_anything_moves() {
    let bench = bench();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap();
    for (options, words) in [
        (format!("--foxglove {taken}"), "with a free port"),
        ("--foxglove nowhere".into(), "as an address for viewers"),
        ("--foxglove 0 --foxglove-rate 0".into(), "samples a second for viewers"),
        ("--foxglove-set".into(), "--foxglove <ADDRESS>"),
    ] {
        let answer = bench.run(&format!("run controller.toml --duration 1 {options}"));
        assert_eq!(answer.status, 2, "{options}: {}", answer.err);
        assert!(answer.err.contains(words), "{}", answer.err);
    }
    assert!(!bench.names().iter().any(|name| name.contains("mcap")), "{:?}", bench.names());
}
