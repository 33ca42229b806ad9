//! What can be wrong with the spelling and the clock of a table, as found and needed.

use super::lines::LONGEST_LINE;
use crate::fault::{Fault, six_digits};

/// What is wrong; every variant carries its numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum TableFault {
    /// A decimal comma in a table with decimal points, or the other way round.
    MixedDecimals {
        /// The column's name.
        name: String,
        /// The cell.
        text: String,
    },
    /// A line beyond what is read.
    LongLine,
    /// Time stamps that are not equally far apart, though none is missing.
    Jitter {
        /// The step that is farthest off [s].
        found_s: f64,
        /// The median step [s].
        needed_s: f64,
        /// Relative tolerance.
        tolerance: f64,
        /// Steps beyond it.
        bad: usize,
        /// Steps that were looked at.
        steps: usize,
        /// Root mean square of all steps' deviation from the median, relative to it.
        rms: f64,
    },
    /// A period to resample to that is far from the mean step.
    FarPeriod {
        /// The period [s].
        period_s: f64,
        /// The shortest that is taken [s].
        least_s: f64,
        /// The longest [s].
        most_s: f64,
    },
}

impl TableFault {
    /// What was found there.
    pub fn found(&self) -> String {
        match self {
            TableFault::MixedDecimals { name, text } => {
                format!("{text:?} in column {name}, after numbers with the other decimal sign")
            }
            TableFault::LongLine => "no end of this line".into(),
            TableFault::Jitter { found_s, needed_s, bad, steps, rms, .. } => format!(
                "unequal sample periods: {bad} of {steps} steps are off, the largest by {:.2} % ({} s to this row from the one \
                 before), {:.2} % rms",
                100.0 * (found_s / needed_s - 1.0),
                six_digits(*found_s),
                100.0 * rms
            ),
            TableFault::FarPeriod { period_s, .. } => format!("a period of {period_s} s to resample to"),
        }
    }

    /// What was needed instead.
    pub fn needed(&self) -> String {
        match self {
            TableFault::MixedDecimals { .. } => "decimal points or decimal commas, not both".into(),
            TableFault::LongLine => format!("lines of at most {LONGEST_LINE} bytes"),
            TableFault::Jitter { needed_s, tolerance, .. } => {
                format!("{} s within {} %", six_digits(*needed_s), 100.0 * tolerance)
            }
            TableFault::FarPeriod { least_s, most_s, .. } => {
                format!("{} to {} s, near the mean step", six_digits(*least_s), six_digits(*most_s))
            }
        }
    }

    /// What the user may do about it.
    pub fn hint(&self) -> String {
        match self {
            TableFault::MixedDecimals { .. } => "write 0.5 throughout, and no signs between thousands".into(),
            TableFault::LongLine => "is it the right file? A row stands in a line".into(),
            TableFault::Jitter { needed_s, .. } => {
                let period_s = two_digits(*needed_s);
                format!("record on a clock; or --resample {period_s} interpolates, and states what that costs")
            }
            TableFault::FarPeriod { .. } => "longer periods need a filter first, shorter ones make samples up".into(),
        }
    }
}

/// A period that a person would choose near this one.
fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

impl From<TableFault> for Fault {
    fn from(fault: TableFault) -> Fault {
        Fault::Table(fault)
    }
}
