//! Recordings: what is read, and what each fault in a file says.

use flexbeam_files::{
    Error, Fault, Layout, Overwrite, PERIOD_TOLERANCE, Recording, STEP_TOLERANCE, csv_text, sha256_hex,
};
use flexbeam_lti::{Mat, Signals};
use proptest::prelude::*;
use std::path::Path;

fn parse(text: &str, layout: &Layout) -> Result<Recording, Error> {
    Recording::parse(text.as_bytes(), Path::new("recording.csv"), layout)
}

fn named(columns: &[&str], period_s: Option<f64>) -> Layout {
    Layout { columns: Some(columns.iter().map(|c| c.to_string()).collect()), period_s, ..Layout::default() }
}

/// Four rows of `time_s,voltage_v,theta_rad` at 2 ms, its rows edited.
fn recording_with(edit: impl Fn(&mut Vec<String>)) -> String {
    let mut lines = vec!["time_s,voltage_v,theta_rad".to_string()];
    lines.extend((0..4).map(|k| format!("{},{}.5,-{k}e-3", 0.002 * f64::from(k), k)));
    edit(&mut lines);
    lines.join("\n")
}

/// The fault in `text`, its line and its column; the message must carry them.
fn fault(text: &str, layout: &Layout) -> (Fault, Option<usize>, Option<usize>) {
    let error = parse(text, layout).expect_err("a fault");
    let message = error.to_string();
    assert!(message.starts_with(&format!("cannot read {}: found ", error.place)), "{message}");
    assert!(message.contains(", needed "), "{message}");
    (*error.fault, error.place.line, error.place.column)
}

#[test]
fn a_csv_file_with_a_header() {
    let text = recording_with(|_| {});
    let recording = parse(&text, &Layout::default()).unwrap();
    assert_eq!(recording.signals.names, ["voltage_v", "theta_rad"]);
    assert_eq!(recording.signals.units, ["v", "rad"]);
    assert_eq!(recording.signals.period_s, 0.002);
    let expected = Mat::from_column_slice(2, 4, &[0.5, 0.0, 1.5, -1e-3, 2.5, -2e-3, 3.5, -3e-3]);
    assert_eq!(recording.signals.data, expected);
    assert_eq!(recording.time_s.as_deref(), Some(&[0.0, 0.002, 0.004, 0.006][..]));
    assert_eq!(recording.sha256, sha256_hex(text.as_bytes()));
}

#[test]
fn one_table_in_many_spellings() {
    let plain = parse(&recording_with(|_| {}), &Layout::default()).unwrap().signals;
    let respelt: [fn(&str) -> String; 7] = [
        |t| t.replace('\n', "\r\n"),
        |t| format!("\u{feff}{t}\n"),
        |t| format!("# measured in room 3\n\n{t}\n\n\n"),
        |t| t.replace(',', ";"),
        |t| t.replace(',', " , ").replace('\n', "  \n"),
        |t| t.replace(',', "\t"),
        |t| t.replacen("time_s,voltage_v", "\"time_s\",\"voltage_v\"", 1).replacen("0,0.5,", "\"0\",0.5,", 1),
    ];
    for (k, spelling) in respelt.iter().enumerate() {
        let text = spelling(&recording_with(|_| {}));
        assert_eq!(parse(&text, &Layout::default()).unwrap().signals, plain, "spelling {k}:\n{text}");
    }
}

#[test]
fn white_space_columns_are_named_on_the_command_line() {
    // The layout of DaISy's files: leading blanks, trailing tabs, no header.
    let text = "   0.00   9.000  129.320\t\n   2.00   9.000  129.320\t\n   4.00   9.000  129.564\t\n";
    let recording = parse(text, &named(&["time", "u", "y"], None)).unwrap();
    assert_eq!((recording.signals.period_s, recording.signals.names.join(",")), (2.0, "u,y".to_string()));
    let without_time = parse(text, &named(&["_", "u", "y"], Some(0.5))).unwrap();
    assert_eq!(without_time.signals.data, recording.signals.data);
    assert_eq!((without_time.signals.period_s, without_time.time_s), (0.5, None));
}

#[test]
fn a_column_left_out_may_hold_anything() {
    let text = "1,a,10\n2,b,20\n3,,30\n";
    let recording = parse(text, &named(&["u", "_", "y"], Some(1.0))).unwrap();
    assert_eq!(recording.signals.data, Mat::from_column_slice(2, 3, &[1.0, 10.0, 2.0, 20.0, 3.0, 30.0]));
}

#[test]
fn faults_of_a_cell_have_line_and_column() {
    let cases: [(&str, Fault, usize); 6] = [
        ("0.002,1.5,abc", Fault::NotANumber { name: "theta_rad".into(), text: "abc".into() }, 11),
        ("0.002,,3", Fault::MissingValue { name: "voltage_v".into() }, 7),
        ("0.002,NaN,3", Fault::NotFinite { name: "voltage_v".into(), text: "NaN".into() }, 7),
        ("0.002,1e999,3", Fault::NotFinite { name: "voltage_v".into(), text: "1e999".into() }, 7),
        ("0.002,1", Fault::Ragged { found: 2, needed: 3 }, 8),
        ("0.002,1,2,3", Fault::Ragged { found: 4, needed: 3 }, 11),
    ];
    for (row, expected, column) in cases {
        let text = recording_with(|lines| lines[2] = row.into());
        assert_eq!(fault(&text, &Layout::default()), (expected, Some(3), Some(column)), "{row}");
    }
}

#[test]
fn a_blank_line_between_rows_is_a_gap() {
    let text = recording_with(|lines| lines.insert(3, String::new()));
    assert_eq!(fault(&text, &Layout::default()), (Fault::Ragged { found: 0, needed: 3 }, Some(4), None));
}

#[test]
fn too_little_to_work_with() {
    let none = Layout::default();
    assert_eq!(fault("", &none).0, Fault::Empty);
    assert_eq!(fault("# only talk\n\n", &none).0, Fault::Empty);
    assert_eq!(fault("time_s,u\n", &none).0, Fault::TooFewRows { found: 0, needed: 3 });
    assert_eq!(fault("time_s,u\n0,1\n1,2\n", &none).0, Fault::TooFewRows { found: 2, needed: 3 });
    assert_eq!(fault("time_s\n0\n1\n2\n", &none).0, Fault::NoSignals);
    assert_eq!(fault("u,y\n1,2\n1,2\n1,2\n", &none).0, Fault::NoPeriod);
}

#[test]
fn faults_of_names() {
    let none = Layout::default();
    let rows = "1,2\n1,2\n1,2\n";
    assert_eq!(fault(rows, &none), (Fault::NoHeader { columns: 2 }, Some(1), None));
    assert_eq!(fault(&format!("u,u\n{rows}"), &none).0, Fault::DuplicateName { name: "u".into() });
    assert_eq!(fault(&format!("u,\n{rows}"), &none).0, Fault::EmptyName { column: 2 });
    for columns in [&["time", "u", "y"][..], &["u"][..]] {
        let expected = Fault::NamesAndColumns { names: columns.len(), columns: 2 };
        assert_eq!(fault(rows, &named(columns, None)), (expected, Some(1), None));
    }
}

#[test]
fn unknown_columns_are_listed_with_the_nearest_name() {
    let recording = parse(&recording_with(|_| {}), &Layout::default()).unwrap();
    let error = recording.select(&["voltage_v", "theta"]).unwrap_err();
    let available = vec!["voltage_v".to_string(), "theta_rad".to_string()];
    let expected = Fault::UnknownColumn { name: "theta".into(), available, nearest: Some("theta_rad".into()) };
    assert_eq!(*error.fault, expected);
    let twice = recording.select(&["voltage_v", "voltage_v"]).unwrap_err();
    assert_eq!(*twice.fault, Fault::DuplicateName { name: "voltage_v".into() });
    let theta = recording.select(&["theta_rad"]).unwrap();
    assert_eq!((theta.units, theta.data), (vec!["rad".into()], recording.signals.data.rows(1, 1).into_owned()));
}

#[test]
fn the_first_unequal_step_is_named() {
    // A comment and a doubled gap later on: the line is the file's, and it is the first bad one.
    let mut lines = vec!["# log".to_string(), "time_s,u".to_string()];
    lines.extend((0..40).filter(|k| *k != 7 && *k != 20).map(|k| format!("{},1", 0.01 * f64::from(k))));
    let (fault, line, _) = fault(&lines.join("\n"), &Layout::default());
    assert_eq!(line, Some(10), "the row of 0.08 s");
    let Fault::UnequalPeriods { found_s, needed_s, tolerance } = fault else { panic!("{fault:?}") };
    assert!((found_s - 0.02).abs() < 1e-12 && (needed_s - 0.01).abs() < 1e-12 && tolerance == STEP_TOLERANCE);
}

#[test]
fn a_clock_that_stands_still_or_runs_back_is_unequal() {
    for row in ["0.004,1,1", "-1,1,1"] {
        let text = recording_with(|lines| lines[4] = row.into());
        assert!(matches!(fault(&text, &Layout::default()), (Fault::UnequalPeriods { .. }, Some(5), None)));
    }
    let still = "time_s,u\n1,1\n1,1\n1,1\n";
    let found = fault(still, &Layout::default());
    assert!(matches!(found, (Fault::UnequalPeriods { .. }, Some(3), None)), "{found:?}");
}

#[test]
fn a_rounded_clock_is_uniform_within_the_tolerance() {
    let third = |digits: usize| {
        let rows: String = (0..301).map(|k| format!("{:.digits$},1\n", f64::from(k) / 3.0)).collect();
        parse(&format!("time_s,u\n{rows}"), &Layout::default())
    };
    assert!((third(4).unwrap().signals.period_s - 1.0 / 3.0).abs() < 1e-6);
    assert!(third(1).is_err());
}

#[test]
fn the_period_is_the_decimal_that_was_meant() {
    for period_s in [0.001, 0.002, 0.08, 1e-4, 0.1, 2.0, 1.0 / 512.0] {
        let rows: String = (0..5000).map(|k| format!("{},1\n", f64::from(k) * period_s + 0.3)).collect();
        assert_eq!(parse(&format!("time_s,u\n{rows}"), &Layout::default()).unwrap().signals.period_s, period_s);
    }
    let milliseconds: String = (0..50).map(|k| format!("{k},1\n")).collect();
    assert_eq!(parse(&format!("time_ms,u\n{milliseconds}"), &Layout::default()).unwrap().signals.period_s, 0.001);
}

#[test]
fn two_periods_must_agree() {
    let text = recording_with(|_| {});
    let given = |period_s| Layout { period_s: Some(period_s), ..Layout::default() };
    let expected = Fault::PeriodsDiffer { in_file_s: 0.002, given_s: 0.001, tolerance: PERIOD_TOLERANCE };
    assert_eq!(fault(&text, &given(0.001)).0, expected);
    assert_eq!(parse(&text, &given(0.0020001)).unwrap().signals.period_s, 0.0020001);
    for period_s in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(fault(&text, &given(period_s)).0, Fault::Period { period_s });
    }
}

#[test]
fn bytes_that_are_not_text() {
    let error = Recording::parse(b"u,y\n1,2\n\xff\xfe", Path::new("x.csv"), &Layout::default()).unwrap_err();
    assert_eq!((*error.fault, error.place.line), (Fault::NotText, Some(3)));
}

#[test]
fn degrees_and_millimetres_become_si() {
    let text = "time_s,voltage_v,theta_deg,tip_mm\n0,1,180,1000\n1,2,90,1\n2,3,0,-1\n";
    let recording = parse(text, &Layout::default()).unwrap().into_si();
    assert_eq!(recording.signals.names, ["voltage_v", "theta_rad", "tip_m"]);
    assert_eq!(recording.signals.units, ["v", "rad", "m"]);
    let first = recording.signals.data.column(0).into_owned();
    let expected = flexbeam_lti::Vector::from_column_slice(&[1.0, std::f64::consts::PI, 1.0]);
    assert!((first - expected).amax() < 1e-15);
}

#[test]
fn a_recording_is_not_written_over_and_never_holds_nan() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    let mut recording = parse(&recording_with(|_| {}), &Layout::default()).unwrap();
    recording.write(&path, Overwrite::Refuse).unwrap();
    assert_eq!(Recording::read(&path, &Layout::default()).unwrap().signals, recording.signals);
    recording.signals.data[(1, 2)] = f64::NAN;
    let error = recording.write(&path, Overwrite::Allow).unwrap_err();
    assert_eq!(*error.fault, Fault::NotFinite { name: "theta_rad".into(), text: "NaN".into() });
    assert_eq!(error.place.line, Some(4));
    recording.signals.data[(1, 2)] = 1.0;
    assert_eq!(*recording.write(&path, Overwrite::Refuse).unwrap_err().fault, Fault::Exists);
    assert!(Recording::read(&path, &Layout::default()).is_ok(), "the old file stands");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, rng_seed: prop::test_runner::RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn numbers_round_trip_bit_for_bit(
        values in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 6..60),
        period_s in 1e-6..10.0f64,
    ) {
        let samples = values.len() / 2;
        let data = Mat::from_column_slice(2, samples, &values[..2 * samples]);
        let names: Vec<String> = vec!["u_v".into(), "y; filtered, twice".into()];
        let signals = Signals::new(names, vec!["v".into(), String::new()], period_s, data).unwrap();
        let read = parse(&csv_text(&signals, None), &Layout { period_s: Some(period_s), ..Layout::default() }).unwrap();
        prop_assert_eq!(&read.signals.names, &signals.names);
        for (found, written) in read.signals.data.iter().zip(signals.data.iter()) {
            prop_assert_eq!(found.to_bits(), written.to_bits());
        }
        let again = csv_text(&read.signals, read.time_s.as_deref());
        prop_assert_eq!(csv_text(&signals, None), again);
    }
}
