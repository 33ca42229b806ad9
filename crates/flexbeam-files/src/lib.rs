//! The files of flexbeam: recordings, models, controllers, certificates, projects, and where they came from.
//!
//! Enters: paths, bytes and plain values with units in their names. Leaves: the same, checked and located: a fault
//! names the file, the line and the column, what was found and what was needed.
//! Deliberately absent: mathematics, the rig, the clock.
//!
//! This is the only crate that derives serde; JSON answers are plain types of this crate, too.

mod columns;
mod csv;
mod error;
mod fault;
mod hash;
mod recording;
mod write;

pub use columns::ColumnName;
pub use csv::{LEFT_OUT, csv_text};
pub use error::{Error, Place, Tried};
pub use fault::Fault;
pub use hash::sha256_hex;
pub use recording::{FEWEST_ROWS, Layout, PERIOD_TOLERANCE, Recording, STEP_TOLERANCE, write_signals};
pub use write::{Overwrite, Written, check_free, read_bytes, write_bytes};
