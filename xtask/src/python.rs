//! A Python of the tests' own, under `target/tools/python`, with the readers that are not ours and the driver of the browser.

use crate::step::{Step, Stop};
use std::path::{Path, PathBuf};

/// Names the interpreter, for the tests that compare with public packages.
pub const PYTHON: &str = "FLEXBEAM_PYTHON";

/// What the tests import. What these need themselves, they choose. Playwright's wheel holds its driver but no browser: that is
/// Debian's. The axe rules of accessibility come with axe-playwright-python.
const PINS: [&str; 9] = [
    "fmpy==0.3.32",
    "ecospy==0.7.2",
    "tbb==2023.2.0",
    "libcosimpy==0.0.6",
    "mcap==1.6.0",
    "mcap-ros2-support==0.6.0",
    "scipy==1.17.1",
    "playwright==1.65.2",
    "axe-playwright-python==0.1.8",
];

/// The environment, from the root.
const FOLDER: &str = "target/tools/python";

/// The interpreter; its environment is made when it is missing, was not completed, or has other pins.
pub fn ensure(root: &Path) -> Result<PathBuf, Stop> {
    let interpreter = root.join(FOLDER).join("bin/python");
    if interpreter.exists() && completed(root) {
        return Ok(interpreter);
    }
    steps().iter().try_for_each(|step| step.run(root))?;
    std::fs::write(stamp(root), pins()).map_err(|e| Stop::failed(format!("xtask: {FOLDER}: {e}")))?;
    Ok(interpreter)
}

fn steps() -> [Step; 2] {
    let install = "-m pip install --quiet --disable-pip-version-check --only-binary :all:";
    let packages = Step::new("Python packages", &format!("{FOLDER}/bin/python"), install);
    [
        Step::new("Python", "python3", &format!("-m venv --clear {FOLDER}")),
        PINS.iter().fold(packages, |step, pin| step.arg(*pin)),
    ]
}

/// Written last, so that an environment without it is not complete.
fn stamp(root: &Path) -> PathBuf {
    root.join(FOLDER).join("pins.txt")
}

fn pins() -> String {
    PINS.join("\n") + "\n"
}

fn completed(root: &Path) -> bool {
    std::fs::read_to_string(stamp(root)).is_ok_and(|found| found == pins())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_pinned_and_never_compiled() {
        assert!(PINS.iter().all(|pin| pin.contains("==")));
        let [environment, packages] = steps().map(|step| step.to_string());
        assert_eq!(environment, "python3 -m venv --clear target/tools/python");
        assert!(packages.starts_with("target/tools/python/bin/python -m pip install "), "{packages}");
        assert!(packages.contains("--only-binary :all:") && packages.ends_with(PINS[PINS.len() - 1]), "{packages}");
    }

    #[test]
    fn other_pins_or_none_are_not_complete() {
        let root = std::env::temp_dir().join(format!("flexbeam-xtask-python-{}", std::process::id()));
        std::fs::create_dir_all(root.join(FOLDER)).unwrap();
        assert!(!completed(&root));
        std::fs::write(stamp(&root), "mcap==0.0.1\n").unwrap();
        assert!(!completed(&root));
        std::fs::write(stamp(&root), pins()).unwrap();
        assert!(completed(&root));
        std::fs::remove_dir_all(root).unwrap();
    }
}
