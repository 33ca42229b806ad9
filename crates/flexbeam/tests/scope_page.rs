//! The scope page in real Chromium: its own tests, and each scenario of `python/scope_*.py` by itself.
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

/// What a script says, in a folder of its own; nothing without a Python.
fn said(script: &str, words: &[&str]) -> Option<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join(script);
    let bench = Bench::new();
    let output = Command::new(python()?)
        .args(["-B".as_ref(), script.as_os_str()])
        .args(words)
        .current_dir(bench.path(""))
        .env("FLEXBEAM_CHROMIUM", "/usr/bin/chromium")
        .output()
        .expect("it starts");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{words:?}\n{text}{}", String::from_utf8_lossy(&output.stderr));
    Some(text)
}

const SCENARIOS: &str = "tests/python/scope_page.py";

/// A test for each scenario, and their names.
macro_rules! scenarios {
    ($($name:ident)*) => {
        const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            #[test]
            fn $name() {
                let shots = shots();
                said(SCENARIOS, &[stringify!($name), env!("CARGO_BIN_EXE_flexbeam"), &shots.to_string_lossy()]);
            }
        )*
    };
}

scenarios! {
    a_lost_connection_comes_back_without_a_hole
    a_page_from_elsewhere_cannot_connect
    a_phone_scrolls_downwards_only
    a_project_that_was_spoilt_by_hand_is_not_written_over
    a_refused_setting_shows_its_limits
    a_reload_in_the_middle_brings_everything_back
    a_run_is_started_changed_and_stopped
    a_slow_viewer_disturbs_nobody
    axe_finds_nothing
    control_is_asked_for_refused_and_given
    escape_twice_is_the_emergency_stop_whatever_is_open
    silence_gives_control_away
    snapshots_are_what_was_measured
    the_emergency_stop_ends_the_run_at_status_3
    the_keyboard_alone_starts_changes_and_stops
    the_next_run_at_the_same_address_is_seen_without_a_reload
    the_page_saves_and_the_next_run_is_as_it_was
    without_the_token_nothing_changes
}

#[test]
fn no_scenario_is_left_out() {
    let Some(listed) = said(SCENARIOS, &["--list"]) else { return };
    let mut names = NAMES.to_vec();
    names.sort_unstable();
    assert_eq!(listed.lines().collect::<Vec<_>>(), names);
}

/// Store, plots, triggers, frames, sliders: the modules of the page by themselves, in the browser that they run in.
#[test]
fn the_modules_of_the_page_pass_their_own_tests() {
    let Some(text) = said("../flexbeam-runtime/page-tests/run.py", &[]) else { return };
    assert!(text.lines().filter(|line| line.starts_with("ok ")).count() > 50, "{text}");
}
