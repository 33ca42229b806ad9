//! Tables of numbers in text, read from front to back with a bounded buffer.
//!
//! Enters: bytes as they come and, for tables without a header, names. Leaves: rows of numbers and their time, or a fault with
//! line, column and byte. What the file's head shows of its spelling (separator, decimal sign, header, units, comments) is
//! settled once, in [`Dialect`]; rows that do not keep to it are faults.
//! Deliberately absent: what the columns mean.

mod cell;
mod dialect;
mod fault;
mod header;
mod lines;
mod row;
mod separator;
mod stamp;
mod stream;

pub use fault::TableFault;

pub(crate) use header::check_names;
pub(crate) use lines::Mark;
pub(crate) use row::Rows;
pub(crate) use stream::Table;

/// In the place of a name: this column is left out, whatever it holds.
pub const LEFT_OUT: &str = "_";
