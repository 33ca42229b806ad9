//! `flexbeam record` and `flexbeam rig test` on the simulated rig.

mod support;

use support::{Bench, column, number};

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let bench = Bench::new();
    for (name, options) in
        [("a.csv", "--seed 7"), ("b.csv", "--seed 7"), ("c.csv", "--seed 8"), ("d.csv", "--seed 7 --linear")]
    {
        bench.done(&format!("record --duration 0.5 -o {name} {options}"));
    }
    let csv = |name| bench.read(name);
    assert_eq!(csv("a.csv"), csv("b.csv"));
    assert_ne!(csv("a.csv"), csv("c.csv"));
    assert_ne!(csv("a.csv"), csv("d.csv"));
    assert_ne!(column(&csv("a.csv"), "voltage_v"), column(&csv("c.csv"), "voltage_v"));
}

#[test]
fn the_recording_has_its_columns_and_its_note() {
    let bench = Bench::new();
    let answer = bench.json("record --duration 2 --period 0.002 --rms 3 --seed 4");
    let csv = bench.read("recording.csv");
    assert_eq!(csv.lines().next(), Some("time_s,voltage_v,theta_rad,alpha_rad"));
    let time = column(&csv, "time_s");
    assert_eq!((time.len(), time[0], time[999]), (1000, 0.0, 1.998));
    assert_eq!(number(&answer, "samples"), 1000.0);
    let voltage = column(&csv, "voltage_v");
    let rms = (voltage.iter().map(|v| v * v).sum::<f64>() / 1000.0).sqrt();
    assert!((number(&answer, "rms_v") / rms - 1.0).abs() < 1e-12);
    // Four standard deviations of the estimate.
    assert!((rms / 3.0 - 1.0).abs() < 4.0 / 2000f64.sqrt(), "{rms}");
    let note = bench.json("show recording.csv.toml");
    assert_eq!(note["content"]["sha256"], answer["sha256"]);
    assert_eq!(bench.json("show recording.csv")["history"][0]["sha256_found"], answer["sha256"]);
}

/// (18) by Heun's rule in steps far below the period: another formula, and close enough to tell a wrong sign.
#[test]
fn the_linear_recording_is_the_paper_s_plant() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1");
    let csv = bench.read("recording.csv");
    let (voltage, theta, alpha) = (column(&csv, "voltage_v"), column(&csv, "theta_rad"), column(&csv, "alpha_rad"));
    const STEPS: usize = 200;
    let h = 0.001 / STEPS as f64;
    let slope = |x: [f64; 4], v: f64| {
        let torque = 107.39 * v - 57.7 * x[2];
        [x[2], x[3], 1060.8 * x[1] + torque, -1465.2 * x[1] - torque]
    };
    let mut x = [0.0; 4];
    let largest = theta.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    for (k, &v) in voltage.iter().enumerate() {
        assert!((x[0] - theta[k]).abs() < 1e-7 * largest, "theta at sample {k}: {} {}", x[0], theta[k]);
        assert!((x[1] - alpha[k]).abs() < 1e-7 * largest, "alpha at sample {k}: {} {}", x[1], alpha[k]);
        for _ in 0..STEPS {
            let first = slope(x, v);
            let ahead = std::array::from_fn(|i| x[i] + h * first[i]);
            let second = slope(ahead, v);
            x = std::array::from_fn(|i| x[i] + 0.5 * h * (first[i] + second[i]));
        }
    }
}

/// A hub that stays where it is: the gauge then reads its own noise, which must not be the excitation again.
#[test]
fn the_sensor_noise_is_independent_of_the_excitation() {
    let bench = Bench::new();
    bench.write(
        "rig.toml",
        "schema = \"flexbeam.rig/1\"\n[friction]\ncoulomb_nm = 100.0\n[gauge]\nconverter_step_rad = 0.0\n",
    );
    bench.done("record --rig rig.toml --duration 10 --rms 1");
    let csv = bench.read("recording.csv");
    let (voltage, alpha) = (column(&csv, "voltage_v"), column(&csv, "alpha_rad"));
    assert!(column(&csv, "theta_rad").iter().all(|theta| *theta == 0.0));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = product(&voltage, &alpha) / (product(&voltage, &voltage) * product(&alpha, &alpha)).sqrt();
    assert!(product(&alpha, &alpha) > 0.0);
    assert!(correlation.abs() < 4.0 / 100.0, "{correlation}");
}

#[test]
fn a_newer_recording_replaces_an_older_one_and_the_rig_is_its_parent() {
    let bench = Bench::new();
    bench.write("rig.toml", "schema = \"flexbeam.rig/1\"\nperiod_s = 0.002\n");
    bench.done("record --duration 0.1 --seed 1");
    bench.done("record --duration 0.1 --seed 2 --rig rig.toml");
    assert_eq!(column(&bench.read("recording.csv"), "time_s")[1], 0.002, "the rig's own period");
    let history = bench.json("show recording.csv")["history"].clone();
    assert_eq!((history[1]["path"].as_str(), history[1]["state"].as_str()), (Some("rig.toml"), Some("same")));
}

/// The default rig breaks away at 0.20 + 0.08 V and at -(0.02 + 0.08) V; the ramp tells it late by a few millivolts.
#[test]
fn the_ramp_finds_the_breakaway_of_the_rig() {
    let bench = Bench::new();
    let answer = bench.json("rig test");
    let late = |key: &str, truth: f64| {
        let late = (number(&answer, key) - truth) * truth.signum();
        assert!((0.0..0.01).contains(&late), "{key}: {late} V late");
    };
    late("breakaway_plus_v", 0.28);
    late("breakaway_minus_v", -0.10);
    for key in ["u_p_plus_v", "u_p_minus_v", "eps_u_v", "eps_e_rad"] {
        assert!(number(&answer, key) > 0.0, "{key}");
    }
    assert_eq!(answer["law"], "inverse");
    assert!(answer["applied_to"].is_null());
}

#[test]
fn the_ramp_finds_another_rig_s_breakaway() {
    let bench = Bench::new();
    bench.write(
        "rig.toml",
        "schema = \"flexbeam.rig/1\"\n[actuator]\ndead_zone_plus_v = 0.05\ndead_zone_minus_v = 0.15\n[friction]\ncoulomb_nm = 0.0\n",
    );
    let answer = bench.json("rig test --rig rig.toml --law switched");
    let (plus, minus) = (number(&answer, "breakaway_plus_v"), number(&answer, "breakaway_minus_v"));
    assert!((0.05..0.06).contains(&plus) && (-0.16..-0.15).contains(&minus), "{plus} {minus}");
    // The switched law sends at least the breakaway, and hands over above it.
    assert!(number(&answer, "u_p_plus_v") > plus && number(&answer, "u_p_minus_v") > -minus);
    assert!(number(&answer, "eps_u_v") > number(&answer, "u_p_minus_v"));
}

/// The settings found go into the controller; nothing else in it changes.
#[test]
fn the_settings_are_written_into_a_controller() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1");
    bench.done("identify recording.csv --order 4");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty 0.2 -o controller.toml");
    let before = bench.json("show controller.toml")["content"].clone();
    let answer = bench.json("rig test --apply-to controller.toml --law switched");
    let after = bench.json("show controller.toml")["content"].clone();
    assert_eq!(answer["applied_to"], "controller.toml");
    assert_eq!(after["settings"]["law"], "switched");
    for key in ["u_p_plus_v", "u_p_minus_v", "eps_u_v", "eps_e_rad", "breakaway_plus_v"] {
        assert_eq!(after["settings"][key], answer[key], "{key}");
    }
    assert_eq!(number(&after["settings"], "breakaway_minus_v"), -number(&answer, "breakaway_minus_v"));
    for (key, value) in before.as_object().expect("a controller") {
        assert!(key == "settings" || after[key] == *value, "{key} changed");
    }
    assert_eq!(bench.json("rig test --apply-to controller.toml")["law"], "switched", "the controller's own law");
}

/// The voltage repeats, its note says how, and so does what the note's reader gets.
#[test]
fn the_excitation_is_what_was_asked_for_and_stands_in_the_note() {
    let bench = Bench::new();
    let line = "record --signal odd-multisine --band 0.5,50 --periods 4 --duration 8 --rms 2 --seed 3";
    let answer = bench.json(line);
    let planned = &answer["excitation"];
    assert_eq!((planned["signal"].as_str(), number(planned, "period_samples")), (Some("odd-multisine"), 2000.0));
    assert_eq!((number(planned, "periods"), &planned["band_hz"]), (4.0, &serde_json::json!([0.5, 50.0])));
    let csv = bench.read("recording.csv");
    let voltage = column(&csv, "voltage_v");
    assert_eq!(voltage.len(), 8000);
    assert!(voltage.chunks(2000).all(|period| period == &voltage[..2000]));
    let peak = voltage.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!((peak - number(planned, "peak_v")).abs() < 1e-12 && (number(planned, "rms_v") - 2.0).abs() < 1e-12);
    let sha256 = answer["sha256"].as_str().unwrap();
    let read = flexbeam_files::Excitation::of_recording(&bench.path("recording.csv"), sha256).expect("the note says");
    assert_eq!(serde_json::to_value(&read).unwrap(), *planned);
    assert_eq!(flexbeam_files::Excitation::of_recording(&bench.path("recording.csv"), "another"), None);
}

/// On the clock the list of voltages is the same one, and the run's own metadata hold the plan.
#[test]
fn a_run_on_the_clock_has_the_same_voltages_and_the_plan_in_its_metadata() {
    let bench = Bench::new();
    let plan = "--signal prbs --band 5,40 --duration 0.3 --period 0.002 --rms 2";
    let planned = bench.json(&format!("record {plan} -o table.csv"))["excitation"].clone();
    bench.done(&format!("record {plan} --hold 5 -o run.mcap"));
    let bytes = std::fs::read(bench.path("run.mcap")).unwrap();
    let sha256 = flexbeam_files::sha256_hex(&bytes);
    let read = flexbeam_files::Excitation::of_recording(&bench.path("run.mcap"), &sha256).expect("the metadata say");
    assert_eq!(serde_json::to_value(&read).unwrap(), planned);
    bench.done("export run.mcap --as csv -o run.csv");
    let (table, run) = (bench.read("table.csv"), bench.read("run.csv"));
    let (sent, came) = (column(&table, "voltage_v"), column(&run, "voltage_v"));
    assert!(came.windows(sent.len()).any(|window| window == sent), "the run holds the planned voltages");
}

/// Before the rig moves: the figures do not depend on what it then does, and twice the voltage halves them.
#[test]
fn the_expected_standard_errors_are_said_before_the_rig_moves() {
    let bench = Bench::new();
    let weak = bench.run("record --duration 2 --rms 1 --json");
    let strong = bench.json("record --duration 2 --rms 2 -o strong.csv");
    assert!(weak.err.contains("expected of the whole recording"), "{}", weak.err);
    let weak: serde_json::Value = serde_json::from_str(&weak.out).unwrap();
    for (key, value) in [("k1", 1060.8), ("k2", 1465.2), ("c", 57.7), ("b", 107.39)] {
        assert!((number(&weak["expected"], key) / value - 1.0).abs() < 1e-12);
        let std = format!("{key}_std");
        let (weak, strong) = (number(&weak["expected"], &std), number(&strong["expected"], &std));
        assert!((weak / strong - 2.0).abs() < 1e-9 && weak > 0.0 && weak < 0.1 * value, "{key}: {weak} {strong}");
    }
    assert!(bench.json("record --linear --duration 1 -o clean.csv")["expected"].is_null(), "no noise, no errors");
}

#[test]
fn excitations_that_cannot_be_made_are_refused_and_nothing_is_written() {
    let bench = Bench::new();
    let refused = [
        ("--band 10", "a band of 1 numbers"),
        ("--signal multisine --band 10,600", "600"),
        ("--signal multisine --band 50,10", "10, needed above the lower one"),
        ("--band=-1,10", "is -1, needed 0 or more"),
        ("--peak 11", "a peak of 11 V"),
        ("--peak nan", "a peak of NaN V"),
        ("--periods 0", "is 0, needed at least 8"),
        ("--signal prbs --periods 5000", "is 2, needed at least 8"),
        ("--signal odd-multisine --band 1.01,1.05 --duration 2", "excited harmonics in the band is 0"),
    ];
    for (options, words) in refused {
        let answer = bench.run(&format!("record {options}"));
        assert_eq!(answer.status, 2, "{options}: {}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("hint: "), "{options}: {}", answer.err);
    }
    assert!(bench.names().is_empty());
}
