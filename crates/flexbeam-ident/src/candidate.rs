//! One estimate among several, and which of them is kept.
//!
//! Enters: the estimating samples, weights and horizons that compete. Leaves: the chosen one.
//! Deliberately absent: the validating samples; they must not choose.

use flexbeam_lti::Mat;

use crate::estimation::Estimation;
use crate::hankel::factor::Factor;
use crate::identify::{Method, Order, Weighting};
use crate::projection::{Directions, directions};
use crate::{Error, Options, order, subspace};

/// Samples that a comparison simulates: what they cannot tell apart is equally good.
const COMPARED: usize = 8192;
/// A past that moves the outputs by less than this part of them is rounding.
const NO_STATE: f64 = 1e-12;
/// Two sums of squared errors within this many standard errors of their difference are equal.
const STANDARD_ERRORS: f64 = 1.0;

/// A and C of one weighting and one horizon.
pub(crate) struct Candidate {
    /// The method whose weights these are.
    pub method: Method,
    /// Block rows i.
    pub block_rows: usize,
    /// Singular values of (14).
    pub singular_values: Vec<f64>,
    /// State matrix.
    pub A: Mat,
    /// Output matrix.
    pub C: Mat,
}

/// The chosen candidate with the factor that it comes from.
pub(crate) struct Chosen {
    /// Who was chosen.
    pub candidate: Candidate,
    /// Of its horizon.
    pub factor: Factor,
}

/// The candidate that `options` asks for; of several, the one that the estimating samples prefer.
///
/// Candidates of one order have equally many parameters, so the squared errors of their simulated outputs compare as they
/// stand. The first in order of preference is taken whose sum is within one standard error of the least: CVA before MOESP before
/// N4SID (its weights give the least variance asymptotically), few block rows before many. The standard error is of the
/// difference, from the means of about sqrt(s) batches, since errors of neighbouring samples are alike.
///
/// Errors: [`Error::Order`], [`Error::NoState`], those of the factor.
/// Source: Bauer 2005 (CVA's efficiency); Breiman et al. 1984, section 3.4.3 (the rule of one standard error).
pub(crate) fn best(samples: &Estimation, options: &Options) -> Result<Chosen, Error> {
    let (mut all, mut factors) = (Vec::new(), Vec::new());
    for (k, &block_rows) in horizons(options).iter().enumerate() {
        let factor = match samples.factor(block_rows) {
            Ok(factor) => factor,
            // A horizon that the record cannot carry does not compete; the first one must.
            Err(why) if k == 0 => return Err(why),
            Err(_) => continue,
        };
        all.extend(of_horizon(samples, &factor, options)?);
        factors.push(factor);
    }
    let k = if all.len() == 1 {
        0
    } else {
        let missed = all.iter().map(|candidate| samples.squares(COMPARED, &candidate.A, &candidate.C));
        preferred(&missed.collect::<Result<Vec<_>, _>>()?)
    };
    let candidate = all.swap_remove(k);
    let place = factors.iter().position(|factor| factor.i == candidate.block_rows).expect("its own");
    Ok(Chosen { candidate, factor: factors.swap_remove(place) })
}

/// Block rows that compete, none twice.
fn horizons(options: &Options) -> Vec<usize> {
    let mut all = vec![options.block_rows];
    all.extend(options.more_block_rows.iter().filter(|&&i| i != options.block_rows));
    all
}

/// One candidate for each weighting of the method, the preferred one first.
fn of_horizon(samples: &Estimation, factor: &Factor, options: &Options) -> Result<Vec<Candidate>, Error> {
    let moesp = directions(factor, Weighting::Moesp);
    let weightings: &[Method] = match options.method {
        // Canonical correlations of data without noise are all one: there the weights mean nothing.
        Method::Auto if order::noise_free(&moesp.singular_values) => &[Method::Moesp],
        Method::Auto => &[Method::Cva, Method::Moesp, Method::N4sid],
        Method::Moesp => &[Method::Moesp],
        Method::Cva => &[Method::Cva],
        Method::N4sid | Method::Paper => &[Method::N4sid],
    };
    let candidate = |&method: &Method| {
        let found = match method {
            Method::Moesp => None,
            _ => Some(directions(factor, method.weighting())),
        };
        let found = found.as_ref().unwrap_or(&moesp);
        let n = chosen_order(factor, found, &moesp, samples.integrators, options)?;
        let gamma = subspace::gamma(found, n); // (15)
        let (A, C) = subspace::shift(&gamma, factor.l).ok_or(Error::NoState)?;
        let (A, C) = samples.structured(&gamma, A, C);
        // The order is read from MOESP's, whichever weights win.
        let shown = if options.method == Method::Auto { &moesp } else { found };
        let singular_values = shown.singular_values.clone();
        Ok(Candidate { method, block_rows: factor.i, singular_values, A, C })
    };
    weightings.iter().map(candidate).collect()
}

/// States beside the known integrators.
///
/// The automatic order is always from the MOESP weighting: canonical correlations of noise-free data are all one and have no floor.
pub(crate) fn chosen_order(
    factor: &Factor,
    found: &Directions,
    moesp: &Directions,
    integrators: usize,
    options: &Options,
) -> Result<usize, Error> {
    let rank = order::rank(&found.singular_values);
    let outputs = factor.L.select_rows(&factor.outputs(factor.i..2 * factor.i)).norm();
    // Beside the outputs themselves: a relation at the same sample leaves singular values that are rounding altogether.
    if rank == 0 || moesp.singular_values[0] <= NO_STATE * outputs {
        return Err(Error::NoState);
    }
    let shift = factor.l * (factor.i - 1);
    let aspect = factor.l as f64 / (factor.m + factor.l) as f64;
    let order = match options.order {
        Order::Auto => order::automatic(&moesp.singular_values, aspect).min(shift).min(rank) + integrators,
        Order::Fixed(order) => order,
    };
    let refused = |largest: usize, reason| Err(Error::Order { order, largest: largest + integrators, reason });
    if order > shift + integrators {
        return refused(shift, "the shift of Gamma has l (i - 1) rows");
    }
    if order > rank + integrators {
        return refused(rank, "only so many singular values stand above rounding");
    }
    Ok(order - integrators)
}

/// The first whose sum of squares is the least within the standard errors of the difference.
fn preferred(missed: &[Vec<f64>]) -> usize {
    let sum = |k: usize| {
        let sum: f64 = missed[k].iter().sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    };
    let least = (0..missed.len()).min_by(|&a, &b| sum(a).total_cmp(&sum(b))).expect("one candidate at least");
    let as_good = |k: &usize| {
        let difference: Vec<f64> = missed[*k].iter().zip(&missed[least]).map(|(a, b)| a - b).collect();
        sum(*k).is_finite() && mean(&difference) <= STANDARD_ERRORS * standard_error(&difference)
    };
    (0..missed.len()).find(as_good).unwrap_or(least)
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Standard error of the mean of correlated samples, from the means of about sqrt(s) batches.
fn standard_error(x: &[f64]) -> f64 {
    let length = (x.len() as f64).sqrt().floor().max(1.0) as usize;
    let means: Vec<f64> = x.chunks_exact(length).map(mean).collect();
    let centre = mean(&means);
    let square: f64 = means.iter().map(|m| (m - centre).powi(2)).sum();
    (square / (means.len() as f64 * (means.len() as f64 - 1.0).max(1.0))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;

    #[test]
    fn a_clear_winner_wins_and_a_tie_goes_to_the_first() {
        let noise = white_gaussian(900, 1.0, f64::INFINITY, 5);
        let squares = |level: f64| noise.iter().map(|e| level * (1.0 + 0.1 * e)).collect::<Vec<f64>>();
        assert_eq!(preferred(&[squares(1.5), squares(1.0), squares(2.0)]), 1);
        let other = white_gaussian(900, 1.0, f64::INFINITY, 6);
        let like: Vec<f64> = squares(1.0).iter().zip(&other).map(|(a, e)| a + 0.001 + e).collect();
        assert_eq!(preferred(&[like, squares(1.0)]), 0);
    }

    /// An overflow never wins, and where all overflow the first one stands.
    #[test]
    fn overflow_loses() {
        assert_eq!(preferred(&[vec![f64::INFINITY; 9], vec![f64::NAN; 9], vec![1.0; 9]]), 2);
        assert_eq!(preferred(&[vec![f64::INFINITY; 9], vec![f64::INFINITY; 9]]), 0);
    }

    /// x(k) = 0.9 x(k-1) + e(k): the variance of a mean is 19 times that of white samples.
    #[test]
    fn standard_error_knows_of_correlation() {
        let white = white_gaussian(40_000, 1.0, f64::INFINITY, 7);
        let mut x = 0.0;
        let coloured: Vec<f64> = white
            .iter()
            .map(|e| {
                x = 0.9 * x + e;
                x
            })
            .collect();
        let exact = 10.0 / (40_000f64).sqrt();
        let ratio = standard_error(&coloured) / exact;
        assert!((0.8..1.2).contains(&ratio), "{ratio}");
    }
}
