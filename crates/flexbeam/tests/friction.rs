//! `flexbeam rig test --friction`: on the simulated rig, at a port, from a recording, into a rig file.

#[allow(dead_code, reason = "each test uses a part")]
mod rigs;
mod support;

use rigs::RigProcess;
use serde_json::Value;
use support::{Bench, number};

const OTHER: &str = "schema = \"flexbeam.rig/1\"\n[actuator]\ndead_zone_plus_v = 0.1\ndead_zone_minus_v = 0.15\n\
    [friction]\ncoulomb_nm = 0.025\n[physical]\nB_eq = 0.01\n";

/// Off by no more than this part of the truth, and by no more than one and a half times its own 95 %.
fn near(answer: &Value, key: &str, truth: f64, part: f64) {
    let quantity = &answer["friction"][key];
    let off = (number(quantity, "value") - truth).abs();
    assert!(off < part * truth.abs(), "{key}: {quantity} for {truth}");
    assert!(off < 1.5 * number(quantity, "half_width_95"), "{key}: {quantity} for {truth}");
}

/// The whole way: another rig's friction is measured, written into a rig file, and that rig breaks away where the first one does.
#[test]
fn another_rig_s_friction_is_found_told_again_and_written() {
    let bench = Bench::new();
    bench.write("other.toml", OTHER);
    // The tester knows the motor of the data sheet and nothing of the friction: only K_g, K_b and R of the file are used.
    let answer = bench.json("rig test --friction --rig other.toml --keep test.csv --write-rig found.toml --plots p");
    near(&answer, "coulomb_nm", 0.025, 0.10);
    near(&answer, "viscous_nm_s", 0.01, 0.05);
    near(&answer, "dead_zone_plus_v", 0.1, 0.10);
    near(&answer, "dead_zone_minus_v", 0.15, 0.10);
    let volts = 0.025 / number(&answer["friction"]["torque_per_volt_nm"], "value");
    for (key, truth) in [("plus_v", 0.1 + volts), ("minus_v", -0.15 - volts)] {
        let value = number(&answer["repeated"][key], "value");
        assert!((value / truth - 1.0).abs() < 0.05, "{key}: {value} for {truth}");
    }
    assert!(bench.path("p/friction.svg").exists() && bench.path("p/friction.png").exists());

    let again = bench.json("rig test --friction --rig other.toml --from test.csv");
    // The CSV file rounds nothing; its period is a difference of times and does.
    let same = number(&again["friction"]["coulomb_nm"], "value") / number(&answer["friction"]["coulomb_nm"], "value");
    assert!((same - 1.0).abs() < 1e-6, "{same}");
    assert_eq!(again["breakaway_plus_v"], answer["breakaway_plus_v"]);

    let written = bench.json("show found.toml")["content"].clone();
    assert_eq!(written["friction"]["coulomb_nm"], answer["friction"]["coulomb_nm"]["value"]);
    let of_found = bench.json("rig test --rig found.toml");
    let off = number(&of_found, "breakaway_plus_v") / number(&answer, "breakaway_plus_v") - 1.0;
    assert!(off.abs() < 0.05, "{off}");
}

/// By the slope and the resistance alone; the rig has nothing viscous.
#[test]
fn without_viscous_friction_the_resistance_is_enough() {
    let answer = Bench::new().json("rig test --friction --no-viscous --repeats 1");
    near(&answer, "coulomb_nm", 0.0165, 0.10);
    assert_eq!(number(&answer["friction"]["viscous_nm_s"], "value"), 0.0);
    assert!(answer["repeated"].is_null(), "one ramp has no standard error");
}

/// A ramp on the clock ends when the hub has moved: it used to turn on for more than a turn, into the angle limit.
#[test]
fn a_ramp_at_a_port_ends_with_the_breakaway() {
    let bench = Bench::new();
    let rig = RigProcess::udp(&bench, "");
    let line = format!("rig test --port {} --sign-check 0 --rest 1 --slope 0.1 --hold 1 --keep test.csv", rig.port);
    let answer = bench.json(&line);
    let (plus, minus) = (number(&answer, "breakaway_plus_v"), number(&answer, "breakaway_minus_v"));
    // A steep ramp finds it late, and the beam still swings before the second.
    assert!((0.27..0.34).contains(&plus) && (-0.15..-0.03).contains(&minus), "{plus} {minus}");
    let turned =
        support::column(&bench.read("test.csv"), "theta_rad").iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(turned > 0.01 && turned < 0.3, "{turned}");
}

#[test]
fn what_cannot_be_tested_is_refused_and_leaves_nothing() {
    let bench = Bench::new();
    bench.done("record --duration 2 --out noise.csv");
    let steps = |levels: &[f64]| {
        let rows = levels.iter().flat_map(|v| std::iter::repeat_n(*v, 1000)).enumerate();
        let text = rows.map(|(k, v)| format!("{},{v},0,0\n", k as f64 / 1000.0)).collect::<String>();
        format!("time_s,voltage_v,theta_rad,alpha_rad\n{text}")
    };
    bench.write("still.csv", &steps(&[0.0, 0.1, 0.0, -0.1]));
    bench.write("no_alpha.csv", "time_s,voltage_v,theta_rad\n0,0,0\n0.001,0,0\n0.002,0,0\n");
    let before = bench.names();
    for (line, words) in [
        ("rig test --friction --from still.csv", ["found 0 runs", "forward"]),
        ("rig test --friction --from noise.csv", ["found 0 runs", "hint: "]),
        ("rig test --from still.csv", ["never moved", "0.1 V"]),
        ("rig test --from no_alpha.csv", ["alpha_rad", "hint: "]),
        ("rig test --friction --travel-deg 2", ["travel of 2 degree", "50 to 138"]),
        ("rig test --friction --travel-deg=-3", ["travel of -3 degree", "--travel-deg 120"]),
        ("rig test --repeats 0", ["number of ramps", "--repeats 1"]),
        ("rig test --write-rig found.toml", ["--friction", "required"]),
        ("rig test --friction --write-rig noise.csv", ["noise.csv", "hint: "]),
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, 2, "{line}: {}", answer.err);
        assert!(answer.out.is_empty(), "{line}: {}", answer.out);
        for word in words {
            assert!(answer.err.contains(word), "{line}: {word:?} is not in {}", answer.err);
        }
    }
    assert_eq!(bench.names(), before);
}
