//! A recording in chunks: of any length, in memory that does not depend on it.
//!
//! Enters: a file. Leaves: channels x samples, one piece after the other, the same numbers to the last bit as
//! [`Recording::read`](crate::Recording::read) gives at once; at the end the period.
//! Deliberately absent: what is done with them.

use crate::error::{Error, Tried};
use crate::recording::{Layout, in_si, rows_of, units_of};
use crate::table::Rows;
use crate::timed_table::TimedTable;
use crate::write::refused;
use flexbeam_lti::Mat;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Samples of a chunk: with three channels less than a megabyte, so that chunk and factor stay in the cache.
pub const CHUNK_SAMPLES: usize = 1 << 15;

/// A recording that is being read: an iterator over matrices, channels x samples, each but the last of the same width.
///
/// After an error there is nothing more.
pub struct Chunks {
    table: TimedTable<File>,
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
        let no_file = |error| refused(Tried::Read, path, &error);
        let file = File::open(path).map_err(no_file)?;
        let bytes = file.metadata().map_err(no_file)?.len();
        let table = TimedTable::open(file, path, layout)?;
        let names = table.names().to_vec();
        Ok(Chunks {
            units: units_of(&names),
            taken: (0..names.len()).map(|k| (k, 1.0)).collect(),
            names,
            table,
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
        self.table.samples()
    }

    /// Bytes that were read, of how many.
    pub fn progress(&self) -> (u64, u64) {
        (self.table.bytes_done(), self.bytes)
    }

    /// How the file was understood, where a person should know.
    pub fn notice(&self) -> Option<String> {
        self.table.notice()
    }

    fn chunk(&mut self) -> Result<Option<Mat>, Error> {
        let mut rows = Rows::default();
        let count = self.table.fill(self.width, &mut rows)?;
        if count < self.width {
            self.over = true;
            self.period_s = Some(self.table.end()?);
        }
        Ok((count > 0).then(|| self.taken_from(rows.signals, count)))
    }

    fn taken_from(&self, rows: Vec<f64>, count: usize) -> Mat {
        let channels = self.table.names().len();
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
