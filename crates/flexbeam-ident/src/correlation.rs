//! Lagged correlations of a recording and the Gram matrix H H' of its block Hankel matrices, without squaring away any digit.
//!
//! Enters: samples, in chunks of any length. Leaves: H H' in double-double. The samples are rounded once, to 52 bits of the largest so far;
//! everything after that is exact until the sums leave as double-doubles. Deliberately absent: triangular factors, block rows' order.

mod channels;
mod gram;
mod kernel;
mod record;
mod rounding;

pub(crate) use channels::{Channels, NotFinite};
pub(crate) use gram::Gram;
pub(crate) use record::Record;
