//! Rigs and clocks for the loop's tests.
#![allow(dead_code, reason = "each test uses a part")]

use flexbeam_kernel::Settings;
use flexbeam_rig::{Measurement, RigParameters, SimulatedRig};
use flexbeam_runtime::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use flexbeam_runtime::{
    Clock, ControllerData, Live, Reference, RunEvent, RunReport, Sample, Session, Setup, Sink, SinkError,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// A clock whose sleeps take no time; `late_ns` is added to the sleeps that it names.
#[derive(Clone, Default)]
pub struct Virtual {
    pub now_ns: u64,
    pub sleeps: u64,
    /// (sleep, how late [ns]).
    pub late_ns: Vec<(u64, u64)>,
}

impl Clock for Virtual {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }
    fn sleep_until(&mut self, deadline_ns: u64) {
        let late = self.late_ns.iter().find(|(sleep, _)| *sleep == self.sleeps).map_or(0, |late| late.1);
        self.now_ns = self.now_ns.max(deadline_ns) + late;
        self.sleeps += 1;
    }
}

/// Sleeps of the dry run at a period of 1 ms, before the loop's own.
pub const DRY_SLEEPS: u64 = 200;

/// What reached the rig, in order; `zero` is logged as instant `None`.
pub type Log = Arc<Mutex<Vec<(Option<u64>, f64)>>>;

/// What a rig is to do at an instant, with a voltage.
type Script = Box<dyn FnMut(u64, f64) -> Result<Answer, LinkFault> + Send>;

/// A rig that follows a script and logs every voltage.
pub struct Scripted {
    pub log: Log,
    pub script: Script,
    pub cut: Arc<AtomicBool>,
}

struct Cut {
    log: Log,
    cut: Arc<AtomicBool>,
}

impl Cutoff for Cut {
    fn cut(&self) {
        self.cut.store(true, Ordering::SeqCst);
        self.log.lock().unwrap().push((None, 0.0));
    }
}

impl Scripted {
    pub fn new(mut script: impl FnMut(u64) -> Result<Answer, LinkFault> + Send + 'static) -> Scripted {
        Scripted::with_voltage(move |instant, _| script(instant))
    }

    pub fn with_voltage(script: impl FnMut(u64, f64) -> Result<Answer, LinkFault> + Send + 'static) -> Scripted {
        Scripted { log: Log::default(), script: Box::new(script), cut: Arc::default() }
    }
}

impl BackEnd for Scripted {
    fn exchange(&mut self, instant: u64, voltage_v: f64) -> Result<Answer, LinkFault> {
        if self.cut.load(Ordering::SeqCst) {
            return Err(LinkFault::CutOff);
        }
        self.log.lock().unwrap().push((Some(instant), voltage_v));
        (self.script)(instant, voltage_v)
    }
    fn zero(&mut self) -> Result<(), LinkFault> {
        self.log.lock().unwrap().push((None, 0.0));
        Ok(())
    }
    fn prepare(&mut self, _timing: Timing) -> Result<(), OpenError> {
        Ok(())
    }
    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        Some(Box::new(Cut { log: self.log.clone(), cut: self.cut.clone() }))
    }
    fn counters(&self) -> Counters {
        Counters::default()
    }
    fn name(&self) -> String {
        "scripted".into()
    }
}

/// A rig that answers as the simulated one does.
pub fn simulated(seed: u64) -> SimulatedRig {
    SimulatedRig::new(&RigParameters::default(), seed).unwrap()
}

pub fn still() -> Answer {
    Answer::Fresh(Measurement { theta_rad: 0.0, alpha_rad: 0.0 })
}

/// Readings of which no two are alike.
pub fn alive(instant: u64) -> Answer {
    Answer::Fresh(Measurement { theta_rad: 1e-6 * (instant % 1000) as f64, alpha_rad: 0.0 })
}

/// Everything a sink hears.
#[derive(Default)]
pub struct Heard {
    pub samples: Vec<Sample>,
    pub settings: Vec<(u64, Live)>,
    pub events: Vec<RunEvent>,
    pub flushes: usize,
    pub reports: Vec<RunReport>,
}

#[derive(Clone, Default)]
pub struct Ear(pub Arc<Mutex<Heard>>);

impl Sink for Ear {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.lock().unwrap().samples.push(*sample);
        Ok(())
    }
    fn settings(&mut self, instant: u64, live: &Live) -> Result<(), SinkError> {
        self.0.lock().unwrap().settings.push((instant, live.clone()));
        Ok(())
    }
    fn event(&mut self, event: &RunEvent) -> Result<(), SinkError> {
        self.0.lock().unwrap().events.push(event.clone());
        Ok(())
    }
    fn flush(&mut self) -> Result<(), SinkError> {
        self.0.lock().unwrap().flushes += 1;
        Ok(())
    }
    fn finish(&mut self, report: &RunReport) -> Result<(), SinkError> {
        self.0.lock().unwrap().reports.push(report.clone());
        Ok(())
    }
}

/// A first set with the reference as the voltage [V].
pub fn constant(voltage_v: f64) -> Live {
    let settings = Settings { deflection_limit_rad: 0.5, ..Settings::default() };
    let reference = Reference { amplitude_rad: voltage_v, delay_s: 0.0, ..Reference::default() };
    Live { revision: 0, settings, reference }
}

/// u = v at 1 kHz.
pub fn open_loop(voltage_v: f64) -> Setup {
    Setup::new(ControllerData::pass_through(), constant(voltage_v), 1e-3)
}

/// Arms on a virtual clock with an ear.
pub fn armed(back_end: impl BackEnd + 'static, setup: Setup, clock: Virtual) -> (Session, Ear) {
    let ear = Ear::default();
    let session = Session::arm_on(clock, Box::new(back_end), setup, vec![Box::new(ear.clone())]).unwrap();
    (session, ear)
}
