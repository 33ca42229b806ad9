//! What is asked of a recording and of the options before anything is computed.
//!
//! Enters: signals, options. Leaves: nothing, or an error that says what was found and what is needed.
//! Deliberately absent: what only the factor can tell.

use flexbeam_lti::{Signals, Time};

use crate::correlation::{Channels, NotFinite};
use crate::identify::{Feedthrough, Method, Order, Poles};
use crate::{Error, Options};

/// Errors: as [`crate::identify()`], those of settings and shapes.
pub(crate) fn check(inputs: &Signals, outputs: &Signals, options: &Options) -> Result<(), Error> {
    let setting = |setting, found, needed| Err(Error::Setting { setting, found, needed });
    expect_together(inputs, outputs)?;
    expect_structure(inputs.channels(), outputs.channels(), options)?;
    if !(options.estimate > 0.0 && options.estimate <= 1.0) {
        return setting("estimate", options.estimate, "more than 0 and at most 1");
    }
    Ok(())
}

/// Errors: fewer than two block rows, an order without a state beside the integrators.
pub(crate) fn expect_order(options: &Options) -> Result<(), Error> {
    let setting = |setting, found: usize, needed| Err(Error::Setting { setting, found: found as f64, needed });
    if let Some(few) = [options.block_rows].iter().chain(&options.more_block_rows).find(|&&i| i < 2) {
        return setting("block_rows", *few, "at least 2");
    }
    match options.order {
        Order::Fixed(0) => setting("order", 0, "at least 1"),
        Order::Fixed(n) if n <= options.integrators => setting("order", n, "more than the known integrators"),
        _ => Ok(()),
    }
}

/// Errors: those of [`expect_order`], an order without a state beside the integrators, more integrators than channels, structure that (13)-(17) do not know.
pub(crate) fn expect_structure(m: usize, l: usize, options: &Options) -> Result<(), Error> {
    expect_order(options)?;
    if options.integrators > m.min(l) {
        let (setting, needed) = ("integrators", "at most as many as inputs and as outputs");
        return Err(Error::Setting { setting, found: options.integrators as f64, needed });
    }
    let known = [
        (options.integrators > 0, "integrators"),
        (options.feedthrough == Feedthrough::Zero, "no feedthrough"),
        (options.poles == Poles::Stable, "stable poles"),
        (!options.more_block_rows.is_empty(), "several block rows"),
    ];
    match known.iter().find(|known| known.0 && options.method == Method::Paper) {
        Some((_, structure)) => Err(Error::Structure { structure }),
        None => Ok(()),
    }
}

/// Channels on both sides, recorded in step.
pub(crate) fn expect_together(inputs: &Signals, outputs: &Signals) -> Result<(), Error> {
    if inputs.channels() == 0 || outputs.channels() == 0 {
        return Err(Error::NoChannel { inputs: inputs.channels(), outputs: outputs.channels() });
    }
    if inputs.samples() != outputs.samples() {
        return Err(Error::Length { inputs: inputs.samples(), outputs: outputs.samples() });
    }
    let (input_s, output_s) = (inputs.period_s, outputs.period_s);
    let axes = [input_s, output_s].map(|period_s| Time::Sampled { period_s });
    if axes[0].common(axes[1]).is_err() {
        return Err(Error::Period { input_s, output_s });
    }
    Ok(())
}

/// All samples finite.
pub(crate) fn expect_finite(inputs: &Signals, outputs: &Signals) -> Result<(), Error> {
    let all = Channels::of_rows(&inputs.data).beside(Channels::of_rows(&outputs.data));
    all.not_finite().map_or(Ok(()), |bad| Err(not_finite(inputs, outputs, bad)))
}

/// The sample by its channel's name.
pub(crate) fn not_finite(inputs: &Signals, outputs: &Signals, bad: NotFinite) -> Error {
    let m = inputs.channels();
    let (signals, row) = if bad.channel < m { (inputs, bad.channel) } else { (outputs, bad.channel - m) };
    let value = signals.data[(row, bad.sample)];
    Error::NotFinite { channel: signals.names[row].clone(), sample: bad.sample, value }
}

/// Whole samples of the estimating part.
pub(crate) fn estimation_samples(all: usize, options: &Options) -> Result<usize, Error> {
    let s = (all as f64 * options.estimate).floor() as usize;
    // The validating part must at least tell its initial state apart from the rest.
    if s < all {
        expect_samples("validation", all - s, 2 * options.block_rows, options.block_rows)?
    }
    Ok(s)
}

/// Errors: [`Error::TooFewSamples`].
pub(crate) fn expect_samples(what: &'static str, found: usize, needed: usize, block_rows: usize) -> Result<(), Error> {
    if found < needed { Err(Error::TooFewSamples { what, found, needed, block_rows }) } else { Ok(()) }
}
