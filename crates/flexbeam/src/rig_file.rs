//! A rig file's plain table turned into the rig's parameters.
//!
//! Enters: the path of a rig file, or none. Leaves: parameters that the `rig` crate has checked.
//! Deliberately absent: defaults of our own; a key that is left out has the `rig` crate's.

use std::path::Path;

use flexbeam_files::{
    Document, Error, Fault, Rig, RigActuator, RigFriction, RigGauge, RigLink, RigLumped, RigPhysical, Sees, Tried,
};
use flexbeam_rig::{
    Actuator, Beam, Damping, Drive, Encoder, Friction, Gauge, GaugeSees, Link, Lumped, Physical, RigParameters,
    Sensors, Stribeck,
};

use crate::Failure;

/// A file that reads well and describes no rig.
#[derive(Debug, thiserror::Error)]
#[error("{0}\nhint: compare the file with the ranges in the book's chapter on the rig; keys left out are the paper's")]
struct NoSuchRig(#[from] flexbeam_rig::Error);

/// The rig that `file` describes; without a file the paper's rig with three modes.
///
/// Errors: those of reading; a quantity that no rig can have, with its range.
pub fn rig_parameters(file: Option<&Path>) -> Result<RigParameters, Failure> {
    let Some(path) = file else { return Ok(RigParameters::default()) };
    let rig = Rig::read(path)?;
    let friction = rig.friction.as_ref().map_or(Ok(Friction::default()), |table| friction(table, path))?;
    of_rig(&rig, friction)
        .map_err(NoSuchRig::from)
        .map_err(Failure::while_trying(format!("use the rig of {}", path.display())))
}

fn of_rig(rig: &Rig, friction: Friction) -> Result<RigParameters, flexbeam_rig::Error> {
    let default = RigParameters::default();
    let counts = rig.encoder.as_ref().and_then(|encoder| encoder.counts_per_turn);
    let parameters = RigParameters {
        physical: physical(rig.lumped.as_ref(), rig.physical.as_ref())?,
        link: rig.link.as_ref().map_or(default.link, link),
        actuator: rig.actuator.as_ref().map_or(default.actuator, actuator),
        friction,
        sensors: Sensors {
            encoder: counts
                .map_or(default.sensors.encoder, |n| Encoder { counts_per_turn: Some(n).filter(|n| *n > 0) }),
            gauge: rig.gauge.as_ref().map_or(default.sensors.gauge, gauge),
        },
        period_s: rig.period_s.unwrap_or(default.period_s),
        computing_delay_periods: rig.computing_delay_periods.unwrap_or(default.computing_delay_periods),
        substeps: rig.substeps.unwrap_or(default.substeps),
    };
    parameters.check()?;
    Ok(parameters)
}

fn physical(lumped: Option<&RigLumped>, table: Option<&RigPhysical>) -> Result<Physical, flexbeam_rig::Error> {
    let paper = Physical::paper();
    let absent = RigPhysical::default();
    let table = table.unwrap_or(&absent);
    let drive = Drive {
        K_g: table.K_g.unwrap_or(paper.K_g),
        R_ohm: table.R_ohm.unwrap_or(paper.R_ohm),
        B_eq: table.B_eq.unwrap_or(paper.B_eq),
        length_m: table.length_m.unwrap_or(paper.length_m),
    };
    if let Some(&RigLumped { k1, k2, c, b }) = lumped {
        return Physical::from_lumped(&Lumped { k1, k2, c, b }, &drive);
    }
    Ok(Physical {
        J_base: table.J_base.unwrap_or(paper.J_base),
        J_link: table.J_link.unwrap_or(paper.J_link),
        K_stiff: table.K_stiff.unwrap_or(paper.K_stiff),
        K_b: table.K_b.unwrap_or(paper.K_b),
        K_g: drive.K_g,
        R_ohm: drive.R_ohm,
        B_eq: drive.B_eq,
        length_m: drive.length_m,
    })
}

fn link(table: &RigLink) -> Link {
    let Link::Modes { count, tip_mass_kg, .. } = Link::default() else { unreachable!("the default link has modes") };
    let damping = match (table.eta_s, table.zeta) {
        (Some(eta_s), _) => Damping::KelvinVoigt { eta_s },
        (None, zeta) => Damping::Modal { zeta: zeta.unwrap_or(Beam::ZETA) },
    };
    match table.modes.unwrap_or(count) {
        0 => Link::Lumped,
        count => Link::Modes { count, damping, tip_mass_kg: table.tip_mass_kg.unwrap_or(tip_mass_kg) },
    }
}

fn actuator(table: &RigActuator) -> Actuator {
    let default = Actuator::default();
    Actuator {
        converter_step_v: resolution(table.converter_step_v, default.converter_step_v),
        limit_v: table.limit_v.map_or(default.limit_v, f64::from),
        dead_zone_plus_v: table.dead_zone_plus_v.unwrap_or(default.dead_zone_plus_v),
        dead_zone_minus_v: table.dead_zone_minus_v.unwrap_or(default.dead_zone_minus_v),
    }
}

/// Errors: a Stribeck torque without its speed, or the other way round: neither has a default.
fn friction(table: &RigFriction, path: &Path) -> Result<Friction, Error> {
    let missing = |key: &str| Error::new(Tried::Read, path, Fault::MissingKey { key: key.into() });
    let stribeck = match (table.stribeck_extra_nm, table.stribeck_speed_rad_s) {
        (None | Some(0.0), None) => None,
        (Some(0.0), Some(_)) => None,
        (Some(extra_nm), Some(speed_rad_s)) => Some(Stribeck { extra_nm, speed_rad_s }),
        (Some(_), None) => return Err(missing("friction.stribeck_speed_rad_s")),
        (None, Some(_)) => return Err(missing("friction.stribeck_extra_nm")),
    };
    Ok(Friction { coulomb_nm: table.coulomb_nm.unwrap_or(Friction::default().coulomb_nm), stribeck })
}

fn gauge(table: &RigGauge) -> Gauge {
    let default = Gauge::default();
    Gauge {
        sees: match table.sees {
            None => default.sees,
            Some(Sees::TipAngle) => GaugeSees::TipAngle,
            Some(Sees::RootStrain) => GaugeSees::RootStrain,
        },
        noise_rad: table.noise_rad.unwrap_or(default.noise_rad),
        bias_rad: table.bias_rad.unwrap_or(default.bias_rad),
        converter_step_rad: resolution(table.converter_step_rad, default.converter_step_rad),
    }
}

/// In a file 0 stands for no steps at all; the rig says so without a number.
fn resolution(stated: Option<f64>, default: Option<f64>) -> Option<f64> {
    stated.map_or(default, |step| Some(step).filter(|step| *step != 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(toml: &str) -> Result<RigParameters, Failure> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rig.toml");
        std::fs::write(&path, format!("schema = \"flexbeam.rig/1\"\n{toml}")).expect("written");
        rig_parameters(Some(&path))
    }

    #[test]
    fn what_is_left_out_is_the_paper_s_rig() {
        assert_eq!(read("").unwrap(), RigParameters::default());
        let tables = "[physical]\n[link]\n[actuator]\n[friction]\n[encoder]\n[gauge]\n";
        assert_eq!(read(tables).unwrap(), RigParameters::default());
    }

    #[test]
    fn every_key_reaches_the_rig() {
        let found = read(
            "period_s = 0.002\ncomputing_delay_periods = 2\nsubsteps = 8\n\
             [physical]\nJ_base = 1.0\nJ_link = 2.0\nK_stiff = 3.0\nK_b = 4.0\nK_g = 5.0\nR_ohm = 6.0\nB_eq = 7.0\nlength_m = 8.0\n\
             [link]\nmodes = 5\neta_s = 0.01\ntip_mass_kg = 0.1\n\
             [actuator]\nconverter_step_v = 0.0\nlimit_v = inf\ndead_zone_plus_v = 0.3\ndead_zone_minus_v = 0.4\n\
             [friction]\ncoulomb_nm = 0.1\nstribeck_extra_nm = 0.2\nstribeck_speed_rad_s = 0.3\n\
             [encoder]\ncounts_per_turn = 0\n\
             [gauge]\nsees = \"root_strain\"\nnoise_rad = 0.5\nbias_rad = -0.6\nconverter_step_rad = 0.7\n",
        );
        let expected = RigParameters {
            physical: Physical {
                J_base: 1.0,
                J_link: 2.0,
                K_stiff: 3.0,
                K_b: 4.0,
                K_g: 5.0,
                R_ohm: 6.0,
                B_eq: 7.0,
                length_m: 8.0,
            },
            link: Link::Modes { count: 5, damping: Damping::KelvinVoigt { eta_s: 0.01 }, tip_mass_kg: 0.1 },
            actuator: Actuator {
                converter_step_v: None,
                limit_v: f64::INFINITY,
                dead_zone_plus_v: 0.3,
                dead_zone_minus_v: 0.4,
            },
            friction: Friction { coulomb_nm: 0.1, stribeck: Some(Stribeck { extra_nm: 0.2, speed_rad_s: 0.3 }) },
            sensors: Sensors {
                encoder: Encoder { counts_per_turn: None },
                gauge: Gauge {
                    sees: GaugeSees::RootStrain,
                    noise_rad: 0.5,
                    bias_rad: -0.6,
                    converter_step_rad: Some(0.7),
                },
            },
            period_s: 0.002,
            computing_delay_periods: 2,
            substeps: 8,
        };
        assert_eq!(found.unwrap(), expected);
    }

    #[test]
    fn the_lumped_numbers_come_back() {
        let found = read("[lumped]\nk1 = 900.0\nk2 = 1400.0\nc = 40.0\nb = 90.0\n[link]\nmodes = 0\n").unwrap();
        assert_eq!(found.link, Link::Lumped);
        let Lumped { k1, k2, c, b } = found.physical.lumped();
        for (x, expected) in [(k1, 900.0), (k2, 1400.0), (c, 40.0), (b, 90.0)] {
            assert!((x / expected - 1.0_f64).abs() < 1e-14, "{x} {expected}");
        }
    }

    #[test]
    fn what_no_rig_can_have_is_refused_with_its_name() {
        for (toml, named) in [
            ("[friction]\nstribeck_extra_nm = 0.01\n", "stribeck_speed_rad_s"),
            ("[friction]\nstribeck_speed_rad_s = 0.1\n", "stribeck_extra_nm"),
            ("[physical]\nJ_base = -1.0\n", "J_base"),
            ("[lumped]\nk1 = 2.0\nk2 = 1.0\nc = 1.0\nb = 1.0\n", "k2"),
            ("[link]\nmodes = 99\n", "modes"),
            ("period_s = 0.0\n", "period"),
        ] {
            let message = read(toml).unwrap_err().to_string();
            assert!(message.contains(named) && message.contains("hint: "), "{message}");
        }
    }
}
