//! Lateness of the full loop with recording, without a scope and with ten viewers of one, beside that of an empty loop, in turns,
//! on the same machine in one run. One of the viewers never reads.
//!
//! cargo bench -p flexbeam-runtime --bench lateness -- [--quick]
//!
//! Each round runs the three loops one after the other for the same time, so that all meet the same machine.
//! Allocations of the loop's thread are counted by the allocator, page faults by the system.

use flexbeam_files::{Overwrite, Provenance, RunFile, RunHeader};
use flexbeam_kernel::Settings;
use flexbeam_rig::{RigParameters, SimulatedRig};
use flexbeam_runtime::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use flexbeam_runtime::scope::{About, ScopeServer, Token};
use flexbeam_runtime::{
    Clock, ControllerData, LOOP_PRIORITY, Latest, Live, Meter, Monotonic, NS_PER_S, PageFaults, Reference, RunContext,
    RunSink, Session, Setup, Shape, SimulatedBackEnd, Sink, Standing, Steering, Times,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::net::TcpStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;

/// Order of the controller; the design of the paper's plant has about as many states.
const ORDER: usize = 12;

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

thread_local! {
    static LOOPING: Cell<bool> = const { Cell::new(false) };
}

// SAFETY: every call goes to the system's allocator unchanged; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(u64::from(LOOPING.with(Cell::get)), Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        ALLOCATIONS.fetch_add(u64::from(LOOPING.with(Cell::get)), Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The simulated rig, which marks its thread from the first exchange on.
struct Marked(SimulatedBackEnd);

impl BackEnd for Marked {
    fn exchange(&mut self, instant: u64, voltage_v: f64) -> Result<Answer, LinkFault> {
        LOOPING.with(|looping| looping.set(true));
        self.0.exchange(instant, voltage_v)
    }
    fn zero(&mut self) -> Result<(), LinkFault> {
        LOOPING.with(|looping| looping.set(false));
        self.0.zero()
    }
    fn prepare(&mut self, timing: Timing) -> Result<(), OpenError> {
        self.0.prepare(timing)
    }
    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        self.0.cutoff()
    }
    fn counters(&self) -> Counters {
        self.0.counters()
    }
    fn name(&self) -> String {
        self.0.name()
    }
}

/// Only the deadlines: what the machine does to any loop.
fn empty(period_s: f64, duration_s: f64, core: usize) -> (Times, u64) {
    let thread = std::thread::spawn(move || {
        Standing::claim(LOOP_PRIORITY, Some(core));
        let (mut clock, mut times, mut missed) = (Monotonic, Times::new(), 0);
        let period_ns = (period_s * NS_PER_S) as u64;
        let mut deadline_ns = clock.now_ns() + 2 * period_ns;
        for _ in 0..(duration_s / period_s) as u64 {
            clock.sleep_until(deadline_ns);
            let late_ns = clock.now_ns() - deadline_ns;
            times.record(late_ns);
            missed += late_ns / period_ns;
            deadline_ns += period_ns * (1 + late_ns / period_ns);
        }
        (times, missed)
    });
    thread.join().expect("an empty loop does not panic")
}

/// Stable, with all coefficients at work.
fn controller() -> ControllerData {
    let n = ORDER;
    let a = (0..n * n).map(|k| if k % (n + 1) == 0 { 0.9 } else { 0.02 / n as f64 });
    let others = (0..5 * n + 4).map(|k| 0.001 * (1.0 + (k % 7) as f64));
    ControllerData { order: n, coefficients: a.chain(others).collect() }
}

/// Whether there is a scope.
#[derive(Clone, Copy, PartialEq)]
enum Scope {
    None,
    TenViewers,
}

/// Viewers of a scope, each on a thread of this process, and one that never reads.
fn viewers(server: &ScopeServer) -> (Vec<JoinHandle<u64>>, TcpStream) {
    let connected = || {
        let address = server.address().to_string();
        let stream = TcpStream::connect(&address).expect("the scope listens");
        let (mut socket, _) = tungstenite::client(format!("ws://{address}/live"), stream).expect("a WebSocket");
        let enter = r#"{"type":"enter","protocol":1,"token":null,"name":"bench","key":"","after":null}"#;
        socket.send(tungstenite::Message::text(enter)).expect("sent");
        socket
    };
    let read = |mut socket: tungstenite::WebSocket<TcpStream>| {
        let mut frames = 0;
        while let Ok(message) = socket.read() {
            frames += u64::from(message.is_binary());
        }
        frames
    };
    let readers = (0..9).map(|_| connected()).map(|socket| std::thread::spawn(move || read(socket))).collect();
    let stalled = connected().get_ref().try_clone().expect("a descriptor");
    (readers, stalled)
}

/// The loop with rig, controller, law, smooth reference, recorder and recording.
fn full(period_s: f64, duration_s: f64, core: usize, folder: &std::path::Path, scope: Scope) -> Meter {
    let settings = Settings { smooth_ticks: 0.2 / period_s, u_p_plus_v: 0.26, u_p_minus_v: 0.1, ..Settings::default() };
    let reference = Reference { shape: Shape::Sine, amplitude_rad: 0.3, period_s: 1.0, ..Reference::default() };
    let live = Live { revision: 0, settings, reference };
    let setup = Setup {
        duration_s: Some(duration_s),
        hold_s: 10.0,
        core: Some(core),
        ..Setup::new(controller(), live, period_s)
    };
    let rig = SimulatedRig::new(&RigParameters { period_s, ..RigParameters::default() }, 1).expect("the paper's rig");
    let rig = Marked(SimulatedBackEnd::new(rig).expect("a rig with delay"));
    let path = folder.join("run.mcap");
    let header = RunHeader {
        period_s,
        start_unix_ns: 0,
        port: "simulated".into(),
        provenance: Provenance { tool: "bench".into(), ..Provenance::default() },
        controller: None,
        excitation: None,
    };
    let file = RunFile::create(&path, Overwrite::SameKind, &header).expect("a folder of our own");
    let context = RunContext { port: "simulated".into(), period_s };
    let latest = Latest::default();
    let mut sinks: Vec<Box<dyn Sink>> = vec![Box::new(RunSink::new(file, &path, context)), Box::new(latest.clone())];
    let server = (scope == Scope::TenViewers).then(|| served(period_s));
    sinks.extend(server.iter().map(|server| Box::new(server.sink(&header)) as Box<dyn Sink>));
    let watching = server.as_ref().map(viewers);
    let session = Session::arm(Box::new(rig), setup, sinks).expect("a period that holds");
    let (controls, live) = (session.controls.clone(), session.live.clone());
    if let Some(server) = &server {
        server.steer(Steering { controls, live, latest, period_s }, session.notes());
    }
    let outcome = session.finish();
    assert!(outcome.recorded.failures.is_empty(), "{:?}", outcome.recorded.failures);
    drop(server);
    for reader in watching.into_iter().flat_map(|(readers, _)| readers) {
        assert!(reader.join().expect("a reader does not panic") > 10, "it saw the run");
    }
    outcome.report.meter
}

fn served(period_s: f64) -> ScopeServer {
    let about = About {
        controller: "bench".into(),
        project: None,
        port: "simulated".into(),
        period_s,
        recording: None,
        certificate: None,
        screen: Default::default(),
        save: None,
        asked: Default::default(),
    };
    let token = Token::new().expect("random numbers");
    ScopeServer::open(&"0".parse().expect("any port"), token, about).expect("a free port")
}

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let (rounds, seconds) = if quick { (2, 2.0) } else { (12, 5.0) };
    let core = std::thread::available_parallelism().map_or(0, |n| n.get() - 1);
    let folder = tempfile::tempdir().expect("a folder");
    println!("lateness from the deadline [us], {rounds} rounds of {seconds} s in turns, core {core}\n");
    println!("| rate | loop | 50 % | 99 % | 99.9 % | longest | missed of ticks |\n|---|---|---|---|---|---|---|");
    for rate_hz in [1000.0, 10_000.0] {
        let period_s = 1.0 / rate_hz;
        let (mut bare, mut bare_missed) = (Times::new(), 0);
        let (mut loaded, mut watched) = (Meter::default(), Meter::default());
        ALLOCATIONS.store(0, Ordering::SeqCst);
        for _ in 0..rounds {
            let (times, missed) = empty(period_s, seconds, core);
            bare.add(&times);
            bare_missed += missed;
            add(&mut loaded, &full(period_s, seconds, core, folder.path(), Scope::None));
            add(&mut watched, &full(period_s, seconds, core, folder.path(), Scope::TenViewers));
        }
        row(rate_hz, "empty", &bare, bare_missed);
        row(rate_hz, "full, recording", &loaded.lateness, loaded.missed);
        row(rate_hz, "full, recording, ten viewers", &watched.lateness, watched.missed);
        ratio(rate_hz, "full : empty", &loaded.lateness, &bare);
        ratio(rate_hz, "ten viewers : none", &watched.lateness, &loaded.lateness);
        let us = |times: &Times, q| times.quantile_ns(q) as f64 / 1e3;
        eprintln!(
            "{} kHz: tick {:.3} us median, {:.3} us 99 %; whole period's work {:.2} us median; allocations {}, page faults {} and {} with viewers, unrecorded {} and {}",
            rate_hz / 1e3,
            us(&loaded.tick, 0.5),
            us(&loaded.tick, 0.99),
            us(&loaded.execution, 0.5),
            ALLOCATIONS.load(Ordering::SeqCst),
            loaded.page_faults.minor + loaded.page_faults.major,
            watched.page_faults.minor + watched.page_faults.major,
            loaded.unrecorded,
            watched.unrecorded
        );
    }
}

fn ratio(rate_hz: f64, name: &str, one: &Times, other: &Times) {
    let part = |q: f64| format!("{:.2}", one.quantile_ns(q) as f64 / other.quantile_ns(q) as f64);
    println!("| {} kHz | {name} | {} | {} | {} | | |", rate_hz / 1e3, part(0.5), part(0.99), part(0.999));
}

fn add(sum: &mut Meter, meter: &Meter) {
    sum.lateness.add(&meter.lateness);
    sum.execution.add(&meter.execution);
    sum.tick.add(&meter.tick);
    sum.missed += meter.missed;
    sum.unrecorded += meter.unrecorded;
    sum.page_faults = PageFaults {
        minor: sum.page_faults.minor + meter.page_faults.minor,
        major: sum.page_faults.major + meter.page_faults.major,
    };
}

fn row(rate_hz: f64, name: &str, times: &Times, missed: u64) {
    let us = |ns: u64| format!("{:.1}", ns as f64 / 1e3);
    println!(
        "| {} kHz | {name} | {} | {} | {} | {} | {missed} of {} |",
        rate_hz / 1e3,
        us(times.quantile_ns(0.5)),
        us(times.quantile_ns(0.99)),
        us(times.quantile_ns(0.999)),
        us(times.max_ns()),
        times.count()
    );
}
