//! The proof that the generated crate cannot panic: a shared library around it links although its panic handler calls a symbol that
//! nothing defines. As for the kernel; a planted panic must not link.
#![cfg(target_os = "linux")]

mod support;

use flexbeam_codegen::Precision;
use std::path::Path;
use std::process::Output;
use support::{Language, named, random, reproduced, run, sources, succeeds, written};

const AROUND: &str = r#"
#![no_std]

use NAME::{Commanded, Measured, Real, Settings, State, selfcheck, tick};

extern "C" {
    fn generated_code_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe { generated_code_can_panic() }
}

#[no_mangle]
extern "C" fn rust_eh_personality() {}

#[no_mangle]
fn linked_tick(settings: &Settings, state: &mut State, measured: Measured) -> Commanded {
    tick(settings, state, measured)
}

#[no_mangle]
fn linked_others(state: &mut State) -> Real {
    *state = State::new();
    state.reset();
    state.x().iter().sum::<Real>() + selfcheck().map_or(0.0, |k| k as Real)
}
"#;

const PLANTED: &str =
    "\n#[no_mangle]\nfn linked_planted(numbers: &[Real], index: usize) -> Real {\n    numbers[index]\n}\n";

fn linked(folder: &Path, text: &str) -> Output {
    let flags = ["--edition", "2021", "-C", "opt-level=3", "-C", "panic=abort"];
    let library = ["--crate-type", "rlib", "--crate-name", "beam", "src/lib.rs"];
    succeeds("rustc", &[&flags[..], &library].concat(), folder);
    std::fs::write(folder.join("around.rs"), named(text)).unwrap();
    let link = ["-C", "link-arg=-Wl,-z,defs", "-C", "link-arg=-nostartfiles", "-C", "link-arg=-lc"];
    let around = ["--crate-type", "cdylib", "--extern", "beam=libbeam.rlib", "around.rs", "-o", "libaround.so"];
    run("rustc", &[&flags[..], &link, &around].concat(), folder)
}

#[test]
fn the_crate_links_without_a_panic_handler() {
    for precision in [Precision::F64, Precision::F32] {
        for (controller, order) in [(random(0), 0), (random(24), 24), (reproduced(), 11)] {
            let name = format!("no_panic_{order}_{precision:?}");
            let folder = written(&name, &sources(&controller, precision, &Language::Rust));
            let built = linked(&folder, AROUND);
            assert!(built.status.success(), "order {order}: {}", String::from_utf8_lossy(&built.stderr));
        }
    }
}

#[test]
fn a_planted_panic_does_not_link() {
    let folder = written("planted", &sources(&random(1), Precision::F64, &Language::Rust));
    let built = linked(&folder, &format!("{AROUND}{PLANTED}"));
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(!built.status.success() && said.contains("generated_code_can_panic"), "the proof cannot fail: {said}");
}
