//! The generated crate against the kernel, and f32: C against Rust to the bit, both within what is stated against f64.

mod support;

use flexbeam_codegen::Precision;
use flexbeam_files::Controller;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use support::{
    Kernel, Language, assert_visited, compile, named, random, reproduced, sources, succeeds, write_ticks, written,
};

const TICKS: usize = 1_000_000;

/// The harness around the crate in `folder`, built without cargo.
fn harness(folder: &Path) -> PathBuf {
    std::fs::write(folder.join("harness.rs"), named(include_str!("support/harness.rs"))).unwrap();
    let flags = ["--edition", "2021", "-C", "opt-level=3", "-D", "warnings"];
    let library: Vec<&str> =
        flags.iter().copied().chain(["--crate-type", "rlib", "--crate-name", "beam", "src/lib.rs"]).collect();
    succeeds("rustc", &library, folder);
    let program = [&flags[..4], &["--extern", "beam=libbeam.rlib", "harness.rs", "-o", "harness"]].concat();
    succeeds("rustc", &program, folder);
    folder.join("harness")
}

fn every_bit(controller: &Controller, name: &str) {
    let folder = written(name, &sources(controller, Precision::F64, &Language::Rust));
    let visits = write_ticks(&folder.join("ticks"), &Kernel::of(controller, Precision::F64), Precision::F64, TICKS);
    assert_visited(&visits, TICKS);
    assert_eq!(succeeds(harness(&folder), &["check", "ticks"], &folder).trim(), format!("{TICKS} ticks"));
    std::fs::remove_file(folder.join("ticks")).unwrap();
}

#[test]
fn in_f64_every_bit_is_the_kernel_s() {
    every_bit(&random(0), "rust_0");
    every_bit(&random(1), "rust_1");
    every_bit(&random(24), "rust_24");
    every_bit(&reproduced(), "rust_reproduced");
}

#[test]
fn the_crate_s_own_tests_pass_without_a_warning() {
    static BUILD: OnceLock<PathBuf> = OnceLock::new();
    for (precision, name) in [(Precision::F64, "rust_crate_64"), (Precision::F32, "rust_crate_32")] {
        let folder = written(name, &sources(&reproduced(), precision, &Language::Rust));
        let target = BUILD.get_or_init(|| folder.join("target")).to_string_lossy().into_owned();
        let cargo = env!("CARGO");
        let said = succeeds(cargo, &["test", "--offline", "--quiet", "--target-dir", &target], &folder);
        assert!(said.contains("2 passed"), "{said}");
        succeeds(
            cargo,
            &["clippy", "--offline", "--quiet", "--target-dir", &target, "--all-targets", "--", "-D", "warnings"],
            &folder,
        );
    }
}

/// One text, two languages, two compilers: the same f32 bits.
#[test]
fn in_f32_c_and_rust_agree_to_the_bit() {
    for (controller, name) in [(random(0), "single_0"), (random(12), "single_12"), (reproduced(), "single_reproduced")]
    {
        let rust = written(&format!("{name}_rust"), &sources(&controller, Precision::F32, &Language::Rust));
        write_ticks(&rust.join("ticks"), &Kernel::of(&controller, Precision::F32), Precision::F32, TICKS / 4);
        let c = written(&format!("{name}_c"), &sources(&controller, Precision::F32, &Language::C));
        let answered = c.join("ticks").to_string_lossy().into_owned();
        succeeds(harness(&rust), &["answer", "ticks", &answered], &rust);
        std::fs::write(c.join("harness.c"), named(include_str!("support/harness.c"))).unwrap();
        for (compiler, flags) in
            [("gcc", ["-O3", "-march=native"]), ("clang", ["-O3", "-march=native"]), ("gcc", ["-O0", "-g"])]
        {
            let program = compile(compiler, &flags, &["beam.c", "harness.c"], "harness", &c);
            assert_eq!(succeeds(&program, &["ticks"], &c).trim(), format!("{} ticks", TICKS / 4), "{compiler}");
        }
        std::fs::remove_file(answered).unwrap();
        std::fs::remove_file(rust.join("ticks")).unwrap();
    }
}
