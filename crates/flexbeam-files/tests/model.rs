//! Models: what is read, what each fault in a file says, and that every number comes back to its bits.

use flexbeam_files::*;
use flexbeam_lti::{Mat, StateSpace, Time};
use proptest::prelude::*;
use std::path::Path;

const SMALLEST: &str = r#"
schema = "flexbeam.model/1"
period_s = 0.001
inputs = ["voltage_v"]
outputs = ["theta_rad", "alpha_rad"]
A = [
  [1.0, 0.5],
  [0.0, 0.9],
]
B = [[0], [1e-3]]
C = [[1, 0], [0, 1]]
D = [[0], [0]]
"#;

fn parse(text: &str) -> Result<Model, Error> {
    Model::parse(text, Path::new("model.toml"))
}

/// The fault in the smallest model with one piece of its text replaced, and where it stands.
fn fault(from: &str, to: &str) -> (Fault, Option<usize>, Option<usize>) {
    assert!(SMALLEST.contains(from));
    let error = parse(&SMALLEST.replace(from, to)).expect_err("a fault");
    let message = error.to_string();
    assert!(message.starts_with(&format!("cannot read {}: found ", error.place)), "{message}");
    assert!(!message.contains('`') && !message.contains("struct"), "serde's words: {message}");
    (*error.fault, error.place.line, error.place.column)
}

#[test]
fn a_model_written_by_hand() {
    let model = parse(SMALLEST).unwrap();
    let G = model.state_space().unwrap();
    assert_eq!((G.order(), G.inputs(), G.outputs(), G.time), (2, 1, 2, Time::Sampled { period_s: 0.001 }));
    assert_eq!((G.A[(0, 1)], G.B[(1, 0)], G.C[(1, 1)]), (0.5, 1e-3, 1.0));
    assert!(model.continuous_state_space().is_none());
    let continuous = parse(&SMALLEST.replace("period_s = 0.001", "time = \"continuous\"")).unwrap();
    assert_eq!(continuous.state_space().unwrap().time, Time::Continuous);
    assert_eq!(continuous.continuous_state_space(), Some(continuous.state_space()));
}

#[test]
fn a_model_without_states() {
    let D = Mat::from_row_slice(2, 1, &[3.0, 4.0]);
    let G = StateSpace::static_gain(D, Time::Continuous).unwrap();
    let model = Model::new(&G, vec!["u".into()], vec!["y1".into(), "y2".into()]);
    let text = model.to_toml(Path::new("gain.toml")).unwrap();
    assert_eq!(parse(&text).unwrap().state_space().unwrap(), G);
}

#[test]
fn numbers_that_are_none_are_found_where_they_stand() {
    let not_finite = |text: &str| Fault::NotFinite { name: "A(1,2)".into(), text: text.into() };
    assert_eq!(fault("[1.0, 0.5]", "[1.0, nan]"), (not_finite("nan"), Some(7), Some(9)));
    assert_eq!(fault("[1.0, 0.5]", "[1.0, -inf]"), (not_finite("-inf"), Some(7), Some(9)));
    assert_eq!(fault("[1.0, 0.5]", "[1.0, 1e999]"), (not_finite("1e999"), Some(7), Some(9)));
    let word = Fault::WrongType { key: "A(1,2)".into(), found: "string \"x\"".into(), needed: "a number".into() };
    assert_eq!(fault("[1.0, 0.5]", "[1.0, \"x\"]"), (word, Some(7), Some(9)));
}

#[test]
fn shapes_that_do_not_fit() {
    let shape = |key: &str, found: (usize, usize), needed: (usize, usize)| Fault::Shape {
        key: key.into(),
        found_rows: found.0,
        found_columns: found.1,
        needed_rows: needed.0,
        needed_columns: needed.1,
    };
    let cases = [
        ("B = [[0], [1e-3]]", "B = [[0, 1], [1e-3, 1]]", shape("B", (2, 2), (2, 1)), 10),
        ("B = [[0], [1e-3]]", "B = [[0]]", shape("B", (1, 1), (2, 1)), 10),
        ("C = [[1, 0], [0, 1]]", "C = [[1, 0]]", shape("C", (1, 2), (2, 2)), 11),
        ("D = [[0], [0]]", "D = []", shape("D", (0, 0), (2, 1)), 12),
        ("[0.0, 0.9]", "[0.0]", Fault::Length { key: "A(2)".into(), found: 1, needed: 2 }, 8),
        ("[\"voltage_v\"]", "[]", Fault::EmptyList { key: "inputs".into() }, 4),
        ("\"alpha_rad\"", "\"theta_rad\"", Fault::DuplicateName { name: "theta_rad".into() }, 5),
    ];
    for (from, to, expected, line) in cases {
        let (found, found_line, _) = fault(from, to);
        assert_eq!((found, found_line), (expected, Some(line)), "{to}");
    }
    let table = "D = [[0], [0]]\n[continuous]\nA = [[0]]\nB = [[0]]\nC = [[0], [0]]\nD = [[0]]\n";
    assert_eq!(fault("D = [[0], [0]]\n", table).0, shape("continuous.D", (1, 1), (2, 1)));
}

#[test]
fn the_time_axis_is_stated_once() {
    let one_of = |found| Fault::OneOf { found, one: "time", other: "period_s" };
    assert_eq!(fault("period_s = 0.001", "").0, one_of(0));
    assert_eq!(fault("period_s = 0.001", "period_s = 0.001\ntime = \"continuous\"").0, one_of(2));
    let (found, line, _) = fault("period_s = 0.001", "period_s = 0");
    assert_eq!(line, Some(3));
    assert_eq!(found, Fault::Range { key: "period_s".into(), found: 0.0, needed: "a positive number" });
    let (found, line, _) = fault("period_s = 0.001", "time = \"continous\"");
    let choices = vec!["continuous".to_string()];
    let nearest = Some("continuous".to_string());
    assert_eq!(found, Fault::Choice { key: "time".into(), found: "continous".into(), choices, nearest });
    assert_eq!(line, Some(3));
}

#[test]
fn unknown_and_missing_keys() {
    let (found, line, column) = fault("outputs =", "output =");
    let Fault::UnknownKey { key, known, nearest } = found else { panic!("{found:?}") };
    assert_eq!((key.as_str(), nearest.as_deref(), line, column), ("output", Some("outputs"), Some(5), Some(1)));
    assert!(known.contains(&"continuous".to_string()));
    let (found, ..) = fault("D = [[0], [0]]\n", "D = [[0], [0]]\n[physical]\nk1 = 1\nk2_sdt = 3\n");
    let Fault::UnknownKey { key, nearest, .. } = found else { panic!("{found:?}") };
    assert_eq!((key.as_str(), nearest.as_deref()), ("physical.k2_sdt", Some("k2_std")));
    assert_eq!(fault("D = [[0], [0]]", "").0, Fault::MissingKey { key: "D".into() });
    let (found, line, _) = fault("D = [[0], [0]]\n", "D = [[0], [0]]\n[physical]\nk1 = 1\n");
    assert_eq!((found, line), (Fault::MissingKey { key: "physical.k2".into() }, Some(13)));
}

#[test]
fn another_schema_is_refused() {
    let needed = "flexbeam.model/1";
    let schema = |found: &str| Fault::Schema { found: found.into(), needed };
    assert_eq!(fault("model/1", "model/2"), (schema("flexbeam.model/2"), Some(2), Some(10)));
    assert_eq!(fault("flexbeam.model/1", "flexbeam.controller/1").0, schema("flexbeam.controller/1"));
    assert_eq!(fault("schema = \"flexbeam.model/1\"", "").0, Fault::NoSchema { needed });
    // A newer schema may have other keys: its version is what is complained about.
    assert_eq!(fault("model/1\"", "model/2\"\nnew_key = 1").0, schema("flexbeam.model/2"));
}

#[test]
fn text_that_is_not_toml() {
    let (found, line, _) = fault("[0.0, 0.9]", "[0.0, 0.9");
    assert!(matches!(found, Fault::Syntax { .. }), "{found:?}");
    assert!(line.is_some());
    let (found, line, _) = fault("A = [", "A = = [");
    assert!(matches!(found, Fault::Syntax { .. }) && line == Some(6), "{found:?} {line:?}");
}

#[test]
fn a_fit_belongs_to_an_output() {
    let with_fit = |name: &str| format!("D = [[0], [0]]\n[validation]\nfit_percent = {{ {name} = 99.5 }}\n");
    let model = parse(&SMALLEST.replace("D = [[0], [0]]\n", &with_fit("theta_rad"))).unwrap();
    assert_eq!(model.validation.unwrap().fit_percent["theta_rad"], 99.5);
    let (found, line, _) = fault("D = [[0], [0]]\n", &with_fit("theta"));
    assert_eq!(line, Some(14));
    let Fault::UnknownKey { key, nearest, .. } = found else { panic!("{found:?}") };
    assert_eq!((key.as_str(), nearest.as_deref()), ("validation.fit_percent.theta", Some("theta_rad")));
}

#[test]
fn what_cannot_be_read_back_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let mut model = parse(SMALLEST).unwrap();
    model.A.0[1][0] = f64::NAN;
    let error = model.write(&path, Overwrite::Allow).unwrap_err();
    assert_eq!(error.tried, Tried::Write);
    assert_eq!(*error.fault, Fault::NotFinite { name: "A(2,1)".into(), text: "nan".into() });
    model.A.0[1].clear();
    assert!(matches!(*model.write(&path, Overwrite::Allow).unwrap_err().fault, Fault::Length { .. }));
    assert!(!path.exists());
}

fn full(entries: &[f64]) -> Model {
    let [a, b, c, d, rest @ ..] = entries else { panic!("five entries at least") };
    let G = StateSpace::new(
        Mat::from_row_slice(2, 2, &[*a, *b, *c, *d]),
        Mat::from_column_slice(2, 1, &rest[..2]),
        Mat::from_row_slice(1, 2, &rest[..2]),
        Mat::from_element(1, 1, *a),
        Time::Sampled { period_s: 0.001 },
    );
    let G = G.unwrap();
    let mut model = Model::new(&G, vec!["voltage_v".into()], vec!["psi, \"filtered\"".into()]);
    model.continuous = Some((&G).into());
    model.physical = Some(Physical { k1: *a, k1_std: Some(*b), k2: *c, c_std: None, ..Physical::default() });
    model.uncertainty = Some(Uncertainty { num: vec![*a, *b], den: rest.to_vec(), beta: a.abs(), origin: None });
    let fit_percent = [(model.outputs[0].clone(), *d)].into();
    model.validation = Some(Validation { fit_percent, samples: Some(5000) });
    model.identification = Some(Identification {
        method: "moesp".into(),
        block_rows: 20,
        order: 2,
        singular_values: entries.to_vec(),
        initial_state: Some(rest.to_vec()),
        estimate: Some(0.5),
        samples: None,
        remove_mean: Some(true),
        integrators: Some(1),
        input_delay: Some(vec![0, 3]),
        output_means: Some(vec![*a]),
        refinement: Some(Refinement {
            errors: "predicted".into(),
            iterations: 9,
            parameters: 14,
            missed_before: Some(0.3),
            missed_after: 0.1,
            reason: "settled".into(),
            K: Some(Rows::from(&Mat::from_row_slice(2, 1, &[0.1, -1e-9]))),
        }),
    });
    let K = Rows(vec![vec![*a], vec![*b]]);
    model.innovations = Some(Innovations { K, covariance: Rows(vec![vec![*d]]) });
    model.provenance = Some(Provenance {
        tool: "flexbeam 0.1.0".into(),
        command: Some("flexbeam identify 'a \"b\".csv' \\ \u{7f}\n".into()),
        time: None,
        parents: vec![Parent { path: "../r.csv".into(), sha256: sha256_hex(b"r"), schema: None }; 2],
    });
    model
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, rng_seed: prop::test_runner::RngSeed::Fixed(2), ..Default::default() })]

    #[test]
    fn models_round_trip_bit_for_bit(
        entries in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 6..9),
    ) {
        let model = full(&entries);
        let text = model.to_toml(Path::new("model.toml")).unwrap();
        let read = parse(&text).unwrap();
        prop_assert_eq!(&read, &model);
        for (found, written) in read.uncertainty.iter().flat_map(|u| &u.den).zip(&entries[4..]) {
            prop_assert_eq!(found.to_bits(), written.to_bits());
        }
        prop_assert_eq!(read.to_toml(Path::new("model.toml")).unwrap(), text);
    }
}
