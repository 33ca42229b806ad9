//! Where the recorder brings what the loop says: a file, a view, a viewer's connection.

use crate::back_end::Counters;
use crate::cause::Cause;
use crate::live::Live;
use crate::meter::Meter;
use crate::sample::Sample;

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The loop's clock runs, 0 V.
    Armed,
    /// The controller took over.
    Started,
    /// Ended as asked.
    Stopped,
    /// Ended by a fault.
    Fault,
    /// Something that a person should know, and that ends nothing.
    Warning,
    /// A rule that was set aside by name.
    Override,
    /// Who steers, and what they changed.
    Control,
    /// Periods or measurements that are missing.
    Lost,
}

impl EventKind {
    /// As it stands in a recording.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::Armed => "armed",
            EventKind::Started => "started",
            EventKind::Stopped => "stopped",
            EventKind::Fault => "fault",
            EventKind::Warning => "warning",
            EventKind::Override => "override",
            EventKind::Control => "control",
            EventKind::Lost => "lost",
        }
    }
}

/// Something that happened in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEvent {
    /// Instant at which it happened.
    pub instant: u64,
    /// Kind.
    pub kind: EventKind,
    /// In words.
    pub text: String,
}

/// How a run went.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// Why it ended.
    pub cause: Cause,
    /// The cause in words; of a board, in its own.
    pub text: String,
    /// What the loop measured of itself.
    pub meter: Meter,
    /// What the link lost or threw away.
    pub link: Counters,
    /// What was refused by the system, or set aside by name.
    pub warnings: Vec<String>,
}

/// A sink that takes no more.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{sink}: {reason}")]
pub struct SinkError {
    /// Which one.
    pub sink: String,
    /// What the system said.
    pub reason: String,
    /// Samples that it had taken and could not keep.
    pub lost: u64,
}

/// Takes what the recorder's thread brings. Real-time: no; it may block, the loop does not wait for it.
///
/// After an error a sink gets nothing more.
pub trait Sink: Send {
    /// One tick.
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError>;

    /// Settings that are in force from this instant on.
    fn settings(&mut self, _instant: u64, _live: &Live) -> Result<(), SinkError> {
        Ok(())
    }

    /// Something happened.
    fn event(&mut self, _event: &RunEvent) -> Result<(), SinkError> {
        Ok(())
    }

    /// Several times a second: what was taken must survive a power loss from here on.
    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// The run is over.
    fn finish(&mut self, _report: &RunReport) -> Result<(), SinkError> {
        Ok(())
    }
}
