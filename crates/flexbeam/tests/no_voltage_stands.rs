//! What a sceptic found in the real-time commands: each test states what the owner of a rig would expect. The board is the
//! comedi stand-in, in the program's own process: what it was told last is what stands at the motor.

#[allow(dead_code, reason = "each test uses a part")]
mod rigs;
mod support;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use rigs::RigProcess;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use support::{Bench, number};

/// The nearest to 0 V that the stand-in's converter has.
const ZERO: &str = "comedi_data_write 1.0 range 0 aref 0: 2048";

/// A board in the bench's folder that logs every call to `calls.txt`.
struct Board {
    bench: Bench,
}

impl Board {
    fn new() -> Board {
        let bench = Bench::new();
        let stand_in = concat!(env!("CARGO_MANIFEST_DIR"), "/../flexbeam-runtime/tests/boards/comedi_stand_in.c");
        let begins = "__attribute__((constructor)) static void begins(void)\n\
                      { stand_in_log_path(getenv(\"STAND_IN_LOG\")); stand_in_sensors(0, 0.0); }\n";
        bench.write("board.c", &format!("#include \"{stand_in}\"\n{begins}"));
        let compiler = Command::new("cc")
            .args(["-shared", "-fPIC", "-o", "board.so", "board.c", "-lm", "-lpthread"])
            .current_dir(bench.path(""))
            .status();
        assert!(compiler.unwrap().success());
        Board { bench }
    }

    /// The stand-in's hub is quick: 400000 counts a turn slow it down.
    fn port(&self) -> String {
        let library = self.bench.path("board.so");
        format!("comedi:/dev/comedi0?library={},counts_per_turn=400000", library.display())
    }

    fn command(&self, line: &str) -> Command {
        let limits = "--sign-check 0 --hold 60 --max-angle-deg 1e6 --max-speed-deg-s 1e9";
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        program.args(line.split_whitespace()).args(["--port", &self.port()]).args(limits.split_whitespace());
        program.current_dir(self.bench.path("")).env("STAND_IN_LOG", self.bench.path("calls.txt"));
        program.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        program
    }

    fn voltages(&self) -> Vec<String> {
        let log = std::fs::read_to_string(self.bench.path("calls.txt")).unwrap_or_default();
        log.lines().filter(|line| line.starts_with("comedi_data_write")).map(String::from).collect()
    }

    /// Until the motor turns: the rest before it is homing.
    fn wait_for_voltage(&self) {
        let start = Instant::now();
        while self.voltages().iter().filter(|line| *line != ZERO).count() < 100 {
            assert!(start.elapsed() < Duration::from_secs(60), "no voltage ever came");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn assert_at_rest(&self, after: &str) {
        assert_eq!(self.voltages().last().map(String::as_str), Some(ZERO), "after {after} this voltage stands");
    }
}

/// Waits for the end; one that does not come is made.
fn ended_or_stopped(child: &mut Child, patience: Duration) {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() && start.elapsed() < patience {
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A recording on the board, and a signal in the middle of it.
fn signalled(signal: Signal) -> Board {
    let board = Board::new();
    let mut program = board.command("record --duration 60 -o recording.mcap");
    // SAFETY: between fork and exec only sigaction is called, which is safe there.
    unsafe {
        program.pre_exec(|| {
            for signal in [Signal::SIGQUIT, Signal::SIGTSTP] {
                nix::sys::signal::signal(signal, nix::sys::signal::SigHandler::SigDfl)?;
            }
            Ok(())
        });
    }
    let mut child = program.spawn().unwrap();
    board.wait_for_voltage();
    kill(Pid::from_raw(child.id() as i32), signal).unwrap();
    ended_or_stopped(&mut child, Duration::from_secs(2));
    let _ = child.kill();
    child.wait().unwrap();
    board
}

#[test]
fn ctrl_z_leaves_no_voltage_standing() {
    signalled(Signal::SIGTSTP).assert_at_rest("Ctrl-Z");
}

#[test]
fn ctrl_backslash_leaves_no_voltage_standing() {
    signalled(Signal::SIGQUIT).assert_at_rest("Ctrl-\\");
}

/// The existing test of a full disk sets the signal aside first (`trap '' XFSZ`); a user's shell does not, and the system then
/// kills the process, with whatever voltage is on.
#[test]
fn a_limit_on_the_size_of_files_does_not_kill_the_loop() {
    let bench = Bench::new();
    let flexbeam = env!("CARGO_BIN_EXE_flexbeam");
    let script = format!("ulimit -f 40; exec {flexbeam} record -o r.mcap --duration 3 --hold 60 --max-angle-deg 1e6");
    // Through pipes: an inherited log may be beyond the limit before the program says its first word, long before a voltage.
    let output = Command::new("bash").args(["-c", &script]).current_dir(bench.path("")).output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{err}");
    assert!(err.contains("file too large"), "{err}");
}

/// `flexbeam run .. 2>&1 | head -1`: the first event after that is a panic of the main thread, which ends the process with the
/// loop's thread in it.
#[test]
fn a_reader_of_standard_error_that_goes_leaves_no_voltage_standing() {
    let board = Board::new();
    let bench = &board.bench;
    bench.done("record --linear --duration 4");
    bench.done("identify recording.csv --order 4");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
    bench.done("rig test --apply-to controller.toml");
    for attempt in 0..10 {
        let line = format!("run controller.toml --duration 1 --offset-deg 45 -o run{attempt}.mcap");
        let mut child = board.command(&line).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = String::new();
        BufReader::new(child.stderr.take().unwrap()).read_line(&mut said).unwrap();
        assert!(said.starts_with("homed"), "{said}");
        let status = child.wait().unwrap();
        board.assert_at_rest("a panic of the main thread");
        assert_ne!(status.code(), Some(101), "a panic");
    }
}

/// A full disk is no recording.
#[test]
fn a_recording_that_breaks_off_is_told_by_record_too() {
    let bench = Bench::new();
    let flexbeam = env!("CARGO_BIN_EXE_flexbeam");
    let script = format!(
        "trap '' XFSZ; ulimit -f 40; exec {flexbeam} record -o r.mcap --duration 3 --hold 60 --max-angle-deg 1e6"
    );
    let output = Command::new("bash").args(["-c", &script]).current_dir(bench.path("")).output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    assert!(!bench.path("r.mcap").exists(), "the disk was full");
    assert_ne!(output.status.code(), Some(0), "{out}");
}

/// A mistyped --control is found before the rig is touched.
#[test]
fn a_control_socket_that_cannot_be_opened_leaves_nothing_behind() {
    let bench = Bench::new();
    bench.done("record --linear --duration 4");
    bench.done("identify recording.csv --order 4");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
    let answer = bench.run("run controller.toml --duration 1 --hold 60 --home --control no-such-folder/run.sock");
    assert_eq!(answer.status, 2);
    assert!(!answer.err.contains("homed"), "the rig moved before the place was looked at: {}", answer.err);
    assert!(!bench.names().contains(&"run.mcap.part".into()), "{:?}", bench.names());
}

/// The zeroes that were found are taken off before anybody identifies.
#[test]
fn a_recording_of_a_homed_rig_is_identified_from_its_zeroes() {
    // Nearly linear, so that order 4 fits but for a bias.
    const RIG: &str = "schema = \"flexbeam.rig/1\"\n[link]\nmodes = 0\n[friction]\ncoulomb_nm = 0.0\n[actuator]\n\
                       dead_zone_plus_v = 0.0\ndead_zone_minus_v = 0.0\n[gauge]\nnoise_rad = 1e-5\nbias_rad = ";
    let fit = |bias_rad: &str| {
        let bench = Bench::new();
        bench.write("rig.toml", &format!("{RIG}{bias_rad}\n"));
        let rig = RigProcess::udp(&bench, "--rig rig.toml");
        let limits = "--hold 60 --max-angle-deg 1e6 --max-speed-deg-s 1e9";
        bench.done(&format!("record --port {} --duration 4 {limits} -o recording.mcap", rig.port));
        let model = bench.json("identify recording.mcap --order 4 -o model.toml");
        number(&model["fit_percent"], "alpha_rad")
    };
    let (straight, biased) = (fit("0.0"), fit("0.3"));
    assert!(biased > straight - 10.0, "alpha fits to {straight} %, with a bias that homing had found to {biased} %");
}

/// DESIGN: no silent fallback.
#[test]
fn a_senseless_duration_of_the_served_rig_is_refused() {
    let bench = Bench::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_flexbeam"))
        .args(["rig", "--listen", "pty", "--duration", "nan"])
        .current_dir(bench.path(""))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    ended_or_stopped(&mut child, Duration::from_secs(3));
    let status = child.try_wait().unwrap();
    let _ = child.kill();
    child.wait().unwrap();
    assert_eq!(status.and_then(|status| status.code()), Some(2), "it serves on, for ever");
}
