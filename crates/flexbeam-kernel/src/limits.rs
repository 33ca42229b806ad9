//! What may stop or bound the voltage. Enters: a voltage, angles, limits. Leaves: the bounded voltage, or the fault that latches 0 V.

use crate::settings::Settings;

/// Why the rig is held at 0 V. A fault latches until [`crate::State::reset`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    #[default]
    None,
    /// The beam's deflection |alpha| went beyond `deflection_limit_rad`.
    Deflection,
    /// The hub moved more than `theta_step_limit_rad` in one tick.
    Speed,
    /// An input or a result was infinite or not a number.
    NonFinite,
    /// The state was made for a controller of another order.
    Order,
}

/// `voltage` within [-limit, limit]; 0 V for a limit that is negative or not a number. A voltage that is not a number stays so, for the check that follows.
pub(crate) fn limited(voltage: f64, limit: f64) -> f64 {
    if !(limit >= 0.0) {
        0.0
    } else if voltage > limit {
        limit
    } else if voltage < -limit {
        -limit
    } else {
        voltage
    }
}

/// The limit that these angles break. A limit that is not a number counts as broken.
pub(crate) fn broken(settings: &Settings, alpha_rad: f64, theta_change_rad: f64) -> Fault {
    if !within(alpha_rad, settings.deflection_limit_rad) {
        Fault::Deflection
    } else if !within(theta_change_rad, settings.theta_step_limit_rad) {
        Fault::Speed
    } else {
        Fault::None
    }
}

fn within(x: f64, limit: f64) -> bool {
    -limit <= x && x <= limit
}
