//! The loop: on each deadline the voltage of the last tick goes out, the sensors come in, the kernel ticks.
//!
//! Enters: a controller, a back end, a clock. Leaves: voltages, one sample a tick, the cause of the end and what was measured of
//! the loop itself. Deliberately absent: files, sockets, locks, allocation.

use crate::back_end::{Answer, BackEnd, LinkFault};
use crate::cause::{Cause, RunFault};
use crate::clock::{Clock, Schedule, Wake};
use crate::controls::Controls;
use crate::frozen::{FrozenLimit, FrozenWatch};
use crate::lifecycle::{Event, Phase};
use crate::live::LiveReader;
use crate::meter::{Meter, PageFaults};
use crate::reference::Generator;
use crate::sample::Sample;
use flexbeam_kernel::{Commanded, Controller, Fault, Measured, Settings, State, tick};
use flexbeam_rig::Measurement;

/// How often 0 V is tried again when the rig did not take it.
const ATTEMPTS: usize = 3;

/// Punctual ticks in a row that make up for one missed period.
const MAKES_UP: u64 = 3;

/// The clock and the patience of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tempo {
    /// Sample period [ns].
    pub period_ns: u64,
    /// Longest time that one voltage may stand, and that measurements may fail to come [ns].
    pub hold_ns: u64,
    /// Length of the run in ticks, armed ones apart; nothing: until it is stopped.
    pub ticks: Option<u64>,
    /// When sensors count as frozen.
    pub frozen: FrozenLimit,
}

/// Everything the loop's thread owns or borrows.
pub(crate) struct RealTimeLoop<'a, C: Clock> {
    tempo: Tempo,
    clock: C,
    schedule: Schedule,
    controls: &'a Controls,
    live: &'a mut LiveReader,
    samples: rtrb::Producer<Sample>,
    controller: Controller<'a>,
    state: State<'a>,
    generator: Generator,
    frozen: FrozenWatch,
    phase: Phase,
    /// What the next exchange sends [V].
    next_v: f64,
    last: Option<Measurement>,
    /// Instant of the last fresh measurement that was ticked on.
    fresh: Option<u64>,
    silent_ns: u64,
    /// Missed periods, less one for every [`MAKES_UP`] ticks: what the loop is behind.
    behind: u64,
    punctual: u64,
    /// Instant of the first running tick, and of the last one.
    started: Option<u64>,
    ticked: Option<u64>,
    sample: Sample,
    meter: Meter,
}

/// The rig goes to 0 V when this goes, however the loop ends: asked, by a fault, by a panic.
struct ZeroAtTheEnd<'a>(&'a mut dyn BackEnd);

impl ZeroAtTheEnd<'_> {
    /// Real-time: yes. 0 V, and whether the rig took it; a call that fails is made again.
    fn end(self) -> Result<(), LinkFault> {
        let taken = (0..ATTEMPTS).fold(self.0.zero(), |taken, _| taken.or_else(|_| self.0.zero()));
        std::mem::forget(self);
        taken
    }
}

impl Drop for ZeroAtTheEnd<'_> {
    fn drop(&mut self) {
        // On the way out of a panic there is nobody to tell.
        let _ = self.0.zero();
    }
}

impl<'a, C: Clock> RealTimeLoop<'a, C> {
    /// Real-time: no. Armed, the first instant two periods from now.
    pub(crate) fn new(
        tempo: Tempo,
        clock: C,
        controls: &'a Controls,
        live: &'a mut LiveReader,
        samples: rtrb::Producer<Sample>,
        (controller, state): (Controller<'a>, State<'a>),
    ) -> RealTimeLoop<'a, C> {
        let start_ns = clock.now_ns().saturating_add(tempo.period_ns.saturating_mul(2));
        RealTimeLoop {
            schedule: Schedule::new(start_ns, tempo.period_ns),
            frozen: FrozenWatch::new(&tempo.frozen),
            generator: Generator::default(),
            phase: Phase::Armed,
            next_v: 0.0,
            last: None,
            fresh: None,
            silent_ns: 0,
            behind: 0,
            punctual: 0,
            started: None,
            ticked: None,
            sample: Sample::default(),
            meter: Meter::default(),
            tempo,
            clock,
            controls,
            live,
            samples,
            controller,
            state,
        }
    }

    /// Real-time: yes. Ticks until something ends the run. At every end the rig is at 0 V before anything else happens.
    pub(crate) fn run(mut self, back_end: &mut dyn BackEnd) -> (Cause, Meter) {
        self.controls.set_phase(self.phase);
        let before = PageFaults::of_this_thread();
        let rig = ZeroAtTheEnd(back_end);
        let cause = match (self.ticks(rig.0), rig.end()) {
            (Cause::Over | Cause::Asked, Err(fault)) => Cause::Fault(RunFault::NotAtZero(fault)),
            (cause, _) => cause,
        };
        self.meter.page_faults = PageFaults::of_this_thread().since(before);
        self.end(cause);
        (cause, self.meter)
    }

    fn ticks(&mut self, rig: &mut dyn BackEnd) -> Cause {
        loop {
            let wake = self.schedule.next(&mut self.clock);
            self.controls.beat();
            if let Some(cause) = self.period(rig, &wake) {
                return cause;
            }
        }
    }

    /// One period; the cause when it is the last one.
    fn period(&mut self, rig: &mut dyn BackEnd, wake: &Wake) -> Option<Cause> {
        self.note(wake);
        self.start_if_asked(wake);
        if let Some(cause) = self.ending(wake) {
            return Some(cause);
        }
        let ended = match rig.exchange(wake.instant, self.next_v) {
            Ok(answer) => self.answered(answer, wake).err(),
            Err(LinkFault::CutOff) if self.controls.bitten() => Some(RunFault::Watchdog),
            Err(fault) => Some(RunFault::Link(fault)),
        };
        self.close(wake);
        match ended {
            Some(fault) => Some(Cause::Fault(fault)),
            None => {
                self.hand_over();
                None
            }
        }
    }

    fn note(&mut self, wake: &Wake) {
        self.meter.lateness.record(wake.lateness_ns);
        self.meter.missed = self.meter.missed.saturating_add(wake.missed);
        self.count_behind(wake.missed);
        self.sample = Sample {
            instant: wake.instant,
            voltage_v: self.next_v,
            lateness_ns: wake.lateness_ns,
            reference_rad: self.sample.reference_rad,
            measured: self.sample.measured,
            commanded: Commanded { voltage_v: 0.0, u_v: 0.0, ..self.sample.commanded },
            revision: self.sample.revision,
            ..Sample::default()
        };
    }

    /// A stall is made up for by the ticks after it; a machine that is too slow falls further and further behind.
    fn count_behind(&mut self, missed: u64) {
        self.punctual = if missed == 0 { self.punctual.saturating_add(1) } else { 0 };
        if self.punctual >= MAKES_UP {
            self.punctual = 0;
            self.behind = self.behind.saturating_sub(1);
        }
        self.behind = if self.phase == Phase::Running { self.behind.saturating_add(missed) } else { 0 };
    }

    fn start_if_asked(&mut self, wake: &Wake) {
        if self.phase == Phase::Armed && self.controls.start_asked() {
            self.started = Some(wake.instant);
            self.enter(Event::Start);
        }
        self.sample.phase = self.phase;
    }

    fn enter(&mut self, event: Event) {
        if let Some(phase) = self.phase.after(event) {
            self.phase = phase;
            self.controls.set_phase(phase);
        }
    }

    /// What ends the run before this instant's exchange.
    fn ending(&self, wake: &Wake) -> Option<Cause> {
        let running = self.started.map(|started| wake.instant.saturating_sub(started));
        if self.controls.bitten() {
            Some(Cause::Fault(RunFault::Watchdog))
        } else if self.controls.emergency_asked() {
            Some(Cause::Fault(RunFault::Emergency))
        } else if self.controls.stop_asked() {
            Some(Cause::Asked)
        } else if running.zip(self.tempo.ticks).is_some_and(|(gone, all)| gone >= all) {
            Some(Cause::Over)
        } else if self.phase == Phase::Running && self.ticked.is_some() && wake.lateness_ns > self.tempo.hold_ns {
            Some(Cause::Fault(RunFault::Overrun { late_ns: wake.lateness_ns }))
        } else if self.behind.saturating_mul(self.tempo.period_ns) > self.tempo.hold_ns {
            Some(Cause::Fault(RunFault::Behind { missed: self.behind }))
        } else {
            None
        }
    }

    /// The sensors' answer, and the tick on it.
    fn answered(&mut self, answer: Answer, wake: &Wake) -> Result<(), RunFault> {
        let live = self.live.newest();
        self.sample.revision = live.revision;
        self.sample.stale = answer == Answer::Lost;
        let passed_ns = self.tempo.period_ns.saturating_mul(wake.missed.saturating_add(1));
        match answer {
            Answer::Fresh(measured) => {
                self.silent_ns = 0;
                self.last = Some(measured);
                self.sample.measured = measured;
            }
            Answer::Lost => {
                self.silent_ns = self.silent_ns.saturating_add(passed_ns);
                self.meter.stale = self.meter.stale.saturating_add(1);
            }
        }
        if self.started.is_some() && self.silent_ns > self.tempo.hold_ns {
            return Err(RunFault::Silent { for_ns: self.silent_ns });
        }
        // Before the first measurement there is nothing to control, and the rig stays at 0 V.
        let Some(measured) = self.last else { return Ok(()) };
        let Some(started) = self.started else {
            self.rest(measured);
            return Ok(());
        };
        if let Some(for_ns) = self.frozen_for(&measured, passed_ns) {
            return Err(RunFault::Frozen { for_ns });
        }
        self.tick(started, wake, measured)
    }

    /// A lost measurement is the link's silence, not frozen sensors.
    fn frozen_for(&mut self, measured: &Measurement, passed_ns: u64) -> Option<u64> {
        if self.sample.stale { None } else { self.frozen.look(measured, self.next_v, passed_ns) }
    }

    /// Armed: nothing is asked of the rig, so reference and model stand where the tip is.
    fn rest(&mut self, measured: Measurement) {
        let Settings { theta, alpha, .. } = self.live.in_force().settings;
        let y = theta.scaled(measured.theta_rad) + alpha.scaled(measured.alpha_rad);
        self.sample.reference_rad = y;
        self.sample.commanded = Commanded { reference_rad: y, y_rad: y, y_model_rad: y, ..Commanded::default() };
    }

    fn tick(&mut self, started: u64, wake: &Wake, measured: Measurement) -> Result<(), RunFault> {
        let live = self.live.in_force();
        let gone = wake.instant.saturating_sub(started);
        let since = self.ticked.map_or(0, |before| wake.instant.saturating_sub(before));
        let period_s = self.tempo.period_ns as f64 / crate::clock::NS_PER_S;
        let reference_rad = self.generator.next(&live.reference, gone, since, period_s);
        let Measurement { theta_rad, alpha_rad } = measured;
        let before_ns = self.clock.now_ns();
        let measured = Measured { reference_rad, theta_rad, alpha_rad };
        let settings = self.allowing_for_gaps(wake);
        let commanded = tick(&settings, &self.controller, &mut self.state, measured);
        self.meter.tick.record(self.clock.now_ns().saturating_sub(before_ns));
        self.sample.reference_rad = reference_rad;
        self.sample.commanded = commanded;
        self.next_v = commanded.voltage_v;
        self.ticked = Some(wake.instant);
        if commanded.fault == Fault::None { Ok(()) } else { Err(RunFault::Kernel(commanded.fault)) }
    }

    /// The settings in force; where periods passed without a measurement, the hub had as many periods to turn in.
    fn allowing_for_gaps(&mut self, wake: &Wake) -> Settings {
        let settings = self.live.in_force().settings;
        if self.sample.stale {
            return settings;
        }
        let periods = self.fresh.replace(wake.instant).map_or(1, |before| wake.instant.saturating_sub(before));
        Settings { theta_step_limit_rad: settings.theta_step_limit_rad * periods as f64, ..settings }
    }

    fn close(&mut self, wake: &Wake) {
        self.sample.execution_ns = self.clock.now_ns().saturating_sub(wake.woke_ns);
        self.meter.execution.record(self.sample.execution_ns);
    }

    fn hand_over(&mut self) {
        if self.samples.push(self.sample).is_err() {
            self.meter.unrecorded = self.meter.unrecorded.saturating_add(1);
        }
    }

    /// The last sample, with the cause on it; the rig is at 0 V.
    fn end(&mut self, cause: Cause) {
        self.enter(match cause {
            Cause::Over | Cause::Asked => Event::Stop,
            Cause::Fault(_) => Event::Fault,
        });
        self.sample.phase = self.phase;
        // What was sent with this instant's exchange stood for microseconds.
        self.sample.voltage_v = 0.0;
        self.sample.commanded.voltage_v = 0.0;
        self.sample.fault = match cause {
            Cause::Fault(fault) => Some(fault),
            Cause::Over | Cause::Asked => None,
        };
        self.hand_over();
    }
}
