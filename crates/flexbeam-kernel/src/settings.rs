//! Everything that may be changed while the loop runs, as plain numbers computed outside it and swapped whole between
//! two ticks.

use crate::law::Law;

/// How one measurement becomes an angle: y = scale (measured - offset), then a first-order low-pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Correction of the sensor's gain. Default 1, no unit.
    pub scale: f64,
    /// What the sensor shows at zero. Default 0 rad; taken off before scaling.
    pub offset_rad: f64,
    /// Share a of the new measurement in y_f += a (y - y_f). Default 1 (passes through), no unit, 0 < a <= 1; a = 1 -
    /// exp(-2 pi f period_s) cuts off at f Hz.
    pub low_pass: f64,
}

impl Default for Channel {
    fn default() -> Self {
        Self { scale: 1.0, offset_rad: 0.0, low_pass: 1.0 }
    }
}

impl Channel {
    /// Real-time: yes. scale (measured - offset).
    pub fn scaled(&self, measured: f64) -> f64 {
        self.scale * (measured - self.offset_rad)
    }

    fn is_sound(&self) -> bool {
        self.scale.is_finite() && self.offset_rad.is_finite() && self.low_pass > 0.0 && self.low_pass <= 1.0
    }
}

/// The loop's live settings. The kernel knows no sample period, so what depends on it is given in ticks or per tick.
///
/// [`crate::tick`] takes any numbers, senseless ones too, and stays safe; [`Settings::first_unsound`] names what does
/// not make sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The hub angle's calibration and filter.
    pub theta: Channel,
    /// The deflection angle's calibration and filter.
    pub alpha: Channel,
    /// Duration of the smooth step. Default 0 ticks: the reference passes unchanged.
    pub smooth_ticks: f64,
    /// Steps above this size take proportionally longer than `smooth_ticks`, which bounds the reference's speed.
    /// Default infinite [rad].
    pub smooth_step_rad: f64,
    /// The variable-structure law. Default [`Law::Inverse`], which does nothing while both u_p are zero.
    pub law: Law,
    /// Voltage added (inverse law) or sent (switched law) in the positive direction. Default 0 V; from the measured
    /// breakaway voltage.
    pub u_p_plus_v: f64,
    /// The same in the negative direction, as a magnitude. Default 0 V.
    pub u_p_minus_v: f64,
    /// Threshold of switch 2: the dead region of the switched law, the width of the inverse law's ramp. Default 0.1 V.
    ///
    /// Near zero the inverse law multiplies the loop gain by 1 + u_p/eps_u, which must stay below the gain margin: below
    /// u_p/(margin - 1) the loop hunts.
    pub eps_u_v: f64,
    /// Threshold of switch 1, the stationary error that the switched law still corrects. Default 0.005 rad.
    pub eps_e_rad: f64,
    /// Switch 2 opens above eps_u (1 + hysteresis_u). Default 0.2, no unit.
    pub hysteresis_u: f64,
    /// Switch 1 opens below eps_e (1 - hysteresis_e). Default 0.5, no unit.
    pub hysteresis_e: f64,
    /// Estimated breakaway voltage in the positive direction, taken off what the controller hears under the switched
    /// law. Default 0 V.
    pub breakaway_plus_v: f64,
    /// The same in the negative direction, as a magnitude. Default 0 V.
    pub breakaway_minus_v: f64,
    /// Largest magnitude of the voltage. Default 10 V.
    pub voltage_limit_v: f64,
    /// Largest magnitude of the filtered deflection angle; beyond it the rig is stopped. Default 0.5 rad.
    pub deflection_limit_rad: f64,
    /// Largest magnitude of the filtered hub angle; beyond it the rig is stopped. Default infinite [rad].
    pub theta_limit_rad: f64,
    /// Largest change of the filtered hub angle in one tick (speed limit times period); beyond it the rig is stopped.
    /// Default infinite [rad].
    pub theta_step_limit_rad: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            theta: Channel::default(),
            alpha: Channel::default(),
            smooth_ticks: 0.0,
            smooth_step_rad: f64::INFINITY,
            law: Law::default(),
            u_p_plus_v: 0.0,
            u_p_minus_v: 0.0,
            eps_u_v: 0.1,
            eps_e_rad: 0.005,
            hysteresis_u: 0.2,
            hysteresis_e: 0.5,
            breakaway_plus_v: 0.0,
            breakaway_minus_v: 0.0,
            voltage_limit_v: 10.0,
            deflection_limit_rad: 0.5,
            theta_limit_rad: f64::INFINITY,
            theta_step_limit_rad: f64::INFINITY,
        }
    }
}

impl Settings {
    /// Real-time: no. Name of the first field whose number makes no sense (not a number, negative, a share outside
    /// 0..1), for the face to complain about.
    pub fn first_unsound(&self) -> Option<&'static str> {
        let finite = |x: f64| x.is_finite() && x >= 0.0;
        let limit = |x: f64| x > 0.0;
        let checks = [
            ("theta", self.theta.is_sound()),
            ("alpha", self.alpha.is_sound()),
            ("smooth_ticks", finite(self.smooth_ticks)),
            ("smooth_step_rad", limit(self.smooth_step_rad)),
            ("u_p_plus_v", finite(self.u_p_plus_v)),
            ("u_p_minus_v", finite(self.u_p_minus_v)),
            ("eps_u_v", finite(self.eps_u_v)),
            ("eps_e_rad", finite(self.eps_e_rad)),
            ("hysteresis_u", finite(self.hysteresis_u)),
            ("hysteresis_e", finite(self.hysteresis_e) && self.hysteresis_e <= 1.0),
            ("breakaway_plus_v", finite(self.breakaway_plus_v)),
            ("breakaway_minus_v", finite(self.breakaway_minus_v)),
            ("voltage_limit_v", finite(self.voltage_limit_v)),
            ("deflection_limit_rad", limit(self.deflection_limit_rad)),
            ("theta_limit_rad", limit(self.theta_limit_rad)),
            ("theta_step_limit_rad", limit(self.theta_step_limit_rad)),
        ];
        checks.iter().find(|(_, sound)| !sound).map(|&(name, _)| name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_sound() {
        assert_eq!(Settings::default().first_unsound(), None);
    }

    #[test]
    fn an_unsound_field_is_named() {
        let d = Settings::default();
        let channel = |low_pass| Channel { low_pass, ..Channel::default() };
        for (settings, name) in [
            (Settings { theta: channel(0.0), ..d }, "theta"),
            (Settings { alpha: channel(1.1), ..d }, "alpha"),
            (Settings { smooth_ticks: -1.0, ..d }, "smooth_ticks"),
            (Settings { smooth_step_rad: 0.0, ..d }, "smooth_step_rad"),
            (Settings { u_p_plus_v: f64::NAN, ..d }, "u_p_plus_v"),
            (Settings { u_p_minus_v: -0.1, ..d }, "u_p_minus_v"),
            (Settings { eps_u_v: -0.1, ..d }, "eps_u_v"),
            (Settings { eps_e_rad: f64::INFINITY, ..d }, "eps_e_rad"),
            (Settings { hysteresis_u: -0.1, ..d }, "hysteresis_u"),
            (Settings { hysteresis_e: 1.5, ..d }, "hysteresis_e"),
            (Settings { breakaway_plus_v: f64::NAN, ..d }, "breakaway_plus_v"),
            (Settings { breakaway_minus_v: -0.1, ..d }, "breakaway_minus_v"),
            (Settings { voltage_limit_v: f64::INFINITY, ..d }, "voltage_limit_v"),
            (Settings { deflection_limit_rad: f64::NAN, ..d }, "deflection_limit_rad"),
            (Settings { theta_limit_rad: 0.0, ..d }, "theta_limit_rad"),
            (Settings { theta_step_limit_rad: -1.0, ..d }, "theta_step_limit_rad"),
        ] {
            assert_eq!(settings.first_unsound(), Some(name));
        }
    }
}
