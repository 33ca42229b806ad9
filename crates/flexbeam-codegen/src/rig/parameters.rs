//! What of a rig may be changed without other matrices, in the order of `struct NAME_parameters`.

use super::number;
use crate::Error;
use flexbeam_rig::{RigParameters, Stribeck};

/// What its values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// A number with its unit, and the least that it may be.
    Number(&'static str, f64, f64),
    /// A whole number from 0 to the largest of 31 bits.
    Whole(u32),
}

/// One of them, named as in a rig file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) name: &'static str,
    pub(crate) kind: Kind,
    pub(crate) description: &'static str,
}

/// Stands where there is no Stribeck effect, and does nothing [rad/s].
const STRIBECK_SPEED_RAD_S: f64 = 0.1;

/// All of them; 0 stands for what is exact or not there.
///
/// Errors: [`Error::Counts`].
pub(crate) fn parameters(rig: &RigParameters) -> Result<Vec<Parameter>, Error> {
    let (actuator, friction, gauge) = (&rig.actuator, &rig.friction, &rig.sensors.gauge);
    let none = Stribeck { extra_nm: 0.0, speed_rad_s: STRIBECK_SPEED_RAD_S };
    let stribeck = friction.stribeck.unwrap_or(none);
    let counts = rig.sensors.encoder.counts_per_turn.unwrap_or(0);
    if i32::try_from(counts).is_err() {
        return Err(Error::Counts { found: counts });
    }
    let from_zero = |name, unit, x, description| Parameter { name, kind: Kind::Number(unit, x, 0.0), description };
    Ok(vec![
        from_zero(
            "actuator.converter_step_v",
            "V",
            actuator.converter_step_v.unwrap_or(0.0),
            "Resolution of the digital-to-analogue converter; 0: exact",
        ),
        from_zero("actuator.limit_v", "V", actuator.limit_v, "Largest magnitude that the amplifier gives, above 0"),
        from_zero(
            "actuator.dead_zone_plus_v",
            "V",
            actuator.dead_zone_plus_v,
            "Positive voltage that is lost before any torque appears",
        ),
        from_zero(
            "actuator.dead_zone_minus_v",
            "V",
            actuator.dead_zone_minus_v,
            "The same in the negative direction, as a magnitude",
        ),
        from_zero("friction.coulomb_nm", "N.m", friction.coulomb_nm, "Torque that opposes a sliding hub at speed"),
        from_zero(
            "friction.stribeck_extra_nm",
            "N.m",
            stribeck.extra_nm,
            "What the breakaway torque exceeds the Coulomb torque by; 0: no Stribeck effect",
        ),
        from_zero(
            "friction.stribeck_speed_rad_s",
            "rad/s",
            stribeck.speed_rad_s,
            "Speed at which that excess has fallen to 1/e, above 0; idle without the effect",
        ),
        Parameter {
            name: "encoder.counts_per_turn",
            kind: Kind::Whole(counts),
            description: "Counts a turn of the encoder on the load shaft; 0: exact",
        },
        from_zero("gauge.noise_rad", "rad", gauge.noise_rad, "Standard deviation of the gauge's white Gaussian noise"),
        Parameter {
            name: "gauge.bias_rad",
            kind: Kind::Number("rad", gauge.bias_rad, f64::NEG_INFINITY),
            description: "What the gauge reads at alpha = 0",
        },
        from_zero(
            "gauge.converter_step_rad",
            "rad",
            gauge.converter_step_rad.unwrap_or(0.0),
            "Resolution of the analogue-to-digital converter; 0: exact",
        ),
    ])
}

/// The inside of an initialiser in C: one line a structure of the same prefix.
pub(super) fn in_c(parameters: &[Parameter]) -> String {
    let group = |p: &Parameter| p.name.split_once('.').map_or(p.name, |(group, _)| group);
    let groups = parameters.chunk_by(|a, b| group(a) == group(b));
    let value = |p: &Parameter| match p.kind {
        Kind::Number(_, x, _) => number(x),
        Kind::Whole(n) => n.to_string(),
    };
    let line = |of: &[Parameter]| format!("    {{{}}},", of.iter().map(value).collect::<Vec<_>>().join(", "));
    groups.map(line).collect::<Vec<_>>().join("\n")
}
