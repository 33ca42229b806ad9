//! What may change while the loop runs.

use super::Real;

/// How one measurement becomes an angle: y = scale (measured - offset), then y_f += low_pass (y - y_f).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Correction of the sensor's gain [-].
    pub scale: Real,
    /// What the sensor shows at zero [rad].
    pub offset_rad: Real,
    /// Share of the new measurement, above 0 and at most 1; 1 passes every bit [-].
    pub low_pass: Real,
}

/// Which variable-structure law stands between the controller and the amplifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// u_c = u.
    None,
    /// u_c = u outside the dead region; inside it u_p sign(e) while the error is large, else 0.
    Switched,
    /// u_c = u + u_p sat(u/eps_u).
    Inverse,
}

/// What may change between two ticks, as a whole. A limit that is not a number counts as broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Hub angle.
    pub theta: Channel,
    /// Deflection angle.
    pub alpha: Channel,
    /// Duration of the smooth step [ticks]; 0 passes the reference.
    pub smooth_ticks: Real,
    /// Steps above this size take proportionally longer [rad].
    pub smooth_step_rad: Real,
    /// Variable-structure law.
    pub law: Law,
    /// Compensation voltage, positive direction [V].
    pub u_p_plus_v: Real,
    /// The same in the negative direction, as a magnitude [V].
    pub u_p_minus_v: Real,
    /// Threshold of switch 2, width of the inverse law's ramp [V].
    pub eps_u_v: Real,
    /// Threshold of switch 1 [rad].
    pub eps_e_rad: Real,
    /// Switch 2 opens above eps_u (1 + hysteresis_u) [-].
    pub hysteresis_u: Real,
    /// Switch 1 opens below eps_e (1 - hysteresis_e) [-].
    pub hysteresis_e: Real,
    /// Estimated breakaway voltage, positive direction [V].
    pub breakaway_plus_v: Real,
    /// The same in the negative direction, as a magnitude [V].
    pub breakaway_minus_v: Real,
    /// Largest magnitude of the voltage [V].
    pub voltage_limit_v: Real,
    /// Largest |alpha|; beyond it: fault [rad].
    pub deflection_limit_rad: Real,
    /// Largest |theta|; beyond it: fault [rad].
    pub theta_limit_rad: Real,
    /// Largest change of theta in one tick; beyond it: fault [rad].
    pub theta_step_limit_rad: Real,
}

impl Channel {
    /// scale (measured - offset).
    pub(super) fn scaled(&self, measured: Real) -> Real {
        self.scale * (measured - self.offset_rad)
    }
}
