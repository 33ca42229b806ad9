use crate::Error;
use crate::error::{not_negative, positive};

/// Converter, amplifier and brushes: what becomes of a commanded voltage before it makes torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Resolution of the digital-to-analogue converter [V]; none: exact. Default 20 V/4096.
    pub converter_step_v: Option<f64>,
    /// Largest magnitude that the amplifier gives [V]. Default 10; infinite: no limit.
    pub limit_v: f64,
    /// Positive voltage that is lost before any torque appears [V]. Default 0.20.
    pub dead_zone_plus_v: f64,
    /// The same in the negative direction, as a magnitude [V]. Default 0.02.
    pub dead_zone_minus_v: f64,
}

impl Default for Actuator {
    /// Source: DESIGN section 4; twelve bits over +-10 V.
    fn default() -> Actuator {
        Actuator {
            converter_step_v: Some(20.0 / 4096.0),
            limit_v: 10.0,
            dead_zone_plus_v: 0.20,
            dead_zone_minus_v: 0.02,
        }
    }
}

impl Actuator {
    /// The commanded voltage, unchanged.
    pub const IDEAL: Actuator =
        Actuator { converter_step_v: None, limit_v: f64::INFINITY, dead_zone_plus_v: 0.0, dead_zone_minus_v: 0.0 };

    /// Voltage at the motor for a commanded voltage: conversion, saturation, dead zone.
    ///
    /// Returns 0 for a command that is not a number.
    pub fn motor_v(&self, commanded_v: f64) -> f64 {
        if commanded_v.is_nan() {
            return 0.0;
        }
        let converted = self.converter_step_v.map_or(commanded_v, |step| (commanded_v / step).round() * step);
        let limited = converted.clamp(-self.limit_v, self.limit_v);
        if limited > self.dead_zone_plus_v {
            limited - self.dead_zone_plus_v
        } else if limited < -self.dead_zone_minus_v {
            limited + self.dead_zone_minus_v
        } else {
            0.0
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        if !(self.limit_v > 0.0) {
            return Err(Error::Parameter {
                quantity: "voltage limit",
                found: self.limit_v,
                unit: "V",
                needed: "positive",
            });
        }
        self.converter_step_v.map_or(Ok(0.0), |step| positive("converter step", "V", step))?;
        not_negative("positive dead zone", "V", self.dead_zone_plus_v)?;
        not_negative("negative dead zone", "V", self.dead_zone_minus_v)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ideal_actuator_changes_no_bit() {
        for v in [0.0, 1e-300, -3.7, 1e9] {
            assert_eq!(Actuator::IDEAL.motor_v(v).to_bits(), v.to_bits());
        }
    }

    #[test]
    fn dead_zone_saturation_and_conversion() {
        let exact = Actuator { converter_step_v: None, ..Actuator::default() };
        for (commanded, motor) in [
            (0.2, 0.0),
            (-0.02, 0.0),
            (1.0, 0.8),
            (-1.0, -0.98),
            (50.0, 9.8),
            (-50.0, -9.98),
            (f64::INFINITY, 9.8),
            (f64::NAN, 0.0),
        ] {
            assert!((exact.motor_v(commanded) - motor).abs() < 1e-15, "{commanded}");
        }
        let coarse = Actuator { converter_step_v: Some(0.5), ..Actuator::IDEAL };
        assert_eq!(coarse.motor_v(1.7), 1.5);
        assert_eq!(coarse.motor_v(-1.8), -2.0);
    }
}
