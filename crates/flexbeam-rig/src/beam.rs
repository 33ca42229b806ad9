//! The distributed beam on its hub: responses that are exact at any point of the s-plane.
//!
//! Euler-Bernoulli, clamped to the hub, free at the tip: y(x,t) = x theta + w, alpha = w(L)/L.

use crate::error::not_negative;
use crate::roots::clamped_free_root;
use crate::{Error, Motion, Physical};
use flexbeam_lti::C64;

/// What takes energy out of the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// Each clamped mode has damping ratio zeta: d_k = s^2 + 2 zeta omega_k s + omega_k^2.
    Modal {
        /// Damping ratio of every mode.
        zeta: f64,
    },
    /// E* = EI (1 + eta s): d_k = s^2 + eta omega_k^2 s + omega_k^2, a ratio that grows with frequency.
    KelvinVoigt {
        /// Retardation time eta [s].
        eta_s: f64,
    },
}

impl Damping {
    /// Damping of a clamped mode, 2 zeta_k omega_k [1/s].
    pub fn rate(self, omega_rad_s: f64) -> f64 {
        match self {
            Damping::Modal { zeta } => 2.0 * zeta * omega_rad_s,
            Damping::KelvinVoigt { eta_s } => eta_s * omega_rad_s * omega_rad_s,
        }
    }
}

/// A uniform beam of length L and mass m = 3 J_link/L^2 on the hub; EI such that its first clamped frequency is
/// sqrt(K_stiff/J_link).
///
/// Its static stiffness 3EI/L differs from the lumped K_stiff by design: both have the clamped frequency right.
/// Source: DESIGN section 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Hub, motor and link.
    pub physical: Physical,
    /// Damping of the beam; [`Beam::new`] checks it.
    pub damping: Damping,
}

/// Response per volt of the distributed beam at one s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// theta/V [rad/V].
    pub theta: C64,
    /// alpha/V [rad/V].
    pub alpha: C64,
}

impl Response {
    /// psi/V = theta/V + alpha/V, the tip angle [rad/V].
    pub fn psi(&self) -> C64 {
        self.theta + self.alpha
    }
}

impl Beam {
    /// Damping ratio of each mode where nothing else is known: aluminium and steel beams with their clamps.
    pub const ZETA: f64 = 0.005;

    /// The beam with these parameters.
    ///
    /// Errors: [`Error::Parameter`] for a quantity that no rig can have.
    pub fn new(physical: Physical, damping: Damping) -> Result<Beam, Error> {
        physical.check()?;
        match damping {
            Damping::Modal { zeta } => not_negative("damping ratio zeta", "of critical", zeta)?,
            Damping::KelvinVoigt { eta_s } => not_negative("retardation time eta", "s", eta_s)?,
        };
        Ok(Beam { physical, damping })
    }

    /// The paper's rig with [`Beam::ZETA`] in every mode.
    pub fn paper() -> Beam {
        Beam { physical: Physical::paper(), damping: Damping::Modal { zeta: Beam::ZETA } }
    }

    /// omega_k = omega_1 (mu_k/mu_1)^2, the k-th frequency with the hub held [rad/s], k = 1, 2, ..
    pub fn clamped_frequency_rad_s(&self, k: usize) -> f64 {
        self.physical.clamped_frequency_rad_s() * (clamped_free_root(k) / clamped_free_root(1)).powi(2)
    }

    /// EI = omega_1^2 m L^3/mu_1^4, the bending stiffness [N m^2].
    pub fn bending_stiffness(&self) -> f64 {
        let p = &self.physical;
        p.K_stiff / p.J_link * p.link_mass_kg() * p.length_m.powi(3) / clamped_free_root(1).powi(4)
    }

    /// theta/V and alpha/V at one point of the s-plane, all modes included.
    ///
    /// Returns infinite or undefined entries at a pole (s = 0 is one).
    /// Numerics: relative error about 1e-14 off the poles; series of some hundred terms for modal damping (20
    /// microseconds), closed form for Kelvin-Voigt.
    /// Source: DESIGN section 3 (a), (b).
    ///
    /// ```
    /// // On s = jw - 1.5 the paper's beam stays within 0.087 rad/V of (18) (DESIGN section 6).
    /// use flexbeam_rig::{Beam, Lumped, Output};
    /// let G0 = Lumped::PAPER.state_space(&[Output::Psi]).unwrap();
    /// let s = nalgebra::Complex::new(-1.5, 26.0);
    /// let dG = Beam::paper().at(s).psi() - G0.at(s)[(0, 0)];
    /// assert!(dG.norm() < 0.087);
    /// ```
    pub fn at(&self, s: C64) -> Response {
        match self.damping {
            Damping::Modal { zeta } => {
                let series = self.modal_series(s, zeta);
                let theta = self.theta_from_series(&series);
                Response { theta, alpha: -s * s * theta * series.tip() * 4.0 }
            }
            Damping::KelvinVoigt { eta_s } => {
                let functions = self.functions(s, eta_s);
                let theta = self.theta_from_functions(s, eta_s, &functions);
                Response { theta, alpha: theta * (functions.tip_slope() - 1.0) }
            }
        }
    }

    /// What a strain gauge at the root reports for alpha, per volt [rad/V]: L w''(0)/mu_1^2, right for the first mode.
    ///
    /// Numerics: as [`Beam::at`], with modal damping slower and (|s|/omega_1)^2 units in the last place worse.
    pub fn gauge(&self, s: C64) -> C64 {
        let curvature = match self.damping {
            Damping::Modal { zeta } => {
                let series = self.modal_series(s, zeta);
                -s * s * self.theta_from_series(&series) * series.root() * 4.0
            }
            Damping::KelvinVoigt { eta_s } => {
                let functions = self.functions(s, eta_s);
                self.theta_from_functions(s, eta_s, &functions) * functions.root_curvature()
            }
        };
        curvature / clamped_free_root(1).powi(2)
    }

    /// Strain at the root per volt of a beam of thickness h: (h/2L) L w''(0).
    ///
    /// Source: DESIGN section 3 (a).
    pub fn root_strain(&self, s: C64, thickness_m: f64) -> C64 {
        self.gauge(s) * (clamped_free_root(1).powi(2) * thickness_m / (2.0 * self.physical.length_m))
    }

    /// The beam's oscillating poles with positive imaginary part, by rising frequency: mode 1, 2, .. of hub and beam.
    ///
    /// Returns at most `count` of them (an overdamped mode does not oscillate).
    /// Numerics: assumed modes, then a secant iteration on V/theta of the exact beam to working precision.
    pub fn modes(&self, count: usize) -> Vec<C64> {
        let start = Motion::assumed_modes(self, count + 4, 0.0).and_then(|motion| motion.state_space(&[]));
        let mut poles = start.expect("a checked beam has finite equations of motion").poles();
        poles.retain(|pole| pole.im > 1e-6 * pole.norm());
        poles.sort_by(|a, b| a.im.total_cmp(&b.im));
        poles.into_iter().take(count).map(|pole| self.refined_pole(pole)).collect()
    }

    fn refined_pole(&self, start: C64) -> C64 {
        let residual = |s: C64| self.at(s).theta.inv();
        let (mut s, mut previous) = (start, start * (1.0 + SECANT_STEP));
        let mut before = residual(previous);
        for _ in 0..SECANT_STEPS {
            let now = residual(s);
            let step = now * (s - previous) / (now - before);
            if !(step.norm() > f64::EPSILON * s.norm()) {
                break;
            }
            (previous, before) = (s, now);
            s -= step;
        }
        s
    }

    fn modal_series(&self, s: C64, zeta: f64) -> ModalSeries {
        ModalSeries { s, zeta, omega_1: self.physical.clamped_frequency_rad_s() }
    }

    /// theta/V = g/((J_base + J_link) s^2 + c0 s - s^4 sum 4 m L^2 mu_k^-4/d_k).
    fn theta_from_series(&self, series: &ModalSeries) -> C64 {
        let (p, s) = (&self.physical, series.s);
        let inertia = series.hub() * s * s * (-12.0 * p.J_link) + (p.J_base + p.J_link);
        C64::from(p.torque_per_volt()) / (s * (s * inertia + p.hub_damping()))
    }

    fn functions(&self, s: C64, eta_s: f64) -> BeamFunctions {
        let p = &self.physical;
        let softening = s * eta_s + 1.0;
        let lambda_4 = -s * s * clamped_free_root(1).powi(4) * p.J_link / (softening * p.K_stiff);
        BeamFunctions::new(lambda_4.powf(0.25))
    }

    /// theta/V = g/(J_base s^2 + c0 s - M_hub/theta), M_hub = (E*/L) L w''(0).
    fn theta_from_functions(&self, s: C64, eta_s: f64, functions: &BeamFunctions) -> C64 {
        let p = &self.physical;
        let stiffness = (s * eta_s + 1.0) * (self.bending_stiffness() / p.length_m);
        let hub = s * (s * p.J_base + p.hub_damping()) - stiffness * functions.root_curvature();
        C64::from(p.torque_per_volt()) / hub
    }
}

/// First step of the secant iteration, relative: of the size by which some assumed modes miss a pole.
const SECANT_STEP: f64 = 1e-6;
/// The secant iteration settles in 4 to 6 steps; a cap for what rounding may keep moving in the last place.
const SECANT_STEPS: usize = 20;

/// Sums over all clamped modes with modal damping.
struct ModalSeries {
    s: C64,
    zeta: f64,
    omega_1: f64,
}

/// A series ends where what is left out is below this part of the sum.
const TAIL: f64 = 1e-15;
/// Never reached for |s| below a million times omega_1.
const MOST_TERMS: usize = 1_000_000;

impl ModalSeries {
    /// sum 1/(mu_k^4 d_k); the terms fall as k^-8.
    fn hub(&self) -> C64 {
        let left_out = |k: f64, term: f64| k * term / 7.0;
        self.sum(C64::from(0.0), left_out, |mu, omega| (self.inertia(omega) + omega * omega).inv() * mu.powi(-4)).0
    }

    /// sum (-1)^(k-1)/(mu_k^2 d_k); the terms fall as k^-6.
    ///
    /// Numerics: the mean of the last two partial sums of an alternating series.
    fn tip(&self) -> C64 {
        let left_out = |k: f64, term: f64| 1.5 * term / k;
        let mut sign = -1.0;
        let (sum, last) = self.sum(C64::from(0.0), left_out, |mu, omega| {
            sign = -sign;
            (self.inertia(omega) + omega * omega).inv() * (sign / (mu * mu))
        });
        sum - last / 2.0
    }

    /// sum 1/d_k.
    ///
    /// Numerics: 1/d_k = 1/omega_k^2 - s (s + 2 zeta omega_k)/(omega_k^2 d_k). The first part sums to
    /// (mu_1^4/omega_1^2)/12, the second falls as k^-6. This loses (|s|/omega_1)^2 units in the last place.
    fn root(&self) -> C64 {
        let at_rest = clamped_free_root(1).powi(4) / (12.0 * self.omega_1 * self.omega_1);
        let left_out = |k: f64, term: f64| k * term / 5.0;
        let (sum, _) = self.sum(C64::from(at_rest), left_out, |_, omega| {
            let inertia = self.inertia(omega);
            -inertia / ((inertia + omega * omega) * (omega * omega))
        });
        sum
    }

    /// s (s + 2 zeta omega_k), that is d_k - omega_k^2.
    fn inertia(&self, omega: f64) -> C64 {
        self.s * (self.s + 2.0 * self.zeta * omega)
    }

    /// `start` + sum of term(mu_k, omega_k), and the last term.
    fn sum(&self, start: C64, left_out: fn(f64, f64) -> f64, mut term: impl FnMut(f64, f64) -> C64) -> (C64, C64) {
        let per_mu = self.omega_1 / clamped_free_root(1).powi(2);
        let beyond = 2.0 * (self.s.re.abs() + self.s.im.abs());
        let (mut sum, mut last) = (start, start);
        for k in 1..=MOST_TERMS {
            let mu = clamped_free_root(k);
            let omega = per_mu * mu * mu;
            last = term(mu, omega);
            sum += last;
            if omega > beyond && left_out(k as f64, last.norm_sqr().sqrt()) <= TAIL * sum.norm_sqr().sqrt() {
                break;
            }
        }
        (sum, last)
    }
}

/// The beam's functions of lambda, each scaled by exp(-|Re lambda| - |Im lambda|) so that none overflows.
struct BeamFunctions {
    lambda: C64,
    /// 1 + cos cosh.
    Delta: C64,
    /// sin + sinh.
    tip: C64,
    /// sin cosh - cos sinh.
    moment: C64,
}

/// Below this |lambda| the difference sin cosh - cos sinh has lost more digits than its Taylor series has to give.
const SMALL_LAMBDA: f64 = 1.5;

impl BeamFunctions {
    fn new(lambda: C64) -> BeamFunctions {
        let (p, q) = (lambda.im.abs(), lambda.re.abs());
        let j = C64::i();
        let (forth, back) = ((j * lambda - p).exp(), (-j * lambda - p).exp());
        let (cos, sin) = ((forth + back) / 2.0, (forth - back) / (j * 2.0));
        let (up, down) = ((lambda - q).exp(), (-lambda - q).exp());
        let (cosh, sinh) = ((up + down) / 2.0, (up - down) / 2.0);
        let moment = match lambda.norm() < SMALL_LAMBDA {
            true => moment_series(lambda) * (-p - q).exp(),
            false => sin * cosh - cos * sinh,
        };
        BeamFunctions { lambda, Delta: cos * cosh + (-p - q).exp(), tip: sin * (-q).exp() + sinh * (-p).exp(), moment }
    }

    /// psi/theta = (sin lambda + sinh lambda)/(lambda Delta).
    fn tip_slope(&self) -> C64 {
        if self.lambda.norm() == 0.0 { C64::from(1.0) } else { self.tip / (self.lambda * self.Delta) }
    }

    /// L w''(0)/theta = lambda (sin lambda cosh lambda - cos lambda sinh lambda)/Delta.
    fn root_curvature(&self) -> C64 {
        self.lambda * self.moment / self.Delta
    }
}

/// sin x cosh x - cos x sinh x = sum (-1)^m 2^(2m+2) x^(4m+3)/(4m+3)!
fn moment_series(lambda: C64) -> C64 {
    let lambda_4 = lambda.powi(4);
    let mut term = lambda.powi(3) * (2.0 / 3.0);
    let mut sum = term;
    for m in 1..8 {
        let n = 4.0 * f64::from(m);
        term *= lambda_4 * (-4.0 / (n * (n + 1.0) * (n + 2.0) * (n + 3.0)));
        sum += term;
    }
    sum
}
