//! What can be wrong with a recording of a run, as found and needed.

use std::path::PathBuf;

/// What is wrong; every variant carries its numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum RunFault {
    /// An MCAP file without the metadata that a recording of a run has.
    Foreign,
    /// An MCAP file of another program, without numbers that can be read.
    NoNumbers {
        /// Its topics.
        there: String,
    },
    /// An MCAP file of another program with numbers on several topics, each of which keeps its own time.
    Topics {
        /// Its topics.
        there: String,
    },
    /// An MCAP file of another program that cannot be read to its end.
    Unreadable {
        /// In the reader's words.
        what: String,
    },
    /// Bytes that are not what was written, with intact ones after them.
    Damaged {
        /// Where the first of them stand, from 0.
        byte: usize,
        /// What is wrong there.
        what: String,
    },
    /// A run that was cut off, or one that is being recorded now, in the place where a new one is to be written.
    Unfinished {
        /// Its name.
        part: PathBuf,
    },
    /// No stretch without a gap is long enough.
    ShortStretch {
        /// Samples of the longest one.
        found: usize,
        /// The fewest that are of use.
        needed: usize,
    },
    /// Names for the columns of a file whose columns have names.
    Named,
    /// A period to resample a run to, whose ticks are on time.
    OnTime,
}

impl RunFault {
    /// What was found there.
    pub fn found(&self) -> String {
        match self {
            RunFault::Foreign => "an MCAP file that flexbeam did not record".into(),
            RunFault::NoNumbers { there } => {
                format!("an MCAP file that flexbeam did not record, without numbers in JSON: {there}")
            }
            RunFault::Topics { there } => format!("an MCAP file with numbers on several topics: {there}"),
            RunFault::Unreadable { what } => format!("an MCAP file that cannot be read to its end ({what})"),
            RunFault::Damaged { byte, what } => format!("damage at byte {byte} ({what})"),
            RunFault::Unfinished { part } => format!("an unfinished recording, {}", part.display()),
            RunFault::ShortStretch { found, .. } => {
                format!("at most {found} samples in a row while the controller ran")
            }
            RunFault::Named => "names for the columns of an MCAP file".into(),
            RunFault::OnTime => "a period to resample a run to".into(),
        }
    }

    /// What was needed instead.
    pub fn needed(&self) -> String {
        match self {
            RunFault::Foreign => "a recording of a run".into(),
            RunFault::NoNumbers { .. } => "a recording of a run, or a topic of JSON messages with numbers".into(),
            RunFault::Topics { .. } => "one such topic".into(),
            RunFault::Unreadable { .. } => "a whole one, its chunks plain or compressed with LZ4".into(),
            RunFault::Damaged { .. } => "the bytes that were written".into(),
            RunFault::Unfinished { .. } => "that name free".into(),
            RunFault::ShortStretch { needed, .. } => format!("at least {needed}"),
            RunFault::Named => "none: they have names".into(),
            RunFault::OnTime => "none: its ticks are equally far apart".into(),
        }
    }

    /// What the user may do about it.
    pub fn hint(&self) -> String {
        match self {
            RunFault::Foreign => "flexbeam identify and flexbeam export take what numbers it has in JSON".into(),
            RunFault::NoNumbers { .. } => {
                "ROS 2 and Protocol Buffers are not read: write the signals as CSV, with a column time_s".into()
            }
            RunFault::Topics { .. } => "take one out with `mcap filter -y TOPIC in.mcap -o out.mcap`".into(),
            RunFault::Unreadable { .. } => "`mcap recover --compression lz4` saves what is whole".into(),
            RunFault::Damaged { .. } => "copy the file again; the tool `mcap recover` saves what is whole".into(),
            RunFault::Unfinished { .. } => {
                "flexbeam show reads it; rename it to keep it, or remove it, unless a run is writing it now".into()
            }
            RunFault::ShortStretch { .. } => "flexbeam show tells what was missed; record again".into(),
            RunFault::OnTime => "leave --resample out".into(),
            RunFault::Named => "leave --columns out; --inputs and --outputs take the file's names".into(),
        }
    }
}
