//! `flexbeam show`: content and history.

mod support;

use support::{Bench, pairs};

/// A model of a recording of a rig, in folders of their own.
fn chain() -> Bench {
    let bench = Bench::new();
    for folder in ["data", "models"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    bench.write("rig.toml", "schema = \"flexbeam.rig/1\"\nname = \"bench rig\"\n");
    bench.done("record --linear --duration 1 --rig rig.toml -o data/linear.csv");
    bench.done("identify data/linear.csv --order 4 -o models/model.toml");
    bench
}

fn history(bench: &Bench, file: &str) -> Vec<(u64, String, String)> {
    let shown = bench.json(&format!("show {file}"));
    let steps = shown["history"].as_array().expect("a history");
    let text = |value: &serde_json::Value| value.as_str().expect("text").to_string();
    steps
        .iter()
        .map(|step| {
            let path = text(&step["path"]);
            let name = path.rsplit('/').next().expect("a name").to_string();
            (step["generation"].as_u64().expect("a number"), name, text(&step["state"]))
        })
        .collect()
}

fn steps(expected: &[(u64, &str, &str)]) -> Vec<(u64, String, String)> {
    expected.iter().map(|(generation, name, state)| (*generation, name.to_string(), state.to_string())).collect()
}

#[test]
fn history_walks_back_to_the_rig_of_the_recording() {
    let bench = chain();
    let expected = [(0, "model.toml", "start"), (1, "linear.csv", "same"), (2, "rig.toml", "same")];
    assert_eq!(history(&bench, "models/model.toml"), steps(&expected));
    let text = bench.done("show models/model.toml");
    let lines: Vec<&str> = text.lines().collect();
    let at = lines.iter().position(|line| *line == "where it came from").expect("the history");
    let indents: Vec<usize> = lines[at + 1..]
        .iter()
        .filter(|line| line.contains("flexbeam."))
        .map(|line| line.chars().take_while(|c| !c.is_alphanumeric()).count())
        .collect();
    assert!(indents[0] == 0 && indents.windows(2).all(|pair| pair[0] < pair[1]), "{text}");
    assert!(text.contains("flexbeam identify data/linear.csv --order 4"), "{text}");
}

#[test]
fn a_parent_that_changed_or_vanished_is_told() {
    let bench = chain();
    bench.write("rig.toml", "schema = \"flexbeam.rig/1\"\nname = \"another rig\"\n");
    assert_eq!(history(&bench, "models/model.toml")[2].2, "changed");
    assert!(bench.done("show models/model.toml").contains("CHANGED"));
    std::fs::remove_file(bench.path("data/linear.csv")).unwrap();
    let expected = [(0, "model.toml", "start"), (1, "linear.csv", "missing")];
    assert_eq!(history(&bench, "models/model.toml"), steps(&expected));
    assert!(bench.done("show models/model.toml").contains("MISSING"));
}

/// Certificate and settings of a controller, and the whole way back.
#[test]
fn a_controller_shows_its_certificate_and_its_settings() {
    let bench = chain();
    bench.done("design models/model.toml --stability-degree 1.5 --uncertainty 0.2 -o controller.toml");
    let names: Vec<String> = history(&bench, "controller.toml").into_iter().map(|(_, name, _)| name).collect();
    assert_eq!(names, ["controller.toml", "model.toml", "linear.csv", "rig.toml"]);
    let shown = bench.json("show controller.toml");
    let text = bench.done("show controller.toml");
    for word in ["robust radius", "stiffness K(0)", "phase margin", "law", "1.5000 1/s"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert!(shown["content"]["certificate"]["sampled"]["bound_norm"].as_f64().unwrap() <= 1.0);
}

/// The sum of (18)'s poles is the trace -c; theirs and the integrator's.
#[test]
fn a_model_shows_its_poles_and_figures() {
    let bench = chain();
    let shown = bench.json("show models/model.toml");
    assert_eq!(shown["schema"], "flexbeam.model/1");
    let trace: f64 = pairs(&shown, "poles").iter().map(|pole| pole[0]).sum();
    assert!((trace / -57.7 - 1.0).abs() < 1e-9, "{trace}");
    assert_eq!(shown["content"]["outputs"], serde_json::json!(["theta_rad", "alpha_rad"]));
    let text = bench.done("show models/model.toml");
    for word in ["integrator", "-34.872", "4.117", "k1 = K_stiff/J_base", "1060.8", "theta_rad", "100.00"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn a_recording_shows_its_columns() {
    let bench = chain();
    let shown = bench.json("show data/linear.csv");
    assert_eq!(shown["content"]["samples"], 1000);
    let csv = bench.read("data/linear.csv");
    for column in shown["content"]["columns"].as_array().unwrap() {
        let values = support::column(&csv, column["name"].as_str().unwrap());
        let fold = |f: fn(f64, f64) -> f64| values.iter().copied().reduce(f).unwrap();
        assert_eq!(column["min"].as_f64(), Some(fold(f64::min)));
        assert_eq!(column["max"].as_f64(), Some(fold(f64::max)));
    }
    bench.write("plain.dat", "1 2\n3 4\n5 7\n");
    let shown = bench.json("show plain.dat --columns u,y --period 0.5");
    assert_eq!(shown["content"]["columns"][1]["max"], 7.0);
    assert_eq!(shown["history"][0]["state"], "start");
}

#[test]
fn a_rig_shows_what_it_leaves_out() {
    let bench = chain();
    let text = bench.done("show rig.toml");
    for word in ["bench rig", "1060.8", "3 modes", "4096", "0.0165"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert_eq!(bench.json("show rig.toml")["content"]["name"], "bench rig");
}

#[test]
fn projects_and_notes_are_shown() {
    let bench = chain();
    bench.write("flexbeam.toml", "schema = \"flexbeam.project/1\"\nname = \"first try\"\nrig = \"rig.toml\"\n");
    assert!(bench.done("show flexbeam.toml").contains("first try"));
    let note = bench.done("show data/linear.csv.toml");
    assert!(note.contains("voltage_v, theta_rad, alpha_rad") && note.contains("1000 samples"), "{note}");
}
