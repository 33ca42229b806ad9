//! `cargo xtask tidy`: the house rules that a compiler does not know.

mod storeys;
mod text;

use crate::metadata::Workspace;
use crate::step::Stop;
use std::path::Path;
use std::process::Command;
use text::File;

/// Checks every rule and reports all that is broken.
pub fn run(workspace: &Workspace) -> Result<(), Stop> {
    eprintln!("\n=== tidy");
    let files = files(&workspace.root)?;
    let recordings = recordings(&workspace.root);
    let mut broken = storeys::broken(&workspace.packages);
    broken.extend(text::broken(&files, &recordings));
    if broken.is_empty() {
        eprintln!("--- tidy : {} packages, {} files", workspace.packages.len(), files.len());
        return Ok(());
    }
    Err(Stop::failed(format!("tidy: what is broken ({}):\n  {}", broken.len(), broken.join("\n  "))))
}

/// Every file that git has or would take.
fn files(root: &Path) -> Result<Vec<File>, Stop> {
    let listed = Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .current_dir(root)
        .output()
        .map_err(|e| Stop::failed(format!("tidy: git did not start: {e}")))?;
    if !listed.status.success() {
        return Err(Stop::failed(format!("tidy: git ls-files: {}", String::from_utf8_lossy(&listed.stderr))));
    }
    let paths = String::from_utf8_lossy(&listed.stdout).into_owned();
    let read = |path: &str| Some(File { path: path.to_owned(), bytes: std::fs::read(root.join(path)).ok()? });
    Ok(paths.split_terminator('\0').filter_map(read).collect())
}

/// The shared recordings, where they are at hand, to find copies under other names.
fn recordings(root: &Path) -> Vec<Vec<u8>> {
    let folder = std::fs::read_dir(root.join("../shared/data")).into_iter().flatten().flatten();
    let data = folder.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == "dat"));
    data.filter_map(|path| std::fs::read(path).ok()).collect()
}
