//! `flexbeam run --scope`: the real program, a viewer on a real socket.

mod support;
#[path = "../../flexbeam-runtime/tests/support/scope_viewer.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod viewer;

use flexbeam_files::RunRecording;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, ChildStderr, Command, Stdio};
use support::Bench;
use viewer::Viewer;

/// A bench with a controller for the paper's rig.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.done("record --linear --duration 2");
    bench.done("identify recording.csv --order 4");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
    bench
}

/// A run with a scope; it is ended with the value.
struct Run {
    child: Child,
    said: BufReader<ChildStderr>,
    address: String,
    token: String,
}

impl Run {
    fn start(bench: &Bench, options: &str) -> Run {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        let line = format!("run controller.toml --hold 60 --max-angle-deg 1e6 --plain --json {options}");
        program.args(line.split_whitespace()).current_dir(bench.path(""));
        let mut child = program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.starts_with("scope: ") {
            line.clear();
            assert!(said.read_line(&mut line).unwrap() > 0, "it ended");
        }
        let url = line.trim().strip_prefix("scope: http://").unwrap();
        let (address, token) = url.split_once("/#").unwrap();
        Run { address: address.into(), token: token.into(), child, said }
    }

    fn viewer(&self, name: &str) -> Viewer {
        Viewer::enter(&self.address, json!({ "token": self.token, "name": name, "key": name }))
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

#[test]
fn a_run_is_started_changed_and_stopped_in_the_browser() {
    let bench = bench();
    let run = Run::start(&bench, "--wait --scope 0 --scope-token-file token");
    assert!(run.address.starts_with("127.0.0.1:") && !run.address.ends_with(":0"), "{}", run.address);
    assert_eq!(bench.read("token").trim(), run.token);
    let mode = std::fs::metadata(bench.path("token")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    let mut viewer = run.viewer("tablet");
    if viewer.hello["knobs"] == json!([]) {
        viewer.hello = viewer.text("hello");
    }
    let hello = viewer.hello.clone();
    assert_eq!((&hello["may"], &hello["run"]["controller"]), (&json!("steer"), &json!("controller.toml")));
    assert_eq!((&hello["certificate"]["holds"], &hello["certificate"]["note"]), (&json!(true), &json!("")));
    let figures = hello["certificate"]["figures"].as_array().unwrap();
    let claimed = bench.json("verify controller.toml --runs 1");
    let radius = figures.iter().find(|figure| figure["label"] == "Robust radius").unwrap()["value"].as_f64().unwrap();
    assert_eq!(claimed["sampled"]["robust_radius"]["claimed"].as_f64(), Some(radius));
    let known = |kind: &str, key: &str| hello[kind].as_array().unwrap().iter().any(|entry| entry["key"] == key);
    for scope in hello["screen"]["scope"].as_array().unwrap() {
        assert!(
            scope["signals"].as_array().unwrap().iter().all(|key| known("signals", key.as_str().unwrap())),
            "{scope}"
        );
    }
    for panel in hello["screen"]["panel"].as_array().unwrap() {
        assert!(
            panel["settings"].as_array().unwrap().iter().all(|key| known("knobs", key.as_str().unwrap())),
            "{panel}"
        );
    }
    viewer.text_with("state", |state| state["phase"] == "armed");
    assert_eq!(viewer.take(), None);
    assert_eq!(viewer.act("start"), None);
    viewer.text_with("state", |state| state["phase"] == "running");
    assert_eq!(viewer.set(json!({ "reference.amplitude_rad": 0.25 })), None);
    viewer.text_with("state", |state| state["values"]["reference.amplitude_rad"] == 0.25);
    let frame = viewer.frame();
    viewer.text_with("event", |event| event["text"].as_str().unwrap().contains("0.25"));
    assert_eq!(viewer.act("stop"), None);
    assert_eq!(viewer.text("over")["result"]["cause"], "asked");
    let (answer, _) = run.end();
    assert_eq!(answer["cause"], "asked");

    let recorded = RunRecording::read(&bench.path("run.mcap")).unwrap();
    assert_eq!(recorded.settings.last().unwrap().reference.amplitude_rad, 0.25);
    let row = recorded.samples.tick.iter().position(|tick| *tick == frame.ticks[0]).unwrap();
    assert_eq!(frame.values[4][0], recorded.samples.theta_rad[row] as f32);
    let told: Vec<&str> =
        recorded.events.iter().filter(|event| event.kind == "control").map(|event| event.text.as_str()).collect();
    let id = viewer.id();
    assert_eq!(told[0], format!("viewer {id} \"tablet\" is in control"));
    assert_eq!(told[1], "viewer \"tablet\" set reference.amplitude_rad = 0.25");

    // The file keeps its token for the next run.
    let again = Run::start(&bench, "--duration 0.5 --scope 0 --scope-token-file token --force");
    assert_eq!(bench.read("token").trim(), again.token);
    again.end();
}

#[test]
fn a_run_without_a_certificate_says_so_on_the_page() {
    let bench = bench();
    let text = bench.read("controller.toml");
    let row = text.lines().skip_while(|line| !line.starts_with("A = [")).nth(1).unwrap();
    bench.write("controller.toml", &text.replacen(row, &row.replacen("0.0,", "0.01,", 1), 1));
    let run = Run::start(&bench, "--wait --scope 0 --unverified test");
    let mut viewer = run.viewer("tablet");
    let certificate = viewer.hello["certificate"].clone();
    assert_eq!((&certificate["holds"], &certificate["note"]), (&json!(false), &json!("run unverified: test")));
    viewer.text_with("state", |state| state["phase"] == "armed");
    assert_eq!(viewer.act("stop"), None);
    run.end();
}

#[test]
fn what_cannot_be_served_is_said_before_anything_moves() {
    let bench = bench();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    bench.write("open", &"a".repeat(26));
    std::fs::set_permissions(bench.path("open"), PermissionsExt::from_mode(0o644)).unwrap();
    bench.write("none", "no token");
    std::fs::set_permissions(bench.path("none"), PermissionsExt::from_mode(0o600)).unwrap();
    for (options, said) in [
        (format!("--scope {port}"), "needed an address of this machine with a free port"),
        ("--scope port".into(), "as an address for viewers"),
        ("--scope-token-file token".into(), "--scope"),
        ("--scope 0 --scope-token-file open".into(), "that others may read (mode 644)"),
        ("--scope 0 --scope-token-file none".into(), "without a token"),
        ("--scope 0 --scope-token-file no/folder".into(), "cannot use the token file"),
    ] {
        let answer = bench.run(&format!("run controller.toml --duration 0.1 {options}"));
        assert_eq!(answer.status, 2, "{options}: {}", answer.err);
        assert!(answer.err.contains(said), "{options}: {}", answer.err);
        assert!(!bench.path("run.mcap").exists(), "{options}");
    }
}

#[test]
fn an_address_that_others_reach_is_warned_of() {
    let bench = bench();
    let answer = bench.run("run controller.toml --duration 0.1 --hold 60 --plain --scope 0.0.0.0:0");
    assert_eq!(answer.status, 0, "{}", answer.err);
    assert!(answer.err.contains("sees the run; the token travels in clear"), "{}", answer.err);
    let answer = bench.run("run controller.toml --duration 0.1 --hold 60 --plain --scope localhost:0 --force");
    assert!(answer.status == 0 && !answer.err.contains("travels in clear"), "{}", answer.err);
}
