//! `flexbeam export --as fmu`: FMPy validates the unit and finds the kernel's bits in it, importers of two more makes find them, too;
//! what is refused.

mod support;

use std::process::Command;

use support::{Answer, Bench, python};

const CONTROLLER: &str = include_str!("../../flexbeam-codegen/tests/data/reproduce.toml");

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("controller.toml", CONTROLLER);
    bench
}

/// With our binary, and with the one that FMPy makes of the sources: validation, all vectors with their settings and resets, two instances, memory copied and as bytes, what is refused: see the
/// script, which ends with an error at the first wrong bit.
#[test]
fn another_importer_finds_the_kernels_bits() {
    let Some(python) = python() else { return };
    let bench = bench();
    bench.done("export controller.toml --as c --name beam -o c");
    for (version, binary) in [("2", ""), ("3", ""), ("2", "--sources-only"), ("3", "--sources-only")] {
        let unit = format!("beam_{version}{binary}.fmu");
        let line = format!("export controller.toml --as fmu --fmi {version} --name beam -o {unit} {binary}");
        let period_s = bench.json(&line)["period_s"].as_f64().expect("a number").to_string();
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/run_fmu.py");
        let mut run = Command::new(&python);
        run.args(["-B", script]).args([bench.path(&unit), bench.path("c/test_vectors.c")]).arg(&period_s);
        // FMPy's own CMake file asks for a C++ compiler, too; gcc's needs a package more.
        run.args((!binary.is_empty()).then_some("--build")).env("CXX", "clang++");
        let output = run.output().expect("Python starts");
        let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success() && said.contains(&format!("399 ticks, 9 changes, FMI {version}.0")), "{said}");
    }
}

/// Ecos reads units with fmi4c, libcosim with Modelon's FMI Library: neither shares a line with FMPy. libcosim 0.0.6 dies of any
/// archive that says FMI 3.0.
#[test]
fn importers_of_two_more_makes_find_the_kernels_bits() {
    let Some(python) = python() else { return };
    let bench = bench();
    bench.done("export controller.toml --as c --name beam -o c");
    for (version, importer) in [("2", "ecos"), ("3", "ecos"), ("2", "libcosim")] {
        let unit = format!("{importer}_{version}.fmu");
        bench.done(&format!("export controller.toml --as fmu --fmi {version} --name beam -o {unit}"));
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/run_fmu_elsewhere.py");
        let mut run = Command::new(&python);
        run.args(["-B", script]).args([bench.path(&unit), bench.path("c/test_vectors.c")]).args(["0.001", importer]);
        let output = run.output().expect("Python starts");
        let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success() && said.contains(&format!("{importer}: 199 ticks of 13 runs")), "{said}");
    }
}

#[test]
fn the_same_controller_gives_the_same_archive() {
    let bench = bench();
    for version in ["2", "3"] {
        let export = |out: &str| bench.json(&format!("export controller.toml --as fmu --fmi {version} -o {out}"));
        let (one, two) = (export(&format!("one_{version}.fmu")), export(&format!("two_{version}.fmu")));
        assert_eq!(one["sha256"], two["sha256"]);
        assert_eq!(export(&format!("one_{version}.fmu"))["sha256"], one["sha256"], "nothing is written over");
        assert_eq!((&one["format"], &one["fmi"]), (&"fmu".into(), &format!("{version}.0").into()));
        let files: Vec<&str> = one["files"].as_array().expect("a list").iter().filter_map(|f| f.as_str()).collect();
        let platform = if version == "2" { "linux64" } else { "x86_64-linux" };
        assert!(files.contains(&format!("binaries/{platform}/controller.so").as_str()), "{files:?}");
        let line = format!("export controller.toml --as fmu --fmi {version} --sources-only -o sources_{version}.fmu");
        let listed = bench.json(&line)["files"].to_string();
        assert!(listed.contains("sources/controller.c") && !listed.contains("binaries"), "{listed}");
    }
}

fn with_compiler(bench: &Bench, compiler: &str, line: &str) -> Answer {
    let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
    program.args(line.split_whitespace()).current_dir(bench.path("")).env("CC", compiler);
    let output = program.output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Answer { status: output.status.code().expect("an end"), out: text(output.stdout), err: text(output.stderr) }
}

#[test]
fn bad_input_is_told_and_nothing_is_left_behind() {
    let bench = bench();
    bench.write("edited.toml", &CONTROLLER.replacen("[0.3896611373753474,", "[0.39,", 1));
    bench.write("standing.fmu", "mine");
    let before = bench.names();
    for (compiler, line, words) in [
        ("cc", "export controller.toml --as fmu --name fmi2 -o out.fmu", "taken by the files"),
        ("cc", "export controller.toml --as fmu --precision f32 -o out.fmu", "found --precision with --as fmu"),
        ("cc", "export controller.toml --as fmu --period 1 -o out.fmu", "found --period with --as fmu"),
        ("cc", "export controller.toml --as c --fmi 3 -o out", "found --fmi with --as c, needed it with --as fmu"),
        ("cc", "export controller.toml --as rust --sources-only -o out", "found --sources-only with --as rust"),
        ("cc", "export controller.toml --as fmu -o standing.fmu", "a file of that name"),
        ("cc", "export controller.toml --as fmu -o no/such/out.fmu", "no folder to write it into"),
        ("cc", "export edited.toml --as fmu -o out.fmu", "stability_degree: claimed"),
        ("no-such-compiler", "export controller.toml --as fmu -o out.fmu", "found no C compiler: `no-such-compiler`"),
        ("cc --no-such-flag", "export controller.toml --as fmu -o out.fmu", "does not compile the sources"),
    ] {
        let answer = with_compiler(&bench, compiler, line);
        assert_eq!(answer.status, 2, "{line}: {}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("\nhint: "), "{line}: {}", answer.err);
        assert_eq!(answer.out, "", "{line}");
        assert_eq!(bench.names(), before, "{line}");
    }
    // Without a compiler the sources are there all the same.
    let line = "export controller.toml --as fmu --sources-only -o standing.fmu --force";
    assert_eq!(with_compiler(&bench, "no-such-compiler", line).status, 0);
}
