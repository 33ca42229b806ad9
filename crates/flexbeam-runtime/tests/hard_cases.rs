//! What a sceptic found in the loop, with a rig of his own in mind: each test states what its owner would expect.

mod scripted;

use flexbeam_kernel::Settings;
use flexbeam_rig::Measurement;
use flexbeam_runtime::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use flexbeam_runtime::{
    Cause, ControlSocket, Controls, FrozenLimit, Latest, Live, Outcome, Phase, Reference, RunFault, Sample, Session,
    Setup, SignWatch, Sink, SinkError, Steering, Zero, live,
};
use scripted::{DRY_SLEEPS, Ear, Scripted, Virtual, alive, armed, open_loop};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Long enough for a stall of this machine, short enough for a test.
const PATIENCE: Duration = Duration::from_secs(10);

fn fresh(theta_rad: f64, alpha_rad: f64) -> Answer {
    Answer::Fresh(Measurement { theta_rad, alpha_rad })
}

/// Does it in another thread; nothing when it takes longer than [`PATIENCE`].
fn in_time<T: Send + 'static>(what: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let (done, wanted) = mpsc::channel();
    std::thread::spawn(move || done.send(what()));
    wanted.recv_timeout(PATIENCE).ok()
}

/// A back end that does as its parts say; everything else as a good one.
struct Odd {
    zero: fn() -> Result<(), LinkFault>,
    cut: fn(),
    exchange: fn(u64) -> Result<Answer, LinkFault>,
}

impl Odd {
    fn good() -> Odd {
        Odd { zero: || Ok(()), cut: || (), exchange: |k| Ok(alive(k)) }
    }
}

struct OddCut(fn());

impl Cutoff for OddCut {
    fn cut(&self) {
        (self.0)()
    }
}

impl BackEnd for Odd {
    fn exchange(&mut self, instant: u64, _voltage_v: f64) -> Result<Answer, LinkFault> {
        (self.exchange)(instant)
    }
    fn zero(&mut self) -> Result<(), LinkFault> {
        (self.zero)()
    }
    fn prepare(&mut self, _timing: Timing) -> Result<(), OpenError> {
        Ok(())
    }
    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        Some(Box::new(OddCut(self.cut)))
    }
    fn counters(&self) -> Counters {
        Counters::default()
    }
    fn name(&self) -> String {
        "odd".into()
    }
}

fn run(rig: impl BackEnd + 'static, setup: Setup) -> (Outcome, Ear) {
    let (session, ear) = armed(rig, setup, Virtual::default());
    (session.finish(), ear)
}

fn is_fault(outcome: &Outcome) -> bool {
    matches!(outcome.report.cause, Cause::Fault(_))
}

/// A loop that hangs with a voltage on is the watchdog's, whoever holds the session.
#[test]
fn a_dropped_session_s_hanging_loop_is_cut_off_all_the_same() {
    let (hangs, hung) = mpsc::channel();
    let rig = Scripted::new(move |instant| {
        if instant == 5 {
            hangs.send(()).unwrap();
            std::thread::sleep(Duration::from_secs(3600));
        }
        Ok(alive(instant))
    });
    let cut = rig.cut.clone();
    let (session, _ear) = armed(rig, Setup { hold_s: 0.2, ..open_loop(2.0) }, Virtual::default());
    hung.recv().unwrap();
    drop(session);
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if cut.load(std::sync::atomic::Ordering::SeqCst) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("2 V stand, and the watchdog was sent home");
}

/// A program that ends next would leave the voltage standing.
#[test]
fn when_a_session_is_dropped_the_rig_is_at_zero_volts() {
    for _ in 0..20 {
        let rig = Scripted::new(|k| {
            std::thread::sleep(Duration::from_millis(2));
            Ok(alive(k))
        });
        let log = rig.log.clone();
        let (session, _ear) = armed(rig, open_loop(2.0), Virtual::default());
        std::thread::sleep(Duration::from_millis(20));
        drop(session);
        let last = log.lock().unwrap().last().copied();
        assert_eq!(last, Some((None, 0.0)), "the session is gone, the voltage is not");
    }
}

/// The end is not well before the rig has taken 0 V.
#[test]
fn a_rig_that_did_not_take_zero_volts_is_a_fault() {
    let rig = Odd { zero: || Err(LinkFault::Board { code: 5 }), ..Odd::good() };
    let (outcome, _) = run(rig, Setup { duration_s: Some(0.05), ..open_loop(2.0) });
    assert!(is_fault(&outcome), "2 V stand at the rig; told: {}", outcome.report.text);
}

/// comedi: "if the loop hangs inside the driver, the 0 V of the other thread waits behind it". Then nobody may wait for it.
#[test]
fn a_cutoff_that_hangs_too_does_not_hang_the_program() {
    let hang = || std::thread::sleep(Duration::from_secs(3600));
    let exchange = |k| {
        if k == 5 {
            std::thread::sleep(Duration::from_secs(3600));
        }
        Ok(alive(k))
    };
    let (session, _ear) = armed(
        Odd { cut: hang, exchange, ..Odd::good() },
        Setup { hold_s: 0.005, ..open_loop(2.0) },
        Virtual::default(),
    );
    let cause = in_time(move || session.finish().report.cause);
    assert_eq!(cause, Some(Cause::Fault(RunFault::Watchdog)), "finish waits for a thread that never ends");
}

struct Panics;

impl Sink for Panics {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        assert!(sample.instant < 20, "planted");
        Ok(())
    }
}

/// A sink that panics is a recording that breaks off.
#[test]
fn a_recorder_that_panicked_is_told() {
    let setup = Setup { duration_s: Some(0.1), ..open_loop(1.0) };
    let rig = Box::new(Scripted::new(|k| Ok(alive(k))));
    let session = Session::arm_on(Virtual::default(), rig, setup, vec![Box::new(Panics)]).unwrap();
    let outcome = session.finish();
    assert!(!outcome.recorded.failures.is_empty() && outcome.recorded.refused >= 80, "{:?}", outcome.recorded);
}

/// Views and the control socket look at the phase.
#[test]
fn after_a_panic_the_phase_is_a_fault() {
    let rig = Scripted::new(|k| if k == 5 { panic!("planted") } else { Ok(alive(k)) });
    let (session, _ear) = armed(rig, Setup { hold_s: 5.0, ..open_loop(2.0) }, Virtual::default());
    let controls: Controls = session.controls.clone();
    let outcome = session.finish();
    assert_eq!(outcome.report.cause, Cause::Fault(RunFault::Panicked));
    assert_eq!(controls.phase(), Phase::Faulted);
}

/// Not one measurement is no run.
#[test]
fn a_rig_that_never_answers_is_silent() {
    let rig = Scripted::new(|_| Ok(Answer::Lost));
    let (outcome, _) = run(rig, Setup { duration_s: Some(0.5), hold_s: 0.02, ..open_loop(2.0) });
    assert!(is_fault(&outcome), "{} ticks, not one measurement: {}", outcome.report.meter.stale, outcome.report.text);
}

/// 300 degree/s is far below the limit of 2000 degree/s; ten lost answers are allowed by the hold.
#[test]
fn lost_measurements_are_no_speed() {
    let theta = |k: u64| (0.3 * k as f64).to_radians();
    let rig = Scripted::new(move |k| Ok(if (50..60).contains(&k) { Answer::Lost } else { fresh(theta(k), 0.0) }));
    let mut setup = Setup { duration_s: Some(0.1), ..open_loop(0.5) };
    setup.live.settings.theta_step_limit_rad = 2000f64.to_radians() * setup.period_s;
    let (outcome, _) = run(rig, setup);
    assert_eq!(outcome.report.cause, Cause::Over, "{}", outcome.report.text);
}

/// The same for periods that the loop itself missed.
#[test]
fn missed_periods_are_no_speed() {
    let theta = |k: u64| (0.3 * k as f64).to_radians();
    let rig = Scripted::new(move |k| Ok(fresh(theta(k), 0.0)));
    let mut setup = Setup { duration_s: Some(0.1), ..open_loop(0.5) };
    setup.live.settings.theta_step_limit_rad = 2000f64.to_radians() * setup.period_s;
    let late_ns = vec![(DRY_SLEEPS + 50, 10_000_000)];
    let (session, _ear) = armed(rig, setup, Virtual { late_ns, ..Virtual::default() });
    let outcome = session.finish();
    assert_eq!(outcome.report.cause, Cause::Over, "{}", outcome.report.text);
}

/// "A cable came off": it is one cable, and the gauge goes on flickering.
#[test]
fn an_encoder_that_came_off_is_found_though_the_gauge_flickers() {
    let rig = Scripted::new(|k| Ok(fresh(0.1, 1e-4 * (k % 7) as f64)));
    let setup = Setup { duration_s: Some(2.0), frozen: FrozenLimit { voltage_v: 0.5, time_s: 0.25 }, ..open_loop(8.0) };
    let (outcome, _) = run(rig, setup);
    assert!(is_fault(&outcome), "8 V for two seconds on a hub that nobody sees: {}", outcome.report.text);
}

/// Every tick 5 ms late at a period of 1 ms: the controller would run at a sixth of its rate to the end.
#[test]
fn a_loop_that_never_keeps_its_period_is_an_overrun() {
    let late_ns = (DRY_SLEEPS..DRY_SLEEPS + 10_000).map(|sleep| (sleep, 5_500_000)).collect();
    let rig = Scripted::new(|k| Ok(alive(k)));
    let setup = Setup { duration_s: Some(5.0), ..open_loop(2.0) };
    let (session, _ear) = armed(rig, setup, Virtual { late_ns, ..Virtual::default() });
    let outcome = session.finish();
    let meter = &outcome.report.meter;
    assert!(is_fault(&outcome), "{} of 5000 periods missed: {}", meter.missed, outcome.report.text);
}

/// "Half a swing after the hub moved, or much movement at once", says its doc.
#[test]
fn a_sign_check_ends_at_much_movement_at_once() {
    let zero = Zero { theta_rad: 0.0, alpha_rad: 0.0, alpha_noise_rad: 2e-4 };
    let mut watch = SignWatch::new(zero, 1e-3);
    let measured = Measurement { theta_rad: 1.5, alpha_rad: -0.3 };
    assert!(watch.enough(&Sample { instant: 7, stale: false, measured, phase: Phase::Running, ..Sample::default() }));
}

/// At a fault 0 V acts from this instant on.
#[test]
fn the_last_sample_of_a_fault_says_zero_volts() {
    let rig = Scripted::new(|k| if k == 5 { Err(LinkFault::CutOff) } else { Ok(alive(k)) });
    let (_, ear) = run(rig, open_loop(2.0));
    assert_eq!(ear.0.lock().unwrap().samples.last().unwrap().voltage_v, 0.0);
}

/// A slip of a slider must not take the limits away.
#[test]
fn safety_limits_are_not_lifted_in_a_run() {
    let settings = Settings { theta_limit_rad: 3.0, theta_step_limit_rad: 0.035, ..Settings::default() };
    let first = Live { revision: 0, settings, reference: Reference::default() };
    let (control, _reader) = live(first).unwrap();
    assert!(control.change(|live| live.settings.theta_limit_rad = 1e9).is_err(), "the angle limit is gone");
    assert!(control.change(|live| live.settings.voltage_limit_v = 1e6).is_err(), "a million volts");
}

/// A square wave of 0.3 s at 1 kHz: 150 ticks each way. Four seconds, which the ring holds.
#[test]
fn a_square_wave_s_edges_stand_where_its_period_says() {
    let rig = Scripted::new(|k| Ok(alive(k)));
    let mut setup = Setup { duration_s: Some(4.0), ..open_loop(0.0) };
    setup.live.reference =
        Reference { shape: flexbeam_runtime::Shape::Square, amplitude_rad: 0.5, period_s: 0.3, ..Reference::default() };
    let (_, ear) = run(rig, setup);
    let heard = ear.0.lock().unwrap();
    let edges: Vec<u64> = heard.samples[..4000]
        .windows(2)
        .filter(|w| w[0].reference_rad != w[1].reference_rad)
        .map(|w| w[1].instant)
        .collect();
    let wrong = edges.iter().filter(|edge| *edge % 150 != 0).count();
    assert_eq!(wrong, 0, "of {} edges: {edges:?}", edges.len());
}

fn steering() -> Steering {
    let first = Live { revision: 0, settings: Settings::default(), reference: Reference::default() };
    let (control, _) = live(first).unwrap();
    Steering { controls: Controls::default(), live: control, latest: Latest::default(), period_s: 1e-3 }
}

fn asks(stream: &UnixStream, line: &str) -> Option<String> {
    stream.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
    let mut sender = stream;
    writeln!(sender, "{line}").ok()?;
    let mut reply = String::new();
    BufReader::new(stream).read_line(&mut reply).ok()?;
    Some(reply).filter(|reply| !reply.is_empty())
}

/// On Linux a connection to a plain file is refused like one to a dead socket.
#[test]
fn a_file_in_the_socket_s_place_is_not_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("controller.toml");
    std::fs::write(&path, "weeks of work").unwrap();
    let opened = ControlSocket::open(&path, steering());
    assert!(opened.is_err(), "opened over a file");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "weeks of work");
}

/// Viewers that are connected and silent.
#[test]
fn sixteen_idle_clients_do_not_keep_the_emergency_stop_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.sock");
    let steering = steering();
    let _socket = ControlSocket::open(&path, steering.clone()).unwrap();
    let idle: Vec<UnixStream> = (0..16).map(|_| UnixStream::connect(&path).unwrap()).collect();
    assert!(idle.iter().all(|client| asks(client, r#"{"do":"status"}"#).is_some()));
    let reply = asks(&UnixStream::connect(&path).unwrap(), r#"{"do":"emergency"}"#);
    assert!(reply.is_some(), "the emergency stop was not heard");
}

/// "Listens until it is dropped."
#[test]
fn a_dropped_socket_serves_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("run.sock");
    let socket = ControlSocket::open(path, steering()).unwrap();
    let client = UnixStream::connect(path).unwrap();
    assert!(asks(&client, r#"{"do":"status"}"#).is_some());
    drop(socket);
    assert_eq!(asks(&client, r#"{"do":"status"}"#), None);
}

/// The file may be another run's by then.
#[test]
fn a_dropped_socket_leaves_another_run_s_file() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("run.sock");
    let first = ControlSocket::open(path, steering()).unwrap();
    std::fs::remove_file(path).unwrap();
    let _second = ControlSocket::open(path, steering()).unwrap();
    drop(first);
    assert!(UnixStream::connect(path).is_ok(), "the second run can no longer be told anything");
}
