//! What may stop or bound the voltage. Enters: a voltage, angles, limits. Leaves: the bounded voltage, or the fault
//! that latches 0 V.

use crate::settings::Settings;

/// Why the rig is held at 0 V. A fault latches until [`crate::State::reset`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    #[default]
    None,
    /// The beam's deflection |alpha| went beyond `deflection_limit_rad`.
    Deflection,
    /// The hub went beyond `theta_limit_rad`.
    Angle,
    /// The hub moved more than `theta_step_limit_rad` in one tick.
    Speed,
    /// An input or a result was infinite or not a number.
    NonFinite,
    /// The state was made for a controller of another order.
    Order,
}

/// `voltage` within [-limit, limit]; 0 V for a limit that is negative or not a number. A voltage that is not a number
/// stays so, for the check that follows.
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
pub(crate) fn broken(settings: &Settings, theta_rad: f64, alpha_rad: f64, theta_change_rad: f64) -> Fault {
    if !within(alpha_rad, settings.deflection_limit_rad) {
        Fault::Deflection
    } else if !within(theta_rad, settings.theta_limit_rad) {
        Fault::Angle
    } else if !within(theta_change_rad, settings.theta_step_limit_rad) {
        Fault::Speed
    } else {
        Fault::None
    }
}

fn within(x: f64, limit: f64) -> bool {
    -limit <= x && x <= limit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voltage_is_bounded_on_both_sides() {
        for (voltage, limit, bounded) in
            [(3.0, 10.0, 3.0), (11.0, 10.0, 10.0), (-11.0, 10.0, -10.0), (f64::INFINITY, 10.0, 10.0)]
        {
            assert_eq!(limited(voltage, limit), bounded);
        }
        assert!(limited(f64::NAN, 10.0).is_nan(), "left for the check that follows");
        assert_eq!(limited(3.0, -1.0), 0.0);
        assert_eq!(limited(3.0, f64::NAN), 0.0);
    }

    #[test]
    fn limits_break_beyond_and_not_at_them() {
        let s = Settings {
            deflection_limit_rad: 0.3,
            theta_limit_rad: 2.0,
            theta_step_limit_rad: 0.02,
            ..Settings::default()
        };
        for (theta, alpha, change, fault) in [
            (2.0, 0.3, 0.02, Fault::None),
            (-2.0, -0.3, -0.02, Fault::None),
            (0.0, 0.31, 0.0, Fault::Deflection),
            (0.0, -0.31, 0.0, Fault::Deflection),
            (2.1, 0.0, 0.0, Fault::Angle),
            (-2.1, 0.0, 0.0, Fault::Angle),
            (0.0, 0.0, 0.021, Fault::Speed),
            (0.0, 0.0, -0.021, Fault::Speed),
        ] {
            assert_eq!(broken(&s, theta, alpha, change), fault);
        }
    }

    #[test]
    fn a_limit_that_is_no_number_is_broken() {
        let s = Settings { deflection_limit_rad: f64::NAN, ..Settings::default() };
        assert_eq!(broken(&s, 0.0, 0.0, 0.0), Fault::Deflection);
        let s = Settings { theta_limit_rad: f64::NAN, ..Settings::default() };
        assert_eq!(broken(&s, 0.0, 0.0, 0.0), Fault::Angle);
        let s = Settings { theta_step_limit_rad: f64::NAN, ..Settings::default() };
        assert_eq!(broken(&s, 0.0, 0.0, 0.0), Fault::Speed);
    }
}
