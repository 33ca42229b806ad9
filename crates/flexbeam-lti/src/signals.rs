use crate::{Error, Mat};

/// Sampled signals: a row a channel, a column a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Signals {
    /// Channel names, one a row: `theta`, `voltage`.
    pub names: Vec<String>,
    /// Units, one a row: `rad`, `v`.
    pub units: Vec<String>,
    /// Sample period [s].
    pub period_s: f64,
    /// channels x samples.
    pub data: Mat,
}

impl Signals {
    /// Shapes: `data` has a row for each name and unit.
    ///
    /// Errors: [`Error::Shape`], [`Error::Period`]. Entries may be anything: who uses them judges them.
    pub fn new(names: Vec<String>, units: Vec<String>, period_s: f64, data: Mat) -> Result<Signals, Error> {
        if !(period_s > 0.0 && period_s.is_finite()) {
            return Err(Error::Period { period_s });
        }
        if names.len() != data.nrows() || units.len() != data.nrows() {
            return Err(Error::Shape {
                what: "signals (rows are channels)",
                found_rows: data.nrows(),
                found_columns: data.ncols(),
                needed_rows: names.len().max(units.len()),
                needed_columns: data.ncols(),
            });
        }
        Ok(Signals { names, units, period_s, data })
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.data.nrows()
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.data.ncols()
    }

    /// Row of the channel of that name.
    pub fn row(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }
}
