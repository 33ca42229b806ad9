//! Periods whose answers are known, for the self-check of the text.

use super::parameters::{in_c, parameters};
use super::{lines, list};
use crate::{Error, Precision};
use flexbeam_rig::{Actuator, Encoder, Friction, Gauge, GaugeSees, RigParameters, Sensors, SimulatedRig, Stribeck};

/// Two short runs: one with nothing that is not linear, at voltages so small that all is subnormal; one with everything.
pub(super) struct Check {
    linear: RigParameters,
    full: RigParameters,
    voltages: Vec<f64>,
    linear_periods: usize,
    /// theta, alpha as read, true alpha, theta' behind each period.
    answers: Vec<[f64; 4]>,
}

/// Of the noise of the second run.
const SEED: u64 = 1;

/// Enough for the beam to move by subnormal amounts.
const LINEAR_PERIODS: usize = 4;

/// There and back, so that the hub slides, sticks and turns.
const FULL_V: [f64; 12] = [0.1, 0.35, 0.0, 0.0, 3.0, 3.0, -4.0, -6.0, 1.0, 0.3, 40.0, -0.5];

impl Check {
    pub(super) fn new(rig: &RigParameters) -> Result<Check, Error> {
        let sees = rig.sensors.gauge.sees;
        let linear = RigParameters {
            sensors: Sensors { gauge: Gauge { sees, ..Gauge::IDEAL }, ..Sensors::IDEAL },
            ..rig.linear()
        };
        let full =
            RigParameters { friction: friction(), actuator: Actuator::default(), sensors: sensors(sees), ..*rig };
        let tiny = Precision::F64.subnormal() * 1e4;
        let voltages: Vec<f64> = (0..LINEAR_PERIODS).map(|k| tiny * (1.0 + k as f64)).chain(FULL_V).collect();
        let mut answers = run(&linear, &voltages[..LINEAR_PERIODS])?;
        answers.extend(run(&full, &voltages[LINEAR_PERIODS..])?);
        Ok(Check { linear, full, voltages, linear_periods: LINEAR_PERIODS, answers })
    }

    pub(super) fn marks(&self) -> Result<Vec<(&'static str, String)>, Error> {
        let rows: Vec<String> = self.answers.iter().map(|answer| format!("    {{{}}},", list(answer))).collect();
        Ok(vec![
            ("CHECKED_PERIODS", self.voltages.len().to_string()),
            ("LINEAR_PERIODS", self.linear_periods.to_string()),
            ("CHECKED_LINEAR", in_c(&parameters(&self.linear)?)),
            ("CHECKED_FULL", in_c(&parameters(&self.full)?)),
            ("CHECKED_VOLTAGES", lines(&self.voltages)),
            ("CHECKED_ANSWERS", rows.join("\n")),
        ])
    }
}

fn friction() -> Friction {
    let stribeck = Some(Stribeck { extra_nm: 0.006, speed_rad_s: 0.15 });
    Friction { coulomb_nm: 0.0125, stribeck }
}

/// Without a converter, so that the noise's last bit shows.
fn sensors(sees: GaugeSees) -> Sensors {
    Sensors { encoder: Encoder::default(), gauge: Gauge { sees, converter_step_rad: None, ..Gauge::default() } }
}

fn run(parameters: &RigParameters, voltages: &[f64]) -> Result<Vec<[f64; 4]>, Error> {
    let mut rig = SimulatedRig::new(parameters, SEED)?;
    let mut answer = |&voltage_v: &f64| {
        rig.apply(voltage_v);
        let (read, truth) = (rig.measure(), rig.truth());
        [read.theta_rad, read.alpha_rad, truth.alpha_rad, truth.theta_rad_s]
    };
    Ok(voltages.iter().map(&mut answer).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subnormal_numbers_and_every_contact_are_in_it() {
        for link in [flexbeam_rig::Link::Lumped, flexbeam_rig::Link::default()] {
            let check = Check::new(&RigParameters { link, ..RigParameters::default() }).unwrap();
            let (linear, full) = check.answers.split_at(LINEAR_PERIODS);
            assert!(linear.iter().all(|answer| answer[0].is_subnormal() && answer[2].is_subnormal()), "{linear:?}");
            let speeds: Vec<f64> = full.iter().map(|answer| answer[3]).collect();
            for kind in [|v: f64| v > 0.0, |v: f64| v < 0.0, |v: f64| v == 0.0] {
                assert!(speeds.iter().any(|&v| kind(v)), "{speeds:?}");
            }
            assert!(
                speeds.windows(2).any(|pair| pair[0] != 0.0 && pair[1] == 0.0),
                "the hub comes to rest: {speeds:?}"
            );
        }
    }
}
