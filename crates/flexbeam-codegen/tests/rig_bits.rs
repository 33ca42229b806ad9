//! The generated rig against flexbeam-rig: a hundred thousand periods of sticking, sliding, saturation and noise, every bit.

mod support;

use flexbeam_codegen::{Name, RigSubject, rig_sources};
use flexbeam_rig::{
    Actuator, Damping, Encoder, Friction, Gauge, GaugeSees, Link, RigParameters, Sensors, SimulatedRig, Stribeck,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use support::{compile, named, run, succeeds};

const PERIODS: usize = 100_000;
const BUILDS: [&[&str]; 4] = [&["-O0"], &["-O1"], &["-O2"], &["-O3"]];

/// How often something happened.
#[derive(Debug, Default)]
struct Visits {
    stuck: usize,
    free: usize,
    sliding: usize,
    changes: usize,
    saturated: usize,
}

/// Noise, holds, ramps through breakaway, swings, saturation, and now and then what is no number.
fn voltages(periods: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(71);
    let (mut held, mut left, mut kind) = (0.0, 0, 0);
    let voltage = |k: usize| {
        if left == 0 {
            kind = random.random_range(0..7);
            left = if kind < 2 { random.random_range(300..1500) } else { random.random_range(20..400) };
            held = random.random_range(-1.0..1.0);
        }
        left -= 1;
        match kind {
            0 => 0.0,
            1 => 0.3 * held,
            6 => held,
            2 => 0.4 * held * f64::from(left) / 100.0,
            3 => 14.0 * held,
            4 => 3.0 * (0.03 * k as f64).sin(),
            _ if left == 7 => f64::NAN,
            _ => random.random_range(-12.0..12.0),
        }
    };
    (0..periods).map(voltage).collect()
}

fn write_periods(path: &Path, parameters: &RigParameters, seed: u64, periods: usize) -> Visits {
    let mut rig = SimulatedRig::new(parameters, seed).unwrap();
    let mut out = BufWriter::with_capacity(1 << 20, std::fs::File::create(path).unwrap());
    let (mut visits, mut before) = (Visits::default(), None);
    let free = parameters.friction.breakaway_nm() == 0.0;
    for voltage_v in voltages(periods) {
        let read = rig.measure();
        rig.apply(voltage_v);
        let truth = rig.truth();
        let contact = if free { 0.0 } else { f64::from(2 - u8::from(truth.stuck)) };
        let row = [
            voltage_v,
            read.theta_rad,
            read.alpha_rad,
            truth.theta_rad,
            truth.alpha_rad,
            truth.theta_rad_s,
            truth.alpha_rad_s,
            contact,
        ];
        row.iter().for_each(|x| out.write_all(&x.to_le_bytes()).unwrap());
        visits.free += usize::from(free);
        visits.stuck += usize::from(truth.stuck);
        visits.sliding += usize::from(!truth.stuck && !free);
        visits.changes += usize::from(before.is_some_and(|before| before != truth.stuck));
        visits.saturated += usize::from(voltage_v.abs() > 10.0);
        before = Some(truth.stuck);
    }
    visits
}

fn written(name: &str, parameters: &RigParameters) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let subject = RigSubject { parameters, sha256: None };
    for file in rig_sources(&subject, &Name::new("beam").unwrap()).unwrap() {
        std::fs::write(folder.join(file.path), file.text).unwrap();
    }
    std::fs::write(folder.join("harness.c"), named(include_str!("support/rig_harness.c"))).unwrap();
    folder
}

fn every_bit(name: &str, parameters: &RigParameters, builds: &[&[&str]], seed: u64, periods: usize) -> Visits {
    let folder = written(name, parameters);
    let file = folder.join("periods");
    let visits = write_periods(&file, parameters, seed, periods);
    for compiler in ["gcc", "clang"] {
        for flags in builds {
            let program = compile(compiler, flags, &["beam.c", "harness.c"], "harness", &folder);
            let said = succeeds(&program, &["periods", &seed.to_string()], &folder);
            assert_eq!(said.trim(), format!("{periods} periods"), "{compiler} {flags:?}");
        }
    }
    visits
}

fn noisy() -> Sensors {
    let gauge = Gauge { noise_rad: 3e-3, bias_rad: -0.01, converter_step_rad: None, sees: GaugeSees::RootStrain };
    Sensors { encoder: Encoder { counts_per_turn: None }, gauge }
}

#[test]
fn the_paper_s_rig() {
    let visits = every_bit("rig_paper", &RigParameters::default(), &BUILDS, 1, PERIODS);
    assert!(visits.stuck > 15_000 && visits.sliding > 40_000 && visits.changes > 400, "{visits:?}");
    assert!(visits.saturated > 2_000, "{visits:?}");
    // The comparison itself: another seed is another reading.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rig_paper");
    let output = run(folder.join("harness"), &["periods", "2"], &folder);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("period 0 differs"));
}

/// The noise in full, with its tail: of the default converter's steps most of it is rounded away.
#[test]
fn a_rig_with_stribeck_friction_and_exact_converters() {
    let stribeck = Some(Stribeck { extra_nm: 0.006, speed_rad_s: 0.15 });
    let parameters = RigParameters {
        friction: Friction { coulomb_nm: 0.0125, stribeck },
        sensors: noisy(),
        actuator: Actuator { converter_step_v: None, ..Actuator::default() },
        ..RigParameters::default()
    };
    let visits = every_bit("rig_stribeck", &parameters, &BUILDS, u64::MAX, PERIODS);
    assert!(visits.changes > 400, "{visits:?}");
}

#[test]
fn lumped_linear_and_long_rigs() {
    let default = RigParameters::default();
    let many = Link::Modes { count: 16, damping: Damping::KelvinVoigt { eta_s: 1e-5 }, tip_mass_kg: 0.02 };
    let one = Link::Modes { count: 1, damping: Damping::Modal { zeta: 0.0 }, tip_mass_kg: 0.0 };
    for (name, parameters, periods) in [
        ("rig_lumped", RigParameters { link: Link::Lumped, period_s: 0.002, substeps: 1, ..default }, PERIODS),
        ("rig_linear", RigParameters { sensors: noisy(), ..default.linear() }, PERIODS),
        ("rig_one_mode", RigParameters { link: one, substeps: 3, ..default }, PERIODS),
        // Thirty times the work a period.
        ("rig_many_modes", RigParameters { link: many, substeps: 8, ..default }, PERIODS / 20),
    ] {
        every_bit(name, &parameters, &[&["-O2"]], 2009, periods);
    }
}

#[test]
fn it_is_clean_under_the_sanitizers() {
    let parameters = RigParameters { sensors: noisy(), ..RigParameters::default() };
    let sanitized: &[&str] = &["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    every_bit("rig_sanitized", &parameters, &[sanitized], 3, 5_000);
}

/// On other processors there may be nothing to contract.
#[cfg(target_arch = "x86_64")]
#[test]
fn the_self_check_finds_a_build_that_contracts_or_flushes() {
    let folder = written("rig_contracted", &RigParameters::default());
    write_periods(&folder.join("periods"), &RigParameters::default(), 1, 10);
    let build = |flags: &[&str]| {
        let mut arguments = flags.to_vec();
        arguments.extend(["beam.c", "harness.c", "-o", "harness"]);
        succeeds("gcc", &arguments, &folder);
        let output = run(folder.join("harness"), &["periods", "1"], &folder);
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    if std::arch::is_x86_feature_detected!("fma") {
        let (status, said) = build(&["-std=c99", "-O2", "-ffp-contract=fast", "-mfma"]);
        assert!(status == Some(3) && said.contains("selfcheck"), "{status:?} {said}");
    } else {
        eprintln!("\n!!! LEFT OUT: this processor cannot contract products and sums !!!\n");
    }
    let start = "#include <xmmintrin.h>\n__attribute__((constructor)) static void flush(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }\n";
    std::fs::write(folder.join("flush.c"), start).unwrap();
    let (status, said) = build(&["-O2", "-ffp-contract=off", "flush.c"]);
    assert!(status == Some(3) && said.contains("selfcheck: period 1"), "{status:?} {said}");
}
