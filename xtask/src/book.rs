//! `cargo xtask book`: the user's book as HTML.

use crate::metadata::Workspace;
use crate::step::{Step, Stop};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// mdBook's versions whose book.toml and output we know.
const MDBOOK: &str = "^0.5";

/// Builds `book/` into `target/book`.
pub fn run(workspace: &Workspace) -> Result<(), Stop> {
    let root = &workspace.root;
    let mdbook = match found(root) {
        Some(mdbook) => mdbook,
        None => compiled(root)?,
    };
    let html = root.join("target/book");
    // Absolute, because versions differ in what a relative one starts from.
    Step::new("book", &mdbook, "build book --dest-dir").arg(html.to_string_lossy()).run(root)?;
    eprintln!("the book: {}", html.join("index.html").display());
    Ok(())
}

/// On the PATH, or compiled earlier.
fn found(root: &Path) -> Option<String> {
    let candidates = [PathBuf::from("mdbook"), tool(root)];
    candidates.into_iter().find(|mdbook| answers(mdbook)).map(|mdbook| mdbook.to_string_lossy().into_owned())
}

fn tool(root: &Path) -> PathBuf {
    root.join("target/tools/bin/mdbook")
}

fn answers(program: &Path) -> bool {
    let quiet = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    quiet.is_ok_and(|status| status.success())
}

fn compiled(root: &Path) -> Result<String, Stop> {
    eprintln!("mdBook is neither on the PATH nor under target/tools: compiling it once, which takes a few minutes");
    Step::cargo("mdBook", "install mdbook --locked --root target/tools --version").arg(MDBOOK).run(root)?;
    Ok(tool(root).to_string_lossy().into_owned())
}
