//! Stretches of a recording in which the voltage is constant and the hub turns at constant speed.

use super::{Options, Recorded};

/// Displacement of a steady stretch at least, in counts: below it the speed is worth less than 3 %.
const LEAST_COUNTS: f64 = 16.0;
/// By how much the speeds of the two halves of a steady stretch may differ.
const STEADY: f64 = 0.05;

/// One run at constant voltage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Its voltage [V].
    pub voltage_v: f64,
    /// Speed of the hub once it is steady [rad/s].
    pub speed_rad_s: f64,
    /// First sample with this voltage.
    pub(crate) first: usize,
    /// First sample that is no longer looked at: the end of the coast when the voltage is cut, else of the run.
    pub(crate) end: usize,
}

/// Returns: steady runs in order, and how many stretches of constant voltage were long enough and yet left out.
pub(crate) fn steady_runs(recorded: &Recorded<'_>, options: &Options) -> (Vec<Run>, usize) {
    let samples = |t_s: f64| (t_s / recorded.period_s).round() as usize;
    let shortest = samples(options.settle_s + options.steady_s);
    let (mut runs, mut left_out, mut first) = (Vec::new(), 0, 0);
    for stretch in recorded.voltage_v.chunk_by(|a, b| a == b) {
        let (cut, voltage_v) = (first + stretch.len(), stretch[0]);
        if voltage_v != 0.0 && stretch.len() >= shortest {
            let steady = first + samples(options.settle_s)..cut;
            match recorded.steady_speed(steady, options) {
                Some(speed_rad_s) => {
                    let end = cut + recorded.zeros_from(cut).min(samples(options.coast_s));
                    runs.push(Run { voltage_v, speed_rad_s, first, end });
                }
                None => left_out += 1,
            }
        }
        first = cut;
    }
    (runs, left_out)
}

impl Recorded<'_> {
    /// None when the hub stands, turns against the voltage, or still changes its speed.
    fn steady_speed(&self, steady: std::ops::Range<usize>, options: &Options) -> Option<f64> {
        let half = steady.start + steady.len() / 2;
        let theta = &self.theta_rad[steady.clone()];
        let speed = slope(theta) / self.period_s;
        let turned = (theta[theta.len() - 1] - theta[0]).abs();
        let [one, other] =
            [steady.start..half, half..steady.end].map(|part| slope(&self.theta_rad[part]) / self.period_s);
        let by_counts = 2.0 * options.resolution_rad / (0.5 * steady.len() as f64 * self.period_s);
        let moves = turned > LEAST_COUNTS * options.resolution_rad && speed * self.voltage_v[steady.start] > 0.0;
        (moves && (one - other).abs() < STEADY * speed.abs() + by_counts).then_some(speed)
    }

    fn zeros_from(&self, sample: usize) -> usize {
        self.voltage_v[sample..].iter().take_while(|v| **v == 0.0).count()
    }
}

/// Slope of the least-squares line, per sample.
pub(crate) fn slope(x: &[f64]) -> f64 {
    let middle = 0.5 * (x.len() as f64 - 1.0);
    let (mut moment, mut square) = (0.0, 0.0);
    for (k, x_k) in x.iter().enumerate() {
        let t = k as f64 - middle;
        moment += t * (x_k - x[0]);
        square += t * t;
    }
    moment / square
}
