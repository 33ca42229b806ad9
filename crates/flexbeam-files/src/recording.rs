//! Recordings: what was measured on a rig, sample by sample.
//!
//! Enters: text files of any of the kinds that `csv` reads, and recordings of runs. Leaves: [`Recording`], with its period
//! established and its names taken apart. Deliberately absent: filtering, resampling, filling of gaps.

use crate::columns::{ColumnName, nearest};
use crate::csv;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::hash::sha256_hex;
use crate::run_file::{RunRecording, is_mcap};
use crate::write::{Overwrite, Written, read_bytes, write_bytes};
use flexbeam_lti::{Mat, Signals};
use std::path::{Path, PathBuf};

/// Each step of a time column is within this of the median step, relative to it.
///
/// A clock printed with three digits per period jitters by up to 1e-3; a missing sample makes a step of twice the
/// median.
pub const STEP_TOLERANCE: f64 = 1e-2;

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
        if is_mcap(bytes) {
            let run = RunRecording::parse(bytes, source)?.agreeing_with(layout)?;
            return Recording::of_run(&run).map_err(|fault| Error::new(Tried::Read, source, fault));
        }
        let text = decoded(bytes, source)?;
        let table = csv::parse(text, source, layout.columns.as_deref())?;
        let fault = |fault| Error::new(Tried::Read, source, fault);
        let Columns { time_s, names, data } = Columns::of(table).map_err(fault)?;
        let period_s = period(time_s.as_deref(), layout.period_s).map_err(|(f, row)| {
            let line = row.and_then(|row| csv::line_of_row(text, row));
            line.map_or(fault(f.clone()), |line| fault(f).at_line(line))
        })?;
        let units = names.iter().map(|name| ColumnName::of(name).unit.to_string()).collect();
        let signals = Signals { names, units, period_s, data };
        Ok(Recording { signals, time_s, source: source.to_path_buf(), sha256: sha256_hex(bytes), notice: None })
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
        let rows = names.iter().map(|name| self.row(name.as_ref())).collect::<Result<Vec<_>, _>>()?;
        if let Some(k) = (0..rows.len()).find(|&k| rows[..k].contains(&rows[k])) {
            let fault = Fault::DuplicateName { name: names[k].as_ref().into() };
            return Err(Error::new(Tried::Select, &self.source, fault));
        }
        Ok(Signals {
            names: rows.iter().map(|&r| self.signals.names[r].clone()).collect(),
            units: rows.iter().map(|&r| self.signals.units[r].clone()).collect(),
            period_s: self.signals.period_s,
            data: self.signals.data.select_rows(&rows),
        })
    }

    fn row(&self, name: &str) -> Result<usize, Error> {
        self.signals.row(name).ok_or_else(|| {
            let available = self.signals.names.clone();
            let nearest = nearest(name, &available);
            Error::new(Tried::Select, &self.source, Fault::UnknownColumn { name: name.into(), available, nearest })
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
            let name = self.signals.names[r].clone();
            let column = ColumnName::of(&name);
            if column.unit == column.si_unit {
                continue;
            }
            self.signals.data.row_mut(r).scale_mut(column.si_factor);
            self.signals.names[r] = format!("{}_{}", column.quantity, column.si_unit);
            self.signals.units[r] = column.si_unit.into();
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

fn decoded<'a>(bytes: &'a [u8], source: &Path) -> Result<&'a str, Error> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    std::str::from_utf8(bytes).map_err(|error| {
        let readable = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        Error::new(Tried::Read, source, Fault::NotText).at_offset(&readable, readable.len())
    })
}

/// A table's columns, the time axis apart from the others.
struct Columns {
    /// [s]
    time_s: Option<Vec<f64>>,
    names: Vec<String>,
    /// channels x samples.
    data: Mat,
}

impl Columns {
    /// Errors: [`Fault::NoSignals`], [`Fault::TooFewRows`].
    fn of(table: csv::Table) -> Result<Columns, Fault> {
        let csv::Table { mut names, values } = table;
        let width = names.len();
        let time = names.iter().position(|name| ColumnName::of(name).is_time());
        if width == usize::from(time.is_some()) {
            return Err(Fault::NoSignals);
        }
        let samples = values.len() / width;
        if samples < FEWEST_ROWS {
            return Err(Fault::TooFewRows { found: samples, needed: FEWEST_ROWS });
        }
        let Some(t) = time else {
            return Ok(Columns { time_s: None, names, data: Mat::from_vec(width, samples, values) });
        };
        let column = ColumnName::of(&names[t]);
        let in_seconds = |x: f64| if column.unit == column.si_unit { x } else { x * column.si_factor };
        let time_s = values.iter().skip(t).step_by(width).map(|&x| in_seconds(x)).collect();
        let others = values.iter().enumerate().filter(|(k, _)| k % width != t).map(|(_, &x)| x).collect();
        names.remove(t);
        Ok(Columns { time_s: Some(time_s), names, data: Mat::from_vec(width - 1, samples, others) })
    }
}

/// The sample period, from the time column, from what was given, or from both when they agree.
///
/// Errors: the fault and, where one row is to blame, that row.
fn period(time_s: Option<&[f64]>, given_s: Option<f64>) -> Result<f64, (Fault, Option<usize>)> {
    if let Some(period_s) = given_s.filter(|&p| !(p > 0.0 && p.is_finite())) {
        return Err((Fault::Period { period_s }, None));
    }
    let in_file_s = time_s.map(uniform_period).transpose()?;
    match (in_file_s, given_s) {
        (None, None) => Err((Fault::NoPeriod, None)),
        (None, Some(given_s)) => Ok(given_s),
        (Some(in_file_s), given_s) => agreed(in_file_s, given_s).map_err(|fault| (fault, None)),
    }
}

/// The file's period, or the one that was given where the two agree.
///
/// Errors: [`Fault::Period`], [`Fault::PeriodsDiffer`].
pub(crate) fn agreed(in_file_s: f64, given_s: Option<f64>) -> Result<f64, Fault> {
    match given_s {
        None => Ok(in_file_s),
        Some(period_s) if !(period_s > 0.0 && period_s.is_finite()) => Err(Fault::Period { period_s }),
        Some(given_s) if (in_file_s - given_s).abs() > PERIOD_TOLERANCE * given_s => {
            Err(Fault::PeriodsDiffer { in_file_s, given_s, tolerance: PERIOD_TOLERANCE })
        }
        Some(given_s) => Ok(given_s),
    }
}

/// The mean step of a time axis whose steps are all equal within [`STEP_TOLERANCE`].
///
/// Assumes: at least two instants.
/// Numerics: steps are compared with the median step, which a few bad rows do not move, so the first bad row is named.
fn uniform_period(time_s: &[f64]) -> Result<f64, (Fault, Option<usize>)> {
    let steps = || time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let mut sorted: Vec<f64> = steps().collect();
    let middle = sorted.len() / 2;
    let needed_s = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    let unequal = |found_s: f64| Fault::UnequalPeriods { found_s, needed_s, tolerance: STEP_TOLERANCE };
    let bad = |step: &f64| !(needed_s > 0.0 && (step - needed_s).abs() <= STEP_TOLERANCE * needed_s);
    if let Some((k, step)) = steps().enumerate().find(|(_, step)| bad(step)) {
        return Err((unequal(step), Some(k + 1)));
    }
    Ok(shortest_near((time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64))
}

/// The decimal number with fewest digits within 1e-12 of `x`, relative: 0.001 for 0.0010000000000000002.
///
/// 1e-12 is what `flexbeam_lti::Time` takes for equal.
fn shortest_near(x: f64) -> f64 {
    let rounded = (0..=16).map(|digits| format!("{x:.digits$e}").parse::<f64>().unwrap_or(x));
    rounded.into_iter().find(|r| (r - x).abs() <= 1e-12 * x.abs()).unwrap_or(x)
}
