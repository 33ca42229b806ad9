//! Generated C against the kernel: a million ticks with saturation, switching, changed settings, faults and resets, every bit.

mod support;

use flexbeam_codegen::Precision;
use flexbeam_files::Controller;
use std::fs::OpenOptions;
use std::io::{Seek, SeekFrom, Write};
use support::{
    Kernel, Language, assert_visited, compile, named, random, reproduced, run, sources, succeeds, write_ticks, written,
};

const TICKS: usize = 1_000_000;
const BUILDS: [&[&str]; 5] = [&["-O0"], &["-O1"], &["-O2"], &["-O3"], &["-O3", "-march=native"]];

fn every_bit(controller: &Controller, name: &str) {
    let folder = written(name, &sources(controller, Precision::F64, &Language::C));
    std::fs::write(folder.join("harness.c"), named(include_str!("support/harness.c"))).unwrap();
    let file = folder.join("ticks");
    let visits = write_ticks(&file, &Kernel::of(controller, Precision::F64), Precision::F64, TICKS);
    assert_visited(&visits, TICKS);
    for compiler in ["gcc", "clang"] {
        for flags in BUILDS {
            let program = compile(compiler, flags, &["beam.c", "harness.c"], "harness", &folder);
            let said = succeeds(&program, &["ticks"], &folder);
            assert_eq!(said.trim(), format!("{TICKS} ticks"), "{compiler} {flags:?}");
        }
    }
    one_bit_shows(&folder);
    std::fs::remove_file(file).unwrap();
}

/// The comparison itself: one bit of the last answer changed.
fn one_bit_shows(folder: &std::path::Path) {
    let mut file = OpenOptions::new().write(true).read(true).open(folder.join("ticks")).unwrap();
    file.seek(SeekFrom::End(-16)).unwrap();
    let mut bytes = [0; 1];
    std::io::Read::read_exact(&mut file, &mut bytes).unwrap();
    file.seek(SeekFrom::End(-16)).unwrap();
    file.write_all(&[bytes[0] ^ 1]).unwrap();
    drop(file);
    let output = run(folder.join("harness"), &["ticks"], folder);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains(&format!("tick {} differs", TICKS - 1)));
}

#[test]
fn order_0() {
    every_bit(&random(0), "c_order_0");
}

#[test]
fn order_1() {
    every_bit(&random(1), "c_order_1");
}

#[test]
fn order_12() {
    every_bit(&random(12), "c_order_12");
}

#[test]
fn order_24() {
    every_bit(&random(24), "c_order_24");
}

#[test]
fn the_reproduced_controller() {
    every_bit(&reproduced(), "c_reproduced");
}
