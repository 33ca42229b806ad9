//! Step responses on many simulated rigs whose parameters differ from the nominal ones.
//!
//! Enters: a rig, the kernel's settings and controller, spreads, a seed. Leaves: every run and its quantiles.
//! Absent: the clock; the result depends on the seed and the number of runs, not on the number of threads.

use crate::Error;
use flexbeam_kernel::{Controller, Settings};
use flexbeam_lti::StateSpace;
use flexbeam_rig::{
    Actuator, Damping, Friction, Link, Physical, RigParameters, SimulatedRig, StepMetrics, closed_loop,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// Relative standard deviations: each quantity is multiplied by e^(sigma n), n standard normal, drawn anew in each run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Hub inertia J_base. Default 0.03: gears and couplings are known from data sheets.
    pub J_base: f64,
    /// Link inertia J_link. Default 0.03: a gauge, its cable and screws.
    pub J_link: f64,
    /// Link stiffness K_stiff. Default 0.05: thickness enters with its cube, and the clamp gives way.
    pub K_stiff: f64,
    /// Motor constant K_b = K_T. Default 0.03: magnets, warm and cold.
    pub K_b: f64,
    /// Armature resistance. Default 0.05: 12 K of copper.
    pub R_ohm: f64,
    /// Viscous friction B_eq. Default 0.3.
    pub B_eq: f64,
    /// Damping of the beam. Default 0.3.
    pub damping: f64,
    /// Coulomb friction and Stribeck excess. Default 0.2: temperature, grease, wear.
    pub friction: f64,
    /// Dead zone, both sides together. Default 0.2.
    pub dead_zone: f64,
    /// Standard deviation of the gauge's bias [rad]; absolute. Default 2e-4, of the size of its noise.
    pub bias_rad: f64,
}

impl Default for Spread {
    fn default() -> Spread {
        Spread {
            J_base: 0.03,
            J_link: 0.03,
            K_stiff: 0.05,
            K_b: 0.03,
            R_ohm: 0.05,
            B_eq: 0.3,
            damping: 0.3,
            friction: 0.2,
            dead_zone: 0.2,
            bias_rad: 2e-4,
        }
    }
}

impl Spread {
    /// Every rig like the nominal one; only sensor noise differs from run to run.
    pub const NONE: Spread = Spread {
        J_base: 0.0,
        J_link: 0.0,
        K_stiff: 0.0,
        K_b: 0.0,
        R_ohm: 0.0,
        B_eq: 0.0,
        damping: 0.0,
        friction: 0.0,
        dead_zone: 0.0,
        bias_rad: 0.0,
    };

    /// A rig of this spread around the nominal one.
    fn draw(&self, nominal: &RigParameters, random: &mut ChaCha8Rng) -> RigParameters {
        let mut factor = |sigma: f64| {
            let n: f64 = StandardNormal.sample(random);
            (sigma * n).exp()
        };
        let p = nominal.physical;
        let physical = Physical {
            J_base: p.J_base * factor(self.J_base),
            J_link: p.J_link * factor(self.J_link),
            K_stiff: p.K_stiff * factor(self.K_stiff),
            K_b: p.K_b * factor(self.K_b),
            R_ohm: p.R_ohm * factor(self.R_ohm),
            B_eq: p.B_eq * factor(self.B_eq),
            ..p
        };
        let link = with_damping(nominal.link, factor(self.damping));
        let friction = with_friction(nominal.friction, factor(self.friction));
        let dead_zone = factor(self.dead_zone);
        let actuator = Actuator {
            dead_zone_plus_v: nominal.actuator.dead_zone_plus_v * dead_zone,
            dead_zone_minus_v: nominal.actuator.dead_zone_minus_v * dead_zone,
            ..nominal.actuator
        };
        let mut sensors = nominal.sensors;
        let bias: f64 = StandardNormal.sample(random);
        sensors.gauge.bias_rad += self.bias_rad * bias;
        RigParameters { physical, link, friction, actuator, sensors, ..*nominal }
    }
}

fn with_damping(link: Link, factor: f64) -> Link {
    match link {
        Link::Lumped => Link::Lumped,
        Link::Modes { count, damping, tip_mass_kg } => {
            let damping = match damping {
                Damping::Modal { zeta } => Damping::Modal { zeta: zeta * factor },
                Damping::KelvinVoigt { eta_s } => Damping::KelvinVoigt { eta_s: eta_s * factor },
            };
            Link::Modes { count, damping, tip_mass_kg }
        }
    }
}

fn with_friction(friction: Friction, factor: f64) -> Friction {
    let mut scaled = friction;
    scaled.coulomb_nm *= factor;
    if let Some(stribeck) = &mut scaled.stribeck {
        stribeck.extra_nm *= factor;
    }
    scaled
}

/// What each run does: a step from rest.
#[derive(Clone, Copy, Debug)]
pub struct Scenario<'a> {
    /// The rig around which the runs' rigs are drawn.
    pub rig: RigParameters,
    /// The kernel's settings.
    pub settings: Settings,
    /// Inputs (v, y, u_applied), outputs (u, y_model).
    pub controller: &'a StateSpace,
    /// Height of the step [rad]; every second run takes it downwards, since friction has a direction.
    pub step_rad: f64,
    /// Length of a run [s].
    pub duration_s: f64,
}

/// How many runs, and which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Campaign {
    /// Number of runs. Default 1000.
    pub runs: usize,
    /// Seed. Default 1.
    pub seed: u64,
    /// Threads. Default 2; the result does not depend on it.
    pub threads: usize,
    /// Spread of the parameters.
    pub spread: Spread,
}

impl Default for Campaign {
    fn default() -> Campaign {
        Campaign { runs: 1000, seed: 1, threads: 2, spread: Spread::default() }
    }
}

/// One run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// The rig that was drawn.
    pub rig: RigParameters,
    /// Its step response.
    pub metrics: StepMetrics,
    /// Time of the first fault that the kernel latched [s].
    pub fault_s: Option<f64>,
}

/// An unstable loop grows until the voltage limit holds it: its residual vibration is then a good part of the step. A stick-slip
/// limit cycle stays below.
const VIBRATING: f64 = 0.1;
/// Or it runs away smoothly at full voltage, and the step is soon a small part of its error. Friction leaves less than this.
const ASTRAY: f64 = 0.5;

impl Run {
    /// No fault, at the end a vibration below a tenth of the step and an error below half of it.
    pub fn is_stable(&self) -> bool {
        let step = self.metrics.step_rad.abs();
        let rests = self.metrics.residual_vibration_rad <= VIBRATING * step;
        self.fault_s.is_none() && rests && self.metrics.stationary_error_rad <= ASTRAY * step
    }
}

/// Of one measure over all runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// Half of the runs are at most this.
    pub median: f64,
    /// 95 % of the runs are at most this.
    pub p95: f64,
    /// The largest.
    pub worst: f64,
}

impl Quantiles {
    /// The smallest values that at least 50, 95, 100 % of the values do not exceed; NaN without values.
    pub fn of(values: impl Iterator<Item = f64>) -> Quantiles {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let at = |percent: usize| {
            let rank = (percent * sorted.len()).div_ceil(100).max(1);
            sorted.get(rank - 1).copied().unwrap_or(f64::NAN)
        };
        Quantiles { median: at(50), p95: at(95), worst: at(100) }
    }
}

/// Figures of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Every run, in order.
    pub runs: Vec<Run>,
    /// Share of runs that are stable, 0 to 1.
    pub share_stable: f64,
    /// Share of runs with a limit cycle, 0 to 1.
    pub share_limit_cycle: f64,
    /// Settling time, 2 % [s]; infinite for a run that did not settle.
    pub settling_time_s: Quantiles,
    /// Stationary error [rad].
    pub stationary_error_rad: Quantiles,
    /// Residual vibration [rad].
    pub residual_vibration_rad: Quantiles,
    /// Overshoot [percent].
    pub overshoot_percent: Quantiles,
    /// Largest voltage [V].
    pub peak_voltage_v: Quantiles,
}

impl Summary {
    fn of(runs: Vec<Run>) -> Summary {
        let share = |count: usize| count as f64 / runs.len() as f64;
        let quantiles = |measure: fn(&StepMetrics) -> f64| Quantiles::of(runs.iter().map(|run| measure(&run.metrics)));
        Summary {
            share_stable: share(runs.iter().filter(|run| run.is_stable()).count()),
            share_limit_cycle: share(runs.iter().filter(|run| run.metrics.limit_cycle).count()),
            settling_time_s: quantiles(|m| m.settling_time_s.unwrap_or(f64::INFINITY)),
            stationary_error_rad: quantiles(|m| m.stationary_error_rad),
            residual_vibration_rad: quantiles(|m| m.residual_vibration_rad),
            overshoot_percent: quantiles(|m| m.overshoot_percent),
            peak_voltage_v: quantiles(|m| m.peak_voltage_v),
            runs,
        }
    }
}

/// Runs the campaign; `progress` hears the number of runs done, on the caller's thread.
///
/// Run k draws from stream k of a ChaCha generator with the campaign's seed: first its rig, then the seed of its sensors' noise.
/// Errors: [`Error::Setting`] for no runs or no threads; [`Error::Shape`], [`Error::Kernel`] for what is no controller;
/// [`Error::Rig`] for a rig that cannot be simulated.
/// Numerics: the runs of 5 s at 1 kHz take some milliseconds each.
pub fn monte_carlo(
    scenario: &Scenario<'_>,
    campaign: &Campaign,
    mut progress: impl FnMut(usize),
) -> Result<Summary, Error> {
    expect_some("runs", campaign.runs)?;
    expect_some("threads", campaign.threads)?;
    let coefficients = coefficients(scenario.controller)?;
    let controller = Controller::new(scenario.controller.order(), &coefficients)?;
    let next = AtomicUsize::new(0);
    let (finished, results) = mpsc::channel();
    let mut runs: Vec<Option<Run>> = vec![None; campaign.runs];
    std::thread::scope(|scope| {
        for _ in 0..campaign.threads {
            let (finished, next, controller) = (finished.clone(), &next, &controller);
            scope.spawn(move || {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= campaign.runs || finished.send((k, run(scenario, campaign, controller, k))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(finished);
        for (done, (k, result)) in results.iter().enumerate() {
            runs[k] = Some(result?);
            progress(done + 1);
        }
        Ok::<(), Error>(())
    })?;
    Ok(Summary::of(runs.into_iter().map(|run| run.expect("every run was sent")).collect()))
}

fn run(scenario: &Scenario<'_>, campaign: &Campaign, controller: &Controller<'_>, k: usize) -> Result<Run, Error> {
    let mut random = ChaCha8Rng::seed_from_u64(campaign.seed);
    random.set_stream(k as u64);
    let parameters = campaign.spread.draw(&scenario.rig, &mut random);
    let mut rig = SimulatedRig::new(&parameters, rand::RngExt::random(&mut random))?;
    let step_rad = if k.is_multiple_of(2) { scenario.step_rad } else { -scenario.step_rad };
    let samples = (scenario.duration_s / parameters.period_s).round() as usize;
    let reference = |time_s: f64| if time_s > 0.0 { step_rad } else { 0.0 };
    let record = closed_loop(&mut rig, &scenario.settings, controller, reference, samples);
    let fault_s = record.first_fault().map(|(time_s, _)| time_s);
    Ok(Run { rig: parameters, metrics: StepMetrics::of(&record)?, fault_s })
}

/// A, B, C and the first two columns of D, column-major: what the kernel steps.
fn coefficients(controller: &StateSpace) -> Result<Vec<f64>, Error> {
    crate::Feedback::new(controller)?;
    let D = controller.D.columns(0, 2).into_owned();
    let parts = [controller.A.as_slice(), controller.B.as_slice(), controller.C.as_slice(), D.as_slice()];
    Ok(parts.concat())
}

fn expect_some(name: &'static str, value: usize) -> Result<(), Error> {
    if value > 0 { Ok(()) } else { Err(Error::Setting { name, value: 0.0, needed: "at least 1" }) }
}
