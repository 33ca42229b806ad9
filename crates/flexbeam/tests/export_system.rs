//! `flexbeam export --as mat|json` of models and controllers: Octave rebuilds the loop, scipy and Octave read the same bits, and
//! what is refused.

mod support;

use std::path::Path;
use std::process::Command;

use flexbeam_files::{Controller, Document, Extended, Model, Overwrite};
use flexbeam_lti::{C64, Mat, StateSpace, Time, connections, sampling};
use support::{Bench, number, python};

/// The reproduced controller, without the seconds that it takes to reproduce it.
const CONTROLLER: &str = include_str!("../../flexbeam-codegen/tests/data/reproduce.toml");

/// A coefficient of it, and the same edited by hand.
const COEFFICIENT: [&str; 2] = ["[0.3896611373753474,", "[0.39,"];

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("beam.toml", CONTROLLER);
    bench
}

fn run(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str], folder: &Path) -> (String, String) {
    let output = Command::new(&program).args(arguments).current_dir(folder).output();
    let output = output.unwrap_or_else(|error| panic!("{:?}: {error}; cargo xtask test installs it", program.as_ref()));
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert!(output.status.success(), "{:?} {arguments:?}: {out}{err}", program.as_ref());
    (out, err)
}

/// What the script of this name leaves behind in Octave.
#[derive(Debug)]
struct Rebuilt {
    largest_distance: f64,
    poles: Vec<C64>,
    warned: bool,
}

fn rebuilt(bench: &Bench, script: &str) -> Rebuilt {
    let line = format!(
        "{script}; printf('\\nrebuilt %.17g', largest_distance); printf(' %.17g', [real(poles(:)), imag(poles(:))].');"
    );
    let (out, err) = run("octave-cli", &["--norc", "--no-history", "--eval", &line], &bench.path(""));
    let words = out.rsplit_once("\nrebuilt ").unwrap_or_else(|| panic!("{out}{err}")).1;
    let numbers: Vec<f64> = words.split_whitespace().map(|word| word.parse().expect("a number")).collect();
    let poles = numbers[1..].chunks_exact(2).map(|pair| C64::new(pair[0], pair[1])).collect();
    Rebuilt { largest_distance: numbers[0], poles, warned: err.contains("warning: the ") }
}

/// sup |prod (z - a)/prod (z - b) - 1| on the unit circle, periods of delay that only one side has left out: multiple poles may
/// part by rounding without changing it.
fn mismatch(a: &[C64], b: &[C64]) -> f64 {
    let product = |poles: &[C64], z: C64| poles.iter().fold(C64::ONE, |x, p| x * (z - p));
    let hidden = b.len() as i32 - a.len() as i32;
    let at = |k: u32| {
        let z = C64::from_polar(1.0, f64::from(k) * 0.01);
        (product(a, z) * z.powi(hidden) / product(b, z) - 1.0).norm()
    };
    (1..628).map(at).fold(0.0, f64::max)
}

fn stated(controller: &Controller) -> Vec<C64> {
    controller.certificate.sampled.closed_loop_poles.iter().map(|[re, im]| C64::new(*re, *im)).collect()
}

#[test]
fn octave_gets_the_certificate_s_poles() {
    let bench = bench();
    let answer = bench.json("export beam.toml --as mat -o beam.mat");
    assert_eq!((&answer["script"], &answer["format"]), (&"beam.m".into(), &"mat".into()));
    assert_eq!((number(&answer, "order"), number(&answer, "period_s")), (11.0, 0.001));
    assert!(answer["notice"].is_null());
    let rebuilt = rebuilt(&bench, "beam");
    assert!(rebuilt.largest_distance < 1e-9 && !rebuilt.warned, "{rebuilt:?}");
    let controller = Controller::read(&bench.path("beam.toml")).unwrap();
    assert!(mismatch(&rebuilt.poles, &stated(&controller)) < 1e-8, "{rebuilt:?}");
}

#[test]
fn octave_gets_the_poles_of_fresh_designs_and_of_their_model() {
    let bench = Bench::new();
    bench.done("record --linear -o recording.csv");
    bench.done("identify recording.csv -o model.toml");
    bench.done("export model.toml --as mat -o plant.mat");
    let model = Model::read(&bench.path("model.toml")).unwrap();
    let plant = rebuilt(&bench, "plant");
    assert!(plant.largest_distance < 1e-9 && mismatch(&plant.poles, &model.state_space().unwrap().poles()) < 1e-9);
    for options in ["", "--stiffness integral", "--period 0.005 --low-pass-hz 60"] {
        bench.done(&format!("design model.toml --stability-degree 1.5 --uncertainty beam {options} -o beam.toml"));
        bench.done("export beam.toml --as mat -o beam.mat");
        let rebuilt = rebuilt(&bench, "beam");
        assert!(rebuilt.largest_distance < 1e-9, "{options}: {rebuilt:?}");
    }
}

/// The design makes the tip follow the model exactly: what Octave calls the closed loop must do so from rest to pi/Ts.
#[test]
fn in_octave_the_tip_follows_the_model() {
    let bench = bench();
    bench.done("export beam.toml --as mat -o beam.mat");
    let line = "beam; omega = logspace(-1, log10(3141), 300); \
                tip = squeeze(freqresp(seen * closed_loop(1, 1), omega)); \
                model = squeeze(freqresp(closed_loop(2, 1), omega)); \
                names = [closed_loop.inname; closed_loop.outname]; \
                printf('\\n%s %s %s %.17g %.17g', names{:}, max(abs(tip - model)), abs(model(1)))";
    let (out, err) = run("octave-cli", &["--norc", "--no-history", "--eval", line], &bench.path(""));
    let words: Vec<&str> = out.lines().last().unwrap_or_default().split(' ').collect();
    let [names @ .., apart, at_rest] = &words[..] else { panic!("{out}{err}") };
    assert_eq!(names, ["v_rad", "u_v", "y_model_rad"]);
    let [apart, at_rest] = [apart, at_rest].map(|word| word.parse::<f64>().expect("a number"));
    assert!(apart < 1e-7 && (at_rest - 1.0).abs() < 1e-3, "{apart} rad/rad apart, {at_rest} at 0.1 rad/s");
}

/// The poles of the loop with another delay and filter, of which the design makes none.
fn poles_by_hand(controller: &Controller) -> Vec<C64> {
    /// States that the feedback reaches; the others are those of prefilter and model.
    const REACHED: usize = 6;
    let (n, time) = (controller.order, Time::Sampled { period_s: controller.period_s });
    let (A, B, C, D) = (controller.A.to_mat(n), controller.B.to_mat(3), controller.C.to_mat(n), controller.D.to_mat(2));
    assert_eq!(A.view((0, REACHED), (REACHED, n - REACHED)).norm(), 0.0);
    let part = |M: &Mat, rows: usize, columns: usize| M.view((0, 0), (rows, columns)).into_owned();
    let applied = B.view((0, 2), (REACHED, 1)).into_owned();
    let C = part(&C, 1, REACHED);
    let input = B.view((0, 1), (REACHED, 1)) + &applied * D[(0, 1)];
    let one = |x: f64| Mat::from_element(1, 1, x);
    let K = StateSpace::new(part(&A, REACHED, REACHED) + applied * &C, input, -C, one(-D[(0, 1)]), time).unwrap();
    let plant = controller.plant_state_space().unwrap();
    let held = sampling::zoh_with_delay(&plant, controller.period_s, controller.design.delay_s).unwrap();
    let a = controller.design.low_pass;
    let seen = match a {
        1.0 => held,
        _ => {
            let filter = StateSpace::new(one(1.0 - a), one(a), one(1.0 - a), one(a), time).unwrap();
            connections::series(&held, &filter).unwrap()
        }
    };
    connections::feedback(&K, &seen).unwrap().poles()
}

#[test]
fn the_script_knows_every_delay() {
    let bench = bench();
    for (delay_s, low_pass) in [(0.0, 0.6), (0.0004, 0.6), (0.001, 1.0), (0.0013, 1.0), (0.002, 0.3), (0.0027, 0.6)] {
        let mut controller = Controller::read(&bench.path("beam.toml")).unwrap();
        controller.design.delay_s = delay_s;
        controller.design.low_pass = low_pass;
        let poles = poles_by_hand(&controller);
        controller.certificate.sampled.closed_loop_poles = poles.iter().map(|z| [z.re, z.im]).collect();
        controller.write(&bench.path("other.toml"), Overwrite::Allow).unwrap();
        let answer = bench.json("export other.toml --as mat -o other.mat");
        assert!(answer["notice"].as_str().unwrap().contains("does not match"), "{answer}");
        let rebuilt = rebuilt(&bench, "other");
        assert!(rebuilt.largest_distance < 1e-9, "{delay_s} s, {low_pass}: {rebuilt:?}");
        assert!(mismatch(&rebuilt.poles, &poles) < 1e-7, "{delay_s} s, {low_pass}: {rebuilt:?}");
    }
}

#[test]
fn a_certificate_of_another_controller_is_told_by_program_and_script() {
    let bench = bench();
    bench.write("edited.toml", &CONTROLLER.replacen(COEFFICIENT[0], COEFFICIENT[1], 1));
    let answer = bench.run("export edited.toml --as mat -o edited.mat");
    assert_eq!(answer.status, 0);
    assert!(answer.err.contains("warning: the certificate does not match"), "{}", answer.err);
    let rebuilt = rebuilt(&bench, "edited");
    assert!(rebuilt.largest_distance > 1e-5 && rebuilt.warned, "{rebuilt:?}");
}

/// Without states there are no rows that say how many columns B has.
#[test]
fn systems_without_states_keep_their_shapes() {
    let bench = Bench::new();
    bench.write(
        "gain.toml",
        "schema = \"flexbeam.model/1\"\nperiod_s = 0.5\ninputs = [\"a\", \"b\"]\noutputs = [\"while\"]\n\
         A = []\nB = []\nC = [[]]\nD = [[1.0, 2.0]]\n[validation.fit_percent]\nwhile = 99.0\n",
    );
    bench.done("export gain.toml --as mat -o gain.mat");
    let rebuilt = rebuilt(&bench, "gain");
    assert_eq!((rebuilt.largest_distance, rebuilt.poles.len()), (0.0, 0));
    let (read, _) = run("octave-cli", &["--norc", &reader("octave/read_mat_tree.m"), "gain.mat"], &bench.path(""));
    for line in ["A real 0 0 ", "B real 0 2 ", "C real 1 0 ", "outputs{1} text while"] {
        assert!(read.lines().any(|found| found == line), "{line}: {read}");
    }
    assert!(read.contains("validation.fit_percent.xwhile real 1 1 "), "{read}");
}

fn reader(script: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script).display().to_string()
}

fn hex(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(|x| format!("{:016x}", x.to_bits())).collect()
}

fn matrix(path: &str, M: &Mat) -> String {
    format!("{path} real {} {} {}", M.nrows(), M.ncols(), hex(M.iter().copied()))
}

fn complex(path: &str, poles: &[C64]) -> String {
    format!("{path} complex {} 1 {} {}", poles.len(), hex(poles.iter().map(|z| z.re)), hex(poles.iter().map(|z| z.im)))
}

/// scipy and Octave: every leaf alike, and those of the file to the last bit.
#[test]
fn scipy_and_octave_read_the_bits_of_the_file() {
    let Some(python) = python() else { return };
    let bench = bench();
    let path = bench.path("beam.toml");
    let mut controller = Controller::read(&path).unwrap();
    controller.certificate.sampled.gain_margin = Extended::INFINITE;
    controller.settings.eps_u_v = Some(5e-324);
    controller.write(&path, Overwrite::Allow).unwrap();
    bench.done("export beam.toml --as mat -o beam.mat");
    let sorted = |text: &str| {
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        lines.sort();
        lines
    };
    let folder = bench.path("");
    let scipy = sorted(&run(python, &[&reader("python/read_mat_tree.py"), "beam.mat"], &folder).0);
    let octave = sorted(&run("octave-cli", &["--norc", &reader("octave/read_mat_tree.m"), "beam.mat"], &folder).0);
    assert_eq!(scipy, octave);
    let row = |values: &[f64]| Mat::from_row_slice(1, values.len(), values);
    for line in [
        matrix("A", &controller.A.to_mat(11)),
        matrix("B", &controller.B.to_mat(3)),
        matrix("C", &controller.C.to_mat(11)),
        matrix("D", &controller.D.to_mat(2).insert_column(2, 0.0)),
        matrix("period_s", &row(&[0.001])),
        matrix("plant.A", &controller.plant.A.to_mat(4)),
        matrix("settings.eps_u_v", &row(&[5e-324])),
        matrix("design.reference_den", &row(&controller.design.reference_den)),
        matrix("certificate.sampled.gain_margin", &row(&[f64::INFINITY])),
        complex("certificate.sampled.closed_loop_poles", &stated(&controller)),
        "settings.law text inverse".into(),
        "inputs{3} text u_applied_v".into(),
        "provenance.parents{1}.schema text flexbeam.model/1".into(),
        "source text beam.toml".into(),
    ] {
        assert!(scipy.contains(&line), "{line}\n{scipy:#?}");
    }
}

/// The TOML's keys and values, told by the public readers of both.
#[test]
fn json_says_what_the_file_says() {
    let bench = bench();
    bench.write("beam.toml", &CONTROLLER.replacen("gain_margin = 4.716903912287702", "gain_margin = inf", 1));
    bench.done("record --linear --duration 2 -o recording.csv");
    bench.done("identify recording.csv -o model.toml");
    for name in ["beam", "model"] {
        let answer = bench.json(&format!("export {name}.toml --as json -o {name}.json"));
        assert!(answer["script"].is_null());
        let toml: toml::Table = bench.read(&format!("{name}.toml")).parse().unwrap();
        let json: serde_json::Value = serde_json::from_str(&bench.read(&format!("{name}.json"))).unwrap();
        assert_eq!(json, serde_json::to_value(&toml).unwrap(), "infinity is null on both sides");
    }
    let json = bench.read("beam.json");
    assert!(json.contains("\"gain_margin\": null"), "{json}");
    assert!(json.contains("\n    [0.3896611373753474, -0.04051653862602714, "), "a row a line: {json}");
}

#[test]
fn bad_input_is_told_and_nothing_is_left_behind() {
    let bench = bench();
    bench.write("newer.toml", &CONTROLLER.replacen("flexbeam.controller/1", "flexbeam.controller/2", 1));
    bench.write("rig.toml", "schema = \"flexbeam.rig/1\"\n");
    bench.write("table.csv", "time_s,voltage_v\n0,1\n0.001,2\n0.002,3\n");
    bench.write("mine.m", "x = 1;\n");
    bench.write("notes.mat", "buy milk\n");
    let model = "schema = \"flexbeam.model/1\"\nperiod_s = 0.5\ninputs = [\"u\"]\noutputs = [\"y;1\", \"y 1\"]\n\
                 A = [[0.5]]\nB = [[1.0]]\nC = [[1.0], [2.0]]\nD = [[0.0], [0.0]]\n\
                 [validation.fit_percent]\n\"y;1\" = 99.0\n\"y 1\" = 98.0\n";
    bench.write("alike.toml", model);
    let before = bench.names();
    for (line, words) in [
        ("export beam.toml --as mat -o 2nd.mat", "--out x2nd.mat"),
        ("export beam.toml --as mat -o my-beam.mat", "--out my_beam.mat"),
        ("export beam.toml --as mat -o while.mat", "no word of the language"),
        ("export beam.toml --as mat -o feedback.mat", "calls itself"),
        ("export beam.toml --as mat -o beam", "ends in .mat"),
        ("export beam.toml --as mat -o mine.mat", "mine.m"),
        ("export beam.toml --as mat -o notes.mat", "notes.mat"),
        ("export beam.toml --as mat -o no/such/beam.mat", "no folder"),
        ("export beam.toml --as json -o beam.toml", "beam.toml"),
        ("export beam.toml --as json -o table.csv", "table.csv"),
        ("export beam.toml --as mat --period 0.1 -o b.mat", "found --period with --as mat"),
        ("export beam.toml --as json --columns a,b -o b.json", "found --columns with --as json"),
        ("export beam.toml --as json --name b -o b.json", "found --name with --as json"),
        ("export beam.toml --as mat --precision f32 -o b.mat", "found --precision with --as mat"),
        ("export newer.toml --as mat -o b.mat", "flexbeam.controller/2"),
        ("export rig.toml --as mat -o b.mat", "flexbeam.model/1 or flexbeam.controller/1"),
        ("export rig.toml --as json -o b.json", "flexbeam.model/1 or flexbeam.controller/1"),
        ("export table.csv --as json -o b.json", "no schema"),
        ("export alike.toml --as mat -o b.mat", "y_1"),
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, 2, "{line}: {}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("\nhint: "), "{line}: {}", answer.err);
        assert_eq!((answer.out.as_str(), bench.names()), ("", before.clone()), "{line}");
    }
    // A newer export replaces an older one, and --force anything.
    for form in ["mat", "json"] {
        bench.done(&format!("export beam.toml --as {form} -o a.{form}"));
        bench.write("beam.toml", &CONTROLLER.replacen(COEFFICIENT[0], COEFFICIENT[1], 1));
        bench.done(&format!("export beam.toml --as {form} -o a.{form}"));
    }
    bench.done("export beam.toml --as mat -o mine.mat --force");
    assert!(bench.read("mine.m").starts_with("% flexbeam script"));
}
