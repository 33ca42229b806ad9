//! Design and verification by the real program: answers, refusals, sabotage.

mod support;

use flexbeam_rig::Lumped;
use support::Bench;

/// A folder with the paper's plant as model.toml.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("model.toml", &support::model(&Lumped::PAPER));
    bench
}

#[test]
fn a_bound_too_large_is_answered_with_no() {
    let bench = bench();
    let answer = bench.run("design model.toml --stability-degree 12 --uncertainty 0.08 --json");
    assert_eq!(answer.status, 1);
    for word in ["0.88681", "12.8 % too large", "hint: ", "alpha is scaled by", "beta is lowered to"] {
        assert!(answer.err.contains(word), "{word:?} is not in {}", answer.err);
    }
    let value: serde_json::Value = serde_json::from_str(&answer.out).unwrap();
    assert_eq!(value["solvable"], false);
    assert!((value["robust_radius"].as_f64().unwrap() - 0.0709455 / 0.08).abs() < 1e-5);
    assert_eq!(bench.names(), ["model.toml"], "no controller is written");
    // The hint is true: at that beta the answer is yes.
    let beta: f64 = answer.err.split("lowered to ").nth(1).unwrap().trim().parse().unwrap();
    bench.done(&format!("design model.toml --stability-degree {beta} --uncertainty 0.08 --robust-only"));
}

#[test]
fn the_beam_refuses_a_beta_beyond_a_neglected_mode() {
    let bench = bench();
    for line in [
        "design model.toml --stability-degree 12 --uncertainty beam",
        "design model.toml --stability-degree 2.02 --uncertainty beam --robust-only",
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, 1, "{line}");
        for word in ["mode 3", "354.3 rad/s", "2.0178", "hint: "] {
            assert!(answer.err.contains(word), "{word:?} is not in {}", answer.err);
        }
    }
    bench.done("design model.toml --stability-degree 2.0 --uncertainty beam --robust-only");
}

#[test]
fn a_stiffness_beyond_the_level_names_the_one_that_fits() {
    let bench = bench();
    let answer = bench.run("design model.toml --stability-degree 1.5 --uncertainty 0.36 --stiffness integral");
    assert_eq!(answer.status, 1);
    let fits: f64 = answer.err.split("hint: ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    bench.done(&format!("design model.toml --stability-degree 1.5 --uncertainty 0.36 --stiffness {}", 0.999 * fits));
    let answer =
        bench.run(&format!("design model.toml --stability-degree 1.5 --uncertainty 0.36 --stiffness {}", 1.01 * fits));
    assert_eq!(answer.status, 1, "{}", answer.err);
}

#[test]
fn bad_models_are_refused_and_nothing_is_written() {
    let sound = support::model(&Lumped::PAPER);
    let cases = [
        (sound.replace("1060.8", "nan"), "--stability-degree 1.5", vec!["model.toml:5:", "A(3,2)"]),
        (
            sound.replace("D = [[0.0], [0.0]]", "D = [[0.0], [0.25]]"),
            "--stability-degree 1.5",
            vec!["D = 0.25", "needed D = 0"],
        ),
        (sound.replace("107.39", "0.0"), "--stability-degree 1.5", vec!["not controllable"]),
        (sound.clone(), "--stability-degree 0", vec!["-beta", "k/(2 beta)", "suits this plant"]),
        (sound.clone(), "--stability-degree -1", vec!["beta", "not negative"]),
        (sound.clone(), "--stability-degree 1.5 --output tip", vec!["tip", "theta_rad, alpha_rad"]),
        (sound.clone(), "--stability-degree 1.5 --stiffness soft", vec!["soft", "integral"]),
        (sound.clone(), "--stability-degree 1.5 --rise-time 5", vec!["pole", "rise time"]),
    ];
    for (text, options, words) in cases {
        let bench = Bench::new();
        bench.write("model.toml", &text);
        bench.write("controller.toml", "mine");
        let before = bench.names();
        let answer = bench.run(&format!("design model.toml --uncertainty 0.2 {options} --force"));
        assert_eq!(answer.status, 2, "{options}: {}{}", answer.out, answer.err);
        for word in words.iter().chain(&["hint: "]) {
            assert!(answer.err.contains(word), "{word:?} is not in the message of {options}:\n{}", answer.err);
        }
        assert_eq!(bench.read("controller.toml"), "mine");
        assert_eq!(bench.names(), before);
    }
}

#[test]
fn beta_on_a_real_part_of_a_pole_is_refused() {
    // s (s + 10): the pole is exactly representable.
    let bench = Bench::new();
    bench.write(
        "model.toml",
        "schema = \"flexbeam.model/1\"\ntime = \"continuous\"\ninputs = [\"voltage_v\"]\noutputs = [\"psi_rad\"]\n\
         A = [[0.0, 1.0], [0.0, -10.0]]\nB = [[0.0], [20.0]]\nC = [[1.0, 0.0]]\nD = [[0.0]]\n",
    );
    let answer = bench.run("design model.toml --stability-degree 10 --uncertainty 0.1");
    assert_eq!(answer.status, 2);
    for word in ["-10.000000", "Re s = -beta", "hint: "] {
        assert!(answer.err.contains(word), "{word:?} is not in {}", answer.err);
    }
    assert_eq!(bench.names(), ["model.toml"]);
    bench.done("design model.toml --stability-degree 3 --uncertainty 0.1");
}

#[test]
fn a_file_of_another_kind_is_not_written_over() {
    let bench = bench();
    bench.write("c.toml", "my notes\n");
    let line = "design model.toml --stability-degree 1.5 --uncertainty 0.2 -o c.toml";
    assert_eq!(bench.run(line).status, 2);
    assert_eq!(bench.read("c.toml"), "my notes\n");
    bench.done(&format!("{line} --force"));
    bench.done(line);
}

#[test]
fn sabotage_is_found() {
    let bench = bench();
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam --low-pass-hz 150");
    bench.done("verify controller.toml --runs 0");
    let sound = bench.read("controller.toml");
    let period = sound.replace("period_s = 0.001", "period_s = 0.002");
    let claim = sound.replacen("disk_margin = ", "disk_margin = 1", 1).replacen("gain_margin = ", "gain_margin = 1", 2);
    let start = sound.find("\nC = ").unwrap();
    let digit = start + sound[start..].find(|c: char| ('1'..='8').contains(&c)).unwrap();
    let coefficient = format!("{}9{}", &sound[..digit], &sound[digit + 1..]);
    for (name, text) in [("period", period), ("claim", claim), ("coefficient", coefficient)] {
        assert_ne!(text, sound);
        bench.write("forged.toml", &text);
        let answer = bench.run("verify forged.toml --runs 0");
        assert_eq!(answer.status, 1, "{name}: {}{}", answer.out, answer.err);
        assert!(answer.err.contains("claimed"), "{name}: {}", answer.err);
    }
}

#[test]
fn monte_carlo_has_one_answer_for_one_seed() {
    let bench = bench();
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam");
    bench.done("rig test --apply-to controller.toml");
    let answer =
        |seed: u64| bench.json(&format!("verify controller.toml --runs 40 --seed {seed}"))["monte_carlo"].clone();
    let first = answer(1);
    assert_eq!(first, answer(1));
    assert_ne!(first, answer(2));
    assert_eq!(first["unstable"], 0);
}

#[test]
fn the_linear_simulation_follows_the_model() {
    let bench = bench();
    bench.done("design model.toml --stability-degree 1.5 --uncertainty 0.2");
    let linear = bench.json("simulate controller.toml --linear -o linear");
    assert!(linear["stationary_error_rad"].as_f64().unwrap() < 1e-6);
    assert_eq!(linear["limit_cycle"], false);
    let rig = bench.json("simulate controller.toml -o rig --law none");
    assert!(rig["stationary_error_rad"].as_f64().unwrap() > 0.5f64.to_radians(), "friction without a law");
    assert!(bench.path("rig/response.svg").is_file() && bench.path("rig/response.csv").is_file());
}
