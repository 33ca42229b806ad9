//! Dead zone, Coulomb and viscous friction from constant-speed runs and from what follows when the voltage is cut.
//!
//! While the hub slides one way, the angular momentum of hub and link obeys, in volts (everything divided by g = K_g K_T/R),
//!
//! ```text
//! J1 theta'' + J2 alpha'' = V - sgn(V) V_dead - s theta' - sgn(theta') V_coulomb,    s = c/b = K_g K_b + B_eq/g
//! ```
//!
//! with a dead zone and a Coulomb voltage of each direction. Three facts decide what signals can tell:
//!
//! * At constant speed both sides of zero read V = sgn (V_dead + V_coulomb) + s theta': the two volts only as a sum.
//! * With V = 0 the dead zone is out of the equation, the back-emf and Coulomb torque are not: the coast after a cut tells them apart.
//! * Nothing measured in volts and angles holds a torque: N m need K_g, K_b and R, or R alone when B_eq is zero ([`Motor`]).
//!
//! Enters: a recording with such runs ([`plan`] makes the voltages). Leaves: numbers, each with the standard error of a
//! jackknife over the runs. Deliberately absent: the simulated rig, whose equations the test must not presume.

mod balance;
mod line;
pub mod plan;
mod runs;

use crate::Error;
use balance::{Balance, Parted};
use line::Line;
pub use runs::Run;

/// Fewest runs each way: two lines with one slope, and one run to spare for the jackknife.
const FEWEST_RUNS: usize = 3;
/// The slope and the sums come apart when the fastest run is at least this many times as fast as the slowest.
const LEAST_SPREAD: f64 = 2.0;

/// The balance is taken over windows of three lengths, as parts of the one asked for: what the answer owes to this choice shows as
/// their scatter.
const LENGTHS: [f64; 3] = [0.8, 1.0, 1.2];

/// What a constant-speed test recorded: one voltage and both angles a sample; the voltage acts from its sample on.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// Commanded voltage [V].
    pub voltage_v: &'a [f64],
    /// Hub angle [rad].
    pub theta_rad: &'a [f64],
    /// Deflection angle [rad]; a bias does not matter.
    pub alpha_rad: &'a [f64],
    /// Sample period [s].
    pub period_s: f64,
}

/// How the recording is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is left out at the start of a run [s], default 0.5: the slowest motion of the paper's hub has died to 0.4 %.
    pub settle_s: f64,
    /// Shortest steady stretch [s], default 0.3.
    pub steady_s: f64,
    /// What is looked at behind a cut [s], default 1.2.
    pub coast_s: f64,
    /// Middle length of the windows of the momentum balance [s], default 0.22: its first zero, at 14 Hz, lies below the second mode, and
    /// half of it hides the resolution of the encoder.
    pub window_s: f64,
    /// One encoder count [rad], default 2 pi / 4096.
    pub resolution_rad: f64,
}

impl Default for Options {
    fn default() -> Options {
        let resolution_rad = std::f64::consts::TAU / 4096.0;
        Options { settle_s: 0.5, steady_s: 0.3, coast_s: 1.2, window_s: 0.22, resolution_rad }
    }
}

/// A number and how far it can be believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error, in the same unit.
    pub standard_error: f64,
    /// Degrees of freedom behind the standard error.
    pub freedom: usize,
}

impl Estimate {
    /// Half the width of the interval that holds the truth in 95 of 100 tests: Student's t times the standard error.
    pub fn half_width_95(&self) -> f64 {
        student_95(self.freedom) * self.standard_error
    }
}

/// The 97.5 % quantile of Student's t.
///
/// Numerics: Cornish-Fisher expansion to the fourth order, within 0.2 % from 3 degrees of freedom on; 1 and 2 are exact.
/// Source: Abramowitz and Stegun 26.7.5.
pub fn student_95(freedom: usize) -> f64 {
    // tan(0.475 pi), and 0.95 sqrt(2/(1 - 0.95^2)).
    match freedom {
        0 | 1 => return 12.706_204_736,
        2 => return 4.302_652_730,
        _ => {}
    }
    let (z, n) = (1.959_963_984_540_054_f64, freedom as f64);
    let g = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
        (79.0 * z.powi(9) + 776.0 * z.powi(7) + 1482.0 * z.powi(5) - 1920.0 * z.powi(3) - 945.0 * z) / 92160.0,
    ];
    z + g[0] / n + g[1] / (n * n) + g[2] / n.powi(3) + g[3] / n.powi(4)
}

/// What makes newton metres of volts; none of it is in the signals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motor {
    /// Gear ratio, motor constant [V s/rad = N m/A] and resistance [ohm] are known: viscous friction is what the slope has beyond
    /// the back-emf.
    Known {
        /// Gear ratio.
        K_g: f64,
        /// Motor constant [V s/rad].
        K_b: f64,
        /// Armature resistance [ohm].
        R_ohm: f64,
    },
    /// There is no viscous friction, so the slope is the back-emf: K_g K_b = s, and only the resistance is needed.
    NoViscous {
        /// Armature resistance [ohm].
        R_ohm: f64,
    },
}

impl Motor {
    /// g = K_g K_T/R [N m/V].
    fn torque_per_volt(&self, slope_v_s: f64) -> f64 {
        match *self {
            Motor::Known { K_g, K_b, R_ohm } => K_g * K_b / R_ohm,
            Motor::NoViscous { R_ohm } => slope_v_s / R_ohm,
        }
    }

    /// B_eq = g (s - K_g K_b) [N m s/rad].
    fn viscous(&self, slope_v_s: f64) -> f64 {
        match *self {
            Motor::Known { K_g, K_b, .. } => self.torque_per_volt(slope_v_s) * (slope_v_s - K_g * K_b),
            Motor::NoViscous { .. } => 0.0,
        }
    }
}

/// One fit of all numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Numbers {
    line: Line,
    parted: Option<Parted>,
}

/// What the runs say.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionTest {
    /// Every steady run, in the order of the recording.
    pub runs: Vec<Run>,
    /// Stretches of constant voltage that were left out: the hub stood, or had not come to a constant speed.
    pub left_out: usize,
    /// Why dead zone and Coulomb torque could not be told apart, where they could not.
    pub together: Option<Error>,
    /// Runs whose coast was seen.
    coasts: usize,
    /// A fit by each of [`LENGTHS`].
    whole: Fits,
    /// The fits without each run in turn.
    without: Vec<Fits>,
}

type Fits = [Numbers; LENGTHS.len()];

/// All numbers of a recorded test.
///
/// Assumes: the voltage is held constant in runs of both directions, each `settle_s + steady_s` or longer, from rest or not;
/// dead zone and Coulomb torque are told apart when some of the runs end in 0 V at once.
/// Errors: [`Error::Length`], [`Error::NotFinite`], [`Error::TooFewRuns`], [`Error::OneSpeed`], [`Error::Setting`] for a sample period too long for the windows.
/// Numerics: O(samples). Standard errors by the jackknife over runs: what differs from run to run is in them, the resolution of
/// the converter, the encoder and what the beam's second mode leaves; the error of [`Motor`]'s constants is not.
pub fn friction(recorded: &Recorded<'_>, options: &Options) -> Result<FrictionTest, Error> {
    recorded.check(options)?;
    let (runs, left_out) = runs::steady_runs(recorded, options);
    enough(&runs)?;
    let line = Line::through(&runs.iter().collect::<Vec<_>>())?;
    let balances =
        LENGTHS.map(|part| Balance::of(recorded, part * options.window_s, &runs, line.stribeck_speed_rad_s()));
    let together = balances.iter().find_map(|balance| balance.parted(&line, None).err());
    let fit = |without: Option<usize>| -> Result<Fits, Error> {
        let others = runs.iter().enumerate().filter(|(k, _)| Some(*k) != without);
        let line = line.again(&others.map(|(_, run)| run).collect::<Vec<_>>())?;
        let mut fits = [Numbers { line, parted: None }; LENGTHS.len()];
        for (fit, balance) in fits.iter_mut().zip(&balances).filter(|_| together.is_none()) {
            fit.parted = Some(balance.parted(&line, without)?);
        }
        Ok(fits)
    };
    let whole = fit(None)?;
    let without = (0..runs.len()).map(|k| fit(Some(k))).collect::<Result<_, _>>()?;
    let coasts = balances[0].coasts();
    Ok(FrictionTest { runs, left_out, together, coasts, whole, without })
}

impl Recorded<'_> {
    fn check(&self, options: &Options) -> Result<(), Error> {
        let inputs = self.voltage_v.len();
        for (name, channel) in [("voltage", self.voltage_v), ("theta", self.theta_rad), ("alpha", self.alpha_rad)] {
            if channel.len() != inputs {
                return Err(Error::Length { inputs, outputs: channel.len() });
            }
            if let Some(sample) = channel.iter().position(|x| !x.is_finite()) {
                return Err(Error::NotFinite { channel: name.into(), sample, value: channel[sample] });
            }
        }
        if self.period_s > 0.0 && self.period_s <= options.window_s / 20.0 {
            return Ok(());
        }
        Err(Error::Setting {
            setting: "the sample period [s] of a friction test",
            found: self.period_s,
            needed: "0.01 s or less",
        })
    }
}

/// Errors: too few runs one way; all runs at about one speed.
fn enough(runs: &[Run]) -> Result<(), Error> {
    for (direction, sign) in [("forward", 1.0), ("backward", -1.0)] {
        let found = runs.iter().filter(|run| sign * run.speed_rad_s > 0.0).count();
        if found < FEWEST_RUNS {
            return Err(Error::TooFewRuns { direction, found, needed: FEWEST_RUNS });
        }
    }
    let speeds = || runs.iter().map(|run| run.speed_rad_s.abs());
    let (slowest, fastest) = (speeds().fold(f64::MAX, f64::min), speeds().fold(0.0, f64::max));
    if fastest < LEAST_SPREAD * slowest { Err(Error::OneSpeed { slowest, fastest }) } else { Ok(()) }
}

/// Numbers in volts, which the signals alone give.
impl FrictionTest {
    /// Dead zone and Coulomb friction together, forward [V].
    pub fn dry_plus_v(&self) -> Estimate {
        self.estimate(|n| n.line.plus_v)
    }

    /// The same backward [V], a magnitude.
    pub fn dry_minus_v(&self) -> Estimate {
        self.estimate(|n| n.line.minus_v)
    }

    /// s = c/b = K_g K_b + B_eq/g [V s/rad].
    pub fn slope_v_s(&self) -> Estimate {
        self.estimate(|n| n.line.slope_v_s)
    }

    /// Stribeck's rise towards standstill [V] and the speed over which it decays [rad/s], where the runs show one.
    pub fn stribeck(&self) -> Option<(Estimate, f64)> {
        let speed_rad_s = self.whole[0].line.stribeck_speed_rad_s()?;
        Some((self.estimate(|n| n.line.extra_v), speed_rad_s))
    }

    /// Coulomb friction alone, forward [V].
    pub fn coulomb_plus_v(&self) -> Option<Estimate> {
        self.of_parts(|_, parts| parts.coulomb_v(1.0))
    }

    /// The same backward [V], a magnitude.
    pub fn coulomb_minus_v(&self) -> Option<Estimate> {
        self.of_parts(|_, parts| parts.coulomb_v(-1.0))
    }

    /// Dead zone forward [V].
    pub fn dead_zone_plus_v(&self) -> Option<Estimate> {
        self.of_parts(|n, parts| n.line.plus_v - parts.coulomb_v(1.0))
    }

    /// The same backward [V], a magnitude.
    pub fn dead_zone_minus_v(&self) -> Option<Estimate> {
        self.of_parts(|n, parts| n.line.minus_v - parts.coulomb_v(-1.0))
    }

    /// Inertia of hub and link together, J1 = (J_base + J_link)/g [V s^2/rad].
    pub fn inertia_v_s2(&self) -> Option<Estimate> {
        self.of_parts(|_, parts| parts.inertia_v_s2)
    }

    /// By how much the voltage acts later than the recording says [s].
    pub fn delay_s(&self) -> Option<Estimate> {
        self.of_parts(|_, parts| parts.delay_s)
    }

    /// The voltage that the fitted curve has at this hub speed [V], and its standard error.
    pub fn voltage_at(&self, speed_rad_s: f64) -> Estimate {
        self.estimate(|n| n.line.voltage_v(speed_rad_s))
    }
}

/// Numbers in newton metres, by the motor's constants.
impl FrictionTest {
    /// Coulomb torque, the mean of both directions [N m].
    pub fn coulomb_nm(&self, motor: &Motor) -> Option<Estimate> {
        self.of_parts(|n, parts| {
            motor.torque_per_volt(n.line.slope_v_s) * 0.5 * (parts.coulomb_v(1.0) + parts.coulomb_v(-1.0))
        })
    }

    /// Viscous friction besides the motor's own B_eq [N m s/rad]; negative when K_b is less than was stated.
    pub fn viscous(&self, motor: &Motor) -> Estimate {
        self.estimate(|n| motor.viscous(n.line.slope_v_s))
    }

    /// Stribeck's rise [N m].
    pub fn stribeck_extra_nm(&self, motor: &Motor) -> Option<Estimate> {
        self.stribeck().map(|_| self.estimate(|n| motor.torque_per_volt(n.line.slope_v_s) * n.line.extra_v))
    }

    /// g, the hub torque at stall per volt [N m/V].
    pub fn torque_per_volt(&self, motor: &Motor) -> Estimate {
        self.estimate(|n| motor.torque_per_volt(n.line.slope_v_s))
    }
}

impl FrictionTest {
    /// Mean over the lengths of the windows; var = (m - 1)/m sum (x_k - mean)^2 over the fits without one of the m runs, and the variance
    /// between the lengths on top.
    ///
    /// Source: Efron and Tibshirani, An Introduction to the Bootstrap, 1993, eq. 11.5.
    fn estimate(&self, number: impl Fn(&Numbers) -> f64) -> Estimate {
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let scatter = |x: &[f64]| x.iter().map(|x_k| (x_k - mean(x)).powi(2)).sum::<f64>();
        let by_length = self.whole.each_ref().map(&number);
        let without: Vec<f64> = self.without.iter().map(|fits| mean(&fits.each_ref().map(&number))).collect();
        let m = without.len() as f64;
        let variance = (m - 1.0) / m * scatter(&without) + scatter(&by_length) / (LENGTHS.len() - 1) as f64;
        let freedom = self.runs.len() - self.whole[0].line.unknowns();
        Estimate { value: mean(&by_length), standard_error: variance.sqrt(), freedom }
    }

    /// Only the runs whose coast was seen count for these.
    fn of_parts(&self, number: impl Fn(&Numbers, &Parted) -> f64) -> Option<Estimate> {
        self.whole[0].parted?;
        let estimate = self.estimate(|n| n.parted.as_ref().map_or(f64::NAN, |parts| number(n, parts)));
        let freedom = self.coasts.saturating_sub(balance::UNKNOWN).max(1);
        Some(Estimate { freedom: freedom.min(estimate.freedom), ..estimate })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_s_t_is_that_of_the_tables() {
        for (freedom, t) in
            [(1, 12.7062), (2, 4.3027), (3, 3.1824), (5, 2.5706), (10, 2.2281), (16, 2.1199), (100, 1.9840)]
        {
            assert!((student_95(freedom) / t - 1.0).abs() < 2e-3, "{freedom}: {}", student_95(freedom));
        }
    }
}
