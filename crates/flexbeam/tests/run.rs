//! `flexbeam run`, `rig`, `record` and `tell`: real processes, real sockets, real pseudo-terminals.
//!
//! The machine may stall, so runs are given a hold time that no stall reaches, unless the hold is what is tested.

mod rigs;
mod support;

use flexbeam_files::{RunColumns, RunPhase, RunRecording};
use rigs::relay::{Mischief, Relay};
use rigs::{Answering, RigProcess};
use serde_json::Value;
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use support::{Bench, column, number};

/// A controller for the paper's rig with its law measured, made once.
fn controller() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let bench = Bench::new();
        bench.done("record --linear --duration 4");
        bench.done("identify recording.csv --order 4");
        bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
        bench.done("rig test --apply-to controller.toml");
        bench.read("controller.toml")
    })
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("controller.toml", controller());
    bench
}

fn run_of(bench: &Bench, name: &str) -> RunRecording {
    RunRecording::read(&bench.path(name)).unwrap()
}

/// Indices of the samples while the controller ran.
fn running(samples: &RunColumns) -> Vec<usize> {
    (0..samples.samples()).filter(|&k| samples.phase[k] == RunPhase::Running as u8).collect()
}

/// Starts the program in the bench's folder.
fn start(bench: &Bench, line: &str) -> Child {
    let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
    program.args(line.split_whitespace()).current_dir(bench.path(""));
    program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn ended(child: Child) -> (i32, String, String) {
    let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (status.code().expect("ended by itself"), text(stdout), text(stderr))
}

/// Waits until something holds, for a minute at most.
fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(60), "never: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Code of the fault that no measurement came for too long.
const SILENT: u8 = 12;

/// Every sample is either there and fresh, or reported: as stale in its row, or as a gap that the count of missed periods states.
fn assert_nothing_lost_in_silence(run: &RunRecording) {
    let samples = &run.samples;
    let report = run.report.as_ref().unwrap();
    let gaps: u64 = samples.tick.windows(2).map(|w| w[1] - w[0] - 1).sum();
    // A run that ends before its last exchange was not owed a measurement; one that ends for want of it was.
    let owed = |k: usize| samples.phase[k] != RunPhase::Stopped as u8 || samples.fault[k] == SILENT;
    let stale = (0..samples.samples()).filter(|&k| samples.stale[k] == 1 && owed(k)).count();
    assert_eq!(gaps + samples.tick[0], number(report, "missed") as u64, "gaps are missed periods");
    assert_eq!(stale as f64, number(report, "stale"));
    assert_eq!(number(report, "unrecorded"), 0.0);
    assert_eq!(samples.samples() as f64, number(report, "ticks"));
}

/// The last row says 0 V, the fault, and the events name it.
fn assert_ends_in_fault(run: &RunRecording, named: &str) {
    let samples = &run.samples;
    let last = samples.samples() - 1;
    assert_eq!((samples.commanded_v[last], samples.phase[last]), (0.0, RunPhase::Stopped as u8));
    assert_ne!(samples.fault[last], 0);
    let event = run.events.last().unwrap();
    assert_eq!(event.kind, "fault");
    assert!(event.text.contains(named), "{event:?}");
    assert!(run.cut_off.is_none());
}

#[test]
fn a_simulation_and_a_run_give_the_same_bits() {
    let bench = bench();
    bench.done("simulate controller.toml --duration 1.5 --seed 3 -o simulation");
    let simulated = bench.read("simulation/response.csv");
    for _ in 0..10 {
        let answer = bench.json("run controller.toml --duration 1.6 --seed 3 --hold 60 --max-angle-deg 1e6");
        if number(&answer, "missed") > 0.0 {
            continue; // a stall of this machine; the run is made again
        }
        let samples = run_of(&bench, "run.mcap").samples;
        let rows = running(&samples);
        assert_eq!(rows.len(), 1600);
        for (name, found) in [
            ("reference_rad", &samples.reference_rad),
            ("smoothed_rad", &samples.smoothed_rad),
            ("voltage_v", &samples.commanded_v),
            ("u_v", &samples.u_v),
            ("theta_measured_rad", &samples.theta_rad),
            ("alpha_measured_rad", &samples.alpha_rad),
            ("y_model_rad", &samples.y_model_rad),
        ] {
            let expected = column(&simulated, name);
            let same = rows.iter().zip(&expected).all(|(&k, x)| found[k].to_bits() == x.to_bits());
            assert!(same && expected.len() == 1600, "{name}");
        }
        return;
    }
    eprintln!("!!! LEFT OUT: in ten attempts this machine never held 1 kHz for 1.6 s !!!");
}

/// Record, identify, design, run, record: over UDP, as on a real rig.
#[test]
fn the_paper_s_circle_closes() {
    let bench = Bench::new();
    let rig = RigProcess::udp(&bench, "");
    let port = &rig.port;
    // A machine that stalls cuts the recording into short stretches; then it is made again.
    for _ in 0..8 {
        bench.done(&format!("record --port {port} --duration 6 --hold 60 --max-angle-deg 1e6 -o recording.mcap"));
        let recording = run_of(&bench, "recording.mcap");
        assert_nothing_lost_in_silence(&recording);
        if recording.longest_stretch().samples.len() > 3000 {
            break;
        }
    }
    let model = bench.json("identify recording.mcap --block-rows 40 -o model.toml");
    assert!(number(&model["fit_percent"], "alpha_rad") > 60.0, "{}", model["fit_percent"]);
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
    bench.done("rig test --apply-to controller.toml");
    bench.done(&format!(
        "run controller.toml --port {port} --duration 4 --hold 60 --signal square --signal-period 2 -o run.mcap"
    ));
    let run = run_of(&bench, "run.mcap");
    assert_nothing_lost_in_silence(&run);
    assert!(run.samples.psi_rad.iter().any(|psi| (psi.to_degrees() - 30.0).abs() < 2.0), "the tip gets there");
    bench.done(&format!("record --port {port} --duration 3 --hold 60 --max-angle-deg 1e6 -o again.mcap"));
    bench.done("identify again.mcap --block-rows 40 -o again.toml");
    bench.done("identify run.mcap --block-rows 20 --order 4 -o closed.toml");
    let history = bench.json("show again.toml");
    assert!(history["history"].as_array().unwrap().iter().any(|step| step["path"] == "again.mcap"));
}

#[test]
fn udp_with_loss_duplicates_and_swaps_goes_on_and_reports_each() {
    let bench = bench();
    let rig = RigProcess::udp(&bench, "");
    let bad = Mischief { loses: 0.02, doubles: 0.02, swaps: 0.02, damages: 0.01, spares: 20, ..Mischief::default() };
    let (relay, address) = Relay::udp(rig.address(), bad);
    let line = format!("run controller.toml --port udp:{address} --sign-check 0 --duration 4 --hold 60 -o run.mcap");
    let answer = bench.json(&line);
    relay.end();
    assert_eq!(answer["cause"], "over");
    let link = &answer["link"];
    // Of 4000 exchanges, each with two ways: four standard deviations below what the road does.
    assert!(
        number(link, "lost") > 100.0 && number(link, "corrupt") > 10.0 && number(link, "duplicate") > 30.0,
        "{link}"
    );
    let run = run_of(&bench, "run.mcap");
    assert_nothing_lost_in_silence(&run);
    let last = *running(&run.samples).last().unwrap();
    assert!((run.samples.psi_rad[last].to_degrees() - 30.0).abs() < 1.0, "and the tip still gets there");
}

#[test]
fn fifty_milliseconds_of_silence_on_udp_end_at_zero_volts() {
    let bench = bench();
    let rig = RigProcess::udp(&bench, "");
    let (relay, address) = Relay::udp(rig.address(), Mischief { silent_after: Some(3000), ..Mischief::default() });
    let answer =
        bench.run(&format!("run controller.toml --port udp:{address} --sign-check 0 --duration 30 --hold 0.02"));
    let delivered = relay.end();
    assert_eq!(answer.status, 3, "{}", answer.err);
    assert!(answer.err.contains("hint") || answer.err.contains("0 V"), "{}", answer.err);
    let run = run_of(&bench, "run.mcap");
    assert_ends_in_fault(&run, "");
    assert_nothing_lost_in_silence(&run);
    let served = rig.end();
    assert!(
        number(&served, "timed_out") >= 1.0 || delivered.last().unwrap().voltage_v == 0.0,
        "the rig is at 0 V: {served}"
    );
}

#[test]
fn a_rig_process_that_is_killed_ends_the_run_at_status_3() {
    let bench = bench();
    for pty in [false, true] {
        let rig = if pty { RigProcess::pty(&bench, "") } else { RigProcess::udp(&bench, "") };
        let run =
            start(&bench, &format!("run controller.toml --port {} --sign-check 0 --duration 60 --force", rig.port));
        std::thread::sleep(Duration::from_millis(1500));
        rig.kill();
        let (status, _, err) = ended(run);
        assert_eq!(status, 3, "{err}");
        assert_ends_in_fault(&run_of(&bench, "run.mcap"), "");
    }
}

#[test]
fn the_serial_line_loses_and_damages_bytes_and_goes_on() {
    let bench = bench();
    let rig = RigProcess::pty(&bench, "");
    let bad = Mischief { loses: 0.0005, damages: 0.0005, doubles: 0.0005, spares: 4000, ..Mischief::default() };
    let (relay, device) = Relay::serial(&rig.device(), bad);
    let port = format!("serial:{}", device.display());
    let answer = bench.json(&format!("run controller.toml --port {port} --sign-check 0 --duration 4 --hold 60"));
    relay.end();
    assert_eq!(answer["cause"], "over");
    assert!(number(&answer["link"], "lost") > 10.0, "{answer}");
    assert_nothing_lost_in_silence(&run_of(&bench, "run.mcap"));
}

#[test]
fn silence_on_the_serial_line_ends_at_zero_volts() {
    let bench = bench();
    let rig = RigProcess::pty(&bench, "");
    let silent = Mischief { silent_after: Some(150_000), ..Mischief::default() };
    let (relay, device) = Relay::serial(&rig.device(), silent);
    let port = format!("serial:{}", device.display());
    let answer = bench.run(&format!("run controller.toml --port {port} --sign-check 0 --duration 30 --hold 0.02"));
    relay.end();
    assert_eq!(answer.status, 3, "{}", answer.err);
    assert_ends_in_fault(&run_of(&bench, "run.mcap"), "");
}

/// An encoder that is alive.
fn flicker(k: u32) -> f64 {
    1e-6 * f64::from(k % 7)
}

#[test]
fn rigs_that_answer_nonsense_are_refused_or_stopped() {
    let bench = bench();
    let run = |rig: &Answering, hold: &str| {
        bench
            .run(&format!("run controller.toml --port {} --sign-check 0 --duration 20 --hold {hold} --force", rig.port))
    };
    let nan = run(&Answering::start(|k| (if k == 900 { f64::NAN } else { flicker(k) }, 0.0, 1)), "60");
    assert_eq!(nan.status, 3, "{}", nan.err);
    assert_ends_in_fault(&run_of(&bench, "run.mcap"), "not finite");
    let frozen = run(&Answering::start(|_| (0.0, 0.0, 1)), "60");
    assert_eq!(frozen.status, 3, "{}", frozen.err);
    assert_ends_in_fault(&run_of(&bench, "run.mcap"), "frozen");
    let other = run(&Answering::start(|_| (0.0, 0.0, 2)), "60");
    assert_eq!(other.status, 2);
    assert!(other.err.contains("version 2") && other.err.contains("hint: "), "{}", other.err);
    let changed = run(&Answering::start(|k| (flicker(k), 0.0, if k > 900 { 2 } else { 1 })), "60");
    assert_eq!(changed.status, 3, "{}", changed.err);
    assert_ends_in_fault(&run_of(&bench, "run.mcap"), "version 2");
}

#[test]
fn a_rig_that_is_not_there_is_said_before_anything_is_written() {
    let bench = bench();
    for port in ["udp:127.0.0.1:9", "serial:/dev/no-such-line", "hil:q2_usb:0", "comedi:/dev/comedi0", "carrier:pigeon"]
    {
        let answer = bench.run(&format!("run controller.toml --port {port} --duration 1"));
        assert_eq!(answer.status, 2, "{port}: {}", answer.err);
        assert!(answer.err.contains("found ") && answer.err.contains("\nhint: "), "{port}: {}", answer.err);
    }
    assert_eq!(bench.names(), ["controller.toml"], "nothing half written");
}

#[test]
fn the_recording_knows_its_controller_and_its_project_by_their_hashes() {
    let bench = bench();
    bench.write(
        "flexbeam.toml",
        "schema = \"flexbeam.project/1\"\nname = \"the bench\"\ncontroller = \"controller.toml\"\n",
    );
    bench.done("run controller.toml --duration 0.2 --hold 60");
    let run = run_of(&bench, "run.mcap");
    let parents: Vec<&str> = run.header.provenance.parents.iter().map(|parent| parent.path.as_str()).collect();
    assert_eq!(parents, ["controller.toml", "flexbeam.toml"]);
    assert_eq!(run.header.controller.as_deref(), Some(controller().as_bytes()));
    let history = bench.json("show run.mcap");
    let states: Vec<&str> =
        history["history"].as_array().unwrap().iter().map(|step| step["state"].as_str().unwrap()).collect();
    assert!(states.iter().filter(|state| **state == "same").count() >= 2, "{states:?}");
}

#[test]
fn a_certificate_that_does_not_match_is_refused_unless_a_reason_is_given() {
    let bench = bench();
    let a = controller().lines().position(|line| line.starts_with("A = [")).unwrap() + 1;
    let row = controller().lines().nth(a).unwrap();
    bench.write("edited.toml", &controller().replacen(row, &row.replacen("0.0,", "0.01,", 1), 1));
    let refused = bench.run("run edited.toml --duration 0.2");
    assert_eq!(refused.status, 2);
    assert!(refused.err.contains("stability_degree") && refused.err.contains("--unverified"), "{}", refused.err);
    let answer =
        bench.run_words(&["run", "edited.toml", "--duration", "0.2", "--hold", "60", "--unverified", "a test of mine"]);
    assert_eq!(answer.status, 0, "{}", answer.err);
    let run = run_of(&bench, "run.mcap");
    assert!(run.events.iter().any(|event| event.kind == "override" && event.text.contains("a test of mine")));
    assert!(run.report.unwrap()["warnings"][0].as_str().unwrap().contains("a test of mine"));
}

#[test]
fn a_period_that_the_machine_cannot_hold_is_found_in_the_dry_run() {
    let bench = Bench::new();
    bench.done("record --linear --duration 4");
    bench.done("identify recording.csv --order 4");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam --period 0.000005");
    let answer = bench.run("run controller.toml --duration 1");
    assert_eq!(answer.status, 2, "{}", answer.err);
    assert!(answer.err.contains("cannot hold a period of 5 us") && answer.err.contains("--period "), "{}", answer.err);
    assert!(!bench.names().iter().any(|name| name.starts_with("run.mcap")), "{:?}", bench.names());
}

#[test]
fn without_permission_it_warns_and_runs() {
    let bench = bench();
    let flexbeam = env!("CARGO_BIN_EXE_flexbeam");
    let drop = ["--bounding-set=-sys_nice,-ipc_lock", "--inh-caps=-sys_nice,-ipc_lock", flexbeam];
    let words = ["run", "controller.toml", "--duration", "0.3", "--hold", "60"];
    // An ordinary user has neither right from the start; root gives both away first.
    let root = nix::unistd::geteuid().is_root();
    let mut program = Command::new(if root { "setpriv" } else { flexbeam });
    program.args(drop.iter().filter(|_| root)).args(words).current_dir(bench.path(""));
    let output = program.output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{err}");
    if root {
        assert!(err.contains("no real-time priority") && err.contains("hint: run as root"), "{err}");
        let warnings = run_of(&bench, "run.mcap").report.unwrap()["warnings"].clone();
        assert!(warnings[0].as_str().unwrap().contains("no real-time priority"), "{warnings}");
    }
}

#[test]
fn a_full_disk_costs_samples_that_are_counted_and_not_the_run() {
    let bench = bench();
    let script = format!(
        "trap '' XFSZ; ulimit -f 40; exec {} run controller.toml --duration 3 --hold 60",
        env!("CARGO_BIN_EXE_flexbeam")
    );
    let mut shell = Command::new("bash");
    let output = shell.args(["-c", &script]).current_dir(bench.path("")).output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{err}");
    let missing = err.split("needed all of it: ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<u64>().ok());
    let kept = run_of(&bench, "run.mcap.part");
    assert!(kept.cut_off.is_some() && !bench.names().contains(&"run.mcap".into()));
    let ticks = 3001 - missing.unwrap() - kept.samples.samples() as u64;
    assert!(ticks < 100, "kept {} and missing {missing:?} are the run, but for stalls", kept.samples.samples());
    bench.done("show run.mcap.part");
}

#[test]
fn ctrl_c_and_termination_end_at_zero_volts_with_a_whole_recording() {
    let bench = bench();
    for signal in
        [nix::sys::signal::Signal::SIGINT, nix::sys::signal::Signal::SIGTERM, nix::sys::signal::Signal::SIGHUP]
    {
        let run = start(&bench, "run controller.toml --hold 60 --json");
        let part = bench.path("run.mcap.part");
        until("the recording begins", || part.metadata().is_ok_and(|file| file.len() > 20_000));
        nix::sys::signal::kill(nix::unistd::Pid::from_raw(run.id() as i32), signal).unwrap();
        let (status, out, err) = ended(run);
        assert_eq!(status, 0, "{err}");
        let answer: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(answer["cause"], "asked");
        let run = run_of(&bench, "run.mcap");
        let last = run.samples.samples() - 1;
        assert_eq!((run.samples.voltage_v[last], run.samples.phase[last]), (0.0, RunPhase::Stopped as u8));
        assert!(run.cut_off.is_none());
    }
}

#[test]
fn a_power_loss_leaves_a_file_that_opens_up_to_the_last_flush() {
    let bench = bench();
    let mut run = start(&bench, "run controller.toml --hold 60");
    let part = bench.path("run.mcap.part");
    until("two flushes", || part.metadata().is_ok_and(|file| file.len() > 100_000));
    run.kill().unwrap();
    run.wait().unwrap();
    let kept = run_of(&bench, "run.mcap.part");
    assert!(kept.samples.samples() > 500, "{}", kept.samples.samples());
    bench.done("identify run.mcap.part --order 4 --block-rows 10 -o model.toml");
    let again = bench.run("run controller.toml --duration 0.2 --hold 60");
    assert_eq!(again.status, 2, "the part of another run is not written over: {}", again.err);
}

#[test]
fn a_run_is_steered_over_its_socket() {
    let bench = bench();
    let run = start(&bench, "run controller.toml --wait --hold 60 --control run.sock --json");
    until("the socket", || bench.path("run.sock").exists());
    let phase = || bench.json("tell run.sock status")["phase"].as_str().unwrap().to_string();
    until("armed", || phase() == "armed");
    bench.done("tell run.sock start");
    until("running", || phase() == "running");
    let set =
        bench.json("tell run.sock set eps_u_v=0.02 reference.shape=square reference.amplitude_rad=0.2 law=switched");
    assert_eq!(number(&set, "revision"), 1.0);
    until("settings in force", || bench.json("tell run.sock status")["settings"]["eps_u_v"] == 0.02);
    for (line, named) in [
        ("set eps_u_v=-1", "eps_u_v"),
        ("set theta.offset_rad=1", "theta.offset_rad"),
        ("set epsilon=1", "epsilon"),
        ("set", "KEY=VALUE"),
        ("stop eps_u_v=1", "takes none"),
    ] {
        let refused = bench.run(&format!("tell run.sock {line}"));
        assert_eq!(refused.status, 2);
        assert!(refused.err.contains(named), "{line}: {}", refused.err);
    }
    std::thread::sleep(Duration::from_millis(300));
    bench.done("tell run.sock emergency");
    let (status, out, err) = ended(run);
    assert_eq!(status, 3, "{err}");
    assert!(!bench.path("run.sock").exists(), "the socket goes with the run");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["cause"], "fault");
    let run = run_of(&bench, "run.mcap");
    assert_ends_in_fault(&run, "emergency");
    let changed = run.settings.iter().find(|set| set.revision == 1).unwrap();
    assert_eq!(changed.settings.eps_u_v, Some(0.02));
    let first = run.samples.settings.iter().position(|&revision| revision == 1).unwrap();
    assert_eq!(run.samples.tick[first], changed.tick, "in force from its tick on");
    assert!(run.samples.phase.contains(&(RunPhase::Armed as u8)));
    assert_eq!(bench.run("tell run.sock status").status, 2, "nobody listens any more");
}

#[test]
fn a_second_run_does_not_take_a_living_socket() {
    let bench = bench();
    let first = start(&bench, "run controller.toml --hold 60 --control run.sock -o first.mcap");
    until("the socket", || bench.path("run.sock").exists());
    let second = bench.run("run controller.toml --hold 60 --duration 0.2 --control run.sock -o second.mcap");
    assert_eq!(second.status, 2, "{}", second.err);
    assert!(second.err.contains("control socket"), "{}", second.err);
    bench.done("tell run.sock stop");
    assert_eq!(ended(first).0, 0);
}

#[test]
fn references_of_every_shape_and_of_a_file() {
    let bench = bench();
    let rows: String = (0..300).map(|k| format!("{},{}\n", f64::from(k) / 1000.0, 0.1 * f64::from(k % 10))).collect();
    bench.write("wave.csv", &format!("time_s,reference_deg\n{rows}"));
    for signal in ["square", "sine", "sawtooth", "step", "file --signal-file wave.csv"] {
        bench
            .done(&format!("run controller.toml --signal {signal} --duration 0.5 --hold 60 --amplitude-deg 5 --force"));
        let samples = run_of(&bench, "run.mcap").samples;
        let largest = samples.reference_rad.iter().fold(0.0_f64, |m, r| m.max(r.abs())).to_degrees();
        assert!(largest > 0.5 && largest < 5.001, "{signal}: {largest}");
    }
    let wrong = bench.run("run controller.toml --signal file --duration 0.5");
    assert!(wrong.status == 2 && wrong.err.contains("--signal-file"), "{}", wrong.err);
    bench.write("slow.csv", "time_s,reference_deg\n0,0\n0.01,1\n0.02,2\n");
    let slow = bench.run("run controller.toml --signal file --signal-file slow.csv --duration 0.5");
    assert!(slow.status == 2 && slow.err.contains("0.01 s"), "{}", slow.err);
}

#[test]
fn a_controller_for_another_delay_and_senseless_numbers_are_refused() {
    let bench = bench();
    bench.write("late.toml", &controller().replace("delay_s = 0.001", "delay_s = 0.002"));
    for (line, named) in [
        ("late.toml --duration 1", "one period of delay"),
        ("controller.toml --duration 0", "--duration"),
        ("controller.toml --hold -1 --duration 1", "--hold"),
        ("controller.toml --sign-check nan --duration 1", "--sign-check"),
        ("controller.toml --max-angle-deg 0 --duration 1", "--max-angle-deg"),
        ("controller.toml --core 999 --duration 0.1 --hold 60 --unverified x", ""),
    ] {
        let answer = bench.run(&format!("run {line}"));
        let expected = if named.is_empty() { 0 } else { 2 };
        assert_eq!(answer.status, expected, "{line}: {}", answer.err);
        assert!(answer.err.contains(named), "{line}: {}", answer.err);
    }
}

#[test]
fn limits_of_angle_and_speed_stop_the_rig() {
    let bench = bench();
    bench.write("slow.toml", &controller().replace("[settings]\n", "[settings]\ntheta_step_limit_rad = 0.0016\n"));
    for (line, named) in
        [("controller.toml --max-angle-deg 10", "theta_limit_rad"), ("slow.toml", "theta_step_limit_rad")]
    {
        let answer = bench.run(&format!("run {line} --duration 3 --hold 60 --force"));
        assert_eq!(answer.status, 3, "{}", answer.err);
        assert_ends_in_fault(&run_of(&bench, "run.mcap"), named);
    }
    let slow = bench.run("run controller.toml --max-speed-deg-s 20 --duration 0.2 --hold 60 --force");
    assert!(slow.status == 0 && slow.err.contains("below 220 degree/s the encoder's steps"), "{}", slow.err);
}
