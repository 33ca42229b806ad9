//! The momentum balance of hub and link over short windows: what tells the dead zone from the Coulomb torque.
//!
//! Each window multiplies the balance of [`super`] by phi = sin^4 and integrates by parts, so that no signal is differentiated:
//!
//! ```text
//! J1 <phi'' theta> + J2 <phi'' alpha> + V_c+ (<phi sgn+> - <phi on+>) + V_c- (<on-> - <sgn->) - delay <phi' V> = <phi V> - dry ..
//! ```
//!
//! The beam's modes above the first follow the hub at once, with a part in the momentum that alpha does not show: a term
//! J3 <phi^(4) theta> stands for them. Without it V_coulomb came out 1 % large on the distributed beam.
//!
//! V_dead = dry - V_coulomb is put in, so the sums that the steady runs give are kept and only the coast parts them.

use super::Recorded;
use super::line::{Line, rise};
use super::runs::{Run, slope};
use crate::Error;
use flexbeam_lti::Mat;
use std::f64::consts::PI;

/// Below this speed the direction is in doubt [rad/s]: the hub may stand. 17 standard deviations of the smoothed encoder.
const SLIDING_RAD_S: f64 = 0.15;
/// Part of a window that may be in doubt.
const DOUBT: f64 = 0.1;
/// Half the width of the line that smooths the encoder [s].
const SMOOTH_S: f64 = 0.015;
/// Windows begin so long after a run began [s]: before, the hub may stick.
const START_S: f64 = 0.1;
/// Windows follow one another at this part of their length.
const STEP: f64 = 0.25;
/// Runs with a coast that are needed each way.
const FEWEST_COASTS: usize = 3;

/// Columns that are solved for: J1, J2, V_coulomb forward and backward, delay, J3.
pub(crate) const UNKNOWN: usize = 6;
/// And those whose coefficients the line has: V, on+, on-, speed, Stribeck.
const COLUMNS: usize = UNKNOWN + 5;
const FORWARD: usize = 2;
const BACKWARD: usize = 3;

/// What the balance gives besides the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parted {
    pub inertia_v_s2: f64,
    pub delay_s: f64,
    coulomb_v: [f64; 2],
}

impl Parted {
    /// Coulomb voltage of this direction.
    pub fn coulomb_v(&self, sign: f64) -> f64 {
        self.coulomb_v[usize::from(sign < 0.0)]
    }
}

/// Z'Z of every run's windows, Z the columns above.
pub(crate) struct Balance {
    of_run: Vec<Mat>,
}

impl Balance {
    pub fn of(recorded: &Recorded<'_>, window_s: f64, runs: &[Run], stribeck_rad_s: Option<f64>) -> Balance {
        let windows = Windows::new(recorded, window_s, stribeck_rad_s);
        let gram = |run: &Run| {
            let mut gram = Mat::zeros(COLUMNS, COLUMNS);
            for row in windows.rows(run) {
                let z = Mat::from_row_slice(1, COLUMNS, &row);
                gram.gemm_tr(1.0, &z, &z, 1.0);
            }
            gram
        };
        Balance { of_run: runs.iter().map(gram).collect() }
    }

    /// Least squares over the windows of all runs but one.
    ///
    /// Errors: [`Error::NoCoast`].
    pub fn parted(&self, line: &Line, without: Option<usize>) -> Result<Parted, Error> {
        self.enough_coasts(without)?;
        let kept = self.of_run.iter().enumerate().filter(|(k, _)| Some(*k) != without).map(|(_, gram)| gram);
        let gram = kept.fold(Mat::zeros(COLUMNS, COLUMNS), |sum, gram| sum + gram);
        let known = Mat::from_column_slice(
            COLUMNS - UNKNOWN,
            1,
            &[1.0, -line.plus_v, line.minus_v, -line.slope_v_s, -line.extra_v],
        );
        let right = gram.view((0, UNKNOWN), (UNKNOWN, COLUMNS - UNKNOWN)) * known;
        let scale = Mat::from_fn(UNKNOWN, 1, |k, _| gram[(k, k)].sqrt().recip());
        let scaled = Mat::from_fn(UNKNOWN, UNKNOWN, |i, j| gram[(i, j)] * scale[i] * scale[j]);
        let factor = scaled.cholesky().ok_or(Error::NoCoast { forward: 0, backward: 0, needed: FEWEST_COASTS })?;
        let x = factor.solve(&right.component_mul(&scale)).component_mul(&scale);
        Ok(Parted { inertia_v_s2: x[0], delay_s: x[4], coulomb_v: [x[FORWARD], x[BACKWARD]] })
    }

    /// Runs whose windows see the hub slide without voltage.
    pub fn coasts(&self) -> usize {
        self.of_run.iter().filter(|gram| sees(gram, FORWARD) || sees(gram, BACKWARD)).count()
    }

    /// Errors: too few of them one way.
    fn enough_coasts(&self, without: Option<usize>) -> Result<(), Error> {
        let seen = |column: usize| self.of_run.iter().filter(|gram| sees(gram, column)).count();
        let needed = FEWEST_COASTS - usize::from(without.is_some());
        let (forward, backward) = (seen(FORWARD), seen(BACKWARD));
        if forward.min(backward) >= needed { Ok(()) } else { Err(Error::NoCoast { forward, backward, needed }) }
    }
}

/// The column of a driven hub is zero but for rounding; one coasting window makes a whole of it.
fn sees(gram: &Mat, column: usize) -> bool {
    gram[(column, column)] > 0.5
}

/// Window functions and the smoothed speed.
struct Windows<'a> {
    recorded: &'a Recorded<'a>,
    phi: Vec<f64>,
    phi_1: Vec<f64>,
    phi_2: Vec<f64>,
    phi_4: Vec<f64>,
    speed_rad_s: Vec<f64>,
    stribeck_rad_s: Option<f64>,
}

impl<'a> Windows<'a> {
    fn new(recorded: &'a Recorded<'a>, window_s: f64, stribeck_rad_s: Option<f64>) -> Windows<'a> {
        let period_s = recorded.period_s;
        let n = (window_s / period_s).round() as usize;
        let per_s = PI / (n as f64 * period_s);
        // The mean of phi is 3/8.
        let weight = 8.0 / (3.0 * n as f64);
        let at = |f: fn(f64, f64) -> f64, scale: f64| {
            let value = |k: usize| (PI * (k as f64 + 0.5) / n as f64).sin_cos();
            (0..n).map(|k| weight * scale * f(value(k).0, value(k).1)).collect()
        };
        Windows {
            recorded,
            phi: at(|s, _| s.powi(4), 1.0),
            phi_1: at(|s, c| 4.0 * s.powi(3) * c, per_s),
            phi_2: at(|s, c| 12.0 * s * s * c * c - 4.0 * s.powi(4), per_s * per_s),
            // sin^4 u = (3 - 4 cos 2u + cos 4u)/8
            phi_4: at(|s, c| 32.0 * (1.0 - 8.0 * s * s * c * c) - 8.0 * (1.0 - 2.0 * s * s), per_s.powi(4)),
            speed_rad_s: smoothed_speed(recorded),
            stribeck_rad_s,
        }
    }

    /// One row a window of the run in which the hub slides.
    fn rows(&self, run: &Run) -> Vec<[f64; COLUMNS]> {
        let n = self.phi.len();
        let first = (run.first + (START_S / self.recorded.period_s).round() as usize).max(1);
        let step = ((STEP * n as f64) as usize).max(1);
        (first..(run.end + 1).saturating_sub(n)).step_by(step).filter_map(|start| self.row(start)).collect()
    }

    fn row(&self, start: usize) -> Option<[f64; COLUMNS]> {
        let Recorded { voltage_v, theta_rad, alpha_rad, .. } = *self.recorded;
        let (mut row, mut doubt) = ([0.0; COLUMNS], 0.0);
        for (j, &phi) in self.phi.iter().enumerate() {
            let k = start + j;
            // The angles are read at instants, each between the voltage before and the one after.
            let v = 0.5 * (voltage_v[k - 1] + voltage_v[k]);
            let (on_plus, on_minus) = (f64::from(u8::from(v > 0.0)), f64::from(u8::from(v < 0.0)));
            let w = self.speed_rad_s[k];
            let sign = (w / SLIDING_RAD_S).clamp(-1.0, 1.0);
            doubt += phi * f64::from(u8::from(sign.abs() < 1.0));
            let angle = theta_rad[k] - theta_rad[start];
            let terms = [
                self.phi_2[j] * angle,
                self.phi_2[j] * alpha_rad[k],
                phi * (sign.max(0.0) - on_plus),
                phi * (sign.min(0.0) + on_minus),
                -self.phi_1[j] * v,
                self.phi_4[j] * angle,
                phi * v,
                phi * on_plus,
                phi * on_minus,
                -self.phi_1[j] * angle,
                self.stribeck_rad_s.map_or(0.0, |w_s| phi * sign * rise(w, w_s)),
            ];
            row.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        (doubt < DOUBT).then_some(row)
    }
}

/// Slope of the line through the encoder's readings around each sample.
fn smoothed_speed(recorded: &Recorded<'_>) -> Vec<f64> {
    let half = ((SMOOTH_S / recorded.period_s).round() as usize).max(2);
    let theta = recorded.theta_rad;
    let around = |k: usize| slope(&theta[k.saturating_sub(half)..(k + half + 1).min(theta.len())]) / recorded.period_s;
    (0..theta.len()).map(around).collect()
}
