//! Every order at once: fits, information criterion, and which swings stay as the order grows.
//!
//! Enters: a recording, options, the largest order. Leaves: one row an order, all from one factor.
//! Deliberately absent: the choice; it is the person's, who sees both halves.

use flexbeam_lti::{Mat, Signals};

use crate::estimation::{Estimate, Estimation};
use crate::identify::{Feedthrough, Method, Order};
use crate::modes::{Mode, modes};
use crate::prepared::Prepared;
use crate::projection::directions;
use crate::{Error, Options, candidate, subspace};

/// A frequency that moves by less than this part from one order to the next is stable.
pub const STABLE_FREQUENCY: f64 = 0.01;
/// The same of a damping ratio.
pub const STABLE_DAMPING: f64 = 0.05;
/// Shapes this alike are one shape.
pub const STABLE_SHAPE: f64 = 0.98;
/// Errors below this part of the outputs are rounding: the criterion has no use for them.
const ROUNDING: f64 = 1e-13;

/// One order.
#[derive(Clone, Debug)]
pub struct OrderRow {
    /// Order n.
    pub order: usize,
    /// Fit of each output on the validating samples; None when there are none.
    pub fit_percent: Option<Vec<f64>>,
    /// Fit of each output on the estimating samples.
    pub estimation_fit_percent: Vec<f64>,
    /// s log det(E'E/s) + p log s, E the simulation's errors, p the free parameters (Schwarz 1978); infinite on overflow.
    pub criterion: f64,
    /// Swings, by frequency, each with what it shares with a swing of the order before.
    pub modes: Vec<(Mode, Stability)>,
}

/// What a swing shares with the nearest one of the order before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stability {
    /// Frequency within 1 %.
    pub frequency: bool,
    /// Damping ratio within 5 %, and frequency.
    pub damping: bool,
    /// Shape with an assurance of 0.98 or more, and frequency.
    pub shape: bool,
}

/// Models of all orders up to `largest` by the weights and block rows that `options` choose.
///
/// Returns fewer rows where block rows or data carry no more.
/// Errors: as [`crate::identify()`].
/// Numerics: one factor, one singular value decomposition; B, D, x(0) and two simulations an order.
/// Source: the stabilisation diagram of experimental modal analysis, Peeters and De Roeck 1999.
pub fn orders(inputs: &Signals, outputs: &Signals, options: &Options, largest: usize) -> Result<Vec<OrderRow>, Error> {
    if options.method == Method::Paper {
        return Err(Error::Structure { structure: "a table of orders" });
    }
    let prepared = Prepared::new(inputs, outputs, options)?;
    let samples = prepared.estimating(options);
    let chosen = candidate::best(&samples, options)?;
    let found = directions(&chosen.factor, chosen.candidate.method.weighting());
    let moesp = directions(&chosen.factor, Method::Moesp.weighting());
    let mut rows: Vec<OrderRow> = Vec::new();
    for order in samples.integrators + 1..=largest {
        let options = Options { order: Order::Fixed(order), ..options.clone() };
        let Ok(n) = candidate::chosen_order(&chosen.factor, &found, &moesp, samples.integrators, &options) else {
            break;
        };
        let gamma = subspace::gamma(&found, n);
        let Some((A, C)) = subspace::shift(&gamma, chosen.factor.l) else { break };
        let (A, C) = samples.structured(&gamma, A, C);
        let estimate = samples.completed(A, C)?;
        let fit_percent = prepared.unseen_fit_percent(&estimate)?;
        let modes = modes(&estimate.model, inputs.period_s);
        let before = rows.last().map_or(&[][..], |row| &row.modes);
        let modes = modes.into_iter().map(|mode| (stability(&mode, before), mode)).map(|(s, mode)| (mode, s)).collect();
        let criterion = criterion(&samples, &estimate)?;
        let estimation_fit_percent = estimate.fit_percent;
        rows.push(OrderRow { order, fit_percent, estimation_fit_percent, criterion, modes });
    }
    Ok(rows)
}

fn stability(mode: &Mode, before: &[(Mode, Stability)]) -> Stability {
    let apart = |other: &Mode| (other.frequency_rad_s / mode.frequency_rad_s - 1.0).abs();
    let nearest = before.iter().map(|(other, _)| other).min_by(|a, b| apart(a).total_cmp(&apart(b)));
    let Some(other) = nearest.filter(|other| apart(other) <= STABLE_FREQUENCY) else { return Stability::default() };
    Stability {
        frequency: true,
        damping: (other.damping - mode.damping).abs() <= STABLE_DAMPING * mode.damping.abs(),
        shape: mode.assurance(other) >= STABLE_SHAPE,
    }
}

fn criterion(samples: &Estimation, estimate: &Estimate) -> Result<f64, Error> {
    let missed = samples.missed(estimate)?;
    let (n, m, l) = (estimate.model.order(), samples.samples.m, samples.outputs());
    let s = missed.nrows() as f64;
    let covariance = missed.transpose() * &missed / s + Mat::identity(l, l) * (ROUNDING * ROUNDING);
    let determinant = covariance.cholesky().map_or(f64::INFINITY, |root| 2.0 * root.l().diagonal().map(f64::ln).sum());
    let direct = if samples.feedthrough == Feedthrough::Free { l * m } else { 0 };
    let offset = if samples.offset { l } else { 0 };
    // Similar systems are one: n (m + l) of A, B, C; the known eigenvalues are given. Then D, x(0), offsets.
    let parameters = n * (m + l) - samples.integrators + direct + n + offset;
    let value = s * determinant + parameters as f64 * s.ln();
    Ok(if value.is_nan() { f64::INFINITY } else { value })
}
