//! `flexbeam export --as c|rust`: what is written, what is refused, and the C program on the simulated rig, without `flexbeam run`.

mod support;

use std::net::UdpSocket;
use std::path::Path;
use std::process::{Command, Stdio};

use flexbeam_files::{Controller, Document};
use flexbeam_kernel as kernel;
use flexbeam_runtime::with_table;
use support::{Bench, column};

/// The reproduced controller, without the seconds that it takes to reproduce it.
const CONTROLLER: &str = include_str!("../../flexbeam-codegen/tests/data/reproduce.toml");

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("controller.toml", CONTROLLER);
    bench
}

/// A program that must succeed.
fn succeeds(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str], folder: &Path) -> String {
    let output = Command::new(&program).args(arguments).current_dir(folder).output().expect("the program starts");
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{:?} {arguments:?}: {said}", program.as_ref());
    said
}

#[test]
fn what_is_written_builds_and_passes_its_own_test() {
    let bench = bench();
    for precision in ["f64", "f32"] {
        let answer =
            bench.json(&format!("export controller.toml --as c --precision {precision} --name beam -o {precision}"));
        assert_eq!((&answer["order"], &answer["precision"]), (&11.into(), &precision.into()));
        assert_eq!(answer["single_error"].is_null(), precision == "f64");
        let said = succeeds("make", &["CFLAGS=-O2 -Werror", "all", "test"], &bench.path(precision));
        assert!(said.contains("every bit"), "{said}");
    }
    assert_eq!(bounds(&bench, "--as c -o c"), bounds(&bench, "--as rust -o rust"));
    let header = bench.read("f32/beam.h");
    assert!(header.contains("rounded to f32") && header.contains("typedef float beam_real;"), "{header}");
}

/// What an export in f32 says that the voltage, u and the tip angle never exceed, beside what was measured over its vectors.
fn bounds(bench: &Bench, words: &str) -> [f64; 3] {
    let answer = bench.json(&format!("export controller.toml --precision f32 {words}"));
    assert!(answer["no_bound"].is_null(), "{answer}");
    let number = |table: &str, key: &str| answer[table][key].as_f64().expect("a number");
    assert_eq!(number("single_bound", "reference_rad"), std::f64::consts::FRAC_PI_4);
    assert!(number("single_error", "u_v") < number("single_bound", "u_v"), "{answer}");
    let found = ["voltage_v", "u_v", "tip_rad"].map(|key| number("single_bound", key));
    assert!(found[1] < 1e-3 && found[0] > 20.0 * found[1] && found[2] < 1e-3, "{answer}");
    found
}

#[test]
fn a_bound_that_is_missing_says_why() {
    let bench = bench();
    bench.write("switched.toml", &CONTROLLER.replacen("law = \"inverse\"", "law = \"switched\"", 1));
    let answer = bench.json("export switched.toml --as c --precision f32 -o out");
    assert!(answer["single_bound"].is_null() && !answer["single_error"].is_null(), "{answer}");
    assert!(answer["no_bound"].as_str().is_some_and(|why| why.contains("switched law jumps")), "{answer}");
    assert!(bench.read("out/controller.h").contains("No bound of the difference"));
}

#[test]
fn the_same_controller_gives_the_same_bytes() {
    let bench = bench();
    for form in ["c", "rust"] {
        bench.done(&format!("export controller.toml --as {form} -o {form}_1"));
        let answer = bench.json(&format!("export controller.toml --as {form} -o {form}_2"));
        for file in answer["files"].as_array().expect("a list") {
            let file = file.as_str().expect("a path");
            assert_eq!(bench.read(&format!("{form}_1/{file}")), bench.read(&format!("{form}_2/{file}")), "{file}");
        }
    }
}

#[test]
fn bad_input_is_told_and_nothing_is_left_behind() {
    let bench = bench();
    bench.write("edited.toml", &CONTROLLER.replacen("[0.3896611373753474,", "[0.39,", 1));
    bench.write("large.toml", &CONTROLLER.replacen("[0.3896611373753474,", "[3.9e38,", 1));
    bench.write("small.toml", &CONTROLLER.replacen("[0.3896611373753474,", "[1e-40,", 1));
    bench.write("newer.toml", &CONTROLLER.replacen("flexbeam.controller/1", "flexbeam.controller/2", 1));
    bench.write("table.csv", "time_s,voltage_v\n0,1\n0.001,2\n0.002,3\n");
    std::fs::create_dir(bench.path("full")).unwrap();
    bench.write("full/mine.txt", "mine");
    let before = bench.names();
    for (line, words) in [
        ("export controller.toml --as c --name 2beam -o out", "no identifier in C"),
        ("export controller.toml --as c --name while -o out", "keyword"),
        ("export controller.toml --as rust --name match -o out", "keyword"),
        ("export controller.toml --as c --name stdio -o out", "header"),
        ("export controller.toml --as c --name main_udp -o out", "taken by the files"),
        ("export controller.toml --as rust --name Beam -o out", "capital letters"),
        ("export controller.toml --as c -o full", "a folder that is not empty"),
        ("export controller.toml --as c -o table.csv", "a folder, or a name that is free"),
        ("export controller.toml --as c -o no/such/folder", "no folder to write it into"),
        ("export controller.toml --as c --period 0.1 -o out", "found --period with --as c"),
        ("export controller.toml --as csv -o out.csv", "flexbeam.controller/1"),
        ("export table.csv --as csv --precision f32 -o out.csv", "found --precision with --as csv"),
        ("export table.csv --as c -o out", "table.csv"),
        ("export newer.toml --as c -o out", "flexbeam.controller/2"),
        ("export edited.toml --as c -o out", "stability_degree: claimed"),
        ("export large.toml --as c --precision f32 --unverified test -o out", "A[1][1] = 3.9e38, which overflows f32"),
        ("export small.toml --as c --precision f32 --unverified test -o out", "A[1][1] = 1e-40, which f32 keeps"),
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, 2, "{line}: {}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("\nhint: "), "{line}: {}", answer.err);
        assert_eq!(answer.out, "", "{line}");
        assert_eq!(bench.names(), before, "{line}");
    }
}

#[test]
fn a_reason_stands_in_the_head_and_force_keeps_what_is_not_ours() {
    let bench = bench();
    bench.write("edited.toml", &CONTROLLER.replacen("[0.3896611373753474,", "[0.39,", 1));
    let words = ["export", "edited.toml", "--as", "c", "-o", "out", "--unverified", "a trial */ only"];
    assert_eq!(bench.run_words(&words).status, 0);
    assert!(bench.read("out/controller.h").contains("a trial * / only"));
    bench.write("out/mine.txt", "mine");
    bench.done("export controller.toml --as c -o out --force");
    assert!(!bench.read("out/controller.h").contains("NOT VERIFIED"));
    assert_eq!(bench.read("out/mine.txt"), "mine");
}

/// Poles that f32 cannot place: the sample period is so short that they lie within its steps of 1.
#[test]
fn a_certificate_that_f32_loses_is_refused_with_its_figure() {
    let bench = Bench::new();
    bench.done("record --linear --duration 2 -o recording.csv");
    bench.done("identify recording.csv -o model.toml");
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam --period 0.00001 -o fast.toml");
    let answer = bench.run("export fast.toml --as c --precision f32 -o out");
    assert_eq!(answer.status, 2, "{}", answer.err);
    assert!(
        answer.err.contains("does not survive rounding to f32") && answer.err.contains("claimed"),
        "{}",
        answer.err
    );
    bench.done("export fast.toml --as c -o out");
    // At 1 kHz even an integrator's pole, which rounding moves off 1, stays one for all purposes.
    bench.done("design model.toml --stability-degree 1.5 --uncertainty beam --stiffness integral -o integral.toml");
    let answer = bench.run("export integral.toml --as c --precision f32 -o integral");
    assert_eq!(answer.status, 0, "{}", answer.err);
}

/// A free port, which the rig takes a moment later.
fn port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a free port").port()
}

/// Every voltage that went out is the kernel's answer to what came in, and the tip arrives.
#[test]
fn the_c_program_drives_the_simulated_rig() {
    let bench = bench();
    bench.done("export controller.toml --as c -o out");
    let folder = bench.path("out");
    succeeds("make", &["main_udp"], &folder);
    let port = port().to_string();
    let mut rig = Command::new(env!("CARGO_BIN_EXE_flexbeam"))
        .args(["rig", "--listen", &format!("udp:127.0.0.1:{port}"), "--duration", "60"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the rig starts");
    // A machine under load may hold a process for a while: half a minute is borne here.
    let run = Command::new(folder.join("main_udp")).args(["127.0.0.1", &port, "0.5", "3", "30000"]).output();
    rig.kill().and_then(|()| rig.wait()).expect("the rig ends");
    let run = run.expect("the program starts");
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let csv = String::from_utf8(run.stdout).expect("text");
    let [theta, alpha, voltage] = ["theta_rad", "alpha_rad", "voltage_v"].map(|name| column(&csv, name));
    assert_eq!(theta.len(), 3000);
    let (end, tip) = (theta.len() - 1, theta[theta.len() - 1] + alpha[alpha.len() - 1]);
    assert!((tip - 0.5).abs() < 0.02, "{tip} rad after {end} ticks");
    as_the_kernel_would(&theta, &alpha, &voltage);
}

fn as_the_kernel_would(theta: &[f64], alpha: &[f64], voltage: &[f64]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("controller.toml");
    std::fs::write(&path, CONTROLLER).expect("written");
    let file = Controller::read(&path).expect("a controller");
    let settings = with_table(&kernel::Settings::default(), &file.settings);
    let coefficients = file.coefficients();
    let controller = kernel::Controller::new(file.order, &coefficients).expect("a controller");
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = kernel::State::new(&controller, &mut memory).expect("its memory");
    for (k, voltage_v) in voltage.iter().enumerate() {
        let measured = kernel::Measured { reference_rad: 0.5, theta_rad: theta[k], alpha_rad: alpha[k] };
        let commanded = kernel::tick(&settings, &controller, &mut state, measured);
        assert_eq!(commanded.voltage_v.to_bits(), voltage_v.to_bits(), "tick {k}");
    }
    assert!(voltage.iter().any(|v| v.abs() > 1.0), "the rig was driven");
}
