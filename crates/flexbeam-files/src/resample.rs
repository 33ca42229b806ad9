//! Samples on a jittered clock, interpolated to an even one: only on request.
//!
//! Enters: instants and signals. Leaves: signals at k times the period from the first instant on, and what the interpolation may have
//! cost. Deliberately absent: gaps, which nothing fills; longer periods, which would need a filter against aliases.

use crate::fault::{Fault, six_digits};
use crate::recording::is_period;
use crate::table::TableFault;
use flexbeam_lti::{Mat, Signals};

/// Samples that a polynomial goes through: degree 5.
const POINTS: usize = 6;

/// The period lies between these multiples of the mean step: a shorter one makes samples up, a longer one needs a filter.
const SHORTEST: f64 = 0.5;
const LONGEST: f64 = 1.1;

/// Signals on an even clock.
pub(crate) struct Resampled {
    pub signals: Signals,
    pub time_s: Vec<f64>,
    /// What was done and what it may have cost, for a person.
    pub notice: String,
}

/// y(k T) = sum_j y_j prod_{i != j} (kT - t_i)/(t_j - t_i) over the six nearest samples.
///
/// Shapes: `time_s` has an entry for each sample; it rises.
/// Errors: [`Fault::Period`]; [`TableFault::FarPeriod`]; [`Fault::TooFewRows`].
/// Numerics: exact for polynomials of degree 5. The error that is stated is the difference to degree 3 through the four nearest: of a
/// signal well below half the sampling frequency it is far above the true error; white noise shows as what it is, near the jitter.
/// Source: Lagrange, in the barycentric-free form; six points are few.
pub(crate) fn resampled(signals: &Signals, time_s: &[f64], period_s: f64) -> Result<Resampled, Fault> {
    check(time_s, period_s)?;
    let (begin_s, end_s) = (time_s[0], time_s[time_s.len() - 1]);
    let count = ((end_s - begin_s) / period_s * (1.0 + f64::EPSILON)).floor() as usize + 1;
    let channels = signals.channels();
    let mut data = Mat::zeros(channels, count);
    let mut errors = vec![Error::default(); channels];
    let mut first = 0;
    for k in 0..count {
        let t = begin_s + k as f64 * period_s;
        while first + POINTS < time_s.len() && time_s[first + POINTS / 2] <= t {
            first += 1;
        }
        let near = &time_s[first..first + POINTS];
        // Towards the ends the nearest four are not the middle ones.
        let inner = if t < near[1] { 0 } else { 1 + usize::from(t > near[POINTS - 2]) };
        let (six, four) = (weights(near, t), weights(&near[inner..inner + POINTS - 2], t));
        for r in 0..channels {
            let value = |weights: &[f64], from: usize| -> f64 {
                weights.iter().enumerate().map(|(j, w)| w * signals.data[(r, from + j)]).sum()
            };
            data[(r, k)] = value(&six, first);
            errors[r].take(data[(r, k)] - value(&four, first + inner), data[(r, k)]);
        }
    }
    let notice = words(&signals.names, &errors, period_s, count);
    let time_s = (0..count).map(|k| begin_s + k as f64 * period_s).collect();
    Ok(Resampled { signals: Signals { period_s, data, ..signals.clone() }, time_s, notice })
}

fn check(time_s: &[f64], period_s: f64) -> Result<(), Fault> {
    if !is_period(period_s) {
        return Err(Fault::Period { period_s });
    }
    if time_s.len() < POINTS {
        return Err(Fault::TooFewRows { found: time_s.len(), needed: POINTS });
    }
    let mean_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    match (SHORTEST..=LONGEST).contains(&(period_s / mean_s)) {
        true => Ok(()),
        false => Err(TableFault::FarPeriod { period_s, least_s: SHORTEST * mean_s, most_s: LONGEST * mean_s }.into()),
    }
}

/// What each of the samples at `near` counts for at t.
fn weights(near: &[f64], t: f64) -> Vec<f64> {
    let weight = |j: usize| {
        let others = near.iter().enumerate().filter(|(i, _)| *i != j);
        others.map(|(_, t_i)| (t - t_i) / (near[j] - t_i)).product()
    };
    (0..near.len()).map(weight).collect()
}

/// Squares of a channel's differences and of its values about their mean.
#[derive(Clone, Default)]
struct Error {
    squares: f64,
    largest: f64,
    count: f64,
    mean: f64,
    spread: f64,
}

impl Error {
    fn take(&mut self, difference: f64, value: f64) {
        self.squares += difference * difference;
        self.largest = self.largest.max(difference.abs());
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.spread += off * (value - self.mean);
    }

    /// Root mean square and largest difference, relative to the channel's standard deviation [percent]; 0 for a constant.
    fn percent(&self) -> (f64, f64) {
        let std = (self.spread / self.count).sqrt();
        let relative = |x: f64| if x == 0.0 { 0.0 } else { 100.0 * x / std };
        (relative((self.squares / self.count).sqrt()), relative(self.largest))
    }
}

fn words(names: &[String], errors: &[Error], period_s: f64, count: usize) -> String {
    let each = names.iter().zip(errors).map(|(name, error)| {
        let (rms, largest) = error.percent();
        format!("{name} {rms:.2} % rms, {largest:.2} % at most")
    });
    format!(
        "resampled to {count} samples every {} s by polynomials of degree 5 through the 6 nearest; their difference to degree 3, of \
         the standard deviation: {}",
        six_digits(period_s),
        each.collect::<Vec<_>>().join("; ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock late by up to a quarter of a period, with a pattern that does not repeat soon.
    fn jittered(count: usize, period_s: f64) -> Vec<f64> {
        (0..count).map(|k| period_s * (k as f64 + 0.25 * (k as f64 * 0.7 + 0.3 * (k as f64).sqrt()).sin())).collect()
    }

    fn of(time_s: &[f64], y: impl Fn(f64) -> f64) -> Signals {
        let data = Mat::from_fn(1, time_s.len(), |_, k| y(time_s[k]));
        Signals::new(vec!["y".into()], vec![String::new()], 0.01, data).unwrap()
    }

    /// Largest error relative to the largest value, and the error that is stated, rms over the standard deviation.
    fn errors(y: impl Fn(f64) -> f64, period_s: f64) -> (f64, f64) {
        let time_s = jittered(2000, 0.01);
        let Resampled { signals, time_s, notice } = resampled(&of(&time_s, &y), &time_s, period_s).unwrap();
        assert!((time_s[1] - time_s[0] - period_s).abs() < 1e-12 && time_s.len() == signals.samples());
        let wrong = time_s.iter().zip(signals.data.iter()).map(|(t, x)| (x - y(*t)).abs()).fold(0.0, f64::max);
        let stated = notice
            .split("deviation: y ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next())
            .and_then(|x| x.parse::<f64>().ok());
        (wrong / signals.data.amax(), stated.expect("a figure") / 100.0)
    }

    #[test]
    fn polynomials_of_degree_5_come_back() {
        for period_s in [0.01, 0.0105, 0.006] {
            let (wrong, _) = errors(|t| 1.0 - t + 0.3 * t.powi(3) - 0.02 * t.powi(5), period_s);
            assert!(wrong < 1e-12, "{wrong}");
        }
    }

    /// The stated error lies above the true one for smooth signals, and says of a signal near half the sampling frequency that it is lost.
    #[test]
    fn the_error_is_stated_and_true() {
        let tone = |hz: f64| move |t: f64| (std::f64::consts::TAU * hz * t + 0.4).sin();
        for (hz, most) in [(1.0, 1e-6), (5.0, 1e-3), (10.0, 0.02)] {
            let (wrong, stated) = errors(tone(hz), 0.01);
            assert!(wrong < most, "{hz} Hz: {wrong}");
            assert!(stated + 1e-4 >= 0.5 * wrong, "{hz} Hz: {wrong} stated {stated}");
        }
        // Nor are the ends worse than the middle by an order, where no sample lies on one side.
        let time_s = jittered(2000, 0.01);
        let notice = resampled(&of(&time_s, tone(5.0)), &time_s, 0.01).unwrap().notice;
        let figures: Vec<f64> =
            notice.rsplit("y ").next().unwrap().split(' ').filter_map(|word| word.parse().ok()).collect();
        assert!(figures.len() == 2 && figures[1] < 10.0 * figures[0], "{notice}");
        let (wrong, stated) = errors(tone(45.0), 0.01);
        assert!(wrong > 0.1 && stated > 0.05, "{wrong} {stated}");
    }

    #[test]
    fn periods_that_would_alias_or_invent_are_refused() {
        let time_s = jittered(100, 0.01);
        let signals = of(&time_s, f64::sin);
        for period_s in [0.02, 0.0115, 0.004] {
            let fault = resampled(&signals, &time_s, period_s).err();
            let far = |found: f64| found == period_s;
            assert!(matches!(fault, Some(Fault::Table(TableFault::FarPeriod { period_s, .. })) if far(period_s)));
        }
        assert!(matches!(resampled(&signals, &time_s, f64::NAN), Err(Fault::Period { .. })));
        let few = of(&time_s[..5], f64::sin);
        assert_eq!(resampled(&few, &time_s[..5], 0.01).err(), Some(Fault::TooFewRows { found: 5, needed: 6 }));
    }
}
