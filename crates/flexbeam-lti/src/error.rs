use crate::Time;

/// Why a question about a linear system cannot be answered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Matrices whose shapes do not fit together.
    #[error("{what}: found {found_rows} x {found_columns}, needed {needed_rows} x {needed_columns}")]
    Shape {
        /// Which matrix, in which role.
        what: &'static str,
        /// Rows found.
        found_rows: usize,
        /// Columns found.
        found_columns: usize,
        /// Rows needed.
        needed_rows: usize,
        /// Columns needed.
        needed_columns: usize,
    },
    /// An entry that is infinite or not a number.
    #[error("{what}({row},{column}) is {value}; a system has finite entries")]
    NotFinite {
        /// Which matrix.
        what: &'static str,
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// The entry found.
        value: f64,
    },
    /// Two time axes that cannot be mixed.
    #[error("{left} and {right} cannot be connected; resample one of the two")]
    TimeMismatch {
        /// The first system's time.
        left: Time,
        /// The second system's time.
        right: Time,
    },
    /// A sample period that is not a positive number.
    #[error("sample period {period_s} s; it must be positive and finite")]
    Period {
        /// The period found.
        period_s: f64,
    },
}
