//! Whole samples between an input and the first that the outputs show of it.
//!
//! Enters: inputs and outputs, or a model and known delays. Leaves: a number of samples for each input, the
//! model with the delays as states. Deliberately absent: delays of parts of a sample, which B and D express.

use flexbeam_lti::{Mat, StateSpace};

use crate::Error;
use crate::triangle::{CHUNK_ROWS, Triangle};

/// Standard errors that an answer must exceed: one in 16 000 by chance, for some tens of lags.
const SIGNIFICANT: f64 = 4.0;
/// An answer below this part of the output is rounding.
const ROUNDING: f64 = 1e-11;

/// Input delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delay {
    /// The same for every input, known.
    Samples(usize),
    /// For each input by itself, the lag after which an answer is significant, less the sample that a held input takes anyway.
    Auto,
}

impl Default for Delay {
    fn default() -> Delay {
        Delay::Samples(0)
    }
}

/// Delay of each input.
///
/// y(k) is regressed on i past outputs and the i + 1 last values of every input, the newest value of the tested input last: while
/// its newer values answer nothing, the coefficient of lag d is the d-th Markov parameter. The first one beyond four standard
/// errors in some output ends the delay. A slow system's first answers drown in noise, and count as delay: so they should, as
/// far as the recording can tell.
///
/// Shapes: U s x m, Y s x l.
/// Errors: [`Error::NoAnswer`]: no lag up to i is significant.
pub(crate) fn estimated(U: &Mat, Y: &Mat, i: usize) -> Result<Vec<usize>, Error> {
    let regression = Regression::new(U, Y, i);
    (0..U.ncols()).map(|c| regression.first_answer(c).map(|lag| lag.saturating_sub(1))).collect()
}

/// Triangular factor of [y(k-1)' .. y(k-i)' | u_1(k-i) .. u_1(k) | .. | u_m(k-i) .. u_m(k) | y(k)'].
struct Regression {
    R: Mat,
    i: usize,
    m: usize,
    l: usize,
    samples: usize,
}

impl Regression {
    fn new(U: &Mat, Y: &Mat, i: usize) -> Regression {
        let (s, m, l) = (U.nrows(), U.ncols(), Y.ncols());
        let past = (1..=i).rev().flat_map(|lag| (0..l).map(move |p| (true, p, lag)));
        let inputs = (0..m).flat_map(|c| (0..=i).rev().map(move |lag| (false, c, lag)));
        let now = (0..l).map(|p| (true, p, 0));
        let columns: Vec<(bool, usize, usize)> = past.chain(inputs).chain(now).collect();
        let mut triangle = Triangle::new(columns.len());
        for first in (i..s).step_by(CHUNK_ROWS) {
            let width = CHUNK_ROWS.min(s - first);
            let value = |k: usize, &(output, channel, lag): &(bool, usize, usize)| {
                let data = if output { Y } else { U };
                data[(first + k - lag, channel)]
            };
            triangle.absorb(&mut Mat::from_fn(width, columns.len(), |k, c| value(k, &columns[c])));
        }
        Regression { R: triangle.R, i, m, l, samples: s.saturating_sub(i) }
    }

    /// Lag of the first significant answer to input c.
    fn first_answer(&self, c: usize) -> Result<usize, Error> {
        let (i, m, l) = (self.i, self.m, self.l);
        let block = |c: usize| i * l + c * (i + 1)..i * l + (c + 1) * (i + 1);
        let others = (0..m).filter(|&other| other != c).flat_map(block);
        let unknowns = i * l + m * (i + 1);
        let order: Vec<usize> = (0..i * l).chain(others).chain(block(c)).chain(unknowns..unknowns + l).collect();
        let mut triangle = Triangle::new(order.len());
        triangle.absorb(&mut self.R.select_columns(&order));
        let freedom = self.samples.saturating_sub(unknowns).max(1) as f64;
        let significant = |lag: usize| {
            (unknowns..unknowns + l).any(|p| {
                let column = triangle.R.column(p);
                let noise = column.rows(unknowns, l).norm() / freedom.sqrt();
                let answer = column[unknowns - 1 - lag].abs();
                answer > SIGNIFICANT * noise && answer > ROUNDING * column.norm()
            })
        };
        (0..=i).find(|&lag| significant(lag)).ok_or(Error::NoAnswer { input: c, lags: i })
    }
}

/// The model with u_c(k-1) .. u_c(k-d_c) as further states: input c reaches the given model d_c samples later.
///
/// Errors: shapes that do not fit, which is a bug of the caller.
pub(crate) fn carried(model: &StateSpace, delays: &[usize]) -> Result<StateSpace, Error> {
    let (n, added) = (model.order(), delays.iter().sum::<usize>());
    let (m, l) = (model.inputs(), model.outputs());
    let mut A = Mat::zeros(n + added, n + added);
    let (mut B, mut C) = (Mat::zeros(n + added, m), Mat::zeros(l, n + added));
    let mut D = model.D.clone();
    A.view_mut((0, 0), (n, n)).copy_from(&model.A);
    C.columns_mut(0, n).copy_from(&model.C);
    let mut first = n;
    for (c, &d) in delays.iter().enumerate() {
        if d == 0 {
            B.view_mut((0, c), (n, 1)).copy_from(&model.B.column(c));
            continue;
        }
        // The chain: newest first.
        let last = first + d - 1;
        B[(first, c)] = 1.0;
        (first..last).for_each(|k| A[(k + 1, k)] = 1.0);
        A.view_mut((0, last), (n, 1)).copy_from(&model.B.column(c));
        C.column_mut(last).copy_from(&model.D.column(c));
        D.column_mut(c).fill(0.0);
        first += d;
    }
    Ok(StateSpace::new(A, B, C, D, model.time)?)
}

#[cfg(test)]
mod tests {
    use flexbeam_lti::{Time, Vector, simulation::simulate};

    use super::*;
    use crate::correlation::Channels;
    use crate::excitation::white_gaussian;

    /// Two inputs, two outputs, D zero: without delays, an answer after one sample.
    fn system() -> StateSpace {
        let A = Mat::from_row_slice(2, 2, &[0.9, 0.3, -0.3, 0.7]);
        let B = Mat::from_row_slice(2, 2, &[1.0, 0.2, -0.5, 1.0]);
        let C = Mat::from_row_slice(2, 2, &[1.0, 0.4, 0.3, -1.0]);
        StateSpace::new(A, B, C, Mat::zeros(2, 2), Time::Sampled { period_s: 1.0 }).unwrap()
    }

    fn inputs(s: usize) -> Mat {
        Mat::from_column_slice(2, s, &white_gaussian(2 * s, 1.0, 9.0, 4))
    }

    /// Both ways of saying that an input comes later give the same output.
    #[test]
    fn carried_delays_are_moved_inputs() {
        let delays = [3, 1];
        let U = inputs(60);
        let with_states = simulate(&carried(&system(), &delays).unwrap(), &U, &Vector::zeros(6)).unwrap();
        let early = Mat::from_fn(2, 60, |c, k| if k >= delays[c] { U[(c, k - delays[c])] } else { 0.0 });
        let wanted = simulate(&system(), &early, &Vector::zeros(2)).unwrap();
        assert!((&with_states - wanted).norm() < 1e-12 * with_states.norm());
        let moved = Channels::of_rows(&U).later(&delays);
        assert_eq!((moved.samples(), moved.at(0, 0), moved.at(1, 0)), (57, U[(0, 0)], U[(1, 2)]));
    }

    #[test]
    fn delays_are_found_with_and_without_noise() {
        for (delays, noise) in [([0, 0], 0.0), ([3, 1], 0.0), ([0, 5], 0.3), ([4, 2], 0.3)] {
            let U = inputs(2000);
            let Y = simulate(&carried(&system(), &delays).unwrap(), &U, &Vector::zeros(2 + delays[0] + delays[1]));
            let e = white_gaussian(4000, 1.0, f64::INFINITY, 12);
            let Y = Y.unwrap() + Mat::from_column_slice(2, 2000, &e) * noise;
            assert_eq!(estimated(&U.transpose(), &Y.transpose(), 10).unwrap(), delays, "noise {noise}");
        }
    }

    #[test]
    fn an_input_that_nothing_answers_to_is_named() {
        let U = inputs(1000).transpose();
        let Y = Mat::from_column_slice(1000, 1, &white_gaussian(1000, 1.0, 9.0, 5));
        assert_eq!(estimated(&U, &Y, 10), Err(Error::NoAnswer { input: 0, lags: 10 }));
    }
}
