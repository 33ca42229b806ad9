//! The recorder's thread: it empties the ring that the loop fills and brings every sample to every sink.
//!
//! Nothing here can hold the loop up: a full ring loses samples, which the loop counts.

use crate::cause::Cause;
use crate::lifecycle::Phase;
use crate::live::LiveControl;
use crate::sample::Sample;
use crate::sink::{EventKind, RunEvent, RunReport, Sink, SinkError};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// How often the ring is emptied; it holds seconds.
const PAUSE: Duration = Duration::from_millis(5);
/// How often the sinks are told to make it last.
const FLUSH: Duration = Duration::from_millis(500);

/// What other threads tell the recorder.
#[derive(Debug)]
pub(crate) enum Message {
    /// Happened now.
    Event(EventKind, String),
    Over(Box<RunReport>),
}

/// The recorder: what it reads, what it brings it to.
pub(crate) struct Recorder {
    samples: rtrb::Consumer<Sample>,
    messages: Receiver<Message>,
    live: LiveControl,
    sinks: Vec<Box<dyn Sink>>,
    failures: Vec<SinkError>,
    /// Revision of the settings that the sinks know.
    known: Option<u32>,
    last: Sample,
    /// Samples that came after a sink had failed.
    refused: u64,
}

/// What the recorder has to say at the end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    /// Sinks that failed on the way.
    pub failures: Vec<SinkError>,
    /// Samples that a failed sink did not get, or could not keep.
    pub refused: u64,
}

impl Recorded {
    /// Of a recorder that died: how much it kept nobody knows.
    pub(crate) fn lost() -> Recorded {
        let reason = "its thread panicked, which is a bug of flexbeam".into();
        Recorded { failures: vec![SinkError { sink: "the recorder".into(), reason, lost: 0 }], refused: 0 }
    }
}

impl Recorder {
    pub(crate) fn new(
        samples: rtrb::Consumer<Sample>,
        messages: Receiver<Message>,
        live: LiveControl,
        sinks: Vec<Box<dyn Sink>>,
    ) -> Recorder {
        let last = Sample::default();
        Recorder { samples, messages, live, sinks, failures: Vec::new(), known: None, last, refused: 0 }
    }

    /// Real-time: no. Until the loop is over and the ring is empty.
    pub(crate) fn run(mut self) -> Recorded {
        let mut flushed = Instant::now();
        loop {
            let message = self.messages.recv_timeout(PAUSE);
            self.drain();
            match message {
                Ok(Message::Event(kind, text)) => self.event(kind, text),
                Ok(Message::Over(report)) => return self.finish(&report),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.result(),
            }
            if flushed.elapsed() >= FLUSH {
                self.all(&mut |sink| sink.flush());
                flushed = Instant::now();
            }
        }
    }

    fn drain(&mut self) {
        while let Ok(sample) = self.samples.pop() {
            self.bring(&sample);
        }
    }

    fn bring(&mut self, sample: &Sample) {
        let before = std::mem::replace(&mut self.last, *sample).phase;
        self.note_phase(before, sample.phase);
        self.note_settings(sample);
        self.refused += self.failures.len() as u64;
        self.all(&mut |sink| sink.sample(sample));
    }

    fn note_phase(&mut self, before: Phase, now: Phase) {
        if before == Phase::Configured && now == Phase::Armed {
            self.event(EventKind::Armed, "the clock runs, 0 V".into());
        } else if before != Phase::Running && now == Phase::Running {
            self.event(EventKind::Started, "the controller drives the rig".into());
        }
    }

    fn note_settings(&mut self, sample: &Sample) {
        if self.known == Some(sample.revision) || !sample.phase.is_alive() {
            return;
        }
        self.known = Some(sample.revision);
        if let Some(live) = self.live.recorded(sample.revision) {
            self.all(&mut |sink| sink.settings(sample.instant, &live));
        }
    }

    fn finish(mut self, report: &RunReport) -> Recorded {
        let kind = match report.cause {
            Cause::Over | Cause::Asked => EventKind::Stopped,
            Cause::Fault(_) => EventKind::Fault,
        };
        self.event(kind, report.text.clone());
        self.all(&mut |sink| sink.finish(report));
        self.result()
    }

    fn result(self) -> Recorded {
        Recorded { failures: self.failures, refused: self.refused }
    }

    fn event(&mut self, kind: EventKind, text: String) {
        let event = RunEvent { instant: self.last.instant, kind, text };
        self.all(&mut |sink| sink.event(&event));
    }

    /// Does it to every sink; one that fails goes, and the others hear of it.
    fn all(&mut self, what: &mut dyn FnMut(&mut dyn Sink) -> Result<(), SinkError>) {
        let mut failed = Vec::new();
        self.sinks.retain_mut(|sink| caught(|| what(sink.as_mut())).map_err(|error| failed.push(error)).is_ok());
        for error in failed {
            self.refused += error.lost;
            self.failures.push(error.clone());
            self.event(EventKind::Warning, error.to_string());
        }
    }
}

/// A sink that panics has failed; the others and the run go on.
fn caught(what: impl FnOnce() -> Result<(), SinkError>) -> Result<(), SinkError> {
    let panicked =
        |_| Err(SinkError { sink: "a sink".into(), reason: "it panicked, which is a bug of flexbeam".into(), lost: 1 });
    catch_unwind(AssertUnwindSafe(what)).unwrap_or_else(panicked)
}
