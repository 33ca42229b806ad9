//! The sampled loop on the exact distributed beam.
//!
//! Behind hold, delay and filter the beam's response at z = e^(s Ts) is the sum over its aliases s_k = s + 2 pi j k/Ts,
//!
//! ```text
//! G_d(z) = H(z) (1/Ts) sum_k G(s_k) (1 - e^(-s_k Ts))/s_k e^(-s_k delay).
//! ```
//!
//! Enters: the rig's beam, timing, a nominal plant, alpha_w. Leaves: counts on the exact response, what the beam differs from
//! the nominal plant, its neglected modes. Absent: model order reduction.

use crate::bound::image_magnitude;
use crate::feedback::{Feedback, Loop};
use crate::plant::{Plant, Sampled, Timing};
use crate::sweep::{self, Peak};
use crate::verify::{Comparison, Verified};
use crate::{Count, Error, count};
use flexbeam_lti::{C64, StateSpace, Zpk};
use flexbeam_rig::{Beam, Motion};
use std::f64::consts::TAU;

/// The distributed beam, sampled exactly.
#[derive(Clone, Debug)]
pub struct BeamPlant {
    beam: Beam,
    timing: Timing,
    /// Aliases s_k, -aliases <= k <= aliases, that are summed.
    aliases: usize,
    /// Bound of what the others add [rad/V].
    tail: f64,
    modes: Vec<C64>,
    poles: Vec<C64>,
}

/// What the aliases left out may add, relative to |G| at the first mode: far below what a verdict depends on (5 aliases to each
/// side at 1 kHz on the paper's beam; 1e-12 takes 3900).
pub const TAIL: f64 = 1e-6;
/// Modes up to this multiple of pi/Ts are known to the count. Later ones fold back with a part in a million of the peak.
const KNOWN_BAND: f64 = 1.5;
/// Modes that are known in any case, for slow periods.
const LEAST_MODES: usize = 4;
/// Assumed modes from which the beam's real poles are taken.
const ASSUMED: usize = 12;
/// The roll-off constant is looked for at this many modes above the band that is summed; it falls from mode to mode.
const ROLL_OFF_MODES: usize = 8;
/// Reserve on the roll-off constant: the peak of a mode lies beside the imaginary part of its pole.
const RESERVE: f64 = 2.0;

impl BeamPlant {
    /// The beam behind hold, delay and filter, aliases left out below [`TAIL`].
    ///
    /// Errors: [`Error::Setting`], [`Error::Rig`].
    pub fn new(beam: &Beam, timing: Timing) -> Result<BeamPlant, Error> {
        BeamPlant::with_tail(beam, timing, TAIL)
    }

    /// The same with another relative tail.
    ///
    /// |G(s)| <= C/|s|^2 above the band, so what is left out is at most
    /// 2 |1 - 1/z| |z|^(-delay/Ts) C Ts^2/(2 pi)^3 sum 1/(k - 1/2)^3, k > aliases, and that sum is below 1/(2 (aliases - 1/2)^2).
    pub fn with_tail(beam: &Beam, timing: Timing, relative: f64) -> Result<BeamPlant, Error> {
        timing.check()?;
        let known =
            (1..).take_while(|k| beam.clamped_frequency_rad_s(*k) < KNOWN_BAND * timing.nyquist_rad_s()).count();
        let modes = beam.modes(known.max(LEAST_MODES));
        let mut poles: Vec<C64> = real_poles(beam)?
            .into_iter()
            .chain(modes.iter().flat_map(|p| [*p, p.conj()]))
            .map(|p| timing.z(p))
            .collect();
        poles.extend(timing.filter_pole());
        let mut plant = BeamPlant { beam: *beam, timing, aliases: 0, tail: 0.0, modes, poles };
        let peak = plant.base_band_peak();
        let unit_tail = plant.tail_constant();
        plant.aliases = (0.5 + (unit_tail / (relative * peak)).sqrt()).ceil().max(1.0) as usize;
        plant.tail = unit_tail / (plant.aliases as f64 - 0.5).powi(2);
        Ok(plant)
    }

    /// Number of aliases summed to each side.
    pub fn aliases(&self) -> usize {
        self.aliases
    }

    /// Bound of what the other aliases add [rad/V].
    pub fn tail_rad_per_v(&self) -> f64 {
        self.tail
    }

    /// The beam's oscillating poles of positive imaginary part, hub and beam together: mode 1, 2, ..
    pub fn modes(&self) -> &[C64] {
        &self.modes
    }

    /// Tail is at most this over (aliases - 1/2)^2.
    fn tail_constant(&self) -> f64 {
        let above = self.timing.nyquist_rad_s();
        let modes = (1..).map(|k| self.beam.clamped_frequency_rad_s(k));
        let roll_off = modes
            .skip_while(|omega| *omega < above)
            .take(ROLL_OFF_MODES)
            .map(|omega| omega * omega * self.beam.at(C64::new(0.0, omega)).psi().norm())
            .fold(0.0, f64::max);
        2.0 * RESERVE * roll_off * self.timing.period_s.powi(2) / TAU.powi(3)
    }

    /// |G| at the first mode, or at its corner: a lower estimate of the peak of |G_d|, which an integrator makes larger.
    fn base_band_peak(&self) -> f64 {
        let omega = self.modes.first().map_or(1.0, |p| p.norm());
        self.beam.at(C64::new(0.0, omega)).psi().norm()
    }
}

/// Real poles: the integrator, exactly, and those of the assumed modes.
fn real_poles(beam: &Beam) -> Result<Vec<C64>, Error> {
    let mut poles = Motion::assumed_modes(beam, ASSUMED, 0.0)?.state_space(&[])?.poles();
    poles.retain(|p| p.im == 0.0);
    let nearest = (0..poles.len()).min_by(|&a, &b| poles[a].norm().total_cmp(&poles[b].norm()));
    if let Some(k) = nearest {
        poles[k] = C64::ZERO;
    }
    Ok(poles)
}

impl Sampled for BeamPlant {
    fn at(&self, z: C64) -> (C64, Option<C64>) {
        let Timing { period_s, delay_s, .. } = self.timing;
        let s = self.timing.s(z);
        let term = |k: i64| {
            let s_k = s + C64::new(0.0, TAU * k as f64 / period_s);
            self.beam.at(s_k).psi() / s_k * (-s_k * delay_s).exp()
        };
        // Small terms first.
        let pairs = (1..=self.aliases as i64).rev().map(|k| term(k) + term(-k));
        let sum = pairs.fold(C64::ZERO, |sum, pair| sum + pair) + term(0);
        (sum * (1.0 - z.inv()) / period_s * self.timing.filter(z).0, None)
    }

    fn poles(&self) -> Vec<C64> {
        self.poles.clone()
    }

    fn timing(&self) -> Timing {
        self.timing
    }
}

/// A mode of the beam that the nominal plant leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeglectedMode {
    /// Its number, 1 being the first mode of hub and beam.
    pub number: usize,
    /// Imaginary part of its pole [rad/s].
    pub omega_rad_s: f64,
    /// -Re of its pole [1/s]: no stability degree above it can be promised.
    pub damping_per_s: f64,
}

/// The loop on the exact beam.
#[derive(Clone, Debug, PartialEq)]
pub struct OnBeam {
    /// Closed-loop poles right of Re s = 0.
    pub unstable: Count,
    /// Closed-loop poles right of Re s = -beta.
    pub beyond_beta: Count,
    /// sup |G_beam,d - G0,d|/|alpha_w| on the circle: below 1 the beam is covered.
    pub difference: Peak,
    /// sup |G_beam,d - G0,d| on the circle [rad/V].
    pub largest_difference: Peak,
    /// Poles of beam and nominal plant right of Re s = -beta: (19) needs them equally many.
    pub poles_beyond_beta: (usize, usize),
    /// The neglected mode with the least damping.
    pub worst_mode: Option<NeglectedMode>,
    /// Aliases summed to each side.
    pub aliases: usize,
    /// Bound of what the other aliases add [rad/V].
    pub tail_rad_per_v: f64,
}

impl OnBeam {
    /// Stable, stable to beta, covered by alpha, with equally many open-loop poles right of the line.
    pub fn figures(&self) -> Vec<Verified> {
        use Comparison::{AtMost, Equal};
        let (beam, nominal) = self.poles_beyond_beta;
        let limit = |figure, claimed: usize, recomputed: usize, comparison| {
            Verified::new(figure, claimed as f64, recomputed as f64, comparison, (0.0, "a count"))
        };
        let covered = (0.0, "(19) asks for less than alpha everywhere on the circle");
        vec![
            limit("beam.unstable_poles", 0, self.unstable.beyond, AtMost),
            limit("beam.poles_beyond_beta", 0, self.beyond_beta.beyond, AtMost),
            limit("beam.open_loop_poles_beyond_beta", nominal, beam, Equal),
            Verified::new("beam.difference_over_alpha", 1.0, self.difference.value, AtMost, covered),
        ]
    }
}

/// Lowest angle [rad] at which the difference is sampled: it is steady below.
const LOWEST: f64 = 1e-6;

/// Counts on the exact beam, and the beam's difference from the nominal plant against alpha_w.
///
/// Errors: [`Error::OnContour`], [`Error::Setting`], those of the rig.
/// Numerics: some thousand evaluations of the alias sum.
/// Source: DESIGN 6, first paragraph and 6.6.
pub fn on_beam(
    beam: &BeamPlant,
    nominal: &StateSpace,
    feedback: &Feedback,
    alpha_w: &Zpk,
    beta: f64,
) -> Result<OnBeam, Error> {
    let timing = beam.timing();
    let model = Plant::new(nominal, timing)?;
    let L = Loop::new(beam, feedback)?;
    let (unstable, rest) = std::thread::scope(|scope| {
        let unstable = scope.spawn(|| count(&L, 0.0));
        let rest = count(&L, beta).map(|beyond_beta| (beyond_beta, differences(beam, &model, alpha_w, beta)));
        (unstable.join().expect("counting does not panic"), rest)
    });
    let (beyond_beta, (difference, largest_difference)) = rest?;
    let beyond = |poles: Vec<C64>| poles.into_iter().filter(|p| p.norm() > timing.radius(beta)).count();
    Ok(OnBeam {
        unstable: unstable?,
        beyond_beta,
        difference,
        largest_difference,
        poles_beyond_beta: (beyond(beam.poles()), beyond(model.poles())),
        worst_mode: worst_neglected_mode(beam, nominal),
        aliases: beam.aliases,
        tail_rad_per_v: beam.tail,
    })
}

/// sup |G_beam,d - G0,d|/|alpha_w| and sup |G_beam,d - G0,d| on the circle.
fn differences(beam: &BeamPlant, model: &Plant, alpha_w: &Zpk, beta: f64) -> (Peak, Peak) {
    let timing = beam.timing;
    let radius = timing.radius(beta);
    let difference = |angle: f64| {
        let z = C64::from_polar(radius, angle);
        (beam.at(z).0 - model.at(z).0).norm()
    };
    let mut poles = beam.poles();
    poles.extend(model.poles());
    let sampled = |angle: f64| (angle, difference(angle));
    let samples: Vec<(f64, f64)> = sweep::angles(&poles, radius, LOWEST).into_iter().map(sampled).collect();
    let peak = |weight: &dyn Fn(f64) -> f64| {
        let known = samples.iter().map(|&(angle, value)| (angle, value * weight(angle))).collect();
        let (angle, value) = sweep::supremum_from(known, 0.0, |angle| difference(angle) * weight(angle));
        Peak { value, omega_rad_s: angle / timing.period_s }
    };
    (peak(&|angle| 1.0 / image_magnitude(alpha_w, angle, timing.period_s)), peak(&|_| 1.0))
}

/// The least damped of the modes that come after those of the nominal plant.
pub fn worst_neglected_mode(beam: &BeamPlant, nominal: &StateSpace) -> Option<NeglectedMode> {
    let kept = nominal.poles().iter().filter(|p| p.im > 0.0).count();
    let neglected = beam.modes.iter().enumerate().skip(kept);
    let named = neglected.map(|(k, p)| NeglectedMode { number: k + 1, omega_rad_s: p.im, damping_per_s: -p.re });
    named.min_by(|a, b| a.damping_per_s.total_cmp(&b.damping_per_s))
}
