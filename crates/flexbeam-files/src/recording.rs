//! Recordings: what was measured on a rig, sample by sample.
//!
//! Enters: text files of any of the kinds that `csv` reads, and recordings of runs. Leaves: [`Recording`], with its period
//! established and its names taken apart. Deliberately absent: filtering, filling of gaps.

use crate::columns::{ColumnName, nearest};
use crate::csv;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::foreign;
use crate::gathered::Gathered;
use crate::hash::sha256_hex;
use crate::mat_file::{self, is_mat};
use crate::resample::{Resampled, resampled};
use crate::run_file::{RunOrigin, RunRecording, is_mcap};
use crate::table::Rows;
use crate::timed_table::TimedTable;
use crate::write::{Overwrite, Written, read_bytes, write_bytes};
use flexbeam_lti::{Mat, Signals};
use std::path::{Path, PathBuf};

/// A period given and the period of the time column agree within this, relative.
///
/// Quartz clocks differ by 1e-4 at most; a wrong period differs by far more.
pub const PERIOD_TOLERANCE: f64 = 1e-3;

/// The fewest rows that are a recording: with two there is one step, and nothing to compare it with.
pub const FEWEST_ROWS: usize = 3;

/// How to read a recording's text; `Layout::default()` is a table with a header and a time column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Names of the columns, in place of a header; `_` leaves a column out. Default: the header's.
    pub columns: Option<Vec<String>>,
    /// Sample period [s]. Default: the time column's.
    pub period_s: Option<f64>,
    /// Period to which jittered samples are interpolated [s]. Default: they are refused.
    pub resample_s: Option<f64>,
}

/// A recording, its period established.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// All columns but time; names as in the file (`theta_rad`), units from the names.
    pub signals: Signals,
    /// The time column [s], where there is one.
    pub time_s: Option<Vec<f64>>,
    /// The file it was read from.
    pub source: PathBuf,
    /// SHA-256 of that file, in hexadecimal.
    pub sha256: String,
    /// What a person should know: of a run with gaps, which part was taken.
    pub notice: Option<String>,
}

impl Recording {
    /// Reads a recording.
    ///
    /// Errors: those of [`read_bytes`] and of [`Recording::parse`].
    pub fn read(path: &Path, layout: &Layout) -> Result<Recording, Error> {
        Recording::parse(&read_bytes(path)?, path, layout)
    }

    /// The recording in `bytes`, CSV or MCAP as their first bytes say; `source` is for messages.
    ///
    /// Of a run it is the longest stretch without a gap while the controller ran.
    ///
    /// Errors: [`Fault::NotText`], those of a table ([`Fault::Empty`], [`Fault::NoHeader`], [`Fault::EmptyName`],
    /// [`Fault::DuplicateName`], [`Fault::NamesAndColumns`], [`Fault::Ragged`], [`Fault::MissingValue`],
    /// [`Fault::NotANumber`], [`Fault::NotFinite`]), [`Fault::TooFewRows`], [`Fault::NoSignals`], and those of the
    /// period ([`Fault::NoPeriod`], [`Fault::Period`], [`Fault::UnequalPeriods`], [`Fault::PeriodsDiffer`]); for a run
    /// those of [`RunRecording::parse`] and [`RunRecording::agreeing_with`], and [`Fault::Run`] with
    /// [`RunFault::ShortStretch`](crate::RunFault::ShortStretch).
    ///
    /// ```
    /// use flexbeam_files::{Layout, Recording};
    /// let text = "time_s,voltage_v,theta_rad\n0.000,1.5,0\n0.002,1.4,1e-3\n0.004,abc,2e-3\n";
    /// let error = Recording::parse(text.as_bytes(), "arm.csv".as_ref(), &Layout::default()).unwrap_err();
    /// assert!(error.to_string().starts_with("cannot read arm.csv:4:7: found \"abc\" in column voltage_v, needed a number"));
    /// let recording = Recording::parse(text.replace("abc", "1.3").as_bytes(), "arm.csv".as_ref(), &Layout::default())?;
    /// assert_eq!(recording.signals.period_s, 0.002);
    /// assert_eq!(recording.select(&["theta_rad"])?.data[(0, 2)], 2e-3);
    /// # Ok::<(), flexbeam_files::Error>(())
    /// ```
    pub fn parse(bytes: &[u8], source: &Path, layout: &Layout) -> Result<Recording, Error> {
        let recording = Recording::as_recorded(bytes, source, layout)?;
        match layout.resample_s {
            Some(period_s) => recording.resampled(period_s),
            None => Ok(recording),
        }
    }

    /// With the steps that the file has.
    fn as_recorded(bytes: &[u8], source: &Path, layout: &Layout) -> Result<Recording, Error> {
        if is_mcap(bytes) && RunOrigin::of(bytes).is_none() {
            return Recording::gathered(foreign::parse(bytes, source)?, bytes, source, layout);
        }
        if is_mcap(bytes) {
            let run = RunRecording::parse(bytes, source)?.agreeing_with(layout)?;
            return Recording::of_run(&run).map_err(|fault| Error::new(Tried::Read, source, fault));
        }
        if is_mat(bytes) {
            return Recording::gathered(mat_file::parse(bytes, source, layout)?, bytes, source, layout);
        }
        let mut table = TimedTable::open(bytes, source, layout)?;
        let mut rows = Rows::default();
        table.fill(usize::MAX, &mut rows)?;
        let period_s = table.end()?;
        let data = Mat::from_vec(table.names().len(), rows.signals.len() / table.names().len(), rows.signals);
        let signals = Signals { names: table.names().to_vec(), units: units_of(table.names()), period_s, data };
        Ok(Recording {
            signals,
            time_s: table.has_time().then_some(rows.time),
            source: source.to_path_buf(),
            sha256: sha256_hex(bytes),
            notice: table.notice(),
        })
    }

    /// On an even clock.
    ///
    /// Errors: [`Fault::NoTime`]; those of [`resampled`].
    fn resampled(self, period_s: f64) -> Result<Recording, Error> {
        let resampled = match &self.time_s {
            Some(time_s) => resampled(&self.signals, time_s, period_s),
            None => Err(Fault::NoTime),
        };
        let Resampled { signals, time_s, notice } =
            resampled.map_err(|fault| Error::new(Tried::Read, &self.source, fault))?;
        let notice = self.notice.iter().cloned().chain([notice]).collect::<Vec<_>>().join("\n");
        Ok(Recording { signals, time_s: Some(time_s), notice: Some(notice), ..self })
    }

    fn gathered(gathered: Gathered, bytes: &[u8], source: &Path, layout: &Layout) -> Result<Recording, Error> {
        Ok(Recording {
            signals: gathered.signals(source, layout)?,
            time_s: gathered.time_s,
            source: source.to_path_buf(),
            sha256: sha256_hex(bytes),
            notice: gathered.notice.map(|notice| format!("{} was read as: {notice}", source.display())),
        })
    }

    /// The longest stretch of a run without a gap.
    fn of_run(run: &RunRecording) -> Result<Recording, Fault> {
        let stretch = run.longest_stretch();
        stretch.check(FEWEST_ROWS)?;
        let notices = run.cut_off_notice().into_iter().chain(stretch.notice(run.header.period_s));
        let notices: Vec<String> = notices.collect();
        Ok(Recording {
            signals: run.signals(stretch.samples.clone()),
            time_s: Some(run.time_s(stretch.samples)),
            source: run.source.clone(),
            sha256: run.sha256.clone(),
            notice: (!notices.is_empty()).then(|| notices.join("\n")),
        })
    }

    /// The channels of these names, in this order.
    ///
    /// Errors: [`Fault::UnknownColumn`], [`Fault::DuplicateName`].
    pub fn select<S: AsRef<str>>(&self, names: &[S]) -> Result<Signals, Error> {
        let rows = rows_of(&self.signals.names, names, &self.source)?;
        Ok(Signals {
            names: rows.iter().map(|&r| self.signals.names[r].clone()).collect(),
            units: rows.iter().map(|&r| self.signals.units[r].clone()).collect(),
            period_s: self.signals.period_s,
            data: self.signals.data.select_rows(&rows),
        })
    }

    /// When the samples were taken: the time column, or k times the period [s].
    pub fn instants_s(&self) -> Vec<f64> {
        let counted = || (0..self.signals.samples() as u64).map(|k| csv::instant(k, self.signals.period_s)).collect();
        self.time_s.clone().unwrap_or_else(counted)
    }

    /// The same recording in SI units: `theta_deg` becomes `theta_rad`, `tip_mm` becomes `tip_m`.
    pub fn into_si(mut self) -> Recording {
        for r in 0..self.signals.channels() {
            let (name, unit, factor) = in_si(&self.signals.names[r]);
            if factor != 1.0 {
                self.signals.data.row_mut(r).scale_mut(factor);
            }
            self.signals.names[r] = name;
            self.signals.units[r] = unit.into();
        }
        self
    }

    /// Writes the recording as CSV.
    ///
    /// Errors: those of [`write_signals`].
    pub fn write(&self, path: &Path, overwrite: Overwrite) -> Result<Written, Error> {
        write_signals(&self.signals, self.time_s.as_deref(), path, overwrite)
    }
}

/// Writes signals as CSV, with `time_s` or with k `period_s` in the first column.
///
/// Shapes: `time_s` has an entry for each sample.
/// Errors: [`Fault::NotFinite`] (what is written can be read), and those of [`write_bytes`].
pub fn write_signals(
    signals: &Signals,
    time_s: Option<&[f64]>,
    path: &Path,
    overwrite: Overwrite,
) -> Result<Written, Error> {
    if let Some(k) = signals.data.iter().position(|x| !x.is_finite()) {
        let (row, sample) = (k % signals.channels(), k / signals.channels());
        let fault = Fault::NotFinite { name: signals.names[row].clone(), text: signals.data[k].to_string() };
        /// Lines before the first sample: the header.
        const HEADER: usize = 1;
        return Err(Error::new(Tried::Write, path, fault).at_line(HEADER + sample + 1));
    }
    write_bytes(path, csv::csv_text(signals, time_s).as_bytes(), overwrite)
}

/// The file's period, or the one that was given where the two agree.
///
/// Errors: [`Fault::Period`], [`Fault::PeriodsDiffer`].
pub(crate) fn agreed(in_file_s: f64, given_s: Option<f64>) -> Result<f64, Fault> {
    match given_s {
        None => Ok(in_file_s),
        Some(period_s) if !is_period(period_s) => Err(Fault::Period { period_s }),
        Some(given_s) if (in_file_s - given_s).abs() > PERIOD_TOLERANCE * given_s => {
            Err(Fault::PeriodsDiffer { in_file_s, given_s, tolerance: PERIOD_TOLERANCE })
        }
        Some(given_s) => Ok(given_s),
    }
}

pub(crate) fn is_period(period_s: f64) -> bool {
    period_s > 0.0 && period_s.is_finite()
}

/// Where the columns of these names stand; a name is found whatever its case, where only one is so called.
///
/// Errors: [`Fault::UnknownColumn`], [`Fault::DuplicateName`].
pub(crate) fn rows_of<S: AsRef<str>>(available: &[String], names: &[S], source: &Path) -> Result<Vec<usize>, Error> {
    let error = |fault| Error::new(Tried::Select, source, fault);
    let row = |name: &S| {
        let name = name.as_ref();
        let alike = || available.iter().enumerate().filter(|(_, other)| other.to_lowercase() == name.to_lowercase());
        let exact = available.iter().position(|other| other == name);
        let found = exact.or_else(|| if alike().count() == 1 { alike().next().map(|(k, _)| k) } else { None });
        found.ok_or_else(|| {
            let (available, nearest) = (available.to_vec(), nearest(name, available));
            error(Fault::UnknownColumn { name: name.into(), available, nearest })
        })
    };
    let rows = names.iter().map(row).collect::<Result<Vec<_>, _>>()?;
    match (0..rows.len()).find(|&k| rows[..k].contains(&rows[k])) {
        Some(k) => Err(error(Fault::DuplicateName { name: names[k].as_ref().into() })),
        None => Ok(rows),
    }
}

/// The units that stand in names.
pub(crate) fn units_of(names: &[String]) -> Vec<String> {
    names.iter().map(|name| ColumnName::of(name).unit.to_string()).collect()
}

/// A column's name in SI units, its unit, and how many of it one of the file's is.
pub(crate) fn in_si(name: &str) -> (String, &'static str, f64) {
    let column = ColumnName::of(name);
    match column.unit == column.si_unit {
        true => (name.into(), column.unit, 1.0),
        false => (format!("{}_{}", column.quantity, column.si_unit), column.si_unit, column.si_factor),
    }
}
