//! Recordings of runs at the command line: `identify`, `show` and `export`, and readers that are not ours.

mod support;

use std::path::Path;
use std::process::Command;

use flexbeam_files::{LiveSettings, RunRecording, RunSample, sha256_hex};
use serde_json::{Value, json};
use support::recorded_run::{FLUSH, linear_loop, samples, write_run};
use support::{Bench, column, number, pairs, python};

const PERIOD_S: f64 = 0.001;

/// `run.mcap` of so many ticks, made of `controller.toml`, edited.
fn recorded(ticks: usize, edit: impl FnOnce(&mut Vec<RunSample>)) -> Bench {
    let bench = Bench::new();
    bench.write("controller.toml", "schema = \"flexbeam.controller/1\"\n# stands for a controller\n");
    let mut samples = samples(&linear_loop(ticks));
    edit(&mut samples);
    write_run(&bench.path("run.mcap"), PERIOD_S, &samples, &[&bench.path("controller.toml")]);
    bench
}

/// (18) from closed-loop data, with its four numbers.
#[test]
fn a_run_is_identified() {
    let bench = recorded(4000, |_| {});
    let answer = bench.run("identify run.mcap --order 4 --json");
    assert_eq!(answer.status, 0, "{}", answer.err);
    assert!(!answer.err.contains("stretch"), "{}", answer.err);
    let result: Value = serde_json::from_str(&answer.out).unwrap();
    assert_eq!(number(&result, "period_s"), PERIOD_S);
    for (key, truth) in [("k1", 1060.8), ("k2", 1465.2), ("c", 57.7), ("b", 107.39)] {
        let found = number(&result["physical"], key);
        assert!((found / truth - 1.0).abs() < 1e-6, "{key}: {found}");
    }
    let history: Vec<Value> = bench.json("show model.toml")["history"].as_array().unwrap().clone();
    let seen: Vec<_> =
        history.iter().map(|step| (step["path"].as_str().unwrap(), step["state"].as_str().unwrap())).collect();
    assert_eq!(seen, [("model.toml", "start"), ("run.mcap", "same"), ("controller.toml", "same")]);
    assert_eq!(history[1]["command"], "flexbeam run controller.toml");
}

/// With the name of a table, and a part in which a tick is missing and one measurement is stale.
#[test]
fn a_run_with_gaps_gives_its_longest_stretch_and_says_so() {
    let bench = recorded(4000, |samples| {
        samples[700].stale = 1;
        samples.remove(500);
    });
    std::fs::rename(bench.path("run.mcap"), bench.path("run.csv")).unwrap();
    let answer = bench.run("identify run.csv --order 4 --json");
    assert_eq!(answer.status, 0, "{}", answer.err);
    for words in ["of 3999 samples", "3299 of them", "ticks missing: 1", "stale measurements: 1"] {
        assert!(answer.err.contains(words), "{words}: {}", answer.err);
    }
    let result: Value = serde_json::from_str(&answer.out).unwrap();
    let slowest = pairs(&result, "continuous_poles").iter().map(|pole| pole[0].hypot(pole[1])).fold(f64::MAX, f64::min);
    assert!(slowest < 1e-3, "the integrator: {slowest}");
}

#[test]
fn show_tells_what_a_run_holds() {
    let bench = recorded(600, |samples| {
        samples[100].stale = 1;
        samples.remove(400);
    });
    let shown = bench.json("show run.mcap");
    assert_eq!(shown["schema"], "flexbeam.run/1");
    let content = &shown["content"];
    for (key, value) in
        [("samples", 599.0), ("running", 599.0), ("missed", 1.0), ("stale", 1.0), ("period_s", PERIOD_S)]
    {
        assert_eq!(number(content, key), value, "{key}");
    }
    assert_eq!((content["port"].as_str(), &content["report"]), (Some("sim"), &json!({ "samples": 599 })));
    assert_eq!(content["settings"][1]["settings"]["voltage_limit_v"], 9.0);
    assert_eq!(content["events"][1]["kind"], "stopped");
    let record = linear_loop(600);
    let theta = content["columns"].as_array().unwrap().iter().find(|column| column["name"] == "theta_rad").unwrap();
    assert_eq!(theta["max"].as_f64(), record.theta_rad.iter().copied().reduce(f64::max));
    assert_eq!(theta["min"].as_f64(), record.theta_rad.iter().copied().reduce(f64::min));
    let text = bench.done("show run.mcap");
    for words in
        ["ticks missed: 1", "voltage_limit_v = 9", "by the test", "\"samples\":599", "flexbeam run controller.toml"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert_eq!(text.matches("law = none").count(), 1, "a revision tells what it changed: {text}");
}

#[test]
fn a_run_that_was_cut_off_is_read_and_said_to_be() {
    let bench = recorded(2000, |_| {});
    let bytes = std::fs::read(bench.path("run.mcap")).unwrap();
    std::fs::write(bench.path("lost.mcap.part"), &bytes[..bytes.len() * 6 / 10]).unwrap();
    let answer = bench.run("identify lost.mcap.part --order 4 --json");
    assert_eq!(answer.status, 0, "{}", answer.err);
    assert!(answer.err.contains("lost.mcap.part ends too early"), "{}", answer.err);
    let shown = bench.json("show lost.mcap.part");
    let cut = &shown["content"]["cut_off"];
    assert_eq!(number(cut, "whole") + number(cut, "unused"), (bytes.len() * 6 / 10) as f64);
    assert!(bench.done("show lost.mcap.part").contains("ENDS TOO EARLY"));
    let exported = bench.json("export lost.mcap.part --as csv -o lost.csv");
    assert!(exported["notice"].as_str().unwrap().contains("ends too early"));
    assert_eq!(number(&exported, "samples"), number(&shown["content"], "samples"));
}

/// All samples, gaps and all; what a table cannot say stands in the note beside it.
#[test]
fn a_run_becomes_a_table() {
    let bench = recorded(300, |samples| {
        samples.remove(200);
        samples[10].fault = 3;
    });
    let answer = bench.json("export run.mcap --as csv -o run.csv");
    let csv = bench.read("run.csv");
    assert_eq!(answer["sha256"].as_str(), Some(sha256_hex(csv.as_bytes()).as_str()));
    let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    assert_eq!(json!(header), answer["columns"]);
    assert_eq!(header[0], "time_s");
    assert_eq!(&header[1..], &RunSample::NAMES[1..]);
    let record = linear_loop(300);
    let time = column(&csv, "time_s");
    assert_eq!((time.len(), time[199], time[200]), (299, 0.199, 0.201));
    assert_eq!(column(&csv, "theta_rad")[199..201], [record.theta_rad[199], record.theta_rad[201]]);
    assert_eq!(column(&csv, "fault")[9..12], [0.0, 3.0, 0.0]);
    let history = bench.json("show run.csv.toml")["history"].clone();
    assert_eq!(history[1]["schema"], "flexbeam.run/1");
    // The gap is seen by whoever reads the table.
    let gap = bench.run("identify run.csv");
    assert!(gap.status == 2 && gap.err.contains("unequal sample periods"), "{}", gap.err);
}

/// A run that was stopped before its first tick.
#[test]
fn a_run_without_samples_is_shown_and_exported_but_not_identified() {
    let bench = recorded(1, |samples| samples.clear());
    let content = bench.json("show run.mcap")["content"].clone();
    assert_eq!((number(&content, "samples"), content["events"].as_array().unwrap().len()), (0.0, 2));
    bench.done("show run.mcap");
    assert_eq!(number(&bench.json("export run.mcap --as csv -o run.csv"), "samples"), 0.0);
    assert_eq!(bench.read("run.csv").lines().count(), 1);
    bench.done("export run.mcap --as mat -o run.mat");
    let answer = bench.run("identify run.mcap");
    assert!(answer.status == 2 && answer.err.contains("at most 0 samples in a row"), "{}", answer.err);
}

#[test]
fn an_export_takes_no_other_file_s_place() {
    let bench = recorded(50, |_| {});
    let run = std::fs::read(bench.path("run.mcap")).unwrap();
    bench.write("notes.mat", "buy milk\n");
    bench.write("table.csv", "time_s,u,y\n0,1,2\n1,2,3\n2,3,4\n");
    for line in [
        "export run.mcap --as csv -o run.mcap",
        "export run.mcap --as mat -o run.mcap",
        "export run.mcap --as mat -o notes.mat",
        "export table.csv --as csv -o table.csv",
        "export controller.toml --as csv -o out.csv",
        "export run.mcap --as csv -o no/such/folder.csv",
        "export run.mcap --as csv -o out.csv --columns a,b",
        "export run.mcap --as csv -o out.csv --period 0.002",
        "export run.mcap --as c -o out.c",
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, 2, "{line}: {}", answer.err);
        assert!(answer.err.contains("hint: ") || line.contains("--as c "), "{line}: {}", answer.err);
    }
    assert_eq!(bench.names(), ["controller.toml", "notes.mat", "run.mcap", "table.csv"]);
    assert_eq!(std::fs::read(bench.path("run.mcap")).unwrap(), run);
    // A newer export replaces an older one, and --force anything.
    bench.done("export run.mcap --as mat -o run.mat");
    bench.done("export table.csv --as mat -o run.mat");
    bench.done("export run.mcap --as mat -o notes.mat --force");
}

fn read_by(python: &Path, script: &str, arguments: &[&str], bench: &Bench) -> Vec<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(script);
    let output =
        Command::new(python).arg(script).args(arguments).current_dir(bench.path("")).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text").lines().map(String::from).collect()
}

fn hex(x: f64) -> String {
    x.to_le_bytes().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The line that the script prints for a sample.
fn line(sample: &RunSample, start_unix_ns: u64) -> String {
    let [_, reals @ .., lateness, execution, settings, phase, fault, stale] = sample.values();
    let reals = reals.map(hex).join(" ");
    let log_time = start_unix_ns + 1_000_000 * sample.tick;
    format!("sample {log_time} {} {reals} {lateness} {execution} {settings} {phase} {fault} {stale}", sample.tick)
}

/// Numbers that a careless reader would change: undefined with a payload, negative zero, subnormal, infinite.
fn awkward(samples: &mut [RunSample]) {
    samples[3].u_v = f64::from_bits(0x7ff8_0000_dead_beef);
    samples[4].theta_rad = -0.0;
    samples[5].alpha_rad = 5e-324;
    samples[6].error_rad = f64::NEG_INFINITY;
    samples[7].lateness_ns = u32::MAX;
    samples[8].stale = 1;
}

fn lines_of<'a>(lines: &'a [String], word: &str) -> Vec<&'a str> {
    lines.iter().map(String::as_str).filter(|line| line.split(' ').next() == Some(word)).collect()
}

/// PyPI's mcap and mcap-ros2-support: every number to the last bit, settings, events, report, controller and metadata.
#[test]
fn the_public_packages_read_the_same_run() {
    let Some(python) = python() else { return };
    let bench = recorded(1100, |samples| {
        awkward(samples);
        samples.remove(900);
    });
    let ours = RunRecording::read(&bench.path("run.mcap")).unwrap();
    let start = ours.header.start_unix_ns;
    let wanted: Vec<String> = (0..ours.samples.samples()).map(|k| line(&ours.samples.get(k).unwrap(), start)).collect();
    for way in [&["run.mcap"][..], &["run.mcap", "--stream"]] {
        let lines = read_by(&python, "read_run.py", way, &bench);
        assert_eq!(lines_of(&lines, "sample"), wanted);
        assert_eq!(lines.last().map(String::as_str), Some("end"));
        let on = |topic: &str| -> Vec<Value> {
            let lines = lines_of(&lines, "json").into_iter().filter(|line| line.split(' ').nth(1) == Some(topic));
            lines.map(|line| serde_json::from_str(line.splitn(4, ' ').nth(3).unwrap()).unwrap()).collect()
        };
        let settings: Vec<LiveSettings> =
            on("/settings").into_iter().map(|live| serde_json::from_value(live).unwrap()).collect();
        assert_eq!(settings, ours.settings);
        assert_eq!((on("/events").len(), on("/report")), (2, vec![json!({ "samples": 1099 })]));
    }
    let lines = read_by(&python, "read_run.py", &["run.mcap"], &bench);
    let controller = sha256_hex(bench.read("controller.toml").as_bytes());
    assert_eq!(lines_of(&lines, "attachment"), [format!("attachment controller.toml application/toml {controller}")]);
    let metadata = lines_of(&lines, "metadata");
    for text in ["port sim", "period_s 0.001", "schema flexbeam.run/1", &format!("controller_sha256 {controller}")] {
        assert!(metadata.contains(&format!("metadata flexbeam {text}").as_str()), "{text}: {metadata:?}");
    }
}

/// A power loss: the public reader and ours agree on what is left.
#[test]
fn the_public_packages_read_a_run_up_to_where_it_was_cut_off() {
    let Some(python) = python() else { return };
    let bench = recorded(1100, |samples| awkward(samples));
    let bytes = std::fs::read(bench.path("run.mcap")).unwrap();
    for tenths in [3, 6, 8] {
        std::fs::write(bench.path("lost.mcap"), &bytes[..bytes.len() * tenths / 10]).unwrap();
        let ours = RunRecording::read(&bench.path("lost.mcap")).unwrap();
        let count = ours.samples.samples();
        assert!(count > 0 && count < 1100 && (count as u64).is_multiple_of(FLUSH), "{count}");
        let start = ours.header.start_unix_ns;
        let wanted: Vec<String> = (0..count).map(|k| line(&ours.samples.get(k).unwrap(), start)).collect();
        let lines = read_by(&python, "read_run.py", &["lost.mcap", "--stream"], &bench);
        assert_eq!(lines_of(&lines, "sample"), wanted);
        assert!(lines.last().unwrap().starts_with("cut "), "{:?}", lines.last());
    }
}

/// scipy: a column for each field, to the last bit, and the texts.
#[test]
fn scipy_reads_the_same_columns() {
    let Some(python) = python() else { return };
    let bench = recorded(700, |samples| awkward(samples));
    let answer = bench.json("export run.mcap --as mat -o run.mat");
    let lines = read_by(&python, "read_mat.py", &["run.mat"], &bench);
    let ours = RunRecording::read(&bench.path("run.mcap")).unwrap();
    let rows: Vec<_> = (0..700).map(|k| ours.samples.get(k).unwrap().values()).collect();
    let mut wanted: Vec<String> = (1..RunSample::NAMES.len())
        .map(|c| {
            let column: String = rows.iter().map(|row| hex(row[c])).collect();
            format!("column {} 700 1 {column}", RunSample::NAMES[c])
        })
        .collect();
    wanted
        .insert(0, format!("column time_s 700 1 {}", (0..700).map(|k| hex(f64::from(k) / 1000.0)).collect::<String>()));
    wanted.push(format!("column period_s 1 1 {}", hex(PERIOD_S)));
    assert_eq!(lines_of(&lines, "column"), wanted);
    let texts = lines_of(&lines, "text");
    let run_sha256 = sha256_hex(&std::fs::read(bench.path("run.mcap")).unwrap());
    for text in
        ["source run.mcap", "port sim", &format!("source_sha256 {run_sha256}"), r#"report_json {"samples":700}"#]
    {
        assert!(texts.contains(&format!("text {text}").as_str()), "{text}: {texts:?}");
    }
    assert_eq!(answer["columns"].as_array().unwrap().len(), lines.len());
}

/// A table without a time column, its names as MATLAB takes them.
#[test]
fn scipy_reads_a_table_made_into_a_matlab_file() {
    let Some(python) = python() else { return };
    let bench = Bench::new();
    bench.write("table.csv", "voltage_v;y; \"2nd, filtered\"\n1;0.1;-0\n2;0.2;1e-320\n3;0.30000000000000004;3\n");
    let answer = bench.json("export table.csv --as mat -o table.mat --period 0.5");
    assert_eq!((number(&answer, "samples"), number(&answer, "period_s")), (3.0, 0.5));
    let lines = read_by(&python, "read_mat.py", &["table.mat"], &bench);
    let column = |name: &str, values: &[f64]| {
        format!("column {name} {} 1 {}", values.len(), values.iter().map(|x| hex(*x)).collect::<String>())
    };
    assert_eq!(
        lines_of(&lines, "column"),
        [
            column("time_s", &[0.0, 0.5, 1.0]),
            column("voltage_v", &[1.0, 2.0, 3.0]),
            column("y", &[0.1, 0.2, 0.1 + 0.2]),
            column("x2nd__filtered", &[-0.0, 1e-320, 3.0]),
            column("period_s", &[0.5]),
        ]
    );
}
