//! Controllers, certificates, rigs and projects.

use flexbeam_files::*;
use flexbeam_lti::Mat;
use proptest::prelude::*;
use std::path::Path;

fn figures(x: f64) -> LoopFigures {
    LoopFigures {
        robust_radius: Extended(0.62),
        bound_norm: 0.9,
        stability_degree: x,
        closed_loop_poles: vec![[-x, 23.4], [-x, -23.4]],
        stiffness: Extended::INFINITE,
        gain_margin: Extended(2.5),
        phase_margin_rad: Extended(0.8),
        delay_margin_s: Extended(0.02),
        disk_margin: Extended(0.7),
    }
}

/// A controller of order 2 whose entries are `x` times small whole numbers.
fn controller(x: f64) -> Controller {
    let rows = |rows: usize, columns: usize| Rows::from(&Mat::from_fn(rows, columns, |r, c| x * (r * 10 + c) as f64));
    Controller {
        period_s: 0.001,
        order: 2,
        A: rows(2, 2),
        B: rows(2, 3),
        C: rows(2, 2),
        D: rows(2, 2),
        settings: Settings {
            law: Some(Law::Inverse),
            u_p_plus_v: Some(0.28),
            theta: Some(Channel { low_pass: Some(0.5), ..Channel::default() }),
            ..Settings::default()
        },
        design: Design {
            method: "sampled".into(),
            output: "psi".into(),
            stability_degree: 1.5,
            uncertainty_num: vec![x],
            uncertainty_den: vec![1.0],
            sampled_uncertainty_num: vec![0.06],
            sampled_uncertainty_den: vec![1.0],
            stiffness: Stiffness::Needed,
            reference_num: vec![1.0],
            reference_den: vec![0.1, 1.0],
            rise_time_s: Some(0.3),
            overshoot_percent: None,
            max_voltage_v: Some(10.0),
            max_step_rad: None,
            delay_s: 0.001,
            low_pass: 1.0,
        },
        plant: Matrices { A: rows(4, 4), B: rows(4, 1), C: rows(1, 4), D: rows(1, 1) },
        certificate: Certificate {
            controller_order: 2,
            v_res_v: Some(0.07),
            stationary_error_rad: None,
            prefilter_degree: None,
            continuous: figures(1.6),
            sampled: figures(1.55),
            provenance: None,
        },
        provenance: None,
    }
}

fn parse<T: Document>(text: &str) -> Result<T, Error> {
    T::parse(text, Path::new("file.toml"))
}

/// The fault in a controller's file with one line replaced, and its line number.
fn fault(line: &str, instead: &str) -> (Fault, Option<usize>) {
    let text = controller(1.0).to_toml(Path::new("controller.toml")).unwrap();
    let number = text.lines().position(|l| l == line).unwrap_or_else(|| panic!("no line {line:?} in\n{text}"));
    let lines: Vec<&str> = text.lines().enumerate().map(|(k, l)| if k == number { instead } else { l }).collect();
    let error = parse::<Controller>(&lines.join("\n")).expect_err("a fault");
    assert!(error.place.line.is_none_or(|l| l == number + 1), "{error}, needed line {}", number + 1);
    (*error.fault, error.place.line)
}

#[test]
fn coefficients_stand_as_the_kernel_reads_them() {
    let coefficients = controller(1.0).coefficients();
    let A = [0.0, 10.0, 1.0, 11.0];
    let B = [0.0, 10.0, 1.0, 11.0, 2.0, 12.0];
    assert_eq!(coefficients, [&A[..], &B[..], &A[..], &A[..]].concat());
    let mut gain = controller(1.0);
    gain.order = 0;
    (gain.A, gain.B, gain.C) = (Rows::default(), Rows::default(), Rows(vec![vec![]; 2]));
    gain.certificate.controller_order = 0;
    assert_eq!(gain.coefficients(), A);
    let text = gain.to_toml(Path::new("gain.toml")).unwrap();
    assert_eq!(parse::<Controller>(&text).unwrap(), gain);
}

#[test]
fn infinite_margins_are_inf_in_toml_and_null_in_json() {
    let text = controller(1.0).to_toml(Path::new("controller.toml")).unwrap();
    assert!(text.contains("\nstiffness = inf\n"));
    let json: serde_json::Value = serde_json::from_str(&json_text(&DesignResult::of(&controller(1.0)))).unwrap();
    assert_eq!(json["stiffness"], serde_json::Value::Null);
    assert_eq!(json["gain_margin"], 2.5);
    // Where infinity means nothing it is a fault.
    let not_finite = |name: &str, text: &str| Fault::NotFinite { name: name.into(), text: text.into() };
    let (found, line) = fault("bound_norm = 0.9", "bound_norm = inf");
    assert_eq!(found, not_finite("certificate.continuous.bound_norm", "inf"));
    assert!(line.is_some());
    assert_eq!(
        fault("gain_margin = 2.5", "gain_margin = nan").0,
        not_finite("certificate.continuous.gain_margin", "nan")
    );
}

#[test]
fn faults_of_a_controller_have_their_line() {
    let range = |key: &str, found: f64, needed: &'static str| Fault::Range { key: key.into(), found, needed };
    let not_negative = "zero or a positive number";
    assert_eq!(fault("u_p_plus_v = 0.28", "u_p_plus_v = -1").0, range("settings.u_p_plus_v", -1.0, not_negative));
    let share = "above 0 and at most 1";
    assert_eq!(fault("low_pass = 0.5", "low_pass = 0").0, range("settings.theta.low_pass", 0.0, share));
    let order = range("certificate.controller_order", 3.0, "the controller's order");
    assert_eq!(fault("controller_order = 2", "controller_order = 3").0, order);
    let whole = Fault::WrongType {
        key: "order".into(),
        found: "the number 2.5".into(),
        needed: "a whole number, not negative".into(),
    };
    assert_eq!(fault("order = 2", "order = 2.5").0, whole);
    let Fault::Choice { key, nearest, .. } = fault("law = \"inverse\"", "law = \"invers\"").0 else { panic!() };
    assert_eq!((key.as_str(), nearest.as_deref()), ("settings.law", Some("inverse")));
    let Fault::WrongType { key, found, needed } = fault("stiffness = \"needed\"", "stiffness = \"soft\"").0 else {
        panic!()
    };
    assert_eq!((key.as_str(), found.as_str()), ("design.stiffness", "string \"soft\""));
    assert!(needed.contains("integral"));
    let Fault::UnknownKey { key, nearest, .. } = fault("u_p_plus_v = 0.28", "u_plus_v = 0.28").0 else { panic!() };
    assert_eq!((key.as_str(), nearest.as_deref()), ("settings.u_plus_v", Some("u_p_plus_v")));
    let empty = Fault::EmptyList { key: "design.uncertainty_den".into() };
    assert_eq!(fault("uncertainty_den = [1.0]", "uncertainty_den = []").0, empty);
}

#[test]
fn a_pair_has_two_entries() {
    let text = controller(1.0).to_toml(Path::new("controller.toml")).unwrap();
    for (pair, found) in [("[-1.6, 23.4, 1.0]", "3 entries"), ("[-1.6]", "1 entries")] {
        let error = parse::<Controller>(&text.replace("[-1.6, 23.4]", pair)).unwrap_err();
        let Fault::WrongType { key, found: words, .. } = &*error.fault else { panic!("{error}") };
        assert_eq!(key, "certificate.continuous.closed_loop_poles(1)");
        assert_eq!(words, found);
    }
}

#[test]
fn stiffness_is_a_word_or_a_number() {
    for (text, stiffness) in [("integral", Stiffness::Integral), ("7.5", Stiffness::Value(7.5))] {
        assert_eq!(text.parse(), Ok(stiffness));
        assert_eq!(stiffness.to_string(), text);
        let mut controller = controller(1.0);
        controller.design.stiffness = stiffness;
        let written = controller.to_toml(Path::new("c.toml")).unwrap();
        assert_eq!(parse::<Controller>(&written).unwrap().design.stiffness, stiffness);
    }
    for text in ["", "0", "-1", "inf", "nan", "Needed"] {
        assert_eq!(text.parse::<Stiffness>(), Err(NoStiffness), "{text}");
    }
}

#[test]
fn the_design_result_has_the_keys_that_scripts_rely_on() {
    let json: serde_json::Value = serde_json::from_str(&json_text(&DesignResult::of(&controller(1.0)))).unwrap();
    for key in [
        "robust_radius",
        "bound_norm",
        "stability_degree",
        "closed_loop_poles",
        "stiffness",
        "gain_margin",
        "phase_margin_rad",
        "delay_margin_s",
        "disk_margin",
        "controller_order",
        "reference_model",
    ] {
        assert!(json.get(key).is_some(), "{key}");
    }
    assert_eq!(json["stability_degree"], 1.6);
    assert_eq!(json["closed_loop_poles"][1], serde_json::json!([-1.6, -23.4]));
    for (key, value) in [("robust_radius", 0.62), ("stability_degree", 1.55), ("bound_norm", 0.9)] {
        assert_eq!(json["sampled"][key], value);
    }
}

#[test]
fn the_identify_result_has_the_keys_that_scripts_rely_on() {
    let result = IdentifyResult {
        order: 4,
        period_s: 0.001,
        block_rows: 20,
        method: "moesp".into(),
        singular_values: vec![3.0, 2.0],
        poles: pairs(&[flexbeam_lti::C64::new(0.9, 0.1)]),
        continuous_poles: None,
        fit_percent: [("theta_rad".to_string(), Some(99.0)), ("alpha_rad".to_string(), None)].into(),
        physical: Some(Physical { k1: 1060.8, ..Physical::default() }),
        inputs: vec!["voltage_v".into()],
        outputs: vec!["theta_rad".into(), "alpha_rad".into()],
        A: Rows(vec![vec![1.0, 2.0]]),
        B: Rows::default(),
        C: Rows::default(),
        D: Rows::default(),
        initial_state: vec![0.0],
        integrators: 1,
        input_delay: vec![0],
        input_means: vec![0.0],
        output_means: vec![0.0, 0.0],
        estimation_fit_percent: [("theta_rad".to_string(), Some(99.5)), ("alpha_rad".to_string(), None)].into(),
        innovations: None,
        doubts: vec![],
        orders: None,
        uncertainty: None,
        identify_s: 0.01,
        refined: None,
    };
    let json: serde_json::Value = serde_json::from_str(&json_text(&result)).unwrap();
    assert_eq!(json["poles"], serde_json::json!([[0.9, 0.1]]));
    assert_eq!(json["continuous_poles"], serde_json::Value::Null);
    assert_eq!(json["fit_percent"], serde_json::json!({"theta_rad": 99.0, "alpha_rad": null}));
    assert_eq!(json["physical"]["k1"], 1060.8);
    assert_eq!(json["physical"]["k1_std"], serde_json::Value::Null);
    assert_eq!(json["A"], serde_json::json!([[1.0, 2.0]]));
    for key in ["order", "period_s", "block_rows", "singular_values", "B", "C", "D", "initial_state", "identify_s"] {
        assert!(json.get(key).is_some(), "{key}");
    }
}

#[test]
fn an_empty_rig_is_the_papers() {
    assert_eq!(parse::<Rig>("schema = \"flexbeam.rig/1\"").unwrap(), Rig::default());
    let text = "schema = \"flexbeam.rig/1\"\n[actuator]\nlimit_v = inf\n[gauge]\nsees = \"root_strain\"\n";
    let rig = parse::<Rig>(text).unwrap();
    assert_eq!(rig.actuator.unwrap().limit_v, Some(Extended::INFINITE));
    assert_eq!(rig.gauge.unwrap().sees, Some(Sees::RootStrain));
}

#[test]
fn a_rig_that_contradicts_itself() {
    let lumped = "[lumped]\nk1 = 1\nk2 = 2\nc = 3\nb = 4\n";
    let both = |rest: &str| parse::<Rig>(&format!("schema = \"flexbeam.rig/1\"\n{rest}"));
    assert!(both(&format!("{lumped}[physical]\nK_g = 70\n")).is_ok());
    let error = both(&format!("{lumped}[physical]\nJ_base = 1\n")).unwrap_err();
    assert!(matches!(*error.fault, Fault::OneOf { found: 2, .. }), "{error}");
    assert_eq!(error.place.line, Some(7));
    assert!(matches!(*both("[link]\nzeta = 1\neta_s = 1\n").unwrap_err().fault, Fault::OneOf { found: 2, .. }));
}

#[test]
fn a_document_replaces_its_own_kind_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.toml");
    controller(1.0).write(&path, Overwrite::Refuse).unwrap();
    assert_eq!(controller(1.0).write(&path, Overwrite::Refuse).unwrap(), Written::Unchanged);
    Controller::check_free(&path, Overwrite::SameKind).unwrap();
    assert_eq!(*Controller::check_free(&path, Overwrite::Refuse).unwrap_err().fault, Fault::Exists);
    assert_eq!(*Rig::check_free(&path, Overwrite::SameKind).unwrap_err().fault, Fault::Exists);
    assert_eq!(controller(2.0).write(&path, Overwrite::SameKind).unwrap(), Written::Replaced);
    assert_eq!(*Rig::default().write(&path, Overwrite::SameKind).unwrap_err().fault, Fault::Exists);
    assert_eq!(Controller::read(&path).unwrap(), controller(2.0));
}

#[test]
fn a_project_names_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let project = Project { model: Some("models/first.toml".into()), ..Project::default() };
    project.write(&folder.path().join(Project::FILE), Overwrite::Refuse).unwrap();
    let opened = Project::open(folder.path()).unwrap();
    assert_eq!(opened.model, Some(folder.path().join("models/first.toml")));
    assert_eq!(opened.controller, None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, rng_seed: prop::test_runner::RngSeed::Fixed(3), ..Default::default() })]

    #[test]
    fn controllers_round_trip_bit_for_bit(x in prop::num::f64::NORMAL.prop_filter("products stay finite", |x| x.abs() < 1e300)) {
        let controller = controller(x);
        let text = controller.to_toml(Path::new("controller.toml")).unwrap();
        let read: Controller = parse(&text).unwrap();
        prop_assert_eq!(&read, &controller);
        let bits = |c: &Controller| c.coefficients().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read), bits(&controller));
    }
}
