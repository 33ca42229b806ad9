//! `cargo xtask bench`: every criterion bench of the workspace, then the scope page in Chromium.

use crate::metadata::Workspace;
use crate::step::{Step, Stop};
use crate::{needs, python};
use std::path::Path;

/// Runs them one after the other; `criterion` is handed on to each of criterion's.
pub fn run(workspace: &Workspace, criterion: &[&str]) -> Result<(), Stop> {
    let root = &workspace.root;
    needs::ensure(root)?;
    let python = python::ensure(root)?;
    steps(workspace, criterion).iter().chain(&of_page(&python)).try_for_each(|step| step.run(root))
}

/// Frame time and memory of the scope page, watched over a run of the program itself.
fn of_page(python: &Path) -> [Step; 2] {
    let script = "-B crates/flexbeam/tests/python/scope_bench.py target/release/flexbeam";
    [
        Step::cargo("program", "build --release -p flexbeam"),
        Step::new("bench of the scope page", &python.to_string_lossy(), script),
    ]
}

/// By name, because `cargo bench` alone would also start the unit tests, which refuse criterion's arguments.
fn steps(workspace: &Workspace, criterion: &[&str]) -> Vec<Step> {
    let step = |package: &str, bench: &str| {
        let step = Step::cargo(&format!("bench {package} {bench}"), &format!("bench -p {package} --bench {bench} --"));
        criterion.iter().fold(step, |step, argument| step.arg(*argument))
    };
    let of_package = |p: &crate::metadata::Package| p.benches.iter().map(|b| step(&p.name, b)).collect::<Vec<_>>();
    workspace.packages.iter().flat_map(of_package).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metadata::Package;

    #[test]
    fn each_bench_is_named_with_its_package() {
        let package = |name: &str, benches: &[&str]| Package {
            name: name.to_owned(),
            dependencies: Vec::new(),
            benches: benches.iter().map(|b| (*b).to_owned()).collect(),
        };
        let packages = vec![package("a", &[]), package("b", &["x", "y"])];
        let workspace = Workspace { root: ".".into(), packages };
        let typed: Vec<String> = steps(&workspace, &["--quick"]).iter().map(Step::to_string).collect();
        assert_eq!(typed, ["cargo bench -p b --bench x -- --quick", "cargo bench -p b --bench y -- --quick"]);
    }

    #[test]
    fn the_page_is_watched_with_the_program_just_built() {
        let typed = of_page(Path::new("/p")).map(|step| step.to_string());
        assert_eq!(typed[0], "cargo build --release -p flexbeam");
        assert!(typed[1].starts_with("/p ") && typed[1].ends_with(" target/release/flexbeam"), "{}", typed[1]);
    }
}
