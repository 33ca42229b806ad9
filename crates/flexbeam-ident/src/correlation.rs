//! Lagged correlations of a recording and the Gram matrix H H' of its block Hankel matrices, without squaring away any digit.
//!
//! Enters: samples, in chunks of any length. Leaves: H H' in double-double. The samples are rounded once, to 52 bits of the largest so far;
//! everything after that is exact until the sums leave as double-doubles. Deliberately absent: triangular factors, block rows' order.

use crate::lanes;

mod channels;
mod fast;
mod gram;
mod kernel;
mod record;
mod rounding;

pub(crate) use channels::{Channels, NotFinite};
#[cfg(test)]
pub(crate) use fast::fast_gram;
pub(crate) use gram::Gram;

pub(crate) use record::Record;

/// H H' of a record in memory.
///
/// A processor that multiplies 52-bit integers eight at a time takes the exact way at once: it costs a third more than plain f64 at best. Others try plain f64, four times as
/// fast there, and take the exact way when that is not provably as good, or when they lack a fused multiply-add.
///
/// Errors: [`NotFinite`].
pub(crate) fn gram_of(channels: &Channels, i: usize, threads: usize) -> Result<Gram, NotFinite> {
    let plain = !kernel::wide() && lanes::fused();
    let fast = if plain { fast::fast_gram(channels, i, threads) } else { None };
    match fast {
        Some(gram) => Ok(gram),
        None => {
            let mut record = Record::new(channels.count(), i);
            record.absorb(channels, threads)?;
            Ok(record.finish())
        }
    }
}
