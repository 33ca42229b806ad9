//! The live view of `flexbeam run`: the real program on a pseudo-terminal, with keys, a screen and an exit status.

mod support;

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use flexbeam_files::{LiveSettings, RunRecording};
use nix::fcntl::OFlag;
use nix::libc;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::pty::{PtyMaster, Winsize, grantpt, posix_openpt, ptsname_r, unlockpt};
use nix::sys::termios::{LocalFlags, Termios, tcgetattr};
use support::Bench;

/// A machine that does other things, too, is not in a hurry.
const PATIENCE: Duration = Duration::from_secs(60);
const LOOK: Duration = Duration::from_millis(20);
/// What no program says.
const MARK: &str = "-- the end --";
const COLUMNS: u16 = 100;
const ROWS: u16 = 30;

/// The program on a terminal of its own.
struct Watched {
    program: Child,
    /// Keyboard and screen; without it the terminal has hung up.
    master: Option<PtyMaster>,
    screen: vt100::Parser,
    /// Keeps the program's end open, so that its state can be read when the program is gone.
    line: File,
    before: Termios,
}

impl Watched {
    /// Runs `flexbeam` with these words.
    fn start(bench: &Bench, words: &str) -> Watched {
        let (master, line) = pseudo_terminal().expect("a pseudo-terminal");
        let before = tcgetattr(&line).expect("the terminal's state");
        let end = || Stdio::from(line.try_clone().expect("another handle"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        command.args(words.split_whitespace()).current_dir(bench.path("")).stdin(end()).stderr(end());
        command.stdout(Stdio::null()).env("TERM", "xterm-256color");
        // SAFETY: between fork and exec only two system calls are made, both of which may be made there.
        unsafe { command.pre_exec(become_the_terminals_own) };
        let program = command.spawn().expect("the program starts");
        let [rows, columns] = [ROWS, COLUMNS].map(|count| NonZeroU16::new(count).expect("not zero"));
        let screen = vt100::Parser::new(rows, columns, 0);
        Watched { program, master: Some(master), screen, line, before }
    }

    fn press(&mut self, keys: &str) {
        let mut keyboard = self.master.as_ref().expect("it has not hung up");
        keyboard.write_all(keys.as_bytes()).expect("the terminal takes keys");
    }

    fn shown(&self) -> String {
        self.screen.screen().contents()
    }

    /// Waits until the screen shows it.
    fn wait_for(&mut self, what: &str) {
        let late = Instant::now() + PATIENCE;
        while !self.shown().contains(what) {
            assert!(Instant::now() < late, "no {what:?} on\n{}", self.shown());
            self.look();
        }
    }

    /// Takes what was drawn, or waits a little for it.
    fn look(&mut self) {
        let Some(mut master) = self.master.as_ref() else { return std::thread::sleep(LOOK) };
        let mut fds = [PollFd::new(master.as_fd(), PollFlags::POLLIN)];
        poll(&mut fds, PollTimeout::try_from(LOOK).expect("a short time")).expect("it can be waited for");
        if fds[0].revents().is_some_and(|found| found.contains(PollFlags::POLLIN)) {
            let mut bytes = [0; 4096];
            let count = master.read(&mut bytes).expect("the terminal is there");
            self.screen.process(&bytes[..count]);
        }
    }

    /// Waits until the loop has gone on for a while: whatever was asked for is in force then, and recorded.
    fn wait_for_ticks(&mut self) {
        let (late, begin_s) = (Instant::now() + PATIENCE, self.time_s());
        while self.time_s() < begin_s + 0.2 {
            assert!(Instant::now() < late, "the clock stands still:\n{}", self.shown());
            self.look();
        }
    }

    /// The time in the first row's end [s].
    fn time_s(&self) -> f64 {
        let shown = self.shown();
        let words: Vec<&str> = shown.lines().next().unwrap_or_default().split_whitespace().collect();
        words[words.len() - 2].parse().unwrap_or_else(|_| panic!("no time in {words:?}"))
    }

    fn status(&mut self) -> i32 {
        let late = Instant::now() + PATIENCE;
        loop {
            self.look();
            if let Some(status) = self.program.try_wait().expect("it can be waited for") {
                return status.code().expect("it ends by itself");
            }
            assert!(Instant::now() < late, "it does not end:\n{}", self.shown());
        }
    }

    /// The exit status, and the screen then; the terminal is as it was before.
    fn end(mut self) -> (i32, String) {
        let status = self.status();
        // What it said last is still on its way; the mark comes behind it.
        self.line.write_all(MARK.as_bytes()).expect("it is written");
        self.wait_for(MARK);
        let after = tcgetattr(&self.line).expect("the terminal's state");
        assert_eq!(after, self.before, "the terminal's modes");
        assert!(after.local_flags.contains(LocalFlags::ICANON | LocalFlags::ECHO));
        assert!(!self.screen.screen().alternate_screen(), "the alternate screen was left");
        assert!(!self.screen.screen().hide_cursor(), "the cursor is back");
        (status, self.shown())
    }
}

/// A test that failed leaves nothing behind that runs.
impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// Both ends. No other program may inherit the first: the terminal would not hang up when the test lets it go.
fn pseudo_terminal() -> std::io::Result<(PtyMaster, File)> {
    let master = posix_openpt(OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_CLOEXEC)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let line = File::options().read(true).write(true).custom_flags(libc::O_NOCTTY).open(ptsname_r(&master)?)?;
    let size = Winsize { ws_row: ROWS, ws_col: COLUMNS, ws_xpixel: 0, ws_ypixel: 0 };
    // SAFETY: `size` lives through the call, which only reads it.
    nix::errno::Errno::result(unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCSWINSZ, &raw const size) })?;
    Ok((master, line))
}

/// A session of its own, with standard input as its terminal: `/dev/tty` is the test's and not the developer's.
fn become_the_terminals_own() -> std::io::Result<()> {
    nix::unistd::setsid()?;
    // SAFETY: the request takes a number and touches no memory.
    nix::errno::Errno::result(unsafe { libc::ioctl(libc::STDIN_FILENO, libc::TIOCSCTTY, 0) })?;
    Ok(())
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("model.toml", &support::model(&flexbeam_rig::Lumped::PAPER));
    bench.done("design model.toml --stability-degree 1.5 --uncertainty 0.2 -o controller.toml");
    bench
}

/// As `flexbeam run` is started by hand; a stall of the machine does not end it.
const RUN: &str = "run controller.toml --hold 20 -o run.mcap";

fn recording(bench: &Bench) -> RunRecording {
    RunRecording::read(&bench.path("run.mcap")).expect("a whole recording")
}

#[test]
fn keys_change_the_run_and_space_stops_it_as_a_fault() {
    let bench = bench();
    let mut watched = Watched::start(&bench, RUN);
    watched.wait_for("RUNNING");
    watched.wait_for("30.00°");
    watched.press("\x1b[C");
    watched.wait_for("35.00°");
    watched.press("\x1b[1;2C");
    watched.wait_for("35.50°");
    watched.press("l");
    watched.wait_for("none");
    // To u_p+, and below zero, which the kernel refuses.
    watched.press("jjjjj-");
    watched.wait_for("refused: found a senseless u_p_plus_v");
    watched.wait_for_ticks();
    watched.press(" ");
    let (status, said) = watched.end();
    assert_eq!(status, 3, "{said}");
    assert!(said.contains("the emergency stop was pressed"), "{said}");
    let recording = recording(&bench);
    let (first, last) = (recording.settings.first().expect("some"), recording.settings.last().expect("some"));
    let degrees = |set: &LiveSettings| (set.reference.amplitude_rad.to_degrees() * 1e6).round() / 1e6;
    assert_eq!((degrees(first), degrees(last)), (30.0, 35.5));
    assert_eq!(last.settings.law, Some(flexbeam_files::Law::None));
}

#[test]
fn a_run_waits_for_its_start_and_q_ends_it_well() {
    let bench = bench();
    let mut watched = Watched::start(&bench, &format!("{RUN} --wait"));
    watched.wait_for("ARMED");
    watched.wait_for("s START");
    watched.press("\r");
    watched.wait_for("RUNNING");
    watched.press("q");
    let (status, said) = watched.end();
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("wrote run.mcap") && said.contains("started: the controller drives the rig"), "{said}");
    assert_eq!(recording(&bench).report.expect("a report")["cause"], "asked");
}

#[test]
fn ctrl_c_and_escape_are_keys_and_end_it_well() {
    let bench = bench();
    for key in ["\x03", "\x1b"] {
        let mut watched = Watched::start(&bench, &format!("{RUN} --force"));
        watched.wait_for("RUNNING");
        watched.press(key);
        assert_eq!(watched.end().0, 0, "{key:?}");
    }
}

/// A closed window or a broken connection: the run ends at 0 V, and its recording is whole.
#[test]
fn a_terminal_that_hangs_up_ends_the_run_with_a_whole_recording() {
    let bench = bench();
    let mut watched = Watched::start(&bench, RUN);
    watched.wait_for("RUNNING");
    watched.master = None;
    watched.status();
    assert_eq!(recording(&bench).report.expect("a report")["cause"], "asked");
}

#[test]
fn plain_draws_nothing() {
    let bench = bench();
    let watched = Watched::start(&bench, &format!("{RUN} --plain --duration 0.5"));
    let (status, said) = watched.end();
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("started: the controller drives the rig") && !said.contains("EMERGENCY"), "{said}");
}
