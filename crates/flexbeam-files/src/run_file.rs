//! Recordings of runs: what the real-time loop did, tick by tick, in an MCAP file.
//!
//! Enters: samples, settings, events and a report as they come. Leaves: a file that is whole up to the last flush, whatever
//! happens to the machine, and the same numbers read back to the last bit.
//! Deliberately absent: the clock (the caller passes when the run began), the loop, what a fault's number means.
//!
//! | topic | encoding | what |
//! |---|---|---|
//! | `/signals` | `cdr`, schema `ros2msg` | a [`RunSample`] a tick |
//! | `/settings` | `json` | [`LiveSettings`], at the start and at each change |
//! | `/events` | `json` | a [`RunEvent`] |
//! | `/report` | `json` | one object at the end |
//!
//! The metadata record `flexbeam` holds the [`RunHeader`], an attachment the controller file.

mod fault;
mod file;
mod header;
mod messages;
mod reader;
mod records;
mod sample;
mod stream;
mod stretch;
mod summary;
mod topics;
mod writer;

pub use fault::RunFault;
pub use file::RunFile;
pub use header::{RUN_SCHEMA, RunHeader};
pub use messages::{LiveSettings, RunEvent, RunReference, RunShape, SettingValue};
pub use reader::{CutOff, RunRecording};
pub use sample::{RunColumns, RunPhase, RunSample};
pub use stretch::Stretch;
pub use summary::RunSummary;
pub use topics::RunTopic;
pub use writer::RunWriter;

pub(crate) use header::{RunOrigin, excitation_of_run};
pub(crate) use messages::by_key;
pub(crate) use reader::{each_record, options as reader_options};
pub(crate) use records::is_mcap;
pub(crate) use stream::RunChunks;
