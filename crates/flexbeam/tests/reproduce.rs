//! `flexbeam reproduce`: what the paper promises, held against the summary.

mod support;

use serde_json::Value;
use support::Bench;

fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('/').fold(value, |value, key| &value[key]);
    found.as_f64().unwrap_or_else(|| panic!("{path}: {found}"))
}

#[test]
fn the_paper_from_end_to_end() {
    let bench = Bench::new();
    let summary = bench.json("reproduce");
    assert_eq!(serde_json::from_str::<Value>(&bench.read("reproduce/summary.json")).unwrap(), summary);

    // (18) comes back: exactly without noise, within 0.2 % with one percent of it.
    assert!(number(&summary, "plant/noise_free_error") < 1e-10);
    assert_eq!(summary["identification"]["order"], 4);
    for key in ["k1", "k2", "c", "b"] {
        let (printed, noisy) =
            (number(&summary, &format!("plant/printed/{key}")), number(&summary, &format!("plant/noisy/{key}")));
        assert!((noisy / printed - 1.0).abs() < 2e-3, "{key}: {noisy}");
    }

    // The certificate of the sampled loop, and the exact beam.
    assert!(number(&summary, "design/sampled/bound_norm") <= 1.0);
    assert!(number(&summary, "design/sampled/stability_degree") > 1.5);
    assert!(number(&summary, "design/stationary_error_rad") <= 0.15f64.to_radians() * (1.0 + 1e-6));
    assert_eq!(summary["verified"], true);
    assert_eq!(summary["distributed_beam"]["stable"], true);
    assert!(number(&summary, "distributed_beam/covered") < 1.0);

    // Thirty degrees, both ways, twenty seeds.
    for direction in ["up", "down"] {
        let law = |law: &str| summary["laws"][law][direction].clone();
        assert!(number(&law("no law"), "stationary_error_rad/median").to_degrees() > 0.5);
        let inverse = law("inverse law");
        assert_eq!(inverse["runs"], 20);
        assert!(number(&inverse, "stationary_error_rad/max").to_degrees() <= 0.3, "{inverse}");
        assert!(number(&inverse, "settling_time_s/max") <= 0.8, "{inverse}");
        assert_eq!(inverse["limit_cycles"], 0);
        assert!(number(&law("switched law"), "stationary_error_rad/median").is_finite());
    }

    for figure in summary["figures"].as_array().unwrap() {
        let name = figure.as_str().unwrap();
        assert!(bench.read(&format!("reproduce/{name}.svg")).starts_with("<svg"));
        assert_eq!(&std::fs::read(bench.path(&format!("reproduce/{name}.png"))).unwrap()[1..4], b"PNG");
    }
    assert!(bench.read("reproduce/report.html").contains("Certificate of the sampled loop"));
    // The chain from the controller back to the recording is unbroken.
    let shown = bench.done("show reproduce/controller.toml");
    assert!(shown.contains("recording.csv") && shown.contains("model.toml"), "{shown}");
}

#[test]
fn files_of_others_stay_and_its_own_are_replaced() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("mine")).unwrap();
    bench.write("mine/recording.csv", "precious\n");
    let answer = bench.run("reproduce --out mine");
    assert_eq!(answer.status, 2, "{}", answer.err);
    assert!(answer.err.contains("recording.csv") && answer.err.contains("hint: "), "{}", answer.err);
    assert_eq!(bench.read("mine/recording.csv"), "precious\n");
    bench.done("reproduce --out ours");
    bench.done("reproduce --out ours --seed 2");
}

#[test]
fn one_seed_one_answer() {
    let (first, second) = (Bench::new(), Bench::new());
    let of = |bench: &Bench, seed: u64| {
        let mut summary = bench.json(&format!("reproduce --seed {seed}"));
        summary["seconds"] = Value::Null;
        summary
    };
    assert_eq!(of(&first, 3), of(&second, 3));
    assert_ne!(of(&first, 4)["plant"]["noisy"], of(&second, 3)["plant"]["noisy"]);
}
