//! Matrices in files: arrays of rows.

use crate::fault::Fault;
use crate::misfit::Misfit;
use flexbeam_lti::{C64, Mat, StateSpace, Time};
use serde::{Deserialize, Serialize};

/// A matrix as an array of rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Rows(pub Vec<Vec<f64>>);

impl Rows {
    /// The matrix with this many columns (an array without rows does not say how many it has).
    ///
    /// An entry that is not there becomes NaN, which [`StateSpace::new`] refuses; a document that was read has none.
    pub fn to_mat(&self, columns: usize) -> Mat {
        Mat::from_fn(self.0.len(), columns, |r, c| self.0[r].get(c).copied().unwrap_or(f64::NAN))
    }

    /// Number of entries of the first row, 0 without rows.
    pub fn columns(&self) -> usize {
        self.0.first().map_or(0, Vec::len)
    }

    /// Errors: [`Fault::Shape`] when the number of rows or the first row's length is wrong, [`Fault::Length`] of a
    /// row that differs from the first.
    pub(crate) fn check(&self, rows: usize, columns: usize) -> Result<(), Misfit> {
        if self.0.len() != rows || (rows > 0 && self.columns() != columns) {
            return Err(Misfit::new(Fault::Shape {
                key: String::new(),
                found_rows: self.0.len(),
                found_columns: self.columns(),
                needed_rows: rows,
                needed_columns: columns,
            }));
        }
        match self.0.iter().position(|row| row.len() != columns) {
            Some(r) => Err(length(self.0[r].len(), columns).in_entry(r)),
            None => Ok(()),
        }
    }
}

impl From<&Mat> for Rows {
    fn from(M: &Mat) -> Rows {
        Rows(M.row_iter().map(|row| row.iter().copied().collect()).collect())
    }
}

fn length(found: usize, needed: usize) -> Misfit {
    Misfit::new(Fault::Length { key: String::new(), found, needed })
}

/// A, B, C, D in a table of their own.
///
/// Shapes: A n*n, B n*m, C l*n, D l*m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Matrices {
    /// State matrix.
    pub A: Rows,
    /// Input matrix.
    pub B: Rows,
    /// Output matrix.
    pub C: Rows,
    /// Feedthrough.
    pub D: Rows,
}

impl Matrices {
    /// The system with these matrices.
    ///
    /// Errors: those of [`StateSpace::new`]; none for matrices that came out of a file.
    pub fn state_space(&self, time: Time) -> Result<StateSpace, flexbeam_lti::Error> {
        let (n, m) = (self.A.0.len(), self.D.columns());
        StateSpace::new(self.A.to_mat(n), self.B.to_mat(m), self.C.to_mat(n), self.D.to_mat(m), time)
    }

    /// Shapes that fit `inputs` and `outputs`.
    pub(crate) fn check(&self, inputs: usize, outputs: usize) -> Result<(), Misfit> {
        let n = self.A.0.len();
        self.A.check(n, n).map_err(|misfit| misfit.under("A"))?;
        self.B.check(n, inputs).map_err(|misfit| misfit.under("B"))?;
        self.C.check(outputs, n).map_err(|misfit| misfit.under("C"))?;
        self.D.check(outputs, inputs).map_err(|misfit| misfit.under("D"))
    }
}

impl From<&StateSpace> for Matrices {
    fn from(G: &StateSpace) -> Matrices {
        Matrices { A: (&G.A).into(), B: (&G.B).into(), C: (&G.C).into(), D: (&G.D).into() }
    }
}

/// Complex numbers as pairs [re, im].
pub fn pairs(numbers: &[C64]) -> Vec<[f64; 2]> {
    numbers.iter().map(|z| [z.re, z.im]).collect()
}
