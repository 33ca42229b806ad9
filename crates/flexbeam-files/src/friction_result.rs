//! What `flexbeam rig test` answers about friction, each number with its uncertainty.

use serde::Serialize;

/// A number with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Standard error, in the same unit.
    pub std: f64,
    /// Half the width of the interval that holds the truth in 95 of 100 tests.
    pub half_width_95: f64,
}

/// Breakaway voltages of repeated ramps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RepeatedBreakaway {
    /// Forward [V].
    pub plus_v: Quantity,
    /// Backward [V], negative.
    pub minus_v: Quantity,
}

/// Friction from constant-speed runs. What needs the coast after a cut is null where no coast was recorded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrictionResult {
    /// Steady runs.
    pub runs: usize,
    /// Stretches of constant voltage without a constant speed.
    pub left_out: usize,
    /// Dead zone and Coulomb friction together, forward [V].
    pub dry_plus_v: Quantity,
    /// The same backward [V], a magnitude.
    pub dry_minus_v: Quantity,
    /// Slope of voltage over speed, c/b [V s/rad].
    pub slope_v_s: Quantity,
    /// Dead zone forward [V].
    pub dead_zone_plus_v: Option<Quantity>,
    /// The same backward [V], a magnitude.
    pub dead_zone_minus_v: Option<Quantity>,
    /// Coulomb friction forward, as a voltage [V].
    pub coulomb_plus_v: Option<Quantity>,
    /// The same backward [V], a magnitude.
    pub coulomb_minus_v: Option<Quantity>,
    /// How much later than recorded the voltage acts [s].
    pub delay_s: Option<Quantity>,
    /// Motor torque per volt that made newton metres of volts [N m/V].
    pub torque_per_volt_nm: Quantity,
    /// Coulomb torque, mean of both directions [N m].
    pub coulomb_nm: Option<Quantity>,
    /// Viscous friction B_eq [N m s/rad].
    pub viscous_nm_s: Quantity,
    /// Stribeck's rise [N m]; null where none shows.
    pub stribeck_extra_nm: Option<Quantity>,
    /// Speed over which it decays [rad/s].
    pub stribeck_speed_rad_s: Option<f64>,
}
