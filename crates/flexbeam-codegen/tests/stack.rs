//! Stack that a tick takes on x86-64: what the compiler says, what its assembly says, and that nothing is called on the way.

#[path = "support/frames.rs"]
mod frames;
mod support;

use flexbeam_codegen::Precision;
use frames::Frames;
use std::path::Path;
use support::{Language, reproduced, sources, succeeds, written};

/// Below 128 bytes a function that calls nothing may lower no stack pointer at all: that must not hide anything.
const NO_RED_ZONE: &str = "-mno-red-zone";

fn read(folder: &Path, file: &str) -> Frames {
    Frames::of_assembly(&std::fs::read_to_string(folder.join(file)).unwrap())
}

fn of_c(compiler: &str, folder: &Path) -> u64 {
    let flags = ["-std=c99", "-O2", "-ffp-contract=off", NO_RED_ZONE, "-fstack-usage"];
    succeeds(compiler, &[&flags[..], &["-S", "beam.c", "-o", "beam.s"]].concat(), folder);
    let frames = read(folder, "beam.s");
    assert_eq!(frames.below("beam_tick"), 0, "{compiler}: the tick calls nothing");
    frames.own("beam_tick")
}

fn of_rust(source: &Path, edition: &str, tick: &str, folder: &Path) -> u64 {
    let flags =
        ["--edition", edition, "--crate-type", "lib", "-C", "opt-level=3", "-C", "no-redzone=yes", "-A", "warnings"];
    succeeds("rustc", &[&flags[..], &["--emit", "asm", &source.to_string_lossy(), "-o", "tick.s"]].concat(), folder);
    let frames = read(folder, "tick.s");
    let tick = frames.named(tick);
    assert_eq!(frames.below(&tick), 0, "the tick calls nothing");
    frames.own(&tick)
}

#[cfg(target_arch = "x86_64")]
#[test]
fn the_tick_s_frame_is_small_and_the_last() {
    println!("| text | precision | stack on x86-64 [bytes] |\n|---|---|---|");
    for precision in [Precision::F64, Precision::F32] {
        let (c, rust) = (Language::C, Language::Rust);
        let folder = written(&format!("stack_c_{precision:?}"), &sources(&reproduced(), precision, &c));
        let (clang, gcc) = (of_c("clang", &folder), of_c("gcc", &folder));
        let usage = std::fs::read_to_string(folder.join("beam.su")).unwrap();
        let line = usage.lines().find(|line| line.contains(":beam_tick\t")).expect("gcc's own figure");
        assert!(line.ends_with("\tstatic"), "{line}");
        assert_eq!(line.split('\t').nth(1).unwrap(), gcc.to_string(), "-fstack-usage and the assembly");
        let folder = written(&format!("stack_rust_{precision:?}"), &sources(&reproduced(), precision, &rust));
        let rust = of_rust(&folder.join("src/lib.rs"), "2021", "3lib4tick17h", &folder);
        for (text, bytes) in [("C, gcc -O2", gcc), ("C, clang -O2", clang), ("Rust, rustc opt-level 3", rust)] {
            println!("| {text} | {precision:?} | {bytes} |");
            assert!((8..256).contains(&bytes), "{text}: {bytes}");
        }
        if precision == Precision::F64 {
            let kernel = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flexbeam-kernel/src/lib.rs");
            let bytes = of_rust(&kernel, "2024", "3lib4tick4tick17h", &folder);
            println!("| kernel, rustc opt-level 3 | F64 | {bytes} |");
            assert!((8..256).contains(&bytes), "{bytes}");
        }
    }
}
