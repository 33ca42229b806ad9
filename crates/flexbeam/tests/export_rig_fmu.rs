//! `flexbeam export --as fmu` of a rig: FMPy finds the bits of flexbeam-rig, and of `flexbeam simulate` with both units in a loop;
//! what is refused.

mod support;

use std::collections::VecDeque;
use std::process::Command;

use flexbeam_rig::{
    Actuator, Beam, Damping, Encoder, Friction, Gauge, GaugeSees, Link, RigParameters, Sensors, SimulatedRig, Stribeck,
};
use support::{Bench, pseudorandom, python};

const CONTROLLER: &str = include_str!("../../flexbeam-codegen/tests/data/reproduce.toml");

/// Other matrices, another noise, more delay; exact converters, so that every bit of the noise shows.
const RIG: &str = r#"schema = "flexbeam.rig/1"
period_s = 0.002
computing_delay_periods = 3
substeps = 2
[link]
modes = 5
tip_mass_kg = 0.01
[actuator]
converter_step_v = 0.0
limit_v = 6.0
[friction]
coulomb_nm = 0.0125
stribeck_extra_nm = 0.006
stribeck_speed_rad_s = 0.15
[encoder]
counts_per_turn = 0
[gauge]
sees = "root_strain"
noise_rad = 0.001
bias_rad = -0.02
converter_step_rad = 0.0
"#;

/// What [`RIG`] says; the delay is not the rig's own.
fn as_in_the_file() -> RigParameters {
    let default = RigParameters::default();
    let stribeck = Some(Stribeck { extra_nm: 0.006, speed_rad_s: 0.15 });
    let gauge = Gauge { sees: GaugeSees::RootStrain, noise_rad: 0.001, bias_rad: -0.02, converter_step_rad: None };
    RigParameters {
        period_s: 0.002,
        substeps: 2,
        link: Link::Modes { count: 5, damping: Damping::Modal { zeta: Beam::ZETA }, tip_mass_kg: 0.01 },
        actuator: Actuator { converter_step_v: None, limit_v: 6.0, ..default.actuator },
        friction: Friction { coulomb_nm: 0.0125, stribeck },
        sensors: Sensors { encoder: Encoder { counts_per_turn: None }, gauge },
        ..default
    }
}

/// Rests, holds, ramps through breakaway, noise beyond the limit.
fn voltages(count: usize) -> Vec<f64> {
    let noise = pseudorandom(count);
    let voltage = |k: usize| match k / 500 % 5 {
        0 => 0.0,
        1 => 3.0 * noise[k / 500 * 500],
        2 => (k % 500) as f64 / 1000.0,
        3 => 15.0 * noise[k],
        _ => 2.0 * (0.05 * k as f64).sin(),
    };
    (0..count).map(voltage).collect()
}

/// What the script reads: at each instant the outputs, whether the hub sticks, and the voltage sent from there on, which arrives
/// `late` periods after.
fn periods(parameters: &RigParameters, seed: u64, late: usize, count: usize) -> Vec<u8> {
    let mut rig = SimulatedRig::new(parameters, seed).expect("a rig");
    let mut on_its_way: VecDeque<f64> = vec![0.0; late].into();
    let (mut bytes, mut stuck) = (Vec::new(), 0);
    for voltage_v in voltages(count) {
        let (read, truth) = (rig.measure(), rig.truth());
        stuck += usize::from(truth.stuck);
        let row = [
            read.theta_rad,
            read.alpha_rad,
            truth.theta_rad,
            truth.alpha_rad,
            truth.psi_rad(),
            truth.theta_rad_s,
            truth.alpha_rad_s,
            f64::from(u8::from(truth.stuck)),
            voltage_v,
        ];
        bytes.extend(row.iter().flat_map(|x| x.to_le_bytes()));
        on_its_way.push_back(voltage_v);
        rig.apply(on_its_way.pop_front().expect("one was put in"));
    }
    assert!(stuck > count / 20 && stuck < count / 2, "stuck in {stuck} of {count} periods");
    bytes
}

/// The script's last words; it ends with an error at the first wrong bit.
fn under_fmpy(bench: &Bench, words: &[&str], expected: &str) {
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/run_rig_fmu.py");
    let mut run = Command::new(python);
    // FMPy's own CMake file asks for a C++ compiler, too; gcc's needs a package more.
    run.args(["-B", script]).args(words).current_dir(bench.path("")).env("CXX", "clang++");
    let output = run.output().expect("Python starts");
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && said.trim_end().ends_with(expected), "{words:?}: {said}");
}

/// Twenty seconds of the paper's rig with its friction, noise and saturation, and of another one from a file, whose sources FMPy
/// compiles. Long because FMPy makes four calls a period.
#[test]
fn another_importer_finds_the_simulated_rig_s_bits() {
    let bench = Bench::new();
    bench.write("rig.toml", RIG);
    let other = as_in_the_file();
    std::fs::write(bench.path("paper"), periods(&RigParameters::default(), 1, 0, 20_000)).expect("written");
    std::fs::write(bench.path("other"), periods(&other, 77, 2, 10_000)).expect("written");
    for version in ["2", "3"] {
        bench.done(&format!("export paper --as fmu --fmi {version} -o paper.fmu --force"));
        let line = format!("export rig.toml --as fmu --fmi {version} --name beam --sources-only -o rig.fmu --force");
        bench.done(&line);
        under_fmpy(&bench, &["paper.fmu", "paper", "0.001"], &format!("20000 periods, FMI {version}.0"));
        under_fmpy(
            &bench,
            &["rig.fmu", "other", "0.002", "--build", "seed=77"],
            &format!("10000 periods, FMI {version}.0"),
        );
    }
}

/// What a host sets before the first step is as if the rig had been made so.
#[test]
fn parameters_set_by_the_host_are_a_rig_made_of_them() {
    let bench = Bench::new();
    let default = RigParameters::default();
    let stribeck = Some(Stribeck { extra_nm: 0.01, speed_rad_s: 0.3 });
    let parameters = RigParameters {
        actuator: Actuator {
            converter_step_v: Some(0.01),
            limit_v: 5.0,
            dead_zone_plus_v: 0.1,
            dead_zone_minus_v: 0.3,
        },
        friction: Friction { coulomb_nm: 0.02, stribeck },
        sensors: Sensors {
            encoder: Encoder { counts_per_turn: Some(1000) },
            gauge: Gauge { noise_rad: 0.002, bias_rad: 0.01, converter_step_rad: None, ..default.sensors.gauge },
        },
        ..default
    };
    std::fs::write(bench.path("periods"), periods(&parameters, 2_147_483_647, 1, 5_000)).expect("written");
    let given = "seed=2147483647 delay_periods=1 actuator.converter_step_v=0.01 actuator.limit_v=5 \
                 actuator.dead_zone_plus_v=0.1 actuator.dead_zone_minus_v=0.3 friction.coulomb_nm=0.02 \
                 friction.stribeck_extra_nm=0.01 friction.stribeck_speed_rad_s=0.3 encoder.counts_per_turn=1000 \
                 gauge.noise_rad=0.002 gauge.bias_rad=0.01 gauge.converter_step_rad=0";
    for version in ["2", "3"] {
        bench.done(&format!("export paper --as fmu --fmi {version} -o rig.fmu --force"));
        let words: Vec<&str> = ["rig.fmu", "periods", "0.001"].into_iter().chain(given.split_whitespace()).collect();
        under_fmpy(&bench, &words, &format!("5000 periods, FMI {version}.0"));
    }
}

/// Each unit takes what the other answered at the step before: so one period of delay lies in the loop, as in `simulate`.
#[test]
fn both_units_in_a_loop_are_flexbeam_simulate() {
    let bench = Bench::new();
    bench.write("controller.toml", CONTROLLER);
    bench.write("late.toml", "schema = \"flexbeam.rig/1\"\ncomputing_delay_periods = 2\n[gauge]\nbias_rad = 0.001\n");
    let late = "--rig late.toml";
    for (rig, source, seed, of_rig, of_controller) in
        [("", "paper", 4, "2", "2"), ("", "paper", 4, "3", "3"), (late, "late.toml", 5, "2", "3")]
    {
        bench.done(&format!("simulate controller.toml {rig} --step-deg 30 --duration 5 --seed {seed} -o out"));
        bench.done(&format!("export {source} --as fmu --fmi {of_rig} -o rig.fmu --force"));
        bench.done(&format!("export controller.toml --as fmu --fmi {of_controller} -o controller.fmu --force"));
        let seed = format!("seed={seed}");
        let words = ["rig.fmu", "out/response.csv", "0.001", "--loop", "controller.fmu", &seed];
        under_fmpy(&bench, &words, &format!("5100 periods in a loop, FMI {of_rig}.0"));
    }
}

#[test]
fn what_it_is_of_is_told_and_the_same_rig_gives_the_same_archive() {
    let bench = Bench::new();
    bench.write("rig.toml", RIG);
    let paper = bench.json("export paper --as fmu -o one.fmu");
    assert_eq!(paper["sha256"], bench.json("export paper --as fmu -o two.fmu")["sha256"]);
    assert_eq!((&paper["schema"], &paper["source"]), (&"flexbeam.rig/1".into(), &"paper".into()));
    assert_eq!((&paper["source_sha256"], &paper["name"]), (&serde_json::Value::Null, &"rig".into()));
    assert_eq!((paper["order"].as_u64(), paper["period_s"].as_f64()), (Some(8), Some(0.001)));
    let own = bench.json("export rig.toml --as fmu --fmi 3 --sources-only -o three.fmu");
    assert_eq!((own["order"].as_u64(), own["period_s"].as_f64()), (Some(12), Some(0.002)));
    assert_eq!(own["source_sha256"].as_str().map(str::len), Some(64));
}

#[test]
fn bad_input_is_told_and_nothing_is_left_behind() {
    let bench = Bench::new();
    bench.write("rig.toml", RIG);
    bench.write("prompt.toml", "schema = \"flexbeam.rig/1\"\ncomputing_delay_periods = 0\n");
    bench.write("heavy.toml", "schema = \"flexbeam.rig/1\"\n[physical]\nJ_link = -1.0\n");
    bench.write("fine.toml", "schema = \"flexbeam.rig/1\"\n[encoder]\ncounts_per_turn = 3000000000\n");
    bench.write("model.toml", "schema = \"flexbeam.model/1\"\n");
    bench.write("table.csv", "time_s,voltage_v\n0,0\n");
    bench.write("standing.fmu", "mine");
    let before = bench.names();
    for (line, words) in [
        ("export prompt.toml --as fmu -o out.fmu", "found a rig without computing delay"),
        ("export heavy.toml --as fmu -o out.fmu", "J_link is -1"),
        (
            "export fine.toml --as fmu -o out.fmu",
            "found encoder.counts_per_turn = 3000000000, needed at most 2147483647",
        ),
        ("export model.toml --as fmu -o out.fmu", "flexbeam.controller/1 or flexbeam.rig/1"),
        ("export table.csv --as fmu -o out.fmu", "flexbeam.controller/1 or flexbeam.rig/1"),
        ("export no.toml --as fmu -o out.fmu", "no.toml"),
        ("export rig.toml --as fmu --name memory -o out.fmu", "taken by the files"),
        ("export rig.toml --as fmu --unverified me -o out.fmu", "found --unverified with --as fmu of a rig"),
        ("export rig.toml --as fmu -o standing.fmu", "a file of that name"),
        ("export rig.toml --as c -o out", "flexbeam.controller/1"),
        ("export paper --as c -o out", "paper"),
        ("export rig.toml --as mat -o out.mat", "flexbeam.model/1 or flexbeam.controller/1"),
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, 2, "{line}: {}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("hint: "), "{line}: {}", answer.err);
        assert_eq!((answer.out.as_str(), bench.names()), ("", before.clone()), "{line}");
    }
}
