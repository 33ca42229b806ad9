//! Dry friction at the hub, set-valued: at rest it takes any value up to the breakaway torque.

use crate::Error;
use crate::elementary::exp;
use crate::error::{not_negative, positive};

/// Coulomb friction, with Stribeck's rise towards standstill if there is one. Viscous friction is
/// [`crate::Physical::B_eq`] and part of the linear model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Torque that opposes a sliding hub at speed [N m]. Default 0.0165; 0 switches friction off when there is no
    /// Stribeck effect either.
    pub coulomb_nm: f64,
    /// Extra torque near standstill. Default none.
    pub stribeck: Option<Stribeck>,
}

/// tau(theta') = coulomb + extra exp(-(theta'/speed)^2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// What the breakaway torque exceeds the Coulomb torque by [N m].
    pub extra_nm: f64,
    /// Speed at which the excess has fallen to 1/e [rad/s].
    pub speed_rad_s: f64,
}

impl Default for Friction {
    /// 0.0165 N m, 0.08 V through the paper's motor.
    ///
    /// Source: DESIGN section 4.
    fn default() -> Friction {
        Friction { coulomb_nm: 0.0165, stribeck: None }
    }
}

impl Friction {
    /// No dry friction.
    pub const NONE: Friction = Friction { coulomb_nm: 0.0, stribeck: None };

    /// Torque that opposes sliding at this speed [N m].
    pub fn sliding_nm(&self, speed_rad_s: f64) -> f64 {
        let excess = |s: Stribeck| s.extra_nm * exp(-(speed_rad_s / s.speed_rad_s).powi(2));
        self.coulomb_nm + self.stribeck.map_or(0.0, excess)
    }

    /// Largest torque that leaves a resting hub where it is [N m].
    pub fn breakaway_nm(&self) -> f64 {
        self.coulomb_nm + self.stribeck.map_or(0.0, |s| s.extra_nm)
    }

    /// What a hub at rest does under this torque: the one answer for which the friction lies in its set.
    pub(crate) fn contact_at_rest(&self, torque_nm: f64) -> Contact {
        if self.breakaway_nm() == 0.0 {
            Contact::Free
        } else if torque_nm.abs() <= self.breakaway_nm() {
            Contact::Stuck
        } else {
            Contact::Sliding { direction: torque_nm.signum() }
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        not_negative("Coulomb torque", "N m", self.coulomb_nm)?;
        if let Some(stribeck) = self.stribeck {
            not_negative("Stribeck excess", "N m", stribeck.extra_nm)?;
            positive("Stribeck speed", "rad/s", stribeck.speed_rad_s)?;
        }
        Ok(())
    }
}

/// Which of the three sets of linear equations the hub obeys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Contact {
    /// There is no dry friction.
    Free,
    /// theta' = 0 exactly.
    Stuck,
    /// theta' has this sign (1 or -1), or is about to have it.
    Sliding { direction: f64 },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Actuator, Physical};

    #[test]
    fn breakaway_voltages_as_measured_on_real_rigs() {
        let coulomb_v = Friction::default().breakaway_nm() / Physical::paper().torque_per_volt();
        assert!((coulomb_v - 0.08).abs() < 5e-4, "{coulomb_v}");
        let actuator = Actuator::default();
        assert!((actuator.dead_zone_plus_v + coulomb_v - 0.28).abs() < 5e-4);
        assert!((actuator.dead_zone_minus_v + coulomb_v - 0.10).abs() < 5e-4);
    }

    #[test]
    fn friction_is_an_interval_at_rest() {
        let friction = Friction { coulomb_nm: 0.01, stribeck: Some(Stribeck { extra_nm: 0.005, speed_rad_s: 0.1 }) };
        assert_eq!(friction.contact_at_rest(0.0149), Contact::Stuck);
        assert_eq!(friction.contact_at_rest(-0.0149), Contact::Stuck);
        assert_eq!(friction.contact_at_rest(0.0151), Contact::Sliding { direction: 1.0 });
        assert_eq!(friction.contact_at_rest(-0.0151), Contact::Sliding { direction: -1.0 });
        assert_eq!(Friction::NONE.contact_at_rest(0.0), Contact::Free);
    }

    #[test]
    fn stribeck_falls_from_breakaway_to_coulomb() {
        let friction = Friction { coulomb_nm: 0.01, stribeck: Some(Stribeck { extra_nm: 0.005, speed_rad_s: 0.1 }) };
        assert_eq!(friction.sliding_nm(0.0), friction.breakaway_nm());
        let at_speed = friction.sliding_nm(-0.1);
        assert!((at_speed - (0.01 + 0.005 * (-1.0_f64).exp())).abs() < 1e-16);
        assert!((friction.sliding_nm(2.0) - 0.01).abs() < 1e-16);
    }
}
