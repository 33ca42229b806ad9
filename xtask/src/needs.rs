//! What the tests need from the system: Debian packages, each with a command that proves it is there. Missing ones are
//! installed as root or with a sudo that asks nothing; otherwise the line to type is printed and the chore stops with
//! status 2.

use crate::step::{Step, Stop};
use std::path::Path;
use std::process::{Command, Stdio};

/// A Debian package and its proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Need {
    package: &'static str,
    /// Succeeds when the package is there.
    proof: &'static [&'static str],
    why: &'static str,
}

const NEEDS: [Need; 13] = [
    Need {
        package: "chromium",
        proof: &["chromium", "--version"],
        why: "shows the scope page, as a person would use it",
    },
    Need {
        package: "fonts-dejavu-core",
        proof: &["test", "-f", "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"],
        why: "letters for that page: without a font its widths mean nothing",
    },
    Need {
        package: "gcc",
        proof: &["cc", "--version"],
        why: "links every program and the kernel's library that proves it cannot panic, compiles the boards' stand-ins",
    },
    Need {
        package: "python3-venv",
        proof: &["python3", "-c", "import ensurepip, venv"],
        why: "makes the environment of the public packages that read our files",
    },
    Need { package: "make", proof: &["make", "--version"], why: "builds the generated C as people do" },
    Need { package: "cmake", proof: &["ctest", "--version"], why: "builds the generated C as people do" },
    Need {
        package: "clang",
        proof: &["clang", "--version"],
        why: "the second compiler of the generated C, whose bits are compared",
    },
    Need {
        package: "libclang-rt-dev",
        proof: &["sh", "-c", "test -e \"$(clang -print-file-name=libclang_rt.asan-x86_64.a)\""],
        why: "its sanitizers",
    },
    Need {
        package: "gcc-arm-none-eabi",
        proof: &["arm-none-eabi-gcc", "--version"],
        why: "compiles the generated C for a Cortex-M",
    },
    Need {
        package: "libnewlib-arm-none-eabi",
        proof: &["sh", "-c", "echo '#include <math.h>' | arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -E -"],
        why: "its headers and library",
    },
    Need { package: "qemu-system-arm", proof: &["qemu-system-arm", "--version"], why: "runs it there" },
    Need {
        package: "valgrind",
        proof: &["valgrind", "--version"],
        why: "counts the instructions of a tick, in a bench",
    },
    Need {
        package: "octave-control",
        proof: &["octave-cli", "--norc", "--no-history", "--eval", "pkg load control"],
        why: "rebuilds exported loops, with Octave, on which it depends",
    },
];

/// How packages may be installed here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Privilege {
    Root,
    Sudo,
    Neither,
}

/// Installs what is missing.
pub fn ensure(root: &Path) -> Result<(), Stop> {
    let missing: Vec<Need> = NEEDS.into_iter().filter(|need| !succeeds(need.proof)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    for need in &missing {
        eprintln!("missing: {} ({})", need.package, need.why);
    }
    plan(&missing, privilege())?.iter().try_for_each(|step| step.run(root))?;
    match missing.iter().find(|need| !succeeds(need.proof)) {
        None => Ok(()),
        Some(need) => {
            Err(Stop::usage(format!("xtask: {} is installed, yet `{}` fails", need.package, need.proof.join(" "))))
        }
    }
}

fn plan(missing: &[Need], privilege: Privilege) -> Result<Vec<Step>, Stop> {
    let packages = missing.iter().map(|need| need.package).collect::<Vec<_>>().join(" ");
    let (program, before) = match privilege {
        Privilege::Root => ("apt-get", ""),
        Privilege::Sudo => ("sudo", "-n apt-get "),
        Privilege::Neither => {
            return Err(Stop::usage(format!(
                "xtask: the tests need packages that only root may install. Type:\n  \
                 sudo apt-get update && sudo apt-get install -y --no-install-recommends {packages}"
            )));
        }
    };
    let install = format!("{before}install -y --no-install-recommends {packages}");
    Ok(vec![
        Step::new("package lists", program, &format!("{before}update -q")),
        Step::new("packages", program, &install),
    ])
}

fn privilege() -> Privilege {
    let id = Command::new("id").arg("-u").output();
    if id.is_ok_and(|id| id.stdout.trim_ascii() == b"0") {
        Privilege::Root
    } else if succeeds(&["sudo", "-n", "true"]) {
        Privilege::Sudo
    } else {
        Privilege::Neither
    }
}

fn succeeds(command: &[&str]) -> bool {
    let [program, arguments @ ..] = command else { return false };
    let mut quiet = Command::new(program);
    quiet.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: [Need; 2] =
        [Need { package: "gcc", proof: &["false"], why: "" }, Need { package: "valgrind", proof: &["false"], why: "" }];

    #[test]
    fn root_installs_and_others_ask_sudo() {
        let typed = |privilege| plan(&TWO, privilege).unwrap().iter().map(Step::to_string).collect::<Vec<_>>();
        let root = ["apt-get update -q", "apt-get install -y --no-install-recommends gcc valgrind"];
        assert_eq!(typed(Privilege::Root), root);
        assert_eq!(typed(Privilege::Sudo), root.map(|line| format!("sudo -n {line}")));
    }

    #[test]
    fn without_either_the_line_to_type_comes_with_status_2() {
        let stop = plan(&TWO, Privilege::Neither).unwrap_err();
        assert_eq!(stop.status, 2);
        assert!(stop.message.ends_with("sudo apt-get install -y --no-install-recommends gcc valgrind"));
    }

    #[test]
    fn a_proof_can_fail() {
        assert!(succeeds(&["true"]) && !succeeds(&["false"]) && !succeeds(&["flexbeam-no-such-program"]));
    }
}
