//! The proof that the kernel cannot panic: `tests/link` is a `no_std` shared library around it whose panic handler
//! calls a symbol that nothing defines. It links only if the optimiser removed every path to a panic.

use std::path::Path;
use std::process::{Command, Output};

const UNDEFINED: &str = "flexbeam_kernel_can_panic";

/// Builds `tests/link` in release. `-z defs` refuses undefined symbols; libc is there for memset and memcpy, libm is
/// not.
fn link(features: &str) -> Output {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/link");
    Command::new(env!("CARGO"))
        .args(["build", "--release", "--offline", "--features", features])
        .arg("--manifest-path")
        .arg(package.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("link").join(features))
        .env("RUSTFLAGS", "-C link-arg=-Wl,-z,defs -C link-arg=-nostartfiles -C link-arg=-lc")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_BUILD_TARGET")
        .output()
        .expect("cargo, which runs this test, starts")
}

#[test]
#[cfg(target_os = "linux")]
fn the_kernel_links_without_a_panic_handler() {
    let built = link("");
    assert!(built.status.success(), "a panic path is left:\n{}", String::from_utf8_lossy(&built.stderr));
}

#[test]
#[cfg(target_os = "linux")]
fn a_planted_panic_does_not_link() {
    let built = link("planted");
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(!built.status.success() && said.contains(UNDEFINED), "the proof cannot fail:\n{said}");
}
