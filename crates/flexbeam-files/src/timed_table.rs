//! A table with its time axis judged and its period established, as the rows come.

use crate::clock::{Clock, Late, Steps};
use crate::columns::ColumnName;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::recording::{FEWEST_ROWS, Layout, agreed, is_period};
use crate::table::{Rows, Table};
use std::io::Read;
use std::path::{Path, PathBuf};

/// A table that is being read, in seconds.
pub(crate) struct TimedTable<R> {
    table: Table<R>,
    /// The time axis, where there is one, and how many seconds its unit is.
    clock: Option<(Clock, f64)>,
    given_s: Option<f64>,
    samples: usize,
    source: PathBuf,
}

impl<R: Read> TimedTable<R> {
    /// Errors: those of [`Table::open`]; [`Fault::NoSignals`], [`Fault::NoPeriod`], [`Fault::Period`].
    pub fn open(reader: R, source: &Path, layout: &Layout) -> Result<TimedTable<R>, Error> {
        let error = |fault| Error::new(Tried::Read, source, fault);
        let table = Table::open(reader, source, layout.columns.as_deref())?;
        if table.names.is_empty() {
            return Err(error(Fault::NoSignals));
        }
        if let Some(period_s) = layout.period_s.filter(|&period_s| !is_period(period_s)) {
            return Err(error(Fault::Period { period_s }));
        }
        if table.time.is_none() && layout.period_s.is_none() {
            return Err(error(Fault::NoPeriod));
        }
        let steps = if layout.resample_s.is_some() { Steps::NoGaps } else { Steps::Equal };
        let clock = table.time.as_ref().map(|name| {
            let column = ColumnName::of(name);
            (Clock::new(steps), if column.unit == column.si_unit { 1.0 } else { column.si_factor })
        });
        Ok(TimedTable { table, clock, given_s: layout.period_s, samples: 0, source: source.to_path_buf() })
    }

    /// Appends up to `most` rows; how many there were. Fewer are there at the end only.
    ///
    /// Errors: those of a row; those of the time axis.
    pub fn fill(&mut self, most: usize, rows: &mut Rows) -> Result<usize, Error> {
        let mut count = 0;
        while count < most {
            let Some(mark) = self.table.next(rows)? else { break };
            count += 1;
            let Some((clock, factor)) = &mut self.clock else { continue };
            let time_s = rows.time.last_mut().expect("a row has its time");
            if !self.table.is_stamped() {
                *time_s *= *factor;
            }
            clock.take(*time_s, mark).map_err(|late| at(late, &self.source))?;
        }
        self.samples += count;
        if let Some((clock, _)) = &self.clock {
            clock.check().map_err(|late| at(late, &self.source))?;
        }
        Ok(count)
    }

    /// The period, when all rows were read [s].
    ///
    /// Errors: [`Fault::TooFewRows`], [`Fault::PeriodsDiffer`]; those of the time axis.
    pub fn end(&mut self) -> Result<f64, Error> {
        let error = |fault| Error::new(Tried::Read, &self.source, fault);
        if self.samples < FEWEST_ROWS {
            return Err(error(Fault::TooFewRows { found: self.samples, needed: FEWEST_ROWS }));
        }
        match (&mut self.clock, self.given_s) {
            (Some((clock, _)), given_s) => {
                let in_file_s = clock.period_s().map_err(|late| at(late, &self.source))?;
                agreed(in_file_s, given_s).map_err(error)
            }
            (None, Some(given_s)) => Ok(given_s),
            (None, None) => unreachable!("asked when the table was opened"),
        }
    }

    /// Names of the signals, in order.
    pub fn names(&self) -> &[String] {
        &self.table.names
    }

    pub fn has_time(&self) -> bool {
        self.clock.is_some()
    }

    /// Rows so far.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Bytes of the file that were read.
    pub fn bytes_done(&self) -> u64 {
        self.table.bytes_done()
    }

    /// How the file was understood, where a person should know.
    pub fn notice(&self) -> Option<String> {
        let understood = self.table.notice()?;
        Some(format!("{} was read as: {understood}", self.source.display()))
    }
}

fn at((fault, mark): Late, source: &Path) -> Error {
    Error::new(Tried::Read, source, fault).at(mark)
}
