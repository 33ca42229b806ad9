//! Recordings that might as well have been made, and what an estimator makes of them.
//!
//! The model's own answer to the recorded input, plus noise with the power and cross spectra of what the model left of the
//! recording: each Fourier line of the residuals is turned by a random angle, the same for all outputs.
//!
//! Source: Theiler et al. 1992 (surrogates by random phases); Efron and Tibshirani 1993, section 6.5 (parametric bootstrap).

use std::f64::consts::TAU;

use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Vector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Error;
use crate::fourier::{lines_of, record_of};

/// A recording and the sampled model that was estimated from it.
pub struct Source<'a> {
    /// Recorded inputs.
    pub inputs: &'a Signals,
    /// Recorded outputs.
    pub outputs: &'a Signals,
    /// The model.
    pub model: &'a StateSpace,
    /// Its state at the first sample.
    pub initial_state: &'a Vector,
}

/// Models that `estimate` finds in `count` such recordings; nothing where it fails.
///
/// Assumes: noise that is stationary and independent of the inputs.
/// Returns: the same for the same seed, on any number of threads.
/// Errors: shapes of the simulation.
/// Numerics: `count` estimates, on as many threads as the machine has; each draws from a seed of its own.
pub fn replicates<M: Send>(
    source: &Source<'_>,
    count: usize,
    seed: u64,
    estimate: impl Fn(&Signals, &Signals) -> Option<M> + Sync,
) -> Result<Vec<Option<M>>, Error> {
    let answer = simulate(source.model, &source.inputs.data, source.initial_state)?;
    let residual = &source.outputs.data - &answer;
    let lines: Vec<Vec<C64>> =
        residual.row_iter().map(|row| lines_of(&row.iter().copied().collect::<Vec<f64>>())).collect();
    let one = |k: usize| {
        let random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(SEEDS_APART).wrapping_add(k as u64));
        let data = &answer + turned(&lines, residual.ncols(), random);
        estimate(source.inputs, &Signals { data, ..source.outputs.clone() })
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(count.max(1));
    let each: Vec<usize> = (0..count).collect();
    let found = std::thread::scope(|scope| {
        let started: Vec<_> = each
            .chunks(count.div_ceil(threads).max(1))
            .map(|part| scope.spawn(|| part.iter().map(|k| one(*k)).collect::<Vec<_>>()))
            .collect();
        started.into_iter().flat_map(|thread| thread.join().expect("an estimate does not panic")).collect()
    });
    Ok(found)
}

/// Seeds that follow each other share no draws.
const SEEDS_APART: u64 = 1_000_003;

/// The records with these lines, each line turned.
fn turned(lines: &[Vec<C64>], samples: usize, mut random: ChaCha8Rng) -> Mat {
    let turns: Vec<C64> = lines[0].iter().map(|_| C64::cis(TAU * random.random::<f64>())).collect();
    // The mean and the line at half the sampling frequency are real: they change sign or not.
    let real = |k: usize| k == 0 || 2 * k == samples;
    let turn = |k: usize| if real(k) { C64::from(turns[k].re.signum()) } else { turns[k] };
    let rows: Vec<Vec<f64>> = lines
        .iter()
        .map(|row| record_of(&row.iter().enumerate().map(|(k, x)| x * turn(k)).collect::<Vec<C64>>(), samples))
        .collect();
    Mat::from_fn(rows.len(), samples, |r, t| rows[r][t])
}

#[cfg(test)]
mod tests {
    use flexbeam_lti::Time;

    use super::*;
    use crate::excitation::white_gaussian;

    /// The estimator sees other noise of the same power and the same correlation between outputs; its order is that of the seeds.
    #[test]
    fn replicates_have_the_residuals_powers_and_correlations() {
        let (n, model) = (4000, StateSpace::static_gain(Mat::from_element(2, 1, 2.0), Time::Sampled { period_s: 1.0 }));
        let (model, e) = (model.unwrap(), white_gaussian(2 * n, 1.0, f64::INFINITY, 3));
        let noise = Mat::from_fn(2, n, |r, t| if r == 0 { e[t] } else { 0.6 * e[t] + 0.8 * e[n + t] });
        let U = Mat::from_row_slice(1, n, &white_gaussian(n, 1.0, f64::INFINITY, 4));
        let signals = |data: Mat| {
            let names: Vec<String> = (0..data.nrows()).map(|k| k.to_string()).collect();
            Signals::new(names.clone(), names, 1.0, data).unwrap()
        };
        let answer = &model.D * &U;
        let (inputs, outputs) = (signals(U), signals(&answer + &noise));
        let source = Source { inputs: &inputs, outputs: &outputs, model: &model, initial_state: &Vector::zeros(0) };
        let of = |seed| replicates(&source, 5, seed, |_, Y| Some(&Y.data - &answer)).unwrap();
        let found: Vec<Mat> = of(1).into_iter().flatten().collect();
        let covariance = |e: &Mat| e * e.transpose() / n as f64;
        for (k, e) in found.iter().enumerate() {
            assert!((covariance(e) - covariance(&noise)).norm() < 1e-10, "replicate {k}: Parseval");
            let repeated = e.row(0).dot(&noise.row(0)) / (e.row(0).norm() * noise.row(0).norm());
            assert!(repeated.abs() < 4.0 / (n as f64).sqrt(), "replicate {k} is other noise: {repeated}");
        }
        assert_eq!(of(1), of(1));
        assert_ne!(of(1)[0], of(2)[0]);
        assert_ne!(found[0], found[1]);
    }
}
