//! `cargo xtask test`: everything that must hold before a change goes in.

use crate::metadata::Workspace;
use crate::python::{self, PYTHON};
use crate::step::{Step, Stop};
use crate::{needs, tidy};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Names the folder with the public recordings, for the tests that identify them.
const DATA: &str = "FLEXBEAM_DATA";

/// Property tests draw the same cases in every run, so that what fails is the change and not the draw. A plain
/// `cargo test` draws anew each time.
const SEED: (&str, &str) = ("PROPTEST_RNG_SEED", "20090821");

/// Runs every step in turn and stops at the first that fails.
pub fn run(workspace: &Workspace) -> Result<(), Stop> {
    let start = Instant::now();
    let root = &workspace.root;
    needs::ensure(root)?;
    let python = python::ensure(root)?;
    let data = recordings(std::env::var_os(DATA).as_deref(), root);
    before_tests().iter().try_for_each(|step| step.run(root))?;
    tidy::run(workspace)?;
    tests(data.as_deref(), &python).iter().try_for_each(|step| step.run(root))?;
    eprintln!("\nxtask test: all holds, {:.0} s", start.elapsed().as_secs_f64());
    if data.is_none() {
        eprintln!("\n*** THE TESTS ON RECORDINGS WERE LEFT OUT: set {DATA} to the folder that holds robot_arm.dat ***");
    }
    Ok(())
}

fn before_tests() -> Vec<Step> {
    vec![
        Step::cargo("format", "fmt --all --check"),
        Step::cargo("clippy", "clippy --workspace --all-targets -- -D warnings"),
        Step::cargo("clippy of the viewers", &format!("clippy {VIEWERS} --all-targets -- -D warnings")),
        Step::cargo("documentation", "doc --workspace --no-deps").env("RUSTDOCFLAGS", "-D warnings"),
    ]
}

/// The kernel and lti run once more in dev, for overflow checks; what calls unsafe code runs under a sanitizer, too.
fn tests(data: Option<&Path>, python: &Path) -> Vec<Step> {
    let dev = Step::cargo("tests with overflow checks", "test -p flexbeam-kernel -p flexbeam-lti");
    let sanitized = SANITIZED.map(|(what, arguments)| {
        Step::cargo(&format!("{what} under the address sanitizer"), &format!("test {APART} {arguments}"))
            .env("RUSTC_BOOTSTRAP", "1")
            .env("RUSTFLAGS", "-Zsanitizer=address -Cunsafe-allow-abi-mismatch=sanitizer")
    });
    let release = Step::cargo("tests", "test --release --workspace").env(PYTHON, python.to_string_lossy());
    let with_data = |step: Step| match data {
        Some(data) => step.env(DATA, data.to_string_lossy()),
        None => step,
    };
    let viewers = Step::cargo("tests of the viewers", &format!("test --release {VIEWERS} {VIEWER_TESTS}"));
    let viewers = viewers.env("CARGO_INCREMENTAL", "0");
    let dev = dev.env("CARGO_INCREMENTAL", "0");
    let release = with_data(release.env("CARGO_INCREMENTAL", "0"));
    if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        [dev].into_iter().chain(sanitized).chain([viewers, release]).map(seeded).collect()
    } else {
        [dev, viewers, release].map(seeded).into()
    }
}

fn seeded(step: Step) -> Step {
    step.env(SEED.0, SEED.1)
}

/// All of the workspace's unsafe calls: the vector code of identification, and what the runtime asks of the system and of the
/// boards' libraries.
const SANITIZED: [(&str, &str); 2] = [
    ("vector code", "-p flexbeam-ident --lib -- triangle correlation columns lanes modal cholesky"),
    ("system calls and boards", "-p flexbeam-runtime --lib --test boards --test serial"),
];

/// A target of its own keeps build scripts plain.
const APART: &str = "--target x86_64-unknown-linux-gnu --target-dir target/sanitized";

/// What a plain build leaves out: live topics and parameters over a WebSocket.
const VIEWERS: &str = "-p flexbeam-runtime -p flexbeam --features foxglove";

/// What the feature adds; all else runs without it.
const VIEWER_TESTS: &str = "--lib --test foxglove --test foxglove_stalled";

/// The folder that the variable names, or `../shared/data` beside the repository if there is one.
fn recordings(variable: Option<&OsStr>, root: &Path) -> Option<PathBuf> {
    match variable.filter(|folder| !folder.is_empty()) {
        Some(folder) => Some(folder.into()),
        None => root.join("../shared/data").canonicalize().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_come_from_the_variable_or_from_beside_the_repository() {
        let root = std::env::temp_dir().join(format!("flexbeam-xtask-{}", std::process::id()));
        let repository = root.join("main");
        std::fs::create_dir_all(&repository).unwrap();
        assert_eq!(recordings(None, &repository), None);
        std::fs::create_dir_all(root.join("shared/data")).unwrap();
        let beside = recordings(None, &repository).unwrap();
        assert!(beside.is_absolute() && beside.ends_with("shared/data"));
        assert_eq!(recordings(Some(OsStr::new("/else")), &repository), Some("/else".into()));
        assert_eq!(recordings(Some(OsStr::new("")), &repository), Some(beside), "empty is unset");
        std::fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn only_the_release_tests_get_python_and_the_recordings_and_they_come_last() {
        let typed: Vec<String> = tests(Some(Path::new("/d")), Path::new("/p")).iter().map(Step::to_string).collect();
        let (last, before) = typed.split_last().unwrap();
        let environment = "FLEXBEAM_PYTHON=/p CARGO_INCREMENTAL=0 FLEXBEAM_DATA=/d PROPTEST_RNG_SEED=20090821";
        assert_eq!(*last, format!("{environment} cargo test --release --workspace"));
        assert!(before.iter().all(|step| !step.contains(DATA) && !step.contains(PYTHON)));
    }
}
