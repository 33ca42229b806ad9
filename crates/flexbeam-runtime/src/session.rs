//! One run from arming to its end: the loop's thread, its watchdog, its recorder.
//!
//! Enters: a back end, a controller, settings, sinks. Leaves: a [`RunReport`], and the back end, at 0 V.

use crate::back_end::{BackEnd, Cutoff, OpenError, Timing};
use crate::cause::{Cause, RunFault};
use crate::clock::{Clock, Monotonic, NS_PER_S};
use crate::controls::Controls;
use crate::dry_run::{CannotHold, dry_run, judge};
use crate::frozen::FrozenLimit;
use crate::lifecycle::Phase;
use crate::live::{Live, LiveControl, LiveReader, Refused, live};
use crate::meter::Meter;
use crate::real_time_loop::{RealTimeLoop, Tempo};
use crate::recorder::{Message, Recorded, Recorder};
use crate::sample::Sample;
use crate::sink::{EventKind, RunReport, Sink};
use crate::standing::{LOOP_PRIORITY, Standing, WATCHDOG_PRIORITY};
use crate::watchdog::watch;
use flexbeam_kernel as kernel;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

/// Seconds of samples that the way to the recorder holds.
const RING_S: f64 = 4.0;
const FEWEST_RING: usize = 4096;
const MOST_RING: usize = 1 << 18;
/// Stack of the loop's thread; all of it is locked with the rest of the memory.
const STACK: usize = 1 << 20;
/// After the watchdog bit, a loop that hangs for this long is left behind: its thread cannot be ended from outside.
const LEFT_BEHIND: Duration = Duration::from_secs(1);

/// A controller as numbers: order, and A, B, C, D as the kernel reads them.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerData {
    /// Number of states.
    pub order: usize,
    /// Coefficients, [`kernel::Controller::coefficients_len`] of them.
    pub coefficients: Vec<f64>,
}

impl ControllerData {
    /// u = v: the reference is the voltage [V]. Recordings and rig tests run on it, behind the kernel's limits.
    pub fn pass_through() -> ControllerData {
        ControllerData { order: 0, coefficients: vec![1.0, 0.0, 0.0, 0.0] }
    }
}

/// What a run is to be.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The controller.
    pub controller: ControllerData,
    /// Settings and reference at the start.
    pub live: Live,
    /// Sample period [s].
    pub period_s: f64,
    /// Longest time that one voltage may stand [s]. Default 0.02.
    pub hold_s: f64,
    /// Longest wait for an answer of the rig, as a part of the period. Default 0.8.
    pub wait_share: f64,
    /// Length [s]; nothing: until it is stopped.
    pub duration_s: Option<f64>,
    /// Whether the controller takes over with the first tick, or waits for [`Controls::start`].
    pub autostart: bool,
    /// When sensors count as frozen.
    pub frozen: FrozenLimit,
    /// Core of the loop's thread; nothing: any.
    pub core: Option<usize>,
    /// Stops this run and every other one that has it, when it is set: by a signal handler, say.
    pub asked: Arc<AtomicBool>,
}

impl Setup {
    /// A run with the defaults.
    pub fn new(controller: ControllerData, live: Live, period_s: f64) -> Setup {
        Setup {
            controller,
            live,
            period_s,
            hold_s: 0.02,
            wait_share: 0.8,
            duration_s: None,
            autostart: true,
            frozen: FrozenLimit::default(),
            core: None,
            asked: Arc::default(),
        }
    }

    fn tempo(&self) -> Tempo {
        Tempo {
            period_ns: (self.period_s * NS_PER_S).round() as u64,
            hold_ns: (self.hold_s * NS_PER_S) as u64,
            ticks: self.duration_s.map(|duration_s| (duration_s / self.period_s).round() as u64),
            frozen: self.frozen,
        }
    }
}

/// Why a run cannot be armed. Nothing has moved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotArmed {
    /// The controller's numbers.
    #[error("found {0}, needed a controller that the kernel can run\nhint: design it again")]
    Controller(kernel::Error),
    /// The settings.
    #[error(transparent)]
    Settings(#[from] Refused),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] OpenError),
    /// The period.
    #[error(transparent)]
    Period(#[from] CannotHold),
    /// No thread could be made.
    #[error("found {0} when starting a thread, needed three threads\nhint: the limit is that of `ulimit -u`")]
    Thread(String),
}

/// A run under way.
pub struct Session {
    /// To start and stop it, and to see where it stands.
    pub controls: Controls,
    /// To change its settings.
    pub live: LiveControl,
    /// What the system granted.
    pub standing: Standing,
    /// What the dry run measured.
    pub dry_run: Meter,
    warnings: Mutex<Vec<String>>,
    events: Arc<Sender<Message>>,
    outcome: Receiver<LoopEnd>,
    watchdog_done: Arc<AtomicBool>,
    /// Both until they are joined.
    watchdog: Option<JoinHandle<bool>>,
    recorder: Option<JoinHandle<Recorded>>,
}

/// What remains of a run.
pub struct Outcome {
    /// How it went.
    pub report: RunReport,
    /// What the recorder had to say.
    pub recorded: Recorded,
    /// The rig, at 0 V; nothing when its thread had to be left behind.
    pub back_end: Option<Box<dyn BackEnd>>,
}

/// Puts events into the recording of a run, and does not keep its recorder waiting.
#[derive(Clone, Debug)]
pub struct Notes(Weak<Sender<Message>>);

impl Notes {
    /// Real-time: no. An event of now; nothing once the session is gone.
    pub fn note(&self, kind: EventKind, text: impl Into<String>) {
        if let Some(events) = self.0.upgrade() {
            // The recorder outlives the session; without it there is nowhere to note anything.
            let _ = events.send(Message::Event(kind, text.into()));
        }
    }
}

struct LoopEnd {
    cause: Cause,
    meter: Meter,
    back_end: Box<dyn BackEnd>,
}

/// What the loop's thread says before the first tick.
type Armed = Result<(Standing, Meter), NotArmed>;

impl Session {
    /// Real-time: no. Dry run, handshake with the rig, threads; then the clock runs at 0 V.
    ///
    /// Errors: [`NotArmed`]; nothing has moved, and the back end is given up.
    pub fn arm(back_end: Box<dyn BackEnd>, setup: Setup, sinks: Vec<Box<dyn Sink>>) -> Result<Session, NotArmed> {
        Session::arm_on(Monotonic, back_end, setup, sinks)
    }

    /// Real-time: no. As [`Session::arm`], on another clock.
    ///
    /// Errors: those of [`Session::arm`].
    pub fn arm_on<C: Clock + 'static>(
        clock: C,
        back_end: Box<dyn BackEnd>,
        setup: Setup,
        sinks: Vec<Box<dyn Sink>>,
    ) -> Result<Session, NotArmed> {
        let ControllerData { order, coefficients } = &setup.controller;
        kernel::Controller::new(*order, coefficients).map_err(NotArmed::Controller)?;
        let (control, reader) = live(setup.live.clone())?;
        let controls = Controls::with(setup.asked.clone());
        if setup.autostart {
            controls.start();
        }
        let ring = ((RING_S / setup.period_s) as usize).clamp(FEWEST_RING, MOST_RING);
        let (producer, consumer) = rtrb::RingBuffer::new(ring);
        let (events, messages) = channel();
        let recorder = Recorder::new(consumer, messages, control.clone(), sinks);
        let recorder = spawn("flexbeam-recorder", move || recorder.run())?;
        let watchdog_done = Arc::new(AtomicBool::new(false));
        let watchdog = watchdog(&controls, back_end.cutoff(), setup.tempo(), &watchdog_done)?;

        let (armed_out, armed) = channel();
        let (outcome_out, outcome) = channel();
        let loop_controls = controls.clone();
        let spawned = spawn("flexbeam-loop", move || {
            if let Some(end) = loop_thread(clock, back_end, &setup, reader, producer, &loop_controls, &armed_out) {
                // Nobody listens when the session was dropped; the rig is at 0 V all the same.
                let _ = outcome_out.send(end);
            }
        });
        let early = |_| NotArmed::Thread("a thread that ended early".into());
        let armed = spawned.and_then(|_| armed.recv().map_err(early)?);
        if armed.is_err() {
            watchdog_done.store(true, Ordering::Release);
        }
        let (standing, dry_run) = armed?;
        let (watchdog, recorder) = (Some(watchdog), Some(recorder));
        let session = Session {
            controls,
            live: control,
            standing,
            dry_run,
            warnings: Mutex::default(),
            events: Arc::new(events),
            outcome,
            watchdog_done,
            watchdog,
            recorder,
        };
        standing.warnings().iter().for_each(|warning| session.note(EventKind::Warning, warning.to_string()));
        Ok(session)
    }

    /// Real-time: no. Puts an event into the recording; a warning or an override into the report, too.
    pub fn note(&self, kind: EventKind, text: impl Into<String>) {
        let text = text.into();
        if matches!(kind, EventKind::Warning | EventKind::Override) {
            self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text.clone());
        }
        // The recorder outlives the session; without it there is nowhere to note anything.
        let _ = self.events.send(Message::Event(kind, text));
    }

    /// Real-time: no. By which others put events into the recording while this session lasts.
    pub fn notes(&self) -> Notes {
        Notes(Arc::downgrade(&self.events))
    }

    /// Real-time: no. Whether the loop has ended.
    pub fn is_over(&self) -> bool {
        matches!(self.controls.phase(), Phase::Stopped | Phase::Faulted) || self.controls.bitten()
    }

    /// Real-time: no. Waits for the end, however long it takes, and brings everything home.
    pub fn finish(mut self) -> Outcome {
        let end = self.wait();
        self.dismiss_watchdog();
        let (cause, meter, back_end) = match end {
            Some(LoopEnd { cause, meter, back_end }) => (cause, meter, Some(back_end)),
            None => (Cause::Fault(RunFault::Watchdog), Meter::default(), None),
        };
        let text = words(cause, back_end.as_deref());
        let link = back_end.as_ref().map(|rig| rig.counters()).unwrap_or_default();
        let warnings = std::mem::take(self.warnings.get_mut().unwrap_or_else(PoisonError::into_inner));
        let report = RunReport { cause, text, meter, link, warnings };
        let _ = self.events.send(Message::Over(Box::new(report.clone())));
        let recorded = self.recorder.take().and_then(|thread| thread.join().ok());
        Outcome { report, recorded: recorded.unwrap_or_else(Recorded::lost), back_end }
    }

    /// After the loop's end. A watchdog that hangs in its cutoff is left behind like the loop that it cut off.
    fn dismiss_watchdog(&mut self) {
        self.watchdog_done.store(true, Ordering::Release);
        if let Some(watchdog) = self.watchdog.take().filter(|_| !self.controls.bitten()) {
            let _ = watchdog.join();
        }
    }

    /// The loop's end; nothing when it hangs although the watchdog has cut the voltage off.
    fn wait(&self) -> Option<LoopEnd> {
        loop {
            match self.outcome.recv_timeout(LEFT_BEHIND) {
                Ok(end) => return Some(end),
                Err(RecvTimeoutError::Timeout) if self.controls.bitten() => return None,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
    }
}

/// A run that nobody holds any more has nobody to stop it: it is brought to 0 V before the holder goes on, also out of a panic.
impl Drop for Session {
    fn drop(&mut self) {
        if self.recorder.is_none() {
            return; // finished
        }
        self.controls.stop();
        drop(self.wait());
        self.dismiss_watchdog();
    }
}

fn spawn<T: Send + 'static>(name: &str, what: impl FnOnce() -> T + Send + 'static) -> Result<JoinHandle<T>, NotArmed> {
    let thread = std::thread::Builder::new().name(name.into()).stack_size(STACK);
    thread.spawn(what).map_err(|error| NotArmed::Thread(error.to_string()))
}

fn watchdog(
    controls: &Controls,
    cutoff: Option<Box<dyn Cutoff>>,
    tempo: Tempo,
    done: &Arc<AtomicBool>,
) -> Result<JoinHandle<bool>, NotArmed> {
    let (controls, done) = (controls.clone(), done.clone());
    spawn("flexbeam-watchdog", move || {
        Standing::claim(WATCHDOG_PRIORITY, None);
        watch(&controls, cutoff.as_deref(), tempo.period_ns, tempo.hold_ns, &done)
    })
}

/// The cause, in the words of whoever knows best.
fn words(cause: Cause, back_end: Option<&dyn BackEnd>) -> String {
    match (cause, back_end) {
        (Cause::Over, _) => "the time is over".into(),
        (Cause::Asked, _) => "stopped as asked".into(),
        (Cause::Fault(RunFault::Link(fault)), Some(rig)) => rig.explain(fault),
        (Cause::Fault(fault), _) => fault.to_string(),
    }
}

/// The loop's thread: rights, dry run, loop. Nothing when the run was not armed.
fn loop_thread<C: Clock>(
    mut clock: C,
    mut back_end: Box<dyn BackEnd>,
    setup: &Setup,
    mut reader: LiveReader,
    samples: rtrb::Producer<Sample>,
    controls: &Controls,
    armed: &Sender<Armed>,
) -> Option<LoopEnd> {
    let standing = Standing::claim(LOOP_PRIORITY, setup.core);
    let tempo = setup.tempo();
    let ControllerData { order, coefficients } = &setup.controller;
    let controller = kernel::Controller::new(*order, coefficients).ok()?;
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = kernel::State::new(&controller, &mut memory).ok()?;
    let meter = dry_run(&mut clock, tempo.period_ns, &controller, &mut state);
    let timing = Timing { period_s: setup.period_s, wait_s: setup.wait_share * setup.period_s, hold_s: setup.hold_s };
    let verdict = judge(&meter, tempo.period_ns).map_err(NotArmed::from);
    // The handshake comes last: from here on the rig waits for a command every period.
    let verdict = verdict.and_then(|()| back_end.prepare(timing).map_err(NotArmed::from));
    let holds = verdict.is_ok();
    armed.send(verdict.map(|()| (standing, meter))).ok()?;
    if !holds {
        return None;
    }
    let the_loop = RealTimeLoop::new(tempo, clock, controls, &mut reader, samples, (controller, state));
    let run = AssertUnwindSafe(|| the_loop.run(back_end.as_mut()));
    let (cause, meter) = catch_unwind(run).unwrap_or_else(|_| (Cause::Fault(RunFault::Panicked), Meter::default()));
    if cause == Cause::Fault(RunFault::Panicked) {
        controls.set_phase(Phase::Faulted);
    }
    Some(LoopEnd { cause, meter, back_end })
}
