//! The literature cases of `cases/`, run by every engine that can run them.

mod support;

use std::path::Path;

use flexbeam_design::{HalfPlane, Uncertainty, radius_by_hankel, robust_radius};
use flexbeam_lti::{C64, Rational, StateSpace, Zpk, sampling};
use flexbeam_rig::{Lumped, Output};
use flexbeam_verify::{Timing, continuous_radius, sampled_radius};
use support::Bench;
use toml::{Table, Value};

fn read(name: &str) -> Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases").join(name);
    std::fs::read_to_string(&path).unwrap().parse().unwrap()
}

fn number(table: &Table, key: &str) -> f64 {
    table[key].as_float().unwrap_or_else(|| panic!("{key} is a number"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect()
}

fn plant(file: &Table) -> Lumped {
    let plant = file["plant"].as_table().unwrap();
    let [k1, k2, c, b] = ["k1", "k2", "c", "b"].map(|key| number(plant, key));
    Lumped { k1, k2, c, b }
}

fn cases(file: &Table) -> impl Iterator<Item = &Table> {
    file["case"].as_array().unwrap().iter().map(|case| case.as_table().unwrap())
}

#[test]
fn robust_radius_by_three_roads() {
    let file = read("radius.toml");
    let nominal = plant(&file).state_space(&[Output::Psi]).unwrap();
    for case in cases(&file) {
        let (beta, published) = (number(case, "stability_degree"), number(case, "robust_radius"));
        let (num, den) = (numbers(&case["uncertainty_num"]), numbers(&case["uncertainty_den"]));
        let alpha = Uncertainty::rational(&Rational::new(num, den).unwrap()).unwrap();
        let period_s = case.get("period_s").and_then(Value::as_float);
        for (road, radius) in roads(&nominal, beta, &alpha, period_s) {
            let error = (radius - published).abs();
            assert!(error < number(&file, "tolerance"), "beta {beta}, {road}: {radius}, published {published}");
        }
    }
}

fn roads(nominal: &StateSpace, beta: f64, alpha: &Uncertainty, period_s: Option<f64>) -> Vec<(&'static str, f64)> {
    let zpk: &Zpk = alpha.zpk();
    let (plant, verified) = match period_s {
        None => (nominal.clone(), continuous_radius(nominal, zpk, beta)),
        Some(period_s) => {
            let timing = Timing { period_s, delay_s: period_s, low_pass: 1.0 };
            let plant = sampling::zoh_with_delay(nominal, period_s, period_s).unwrap();
            (plant, sampled_radius(nominal, timing, zpk, beta))
        }
    };
    let plant = HalfPlane::new(&plant, beta).unwrap();
    vec![
        ("Hankel singular values", radius_by_hankel(&plant, alpha).unwrap()),
        ("Nevanlinna-Pick, eigenvalue", robust_radius(&plant, alpha).unwrap().unwrap()),
        ("Pick by Cholesky bisection", verified.unwrap().unwrap()),
    ]
}

/// By the program: design writes the figures, verify finds the sampled ones again.
#[test]
fn closed_loops_have_the_published_poles_and_level() {
    let file = read("closed_loop.toml");
    let bench = Bench::new();
    bench.write("model.toml", &support::model(&plant(&file)));
    for case in cases(&file) {
        let name = case["name"].as_str().unwrap();
        let line = format!(
            "design model.toml --stability-degree {} --uncertainty {} --stiffness {} -o c.toml",
            case["stability_degree"],
            case["uncertainty"],
            case["stiffness"].as_str().unwrap()
        );
        let found = bench.json(&line);
        let near = |found: &serde_json::Value, key: &str, tolerance: f64| {
            let (found, wanted) = (found.as_f64().unwrap(), number(case, key));
            assert!((found - wanted).abs() <= tolerance, "{name}, {key}: {found}, published {wanted}");
        };
        near(&found["bound_norm"], "bound_norm", number(case, "bound_norm_tolerance"));
        if case.contains_key("sampled_bound_norm") {
            near(&found["sampled"]["bound_norm"], "sampled_bound_norm", 1e-4);
            near(&found["sampled"]["stability_degree"], "sampled_stability_degree", 1e-3);
        }
        let poles = found["closed_loop_poles"].as_array().unwrap();
        let poles = poles.iter().map(|p| C64::new(p[0].as_f64().unwrap(), p[1].as_f64().unwrap())).collect();
        expect_poles(name, poles, case);
        let verified = bench.run("verify c.toml --runs 0 --json");
        let verified: serde_json::Value = serde_json::from_str(&verified.out).unwrap();
        for (figure, answer) in verified["sampled"].as_object().unwrap() {
            assert_eq!(answer["agrees"], true, "{name}, {figure}: {answer}");
        }
    }
}

fn expect_poles(name: &str, mut found: Vec<C64>, case: &Table) {
    let wanted: Vec<Vec<f64>> = case["poles"].as_array().unwrap().iter().map(numbers).collect();
    assert_eq!(found.len(), wanted.len(), "{name}: {found:?}");
    for pole in wanted {
        let pole = C64::new(pole[0], pole[1]);
        let distance = |k: &usize| (found[*k] - pole).norm();
        let k = (0..found.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        assert!(distance(&k) <= number(case, "poles_tolerance"), "{name}, {pole}: nearest is {}", found[k]);
        found.swap_remove(k);
    }
}
