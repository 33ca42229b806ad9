//! The scope page in real Chromium: each scenario of `python/scope_*.py` by itself.
//!
//! Nothing here asserts a time: the machine may stall.

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;
use support::{Bench, python};

/// Pictures of every scenario, for people to look at.
fn shots() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("the target folder").join("scope-shots")
}

/// What the script says; nothing without a Python.
fn script(words: &[&str]) -> Option<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/scope_page.py");
    let bench = Bench::new();
    let output = Command::new(python()?)
        .args(["-B".as_ref(), script.as_os_str()])
        .args(words)
        .current_dir(bench.path(""))
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{words:?}\n{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).expect("text"))
}

/// A test for each scenario, and their names.
macro_rules! scenarios {
    ($($name:ident)*) => {
        const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            #[test]
            fn $name() {
                script(&[stringify!($name), env!("CARGO_BIN_EXE_flexbeam"), &shots().to_string_lossy()]);
            }
        )*
    };
}

scenarios! {}

#[test]
fn no_scenario_is_left_out() {
    let Some(listed) = script(&["--list"]) else { return };
    let mut names = NAMES.to_vec();
    names.sort_unstable();
    assert_eq!(listed.lines().collect::<Vec<_>>(), names);
}
