//! Before a real rig runs: does it turn the way the model does, and where is zero.
//!
//! Enters: samples of short open-loop runs. Leaves: a verdict on the signs, the zeroes of encoder and gauge. Deliberately absent:
//! the runs themselves ([`crate::drive`]).

use crate::lifecycle::Phase;
use crate::sample::Sample;
use std::sync::Arc;

/// One count of an encoder with 4096 counts a turn [rad].
const COUNT_RAD: f64 = std::f64::consts::TAU / 4096.0;
/// A hub at rest flickers between two counts.
const REST_THETA_RAD: f64 = 2.5 * COUNT_RAD;
/// A beam at rest: the gauge's noise and what is left of a swing, root mean square [rad]; a fifth of a degree.
const REST_ALPHA_RAD: f64 = 0.0035;
/// The hub has moved when it is this far from where it was [rad].
const MOVED_RAD: f64 = 6.0 * COUNT_RAD;
/// Further than this nothing is waited for [rad]: 10 degrees.
const MUCH_RAD: f64 = 0.175;
/// The beam lags behind for less than half a swing at the clamped frequency of 3.2 Hz [s].
const LAG_S: f64 = 0.12;
/// A lag counts beyond this multiple of the gauge's noise at rest.
const ABOVE_NOISE: f64 = 5.0;

/// Where the sensors stand when the rig rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zero {
    /// Reading of the encoder [rad].
    pub theta_rad: f64,
    /// Reading of the gauge: its bias [rad].
    pub alpha_rad: f64,
    /// Noise of the gauge, root mean square [rad].
    pub alpha_noise_rad: f64,
}

/// A rig that cannot be homed, or must not run.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotHomed {
    /// It moves.
    #[error(
        "found a rig that moves at 0 V (hub by {theta_deg:.2} degree, beam by {alpha_deg:.2} degree rms), needed one at rest\nhint: hold the beam until it is still, then start again"
    )]
    NotAtRest {
        /// Range of the hub angle [degree].
        theta_deg: f64,
        /// Standard deviation of the deflection [degree].
        alpha_deg: f64,
    },
    /// No measurement at all.
    #[error("found no measurement, needed some\nhint: look at the link's counters: lost, corrupt, foreign")]
    NoMeasurement,
    /// The hub goes the other way.
    #[error(
        "found that the hub turns against the voltage: {theta_deg:+.2} degree at {voltage_v:+.2} V; needed the same sign\nhint: swap the motor's leads, or turn the sign of voltage or encoder round (theta=-1 in a board's port, or in the rig's firmware); with this sign the loop would run away"
    )]
    HubAgainst {
        /// How far it turned [degree].
        theta_deg: f64,
        /// At which voltage [V].
        voltage_v: f64,
    },
    /// The gauge goes the other way.
    #[error(
        "found that the gauge leads: {alpha_deg:+.2} degree while the hub turned {theta_deg:+.2} degree; needed the opposite sign, because the tip lags behind\nhint: turn the gauge's sign round (alpha=-1 in a board's port, or in the rig's firmware); with this sign the loop would feed the swing"
    )]
    GaugeAgainst {
        /// Largest deflection in the first swing [degree].
        alpha_deg: f64,
        /// How far the hub turned [degree].
        theta_deg: f64,
    },
    /// Nothing happened.
    #[error(
        "found no movement up to {voltage_v:.2} V, needed one\nhint: is the amplifier on, the emergency stop released, the encoder plugged in? --sign-check VOLTS goes higher"
    )]
    NeverMoved {
        /// The highest voltage [V].
        voltage_v: f64,
    },
}

/// What the sign check saw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignsAgree {
    /// Voltage at which the hub moved [V].
    pub voltage_v: f64,
    /// How far it went [rad].
    pub theta_rad: f64,
    /// The first swing of the beam [rad]; nothing where it drowned in the gauge's noise, so that its sign is not proven.
    pub alpha_rad: Option<f64>,
}

/// The zeroes of a rig at rest.
///
/// Errors: [`NotHomed::NotAtRest`], [`NotHomed::NoMeasurement`].
pub fn zero_of(samples: &[Sample]) -> Result<Zero, NotHomed> {
    let (theta, alpha): (Vec<f64>, Vec<f64>) =
        fresh(samples).map(|s| (s.measured.theta_rad, s.measured.alpha_rad)).unzip();
    if theta.is_empty() {
        return Err(NotHomed::NoMeasurement);
    }
    let (theta_rad, alpha_rad) = (mean(&theta), mean(&alpha));
    let alpha_noise_rad = mean(&alpha.iter().map(|a| (a - alpha_rad).powi(2)).collect::<Vec<_>>()).sqrt();
    let range = theta.iter().fold(0.0_f64, |widest, t| widest.max((t - theta[0]).abs()));
    if range <= REST_THETA_RAD && alpha_noise_rad <= REST_ALPHA_RAD {
        return Ok(Zero { theta_rad, alpha_rad, alpha_noise_rad });
    }
    Err(NotHomed::NotAtRest { theta_deg: range.to_degrees(), alpha_deg: alpha_noise_rad.to_degrees() })
}

/// Voltages of a sign check: up to `highest_v` at `rate_v_s`. The run is to be ended by [`SignWatch`] soon after the hub moves.
pub fn sign_check_voltages(highest_v: f64, rate_v_s: f64, period_s: f64) -> Arc<[f64]> {
    let ticks = (highest_v / rate_v_s / period_s).ceil().max(1.0);
    (1..=ticks as usize).map(|k| highest_v * k as f64 / ticks).collect()
}

/// Watches a sign check and says when it has seen enough: half a swing after the hub moved, or much movement at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignWatch {
    zero: Zero,
    lag_ticks: u64,
    moved: Option<u64>,
}

impl SignWatch {
    /// From a rig at rest.
    pub fn new(zero: Zero, period_s: f64) -> SignWatch {
        SignWatch { zero, lag_ticks: (LAG_S / period_s).ceil() as u64, moved: None }
    }

    /// Whether the run may end with this sample.
    pub fn enough(&mut self, sample: &Sample) -> bool {
        let turned = (sample.measured.theta_rad - self.zero.theta_rad).abs();
        if self.moved.is_none() && !sample.stale && turned > MOVED_RAD {
            self.moved = Some(sample.instant);
        }
        let half_a_swing = |moved| sample.instant.saturating_sub(moved) >= self.lag_ticks;
        self.moved.is_some_and(|moved| turned > MUCH_RAD || half_a_swing(moved))
    }
}

/// Whether hub and gauge answered a positive voltage as the model does.
///
/// The hub must turn with the voltage. The tip lags behind a hub that sets off, so alpha first has the sign opposite to theta's.
///
/// Errors: [`NotHomed::NeverMoved`], [`NotHomed::HubAgainst`], [`NotHomed::GaugeAgainst`].
pub fn signs_of(samples: &[Sample], zero: &Zero) -> Result<SignsAgree, NotHomed> {
    let turned = |s: &Sample| s.measured.theta_rad - zero.theta_rad;
    let highest_v = samples.iter().fold(0.0_f64, |highest, s| highest.max(s.voltage_v));
    let Some(first) = fresh(samples).find(|s| turned(s).abs() > MOVED_RAD) else {
        return Err(NotHomed::NeverMoved { voltage_v: highest_v });
    };
    let theta_rad = turned(first);
    if theta_rad < 0.0 {
        return Err(NotHomed::HubAgainst { theta_deg: theta_rad.to_degrees(), voltage_v: first.voltage_v });
    }
    let bent = fresh(samples).map(|s| s.measured.alpha_rad - zero.alpha_rad);
    let alpha_rad = bent.fold(0.0_f64, |largest, a| if a.abs() > largest.abs() { a } else { largest });
    let seen = alpha_rad.abs() > ABOVE_NOISE * zero.alpha_noise_rad.max(f64::MIN_POSITIVE);
    if seen && alpha_rad > 0.0 {
        return Err(NotHomed::GaugeAgainst { alpha_deg: alpha_rad.to_degrees(), theta_deg: theta_rad.to_degrees() });
    }
    Ok(SignsAgree { voltage_v: first.voltage_v, theta_rad, alpha_rad: Some(alpha_rad).filter(|_| seen) })
}

fn fresh(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    samples.iter().filter(|s| !s.stale && s.phase == Phase::Running)
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}
