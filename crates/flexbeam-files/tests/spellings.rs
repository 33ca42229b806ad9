//! Tables as people's programs write them, and what is said of those that can be read in more than one way.

use flexbeam_files::{Error, Fault, Layout, Recording, TableFault};
use flexbeam_lti::Mat;
use std::path::Path;

fn parse(text: &str, layout: &Layout) -> Result<Recording, Error> {
    Recording::parse(text.as_bytes(), Path::new("recording.csv"), layout)
}

fn named(columns: &str) -> Layout {
    Layout { columns: Some(columns.split(',').map(String::from).collect()), period_s: Some(0.5), ..Layout::default() }
}

/// The signals of the table that all of these spell: `u` and `y` over four samples, 0.5 s apart.
fn expected() -> Mat {
    Mat::from_column_slice(2, 4, &[0.5, -1e-3, 1.5, 2.25, -2.5, 0.0, 1000.0, 3.0])
}

/// Names, data, period, and what was said.
fn read(text: &str) -> (String, Mat, f64, String) {
    let recording = parse(text, &Layout::default()).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let notice = recording.notice.unwrap_or_default();
    (recording.signals.names.join(" "), recording.signals.data, recording.signals.period_s, notice)
}

const POINTS: &str = "time_s,u,y\n0,0.5,-1e-3\n0.5,1.5,2.25\n1,-2.5,0\n1.5,1000,3\n";

#[test]
fn decimal_commas() {
    let semicolons = POINTS.replace(',', ";").replace('.', ",");
    let tabs = semicolons.replace(';', "\t");
    let blanks = semicolons.replace(';', "   ");
    let quoted = POINTS.lines().map(|line| {
        let cells = line.split(',').map(|cell| format!("\"{}\"", cell.replace('.', ",")));
        cells.collect::<Vec<_>>().join(",") + "\r\n"
    });
    let trailing = semicolons.replace('\n', ";\n");
    for text in [semicolons.clone(), tabs, blanks, quoted.collect(), trailing, semicolons + &"\r\n".repeat(5000)] {
        let (names, data, period_s, notice) = read(&text);
        assert_eq!((names.as_str(), data, period_s), ("u y", expected(), 0.5), "{text}");
        assert!(notice.contains("decimal commas"), "{notice}");
    }
}

#[test]
fn decimal_commas_may_come_late() {
    let whole: String = (0..3000).map(|k| format!("{k};1;2\n")).collect();
    let text = format!("time_s;u;y\n{whole}3000;0,5;-1\n");
    assert_eq!(read(&text).1[(0, 3000)], 0.5);
    let mixed = format!("{text}3001;0.5;1\n");
    let error = parse(&mixed, &Layout::default()).unwrap_err();
    let fault = TableFault::MixedDecimals { name: "u".into(), text: "0.5".into() };
    assert_eq!((*error.fault, error.place.line, error.place.column), (Fault::Table(fault), Some(3003), Some(6)));
}

#[test]
fn signs_between_thousands_are_no_numbers() {
    for cell in ["1.000,5", "1,000,000"] {
        let text = POINTS.replace(',', ";").replace(".", ",").replace("1000", cell);
        let error = parse(&text, &Layout::default()).unwrap_err();
        assert_eq!(
            (*error.fault, error.place.line),
            (Fault::NotANumber { name: "u".into(), text: cell.into() }, Some(5))
        );
    }
}

#[test]
fn commas_for_both_cannot_be_told_apart() {
    let error = parse(&POINTS.replace('.', ","), &Layout::default()).unwrap_err();
    assert!(matches!(*error.fault, Fault::Ragged { needed: 3, .. }), "{error}");
    let both = "u,y\n0,5,1,5\n1,5,1,5\n0,5,2,5\n";
    let error = parse(both, &Layout { period_s: Some(1.0), ..Layout::default() }).unwrap_err();
    assert_eq!(*error.fault, Fault::Ragged { found: 4, needed: 2 });
    assert!(error.hint().contains("decimal commas"));
    // One name: one column with decimal commas, or one name too few? With a header in the file it is clear.
    let column = "0,5\n1,5\n0,5\n";
    assert_eq!(*parse(column, &named("u")).unwrap_err().fault, Fault::NamesAndColumns { names: 1, columns: 2 });
    let one = parse(&format!("u\n{column}"), &Layout { period_s: Some(1.0), ..Layout::default() }).unwrap();
    assert_eq!(one.signals.data, Mat::from_row_slice(1, 3, &[0.5, 1.5, 0.5]));
}

#[test]
fn units_in_brackets_and_in_a_row_of_their_own() {
    for (head, names) in [
        ("Time (s),Voltage (V),theta [deg]", "Voltage_v theta_deg"),
        ("Time / s,Voltage / V,theta / °", "Voltage_v theta_deg"),
        ("Time,Voltage,theta\ns,V,deg", "Voltage_v theta_deg"),
        ("Time,Channel A,Channel B\n(s),(V),(mV)\n", "Channel_A_v Channel_B_mv"),
        ("t,\"Voltage, filtered (V)\",y\n\"s\",\"\",\"-\"", "Voltage,_filtered_v y"),
    ] {
        let text = POINTS.replace("time_s,u,y", head);
        let (found, data, period_s, notice) = read(&text);
        assert_eq!((found.as_str(), data, period_s), (names, expected(), 0.5), "{text}");
        assert!(notice.contains("names in line 1"), "{notice}");
    }
    let milliseconds = POINTS.replace("time_s,u,y", "time,u,y\nms,V,rad");
    assert_eq!(read(&milliseconds).2, 0.0005);
    // What is no unit is no row of units.
    let error = parse(&POINTS.replace("time_s,u,y", "time,u,y\ns,furlong,rad"), &Layout::default()).unwrap_err();
    assert_eq!(
        (*error.fault, error.place.line),
        (Fault::NotANumber { name: "time".into(), text: "s".into() }, Some(2))
    );
}

#[test]
fn a_name_is_found_whatever_its_case() {
    let recording = parse(&POINTS.replace("u,y", "Voltage (V),Y"), &Layout::default()).unwrap();
    assert_eq!(recording.select(&["voltage_v", "y"]).unwrap().names, ["Voltage_v", "Y"]);
    let twice = parse(&POINTS.replace("u,y", "Y,y"), &Layout::default()).unwrap();
    assert_eq!(twice.select(&["y"]).unwrap().names, ["y"], "the exact one");
    assert!(matches!(*twice.select(&["Z"]).unwrap_err().fault, Fault::UnknownColumn { .. }));
}

#[test]
fn comments_of_every_kind_and_names_in_one() {
    let rows = POINTS.split_once('\n').unwrap().1.replace(',', "  ");
    for comment in ["#", "%", "//"] {
        let commented = format!("{comment} room 3\n\n{comment} time_s u y\n{rows}")
            .replace("\n1 ", &format!("\n {comment} 1 5\n1 "));
        let (names, data, _, notice) = read(&commented);
        assert_eq!((names.as_str(), data), ("u y", expected()), "{commented}");
        assert!(notice.contains("names in line 3"), "{notice}");
    }
    let talk = format!("# measured in room 3\n{rows}");
    assert_eq!(*parse(&talk, &Layout::default()).unwrap_err().fault, Fault::NoHeader { columns: 3 });
    let given = Layout { columns: Some(vec!["t".into(), "u".into(), "y".into()]), ..Layout::default() };
    assert_eq!(parse(&talk, &given).unwrap().signals.data, expected());
}

#[test]
fn time_stamps_in_words() {
    for stamps in [
        [
            "2026-11-27T23:59:59.250Z",
            "2026-11-27T23:59:59.75Z",
            "2026-11-28T00:00:00.250Z",
            "2026-11-28T01:00:00.75+01:00",
        ],
        ["2026-11-27 10:00:00", "2026-11-27 10:00:00,5", "2026-11-27 10:00:01", "2026-11-27 10:00:01.5"],
        ["10:00:00.000", "10:00:00.500", "10:00:01.000", "10:00:01.500"],
    ] {
        let rows = POINTS.lines().skip(1).map(|row| row.split_once(',').unwrap().1);
        let rows: Vec<String> = stamps.iter().zip(rows).map(|(stamp, row)| format!("\"{stamp}\",{row}\n")).collect();
        let (names, data, period_s, notice) = read(&format!("timestamp,u,y\n{}", rows.concat()));
        assert_eq!((names.as_str(), data, period_s), ("u y", expected(), 0.5), "{rows:?}");
        assert!(notice.contains("time axis timestamp"), "{notice}");
    }
}

#[test]
fn a_plain_table_needs_no_words() {
    for text in [POINTS.into(), POINTS.replace(',', ";"), POINTS.replace(',', "\t"), format!("# talk\n{POINTS}")] {
        assert_eq!(read(&text).3, "", "{text}");
    }
}

#[test]
fn jitter_is_stated() {
    let rows: String =
        (0..200).map(|k| format!("{},1\n", 0.01 * (f64::from(k) + if k == 50 { 0.25 } else { 0.0 }))).collect();
    let error = parse(&format!("time_s,u\n{rows}"), &Layout::default()).unwrap_err();
    assert_eq!(error.place.line, Some(52));
    for words in ["2 of 199 steps are off", "the largest by 25.00 %", "% rms", "0.01", "within 1 %", "--resample"] {
        assert!(error.to_string().contains(words), "{words}: {error}");
    }
}

#[test]
fn a_fault_far_into_a_file_is_named_by_its_byte_too() {
    let rows: String = (0..200_000).map(|k| format!("{k},{}\n", if k == 150_000 { "NaN" } else { "1.25" })).collect();
    let text = format!("time_s,u\n{rows}");
    let byte = text.find("NaN").unwrap();
    let error = parse(&text, &Layout::default()).unwrap_err();
    assert!(error.to_string().contains(&format!("recording.csv:150002:8 (byte {byte})")), "{error}");
}
