//! `cargo xtask bench`: every criterion bench of the workspace.

use crate::metadata::Workspace;
use crate::step::{Step, Stop};

/// Runs them one after the other; `criterion` is handed on to each.
pub fn run(workspace: &Workspace, criterion: &[&str]) -> Result<(), Stop> {
    steps(workspace, criterion).iter().try_for_each(|step| step.run(&workspace.root))
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
}
