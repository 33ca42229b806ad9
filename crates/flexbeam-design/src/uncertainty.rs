//! The bound alpha(s) on the neglected dynamics, equation (19), in the shifted plane.
//!
//! Enters: coefficients, a constant, or a difference |dG(jw - beta)| to be covered. Leaves: a stable, minimum-phase, biproper
//! alpha(s), and its image in the w-plane of a sampled design.

use flexbeam_lti::{C64, Rational, Zpk};

use crate::Error;

/// alpha(s) [rad/V]: stable, minimum phase, as many zeros as poles.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    alpha: Zpk,
}

impl Uncertainty {
    /// Checks what (19) asks of alpha.
    ///
    /// Errors: [`Error::Weight`] names the pole or zero; [`Error::WeightDegree`]; [`Error::Setting`] for a gain that is not
    /// finite or zero.
    pub fn new(alpha: Zpk) -> Result<Uncertainty, Error> {
        if !(alpha.gain.abs() > 0.0 && alpha.gain.is_finite()) {
            return Err(Error::Setting { name: "uncertainty alpha", value: alpha.gain, needed: "finite and not 0" });
        }
        for (what, roots) in [("has a pole in Re s >= 0,", &alpha.poles), ("has a zero in Re s >= 0,", &alpha.zeros)] {
            if let Some(s) = roots.iter().find(|s| !(s.re < 0.0)) {
                return Err(Error::Weight { what, re: s.re, im: s.im });
            }
        }
        let (zeros, poles) = (alpha.zeros.len(), alpha.poles.len());
        if zeros != poles {
            return Err(Error::WeightDegree { zeros, poles });
        }
        Ok(Uncertainty { alpha })
    }

    /// alpha(s) = value [rad/V].
    ///
    /// Errors: [`Error::Setting`] unless the value is positive and finite.
    pub fn constant(value: f64) -> Result<Uncertainty, Error> {
        if !(value > 0.0) {
            return Err(Error::Setting { name: "uncertainty alpha", value, needed: "a positive number of rad/V" });
        }
        Uncertainty::new(Zpk { zeros: vec![], poles: vec![], gain: value })
    }

    /// alpha(s) from coefficients, highest power first.
    pub fn rational(alpha: &Rational) -> Result<Uncertainty, Error> {
        let gain = alpha.num[0] / alpha.den[0];
        Uncertainty::new(Zpk { zeros: alpha.zeros()?, poles: alpha.poles()?, gain })
    }

    /// alpha(s) as zeros, poles and gain.
    pub fn zpk(&self) -> &Zpk {
        &self.alpha
    }

    /// |alpha(jw)| [rad/V].
    pub fn magnitude(&self, omega_rad_s: f64) -> f64 {
        self.alpha.at(C64::new(0.0, omega_rad_s)).norm()
    }

    /// A bound in the w-plane, from above, of |alpha(jw)| on |w| <= pi/Ts.
    ///
    /// Zeros and poles go to w = (2/Ts) tanh(s Ts/2), as those of a sampled plant do; the gain is raised until the image lies
    /// nowhere below alpha (for a constant alpha nothing is raised). alpha is biproper, so the sum over its aliases diverges:
    /// the bound holds for the base band, and the sampled difference itself is what `verify` compares it with.
    ///
    /// Source: DESIGN 6.6.
    #[must_use]
    pub fn in_w_plane(&self, period_s: f64) -> Uncertainty {
        if self.alpha.zeros.is_empty() {
            return self.clone();
        }
        let image = |s: &C64| w_of_s(*s, period_s);
        let zeros: Vec<C64> = self.alpha.zeros.iter().map(image).collect();
        let poles: Vec<C64> = self.alpha.poles.iter().map(image).collect();
        let mut alpha = Zpk { zeros, poles, gain: 1.0 };
        let worst = (0..=IMAGE_POINTS)
            .map(|k| {
                let omega = std::f64::consts::PI / period_s * k as f64 / IMAGE_POINTS as f64;
                let w = C64::new(0.0, 2.0 / period_s * (omega * period_s / 2.0).tan());
                self.magnitude(omega) / alpha.at(w).norm()
            })
            .fold(0.0, f64::max);
        alpha.gain = worst.copysign(self.alpha.gain) * (1.0 + BETWEEN_POINTS);
        Uncertainty { alpha }
    }
}

/// Points at which the image is compared with alpha: both are smooth over the band, with poles and zeros far from the axis
/// beside the spacing.
const IMAGE_POINTS: usize = 2000;

/// What the image may be short of between two points: second order in the spacing.
const BETWEEN_POINTS: f64 = 1e-6;

/// w = (2/Ts) (z - 1)/(z + 1) at z = e^(s Ts).
pub(crate) fn w_of_s(s: C64, period_s: f64) -> C64 {
    (s * (period_s / 2.0)).tanh() * (2.0 / period_s)
}
