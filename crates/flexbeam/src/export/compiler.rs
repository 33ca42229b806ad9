//! The C compiler at hand, for the binary of a functional mock-up unit.

use std::path::Path;
use std::process::Command;

use flexbeam_codegen::fmu::Version;

/// Why there is no binary.
#[derive(Debug, thiserror::Error)]
pub(super) enum Error {
    /// The interface has no folder for this machine, or we have no compiler's flags for it.
    #[error(
        "found {os} on {architecture}, needed Linux on x86-64 for the binary of an FMU\nhint: --sources-only leaves the binary to whoever imports it"
    )]
    Platform { os: &'static str, architecture: &'static str },
    /// No program of that name.
    #[error(
        "found no C compiler: `{program}`: {found}; needed one for the binary of an FMU\nhint: install one, name one in the variable CC, or --sources-only, which leaves the binary to whoever imports it"
    )]
    Missing { program: String, found: std::io::Error },
    /// It does not take the text.
    #[error(
        "found that {program} does not compile the sources:\n  {}\nneeded a compiler of C99 with -ffp-contract=off\nhint: name another one in the variable CC, or --sources-only, which leaves the binary to whoever imports it",
        .said.join("\n  ")
    )]
    Refused { program: String, said: Vec<String> },
    /// A folder to compile in.
    #[error(
        "found no place for temporary files: {0}; needed a folder to compile in\nhint: the variable TMPDIR names one, or --sources-only"
    )]
    Folder(std::io::Error),
}

/// Where a binary runs.
pub(super) struct Platform {
    /// Of the archive, below `binaries/`.
    pub(super) folder: &'static str,
}

impl Platform {
    /// Errors: [`Error::Platform`].
    pub(super) fn of_this_machine(version: Version) -> Result<Platform, Error> {
        let (os, architecture) = (std::env::consts::OS, std::env::consts::ARCH);
        match (version, os, architecture) {
            (Version::Two, "linux", "x86_64") => Ok(Platform { folder: "linux64" }),
            (Version::Three, "linux", "x86_64") => Ok(Platform { folder: "x86_64-linux" }),
            _ => Err(Error::Platform { os, architecture }),
        }
    }
}

/// Such that the bits are the kernel's, and that no more is seen from outside than the interface.
const FLAGS: [&str; 7] = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden", "-s"];

/// Most lines of a compiler's complaint.
const SHOWN_LINES: usize = 12;

/// The bytes of a shared library made of these texts, of which the compiler is given `compiled`.
///
/// Errors: [`Error::Missing`], [`Error::Refused`], [`Error::Folder`].
pub(super) fn library(texts: &[(&str, &str)], compiled: &[String]) -> Result<Vec<u8>, Error> {
    let folder = tempfile::tempdir().map_err(Error::Folder)?;
    for (name, text) in texts {
        std::fs::write(folder.path().join(name), text).map_err(Error::Folder)?;
    }
    compile(folder.path(), compiled)?;
    std::fs::read(folder.path().join(LIBRARY)).map_err(Error::Folder)
}

const LIBRARY: &str = "library.so";

fn compile(folder: &Path, compiled: &[String]) -> Result<(), Error> {
    let named = std::env::var("CC").ok().filter(|words| !words.trim().is_empty()).unwrap_or_else(|| "cc".into());
    let mut words = named.split_whitespace();
    let program = words.next().unwrap_or("cc").to_owned();
    let mut command = Command::new(&program);
    command.args(words).args(FLAGS).args(["-o", LIBRARY]).args(compiled);
    let output = match command.current_dir(folder).output() {
        Ok(output) => output,
        Err(found) => return Err(Error::Missing { program, found }),
    };
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr).lines().take(SHOWN_LINES).map(str::to_owned).collect();
    Err(Error::Refused { program: named, said })
}
