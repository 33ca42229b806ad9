//! Signals as a table in text, comma separated, with a header.
//!
//! Deliberately absent: reading, which `table` does.

use flexbeam_lti::Signals;
use std::fmt::Write;

/// Signals as CSV: `time_s` first, then the channels; every number in the shortest form that reads back to its bits.
///
/// `time_s` defaults to k `period_s`. Shapes: `time_s` has an entry for each sample.
pub fn csv_text(signals: &Signals, time_s: Option<&[f64]>) -> String {
    /// Bytes that a number takes, roughly; for the allocation only.
    const CELL: usize = 20;
    let mut text = String::with_capacity(CELL * (signals.channels() + 1) * (signals.samples() + 1));
    text.push_str("time_s");
    for name in &signals.names {
        let quotes = if name.contains([',', ';']) { "\"" } else { "" };
        push(&mut text, format_args!(",{quotes}{name}{quotes}"));
    }
    text.push('\n');
    for k in 0..signals.samples() {
        let time = time_s.map_or_else(|| instant(k as u64, signals.period_s), |time_s| time_s[k]);
        push(&mut text, format_args!("{time:?}"));
        for value in signals.data.column(k) {
            push(&mut text, format_args!(",{value:?}"));
        }
        text.push('\n');
    }
    text
}

fn push(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("a String takes any text");
}

/// k Ts.
///
/// NUMERICS: where a whole number of samples makes a second, k / rate is the correctly rounded instant (0.009, where
/// 9 * 0.001 is 0.009000000000000001) and prints short.
pub(crate) fn instant(k: u64, period_s: f64) -> f64 {
    let rate = period_s.recip().round();
    if rate > 0.0 && rate.recip() == period_s { k as f64 / rate } else { k as f64 * period_s }
}
