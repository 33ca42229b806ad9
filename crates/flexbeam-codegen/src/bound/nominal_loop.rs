//! The loop that the certificate speaks of, with a place for every error that a tick can make.
//!
//! Enters: the controller's numbers, its nominal plant. Leaves: a stable sampled system from the reference and the errors to any
//! signal of the loop. Deliberately absent: how large the errors are.

use flexbeam_files::Controller;
use flexbeam_lti::{Error, Mat, StateSpace, Time, sampling};

/// A signal: its coefficients in the loop's states, then in its inputs.
pub(super) type Signal = Mat;

/// Inputs of the loop: the reference v with what is wrong with it, then one error each.
pub(super) enum Input {
    /// v, and errors of v.
    Reference,
    /// Of the filters' state.
    Filter,
    /// Of y, behind the filters.
    Sum,
    /// Of u, which the observer hears, too.
    Voltage,
    /// Between u and the plant, not heard.
    Actuator,
    /// Of the next x, one each.
    State,
}

/// x+ = A x + B (v, y, u), u = C x + D (v, y), y = y_f + error, y_f = a psi + (1 - a) y_f(before), and the sampled plant from u to psi.
pub(super) struct NominalLoop {
    period_s: f64,
    states: usize,
    /// States of the next tick.
    next: Vec<Signal>,
    /// x, v, y, u: what the controller multiplies.
    pub(super) z: Vec<Signal>,
    /// The filtered tip angle before the sum of the channels is rounded.
    pub(super) filtered: Signal,
    /// The tip angle.
    pub(super) psi: Signal,
    /// psi - y_f(before), which the filters multiply.
    pub(super) increment: Signal,
    /// Rows of [A B].
    pub(super) rows: Vec<Vec<f64>>,
    /// The row of u in [C D].
    pub(super) output: Vec<f64>,
}

impl NominalLoop {
    /// Errors: those of [`sampling::zoh_with_delay`].
    pub(super) fn new(file: &Controller, coefficients: &[f64], low_pass: f64) -> Result<NominalLoop, Error> {
        let n = file.order;
        let (ab, cd) = coefficients.split_at(n * (n + 3));
        let rows: Vec<Vec<f64>> = (0..n).map(|i| ab.iter().skip(i).step_by(n).copied().collect()).collect();
        let output: Vec<f64> = cd.iter().step_by(2).copied().collect();
        let plant = sampling::zoh_with_delay(&file.plant_state_space()?, file.period_s, file.design.delay_s)?;
        let (p, states) = (plant.order(), n + plant.order() + 1);
        let one = |k: usize| Signal::from_fn(1, states + n + 5, |_, column| f64::from(u8::from(column == k)));
        let input = |input: Input| one(states + input as usize);
        let of_plant = |row: usize, M: &Mat| (0..p).fold(one(0) * 0.0, |sum, j| sum + one(n + j) * M[(row, j)]);

        let (psi, before) = (of_plant(0, &plant.C), one(states - 1));
        let increment = &psi - &before;
        let filtered = &psi - &increment * (1.0 - low_pass) + input(Input::Filter);
        let mut z: Vec<Signal> = (0..n).map(one).collect();
        z.extend([input(Input::Reference), &filtered + input(Input::Sum)]);
        let u = combined(&output, &z) + input(Input::Voltage);
        z.push(u.clone());
        let heard = u + input(Input::Actuator);
        let of_controller =
            rows.iter().enumerate().map(|(i, row)| combined(row, &z) + one(states + Input::State as usize + i));
        let mut next: Vec<Signal> = of_controller.collect();
        next.extend((0..p).map(|i| of_plant(i, &plant.A) + &heard * plant.B[(i, 0)]));
        next.push(filtered.clone());
        Ok(NominalLoop { period_s: file.period_s, states, next, z, filtered, psi, increment, rows, output })
    }

    /// From the first `inputs` of the inputs to the signals.
    pub(super) fn system(&self, signals: &[&Signal], inputs: usize) -> Result<StateSpace, Error> {
        let stacked =
            |of: &[&Signal], from: usize, columns: usize| Mat::from_fn(of.len(), columns, |i, j| of[i][(0, from + j)]);
        let (n, next) = (self.states, self.next.iter().collect::<Vec<_>>());
        let time = Time::Sampled { period_s: self.period_s };
        StateSpace::new(
            stacked(&next, 0, n),
            stacked(&next, n, inputs),
            stacked(signals, 0, n),
            stacked(signals, n, inputs),
            time,
        )
    }

    /// Number of inputs.
    pub(super) fn inputs(&self) -> usize {
        self.rows.len() + Input::State as usize
    }
}

/// The sum of signals with these coefficients; signals beyond them do not count.
pub(super) fn combined(coefficients: &[f64], signals: &[Signal]) -> Signal {
    let none = signals[0].clone() * 0.0;
    coefficients.iter().zip(signals).fold(none, |sum, (c, signal)| sum + signal * *c)
}
