//! Rig files: the apparatus as a plain table. The `rig` crate owns meaning and defaults.

use crate::document::Document;
use crate::extended::Extended;
use crate::fault::Fault;
use crate::misfit::Misfit;
use crate::provenance::Provenance;
use serde::{Deserialize, Serialize};

/// `flexbeam.rig/1`. Every key may be left out; it then has the default of the paper's rig.
///
/// Where something is to be exact or without limit, 0 stands for no resolution steps and `inf` for no limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// What the rig is called.
    pub name: Option<String>,
    /// Sample period [s].
    pub period_s: Option<f64>,
    /// Whole periods between a measurement and the voltage computed from it.
    pub computing_delay_periods: Option<usize>,
    /// Pieces into which a period is cut to look for changes between sticking and sliding.
    pub substeps: Option<u32>,
    /// The lumped model's numbers, in place of inertias, stiffness and motor constant.
    pub lumped: Option<RigLumped>,
    /// Motor, hub and link.
    pub physical: Option<RigPhysical>,
    /// How the link is modelled.
    pub link: Option<RigLink>,
    /// Converter, amplifier, dead zone.
    pub actuator: Option<RigActuator>,
    /// Dry friction at the hub.
    pub friction: Option<RigFriction>,
    /// Encoder of the hub angle.
    pub encoder: Option<RigEncoder>,
    /// Strain gauge.
    pub gauge: Option<RigGauge>,
    /// Where it came from.
    pub provenance: Option<Provenance>,
}

/// The four numbers of (18).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigLumped {
    /// K_stiff/J_base [1/s^2].
    pub k1: f64,
    /// K_stiff (1/J_link + 1/J_base) [1/s^2].
    pub k2: f64,
    /// Damping of the hub [1/s].
    pub c: f64,
    /// Angular acceleration of the hub per volt [rad/s^2/V].
    pub b: f64,
}

/// Physical parameters, referred to the load shaft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigPhysical {
    /// Inertia of hub, gears and motor [kg m^2].
    pub J_base: Option<f64>,
    /// Inertia of the link about the hub's axis [kg m^2].
    pub J_link: Option<f64>,
    /// Torsion spring of the lumped link [N m/rad].
    pub K_stiff: Option<f64>,
    /// Motor constant [V s/rad].
    pub K_b: Option<f64>,
    /// Gear ratio.
    pub K_g: Option<f64>,
    /// Armature resistance [ohm].
    pub R_ohm: Option<f64>,
    /// Viscous friction [N m s/rad].
    pub B_eq: Option<f64>,
    /// Length of the link [m].
    pub length_m: Option<f64>,
}

/// How the link is modelled: no modes for (18), or modes of the distributed beam.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigLink {
    /// Assumed modes; 0 for the lumped link.
    pub modes: Option<usize>,
    /// Damping ratio of every mode.
    pub zeta: Option<f64>,
    /// Retardation time of Kelvin-Voigt damping [s], in place of `zeta`.
    pub eta_s: Option<f64>,
    /// Mass at the tip [kg].
    pub tip_mass_kg: Option<f64>,
}

/// Converter, amplifier and brushes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigActuator {
    /// Resolution of the digital-to-analogue converter [V]; 0: exact.
    pub converter_step_v: Option<f64>,
    /// Largest magnitude that the amplifier gives [V]; `inf`: no limit.
    pub limit_v: Option<Extended>,
    /// Positive voltage that is lost before any torque appears [V].
    pub dead_zone_plus_v: Option<f64>,
    /// The same in the negative direction, as a magnitude [V].
    pub dead_zone_minus_v: Option<f64>,
}

/// Dry friction at the hub.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigFriction {
    /// Coulomb torque [N m].
    pub coulomb_nm: Option<f64>,
    /// Torque above Coulomb's at rest [N m]; 0: no Stribeck effect.
    pub stribeck_extra_nm: Option<f64>,
    /// Speed over which it decays [rad/s].
    pub stribeck_speed_rad_s: Option<f64>,
}

/// The encoder on the load shaft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigEncoder {
    /// Counts a turn; 0: exact.
    pub counts_per_turn: Option<u32>,
}

/// Strain gauge, its amplifier and converter, referred to the deflection angle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigGauge {
    /// What the gauge sees.
    pub sees: Option<Sees>,
    /// Standard deviation of white noise [rad].
    pub noise_rad: Option<f64>,
    /// What it reads at zero [rad].
    pub bias_rad: Option<f64>,
    /// Resolution of the analogue-to-digital converter [rad]; 0: exact.
    pub converter_step_rad: Option<f64>,
}

/// What a strain gauge is taken to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sees {
    /// The deflection angle of the tip.
    TipAngle,
    /// The curvature at the root.
    RootStrain,
}

impl Document for Rig {
    const SCHEMA: &'static str = "flexbeam.rig/1";
    const HEAD: &'static str = "flexbeam rig. SI units; what is left out is as on the paper's rig.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    /// Only contradictions: the `rig` crate judges the numbers.
    fn check(&self) -> Result<(), Misfit> {
        let twice = |one, other| Misfit::new(Fault::OneOf { found: 2, one, other });
        let derived = |p: &RigPhysical| [p.J_base, p.J_link, p.K_stiff, p.K_b].iter().any(Option::is_some);
        if self.lumped.is_some() && self.physical.as_ref().is_some_and(derived) {
            return Err(twice("lumped", "J_base, J_link, K_stiff or K_b").under("physical"));
        }
        if self.link.as_ref().is_some_and(|link| link.zeta.is_some() && link.eta_s.is_some()) {
            return Err(twice("zeta", "eta_s").under("link"));
        }
        Ok(())
    }
}
