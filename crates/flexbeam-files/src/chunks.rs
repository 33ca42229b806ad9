//! A recording in chunks: of any length, in memory that does not depend on it. MATLAB's
//! files, foreign MCAP files and what is to be resampled are held whole.
//!
//! Enters: a file. Leaves: channels x samples, one piece after the other, the same numbers to the last bit as
//! [`Recording::read`](crate::Recording::read) gives at once; at the end the period.
//! Deliberately absent: what is done with them.

use crate::error::{Error, Tried};
use crate::mat_file::is_mat;
use crate::recording::{Layout, Recording, in_si, rows_of, units_of};
use crate::run_file::{RunChunks, RunFault, is_mcap};
use crate::table::Rows;
use crate::timed_table::TimedTable;
use crate::write::refused;
use flexbeam_lti::Mat;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// Samples of a chunk: with three channels less than a megabyte, so that chunk and factor stay in the cache.
pub const CHUNK_SAMPLES: usize = 1 << 15;

/// A recording that is being read: an iterator over matrices, channels x samples, each but the last of the same width.
///
/// After an error there is nothing more.
pub struct Chunks {
    from: From,
    /// Channels in the file.
    channels: usize,
    names: Vec<String>,
    units: Vec<String>,
    /// For each channel its column in the file, and the factor that makes it SI.
    taken: Vec<(usize, f64)>,
    width: usize,
    bytes: u64,
    period_s: Option<f64>,
    over: bool,
    source: PathBuf,
}

impl Chunks {
    /// Opens a recording; names are settled, no row is read yet.
    ///
    /// Errors: [`Fault::NoFile`](crate::Fault::NoFile) and its like; those of the names and of the period that do not need the rows.
    pub fn open(path: &Path, layout: &Layout) -> Result<Chunks, Error> {
        let (from, bytes) = From::open(path, layout)?;
        let names = from.names();
        Ok(Chunks {
            channels: names.len(),
            units: units_of(&names),
            taken: (0..names.len()).map(|k| (k, 1.0)).collect(),
            names,
            from,
            width: CHUNK_SAMPLES,
            bytes,
            period_s: None,
            over: false,
            source: path.to_path_buf(),
        })
    }

    /// The same in SI units: `theta_deg` becomes `theta_rad`.
    pub fn in_si(mut self) -> Chunks {
        for (k, (_, factor)) in self.taken.iter_mut().enumerate() {
            let (name, unit, si_factor) = in_si(&self.names[k]);
            (self.names[k], self.units[k]) = (name, unit.into());
            *factor *= si_factor;
        }
        self
    }

    /// The channels of these names, in this order.
    ///
    /// Errors: [`Fault::UnknownColumn`](crate::Fault::UnknownColumn), [`Fault::DuplicateName`](crate::Fault::DuplicateName).
    pub fn select<S: AsRef<str>>(self, names: &[S]) -> Result<Chunks, Error> {
        let rows = rows_of(&self.names, names, &self.source)?;
        Ok(Chunks {
            names: rows.iter().map(|&r| self.names[r].clone()).collect(),
            units: rows.iter().map(|&r| self.units[r].clone()).collect(),
            taken: rows.iter().map(|&r| self.taken[r]).collect(),
            ..self
        })
    }

    /// The same in chunks of so many samples; at least one.
    pub fn of_width(self, samples: usize) -> Chunks {
        Chunks { width: samples.max(1), ..self }
    }

    /// Names of the channels.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Units of the channels.
    pub fn units(&self) -> &[String] {
        &self.units
    }

    /// The sample period [s]: known when all chunks were read without an error.
    pub fn period_s(&self) -> Option<f64> {
        self.period_s
    }

    /// Samples so far.
    pub fn samples(&self) -> usize {
        match &self.from {
            From::Table(table) => table.samples(),
            From::Run(run) => run.samples(),
            From::Whole(_, given) => *given,
        }
    }

    /// Bytes that were read, of how many.
    pub fn progress(&self) -> (u64, u64) {
        let done = match &self.from {
            From::Table(table) => table.bytes_done(),
            From::Run(run) => run.bytes_done(),
            From::Whole(..) => self.bytes,
        };
        (done, self.bytes)
    }

    /// How the file was understood, where a person should know.
    pub fn notice(&self) -> Option<String> {
        match &self.from {
            From::Table(table) => table.notice(),
            From::Run(run) => run.notice(),
            From::Whole(recording, _) => recording.notice.clone(),
        }
    }

    fn chunk(&mut self) -> Result<Option<Mat>, Error> {
        // A width beyond the file's length must not fill memory before a row is read.
        let room = self.width.min(CHUNK_SAMPLES);
        let mut rows = Rows::with_capacity(room, self.channels);
        let count = self.from.fill(self.width, &mut rows)?;
        if count < self.width {
            self.over = true;
            self.period_s = Some(self.from.end()?);
        }
        Ok((count > 0).then(|| self.taken_from(rows.signals, count)))
    }

    fn taken_from(&self, rows: Vec<f64>, count: usize) -> Mat {
        let channels = self.channels;
        let all = self.taken.iter().enumerate().all(|(k, taken)| *taken == (k, 1.0));
        if all && self.taken.len() == channels {
            return Mat::from_vec(channels, count, rows);
        }
        Mat::from_fn(self.taken.len(), count, |r, k| {
            let (column, factor) = self.taken[r];
            rows[k * channels + column] * factor
        })
    }
}

impl Iterator for Chunks {
    type Item = Result<Mat, Error>;

    fn next(&mut self) -> Option<Result<Mat, Error>> {
        if self.over {
            return None;
        }
        self.chunk().inspect_err(|_| self.over = true).transpose()
    }
}

/// What is read.
enum From {
    Table(Box<TimedTable<File>>),
    Run(Box<RunChunks>),
    /// Held in memory, with the number of samples given: a MATLAB file, which holds 4 GB at most, a foreign MCAP file, or what is
    /// to be resampled.
    Whole(Box<Recording>, usize),
}

impl From {
    /// The file as its first bytes say, and how long it is.
    fn open(path: &Path, layout: &Layout) -> Result<(From, u64), Error> {
        let no_file = |error| refused(Tried::Read, path, &error);
        let mut file = File::open(path).map_err(no_file)?;
        let bytes = file.metadata().map_err(no_file)?.len();
        let mut first = Vec::new();
        (&file).take(FIRST_BYTES).read_to_end(&mut first).map_err(no_file)?;
        file.rewind().map_err(no_file)?;
        let from = if layout.resample_s.is_some() {
            // The polynomials look ahead and behind.
            From::whole(path, layout)?
        } else if is_mcap(&first) {
            From::mcap(path, layout)?
        } else if is_mat(&first) {
            From::whole(path, layout)?
        } else {
            From::Table(Box::new(TimedTable::open(file, path, layout)?))
        };
        Ok((from, bytes))
    }

    fn mcap(path: &Path, layout: &Layout) -> Result<From, Error> {
        match RunChunks::open(path, layout) {
            Err(error) if *error.fault == RunFault::Foreign.into() => From::whole(path, layout),
            run => Ok(From::Run(Box::new(run?))),
        }
    }

    fn whole(path: &Path, layout: &Layout) -> Result<From, Error> {
        Ok(From::Whole(Box::new(Recording::read(path, layout)?), 0))
    }

    fn names(&self) -> Vec<String> {
        match self {
            From::Table(table) => table.names().to_vec(),
            From::Run(_) => RunChunks::names(),
            From::Whole(recording, _) => recording.signals.names.clone(),
        }
    }

    fn fill(&mut self, most: usize, rows: &mut Rows) -> Result<usize, Error> {
        match self {
            From::Table(table) => table.fill(most, rows),
            From::Run(run) => run.fill(most, rows),
            From::Whole(recording, given) => {
                let count = most.min(recording.signals.samples() - *given);
                rows.signals.extend(recording.signals.data.columns(*given, count).iter());
                *given += count;
                Ok(count)
            }
        }
    }

    fn end(&mut self) -> Result<f64, Error> {
        match self {
            From::Table(table) => table.end(),
            From::Run(run) => Ok(run.period_s()),
            From::Whole(recording, _) => Ok(recording.signals.period_s),
        }
    }
}

/// Bytes that tell what a file is.
const FIRST_BYTES: u64 = 1024;
