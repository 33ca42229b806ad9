//! Generated C against the kernel: a million ticks with saturation, switching, changed settings, faults and resets, every bit.

mod support;

use flexbeam_codegen::Precision;
use flexbeam_files::Controller;
use std::fs::OpenOptions;
use std::io::{Seek, SeekFrom, Write};
use support::{
    Kernel, Language, assert_visited, compile, named, random, reproduced, run, sources, succeeds, write_ticks, written,
};

const MOST: usize = 1_000_000;
/// Of the orders beside it: fewer, for time.
const FEWER: usize = 200_000;
const BUILDS: [&[&str]; 5] = [&["-O0"], &["-O1"], &["-O2"], &["-O3"], &["-O3", "-march=native"]];

fn every_bit(controller: &Controller, ticks: usize, name: &str) {
    let folder = written(name, &sources(controller, Precision::F64, &Language::C));
    std::fs::write(folder.join("harness.c"), named(include_str!("support/harness.c"))).unwrap();
    let file = folder.join("ticks");
    let visits = write_ticks(&file, &Kernel::of(controller, Precision::F64), Precision::F64, ticks);
    assert_visited(&visits, ticks);
    for compiler in ["gcc", "clang"] {
        for flags in BUILDS {
            let program = compile(compiler, flags, &["beam.c", "harness.c"], "harness", &folder);
            let said = succeeds(&program, &["ticks"], &folder);
            assert_eq!(said.trim(), format!("{ticks} ticks"), "{compiler} {flags:?}");
        }
    }
    one_bit_shows(&folder, ticks);
    std::fs::remove_file(file).unwrap();
}

/// The comparison itself: one bit of the last answer changed.
fn one_bit_shows(folder: &std::path::Path, ticks: usize) {
    let mut file = OpenOptions::new().write(true).read(true).open(folder.join("ticks")).unwrap();
    file.seek(SeekFrom::End(-16)).unwrap();
    let mut bytes = [0; 1];
    std::io::Read::read_exact(&mut file, &mut bytes).unwrap();
    file.seek(SeekFrom::End(-16)).unwrap();
    file.write_all(&[bytes[0] ^ 1]).unwrap();
    drop(file);
    let output = run(folder.join("harness"), &["ticks"], folder);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains(&format!("tick {} differs", ticks - 1)));
}

#[test]
fn order_0() {
    every_bit(&random(0), FEWER, "c_order_0");
}

#[test]
fn order_1() {
    every_bit(&random(1), FEWER, "c_order_1");
}

#[test]
fn order_12() {
    every_bit(&random(12), MOST, "c_order_12");
}

#[test]
fn order_24() {
    every_bit(&random(24), FEWER, "c_order_24");
}

#[test]
fn the_reproduced_controller() {
    every_bit(&reproduced(), MOST, "c_reproduced");
}
