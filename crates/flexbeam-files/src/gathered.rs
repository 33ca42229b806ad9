//! Columns gathered from a file that is no table: their time axis judged, their period established.

use crate::clock::{Clock, Steps};
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::recording::{FEWEST_ROWS, Layout, agreed, is_period, units_of};
use crate::table::Mark;
use flexbeam_lti::{Mat, Signals};
use std::path::Path;

/// Columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gathered {
    pub names: Vec<String>,
    /// Each as long as the others.
    pub columns: Vec<Vec<f64>>,
    /// As long as the columns [s].
    pub time_s: Option<Vec<f64>>,
    /// A period that stands in the file [s].
    pub period_s: Option<f64>,
    /// How the file was understood, where a person should know.
    pub notice: Option<String>,
}

impl Gathered {
    /// The signals. Samples count as lines do, from 1.
    ///
    /// Errors: [`Fault::NotFinite`], [`Fault::TooFewRows`], [`Fault::NoSignals`], [`Fault::NoPeriod`], [`Fault::Period`],
    /// [`Fault::PeriodsDiffer`]; those of a time axis.
    pub fn signals(&self, source: &Path, layout: &Layout) -> Result<Signals, Error> {
        let error = |fault| Error::new(Tried::Read, source, fault);
        let samples = self.columns.first().ok_or_else(|| error(Fault::NoSignals))?.len();
        if samples < FEWEST_ROWS {
            return Err(error(Fault::TooFewRows { found: samples, needed: FEWEST_ROWS }));
        }
        let period_s = self.period(layout).map_err(|(fault, mark)| match mark {
            Some(mark) => error(fault).at_line(mark.line),
            None => error(fault),
        })?;
        let time = self.time_s.as_ref().map(|time_s| ("time", time_s));
        let all = self.names.iter().map(String::as_str).zip(&self.columns).chain(time);
        let wrong = all.filter_map(|(name, column)| Some((column.iter().position(|x| !x.is_finite())?, name, column)));
        if let Some((k, name, column)) = wrong.min_by_key(|(k, ..)| *k) {
            return Err(error(Fault::NotFinite { name: name.into(), text: column[k].to_string() }).at_line(k + 1));
        }
        let data = Mat::from_fn(self.columns.len(), samples, |r, k| self.columns[r][k]);
        Ok(Signals { names: self.names.clone(), units: units_of(&self.names), period_s, data })
    }

    fn period(&self, layout: &Layout) -> Result<f64, (Fault, Option<Mark>)> {
        let place = |fault| (fault, None);
        if let Some(period_s) = layout.period_s.or(self.period_s).filter(|&period_s| !is_period(period_s)) {
            return Err(place(Fault::Period { period_s }));
        }
        let in_file_s = match (&self.time_s, self.period_s) {
            (Some(time_s), _) => {
                let mut clock = Clock::new(if layout.resample_s.is_some() { Steps::NoGaps } else { Steps::Equal });
                let late = |(fault, mark)| (fault, Some(mark));
                for (k, time_s) in time_s.iter().enumerate().filter(|(_, time_s)| time_s.is_finite()) {
                    clock.take(*time_s, Mark { line: k + 1, byte: 0 }).map_err(late)?;
                }
                clock.period_s().map_err(late)?
            }
            (None, Some(period_s)) => period_s,
            (None, None) => return layout.period_s.ok_or(place(Fault::NoPeriod)),
        };
        agreed(in_file_s, layout.period_s).map_err(place)
    }
}
