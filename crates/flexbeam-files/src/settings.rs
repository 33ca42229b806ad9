//! The loop's live settings, by the kernel's names and in the kernel's units.

use crate::misfit::Misfit;
use crate::model::out_of_range;
use serde::{Deserialize, Serialize};

/// The table `settings` of a controller. A key that is left out has the kernel's default.
///
/// The kernel owns meaning and defaults; durations are in ticks because it knows no sample period.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Variable-structure law.
    pub law: Option<Law>,
    /// Voltage added (inverse law) or sent (switched law) in the positive direction [V].
    pub u_p_plus_v: Option<f64>,
    /// The same in the negative direction, as a magnitude [V].
    pub u_p_minus_v: Option<f64>,
    /// Threshold of switch 2 [V].
    pub eps_u_v: Option<f64>,
    /// Threshold of switch 1 [rad].
    pub eps_e_rad: Option<f64>,
    /// Switch 2 opens above eps_u (1 + hysteresis_u).
    pub hysteresis_u: Option<f64>,
    /// Switch 1 opens below eps_e (1 - hysteresis_e).
    pub hysteresis_e: Option<f64>,
    /// Estimated breakaway voltage in the positive direction [V].
    pub breakaway_plus_v: Option<f64>,
    /// The same in the negative direction, as a magnitude [V].
    pub breakaway_minus_v: Option<f64>,
    /// Largest magnitude of the voltage [V].
    pub voltage_limit_v: Option<f64>,
    /// Largest magnitude of the deflection angle before the rig is stopped [rad].
    pub deflection_limit_rad: Option<f64>,
    /// Largest magnitude of the hub angle before the rig is stopped [rad]. Left out: no limit.
    pub theta_limit_rad: Option<f64>,
    /// Largest change of the hub angle in a tick before the rig is stopped [rad]. Left out: no limit.
    pub theta_step_limit_rad: Option<f64>,
    /// Duration of the smooth step [ticks].
    pub smooth_ticks: Option<f64>,
    /// Steps above this size take proportionally longer [rad]. Left out: none do.
    pub smooth_step_rad: Option<f64>,
    /// Calibration and filter of the hub angle.
    pub theta: Option<Channel>,
    /// Calibration and filter of the deflection angle.
    pub alpha: Option<Channel>,
}

/// Variable-structure laws.
///
/// Source: DESIGN section 7.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Law {
    /// u_c = u.
    None,
    /// Figure 8 of the paper.
    Switched,
    /// u_c = u + u_p sat(u/eps_u).
    Inverse,
}

/// How a measurement becomes an angle: scale (measured - offset), then y_f += low_pass (y - y_f).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Correction of the sensor's gain.
    pub scale: Option<f64>,
    /// What the sensor shows at zero [rad].
    pub offset_rad: Option<f64>,
    /// Share of the new measurement, above 0 and at most 1.
    pub low_pass: Option<f64>,
}

impl Settings {
    /// These settings, with those of `other` in their place where it has any.
    pub fn with(&self, other: &Settings) -> Settings {
        let or = |other: Option<f64>, own: Option<f64>| other.or(own);
        let channel = |other: &Option<Channel>, own: &Option<Channel>| {
            let (Some(other), Some(own)) = (other, own) else { return other.clone().or_else(|| own.clone()) };
            Some(Channel {
                scale: or(other.scale, own.scale),
                offset_rad: or(other.offset_rad, own.offset_rad),
                low_pass: or(other.low_pass, own.low_pass),
            })
        };
        Settings {
            law: other.law.or(self.law),
            u_p_plus_v: or(other.u_p_plus_v, self.u_p_plus_v),
            u_p_minus_v: or(other.u_p_minus_v, self.u_p_minus_v),
            eps_u_v: or(other.eps_u_v, self.eps_u_v),
            eps_e_rad: or(other.eps_e_rad, self.eps_e_rad),
            hysteresis_u: or(other.hysteresis_u, self.hysteresis_u),
            hysteresis_e: or(other.hysteresis_e, self.hysteresis_e),
            breakaway_plus_v: or(other.breakaway_plus_v, self.breakaway_plus_v),
            breakaway_minus_v: or(other.breakaway_minus_v, self.breakaway_minus_v),
            voltage_limit_v: or(other.voltage_limit_v, self.voltage_limit_v),
            deflection_limit_rad: or(other.deflection_limit_rad, self.deflection_limit_rad),
            theta_limit_rad: or(other.theta_limit_rad, self.theta_limit_rad),
            theta_step_limit_rad: or(other.theta_step_limit_rad, self.theta_step_limit_rad),
            smooth_ticks: or(other.smooth_ticks, self.smooth_ticks),
            smooth_step_rad: or(other.smooth_step_rad, self.smooth_step_rad),
            theta: channel(&other.theta, &self.theta),
            alpha: channel(&other.alpha, &self.alpha),
        }
    }

    /// Errors: [`Fault::Range`](crate::Fault::Range).
    pub(crate) fn check(&self) -> Result<(), Misfit> {
        let numbers = [
            ("u_p_plus_v", self.u_p_plus_v, NOT_NEGATIVE),
            ("u_p_minus_v", self.u_p_minus_v, NOT_NEGATIVE),
            ("eps_u_v", self.eps_u_v, NOT_NEGATIVE),
            ("eps_e_rad", self.eps_e_rad, NOT_NEGATIVE),
            ("hysteresis_u", self.hysteresis_u, NOT_NEGATIVE),
            ("hysteresis_e", self.hysteresis_e, SHARE),
            ("breakaway_plus_v", self.breakaway_plus_v, NOT_NEGATIVE),
            ("breakaway_minus_v", self.breakaway_minus_v, NOT_NEGATIVE),
            ("voltage_limit_v", self.voltage_limit_v, NOT_NEGATIVE),
            ("deflection_limit_rad", self.deflection_limit_rad, POSITIVE),
            ("theta_limit_rad", self.theta_limit_rad, POSITIVE),
            ("theta_step_limit_rad", self.theta_step_limit_rad, POSITIVE),
            ("smooth_ticks", self.smooth_ticks, NOT_NEGATIVE),
            ("smooth_step_rad", self.smooth_step_rad, POSITIVE),
        ];
        for (key, found, (holds, needed)) in numbers {
            found.filter(|x| !holds(*x)).map_or(Ok(()), |found| Err(out_of_range(key, found, needed)))?;
        }
        for (name, channel) in [("theta", &self.theta), ("alpha", &self.alpha)] {
            channel.as_ref().map_or(Ok(()), Channel::check).map_err(|misfit| misfit.under(name))?;
        }
        Ok(())
    }
}

/// A range, and how it is called.
type Range = (fn(f64) -> bool, &'static str);

const NOT_NEGATIVE: Range = (|x| x >= 0.0, "zero or a positive number");
const POSITIVE: Range = (|x| x > 0.0, "a positive number");
const SHARE: Range = (|x| (0.0..=1.0).contains(&x), "0 to 1");

impl Channel {
    fn check(&self) -> Result<(), Misfit> {
        match self.low_pass {
            Some(a) if !(a > 0.0 && a <= 1.0) => Err(out_of_range("low_pass", a, "above 0 and at most 1")),
            _ => Ok(()),
        }
    }
}
