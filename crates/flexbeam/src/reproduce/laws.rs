//! Steps on the nonlinear rig with each law: Figures 8, 9 and 10.

use std::collections::BTreeMap;

use flexbeam_files::{Controller, DirectionSummary, Law, LawSummary, Spread};
use flexbeam_ident::breakaway::Thresholds;
use flexbeam_kernel as kernel;
use flexbeam_rig::{ClosedLoopRecord, RigParameters, StepMetrics};
use flexbeam_verify::Quantiles;

use crate::Failure;
use crate::controller_file::kernel_settings;
use crate::law::law_name;
use crate::response::{linear_rig, step_response};

/// The step of Figure 9 [degree].
pub const STEP_DEG: f64 = 30.0;

/// Length of a run [s].
const DURATION_S: f64 = 5.0;

/// Noise seeds for each law and direction.
pub const SEEDS: u64 = 20;

/// The three laws.
pub const LAWS: [Law; 3] = [Law::None, Law::Switched, Law::Inverse];

/// Records to draw and metrics to count.
pub struct Laws {
    /// One upward step of each law, in the order of [`LAWS`].
    pub records: Vec<ClosedLoopRecord>,
    /// What the design had before its eyes: the linear lumped rig.
    pub ideal: ClosedLoopRecord,
    /// Metrics of each law: upward, downward.
    pub metrics: Vec<[Vec<StepMetrics>; 2]>,
}

/// Runs all laws in both directions over the noise seeds.
pub fn run(rig: &RigParameters, file: &Controller, switched: &Thresholds, seed: u64) -> Result<Laws, Failure> {
    let coefficients = file.coefficients();
    let controller =
        kernel::Controller::new(file.order, &coefficients).map_err(Failure::while_trying("run the controller"))?;
    let step = |rig: &RigParameters, law: Law, sign: f64, seed: u64| {
        let settings = settings(file, law, switched);
        let step_rad = sign * STEP_DEG.to_radians();
        let response = step_response(rig, &settings, &controller, step_rad, DURATION_S, seed)?;
        response.stopped().map_or(Ok(response), |stopped| Err(Failure::Fault(Box::new(stopped))))
    };
    let mut laws =
        Laws { records: vec![], ideal: step(&linear_rig(rig), Law::None, 1.0, seed)?.record, metrics: vec![] };
    for law in LAWS {
        let mut directions = [vec![], vec![]];
        for (direction, sign) in [1.0, -1.0].into_iter().enumerate() {
            for k in 0..SEEDS {
                let response = step(rig, law, sign, seed.wrapping_add(k))?;
                directions[direction].push(response.metrics);
                if direction == 0 && k == 0 {
                    laws.records.push(response.record);
                }
            }
        }
        laws.metrics.push(directions);
    }
    Ok(laws)
}

/// The controller's settings; the switched law has thresholds of its own.
fn settings(file: &Controller, law: Law, switched: &Thresholds) -> kernel::Settings {
    let settings = kernel_settings(&file.settings, Some(law));
    match law {
        Law::Switched => kernel::Settings {
            u_p_plus_v: switched.u_p_plus_v,
            u_p_minus_v: switched.u_p_minus_v,
            eps_u_v: switched.eps_u_v,
            eps_e_rad: switched.eps_e_rad,
            ..settings
        },
        _ => settings,
    }
}

impl Laws {
    /// Figures of each law, by its name.
    pub fn summaries(&self) -> BTreeMap<String, LawSummary> {
        LAWS.iter()
            .zip(&self.metrics)
            .map(|(law, [up, down])| {
                (law_name(*law).to_string(), LawSummary { up: direction(up, 1.0), down: direction(down, -1.0) })
            })
            .collect()
    }
}

fn direction(metrics: &[StepMetrics], sign: f64) -> DirectionSummary {
    let spread = |value: fn(&StepMetrics) -> f64| {
        let Quantiles { median, p95, worst } = Quantiles::of(metrics.iter().map(value));
        Spread { median, p95, max: worst }
    };
    let unsettled = metrics.iter().filter(|m| m.settling_time_s.is_none()).count();
    DirectionSummary {
        runs: metrics.len(),
        step_rad: sign * STEP_DEG.to_radians(),
        stationary_error_rad: spread(|m| m.stationary_error_rad),
        settling_time_s: (unsettled == 0).then(|| spread(|m| m.settling_time_s.unwrap_or(f64::INFINITY))),
        unsettled,
        overshoot_percent: spread(|m| m.overshoot_percent),
        residual_vibration_rad: spread(|m| m.residual_vibration_rad),
        limit_cycles: metrics.iter().filter(|m| m.limit_cycle).count(),
    }
}
