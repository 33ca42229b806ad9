//! Answers and files on their way out: data to standard output, talk to standard error.

use std::path::Path;

use flexbeam_files::{Document, Error, Overwrite, Parent, Provenance};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::Failure;

/// A new file of our own kind may replace an older one of the same schema; anything else only with `--force`.
///
/// Asked before the work begins, so that nothing is computed in vain.
pub fn overwrite<D: Document>(path: &Path, force: bool) -> Result<Overwrite, Failure> {
    let overwrite = if force { Overwrite::Allow } else { Overwrite::SameKind };
    D::check_free(path, overwrite)?;
    Ok(overwrite)
}

/// This tool, the command as it was typed, and the files that the answer came from.
pub fn provenance(parents: &[&Path], child: &Path) -> Result<Provenance, Error> {
    Ok(Provenance {
        tool: format!("flexbeam {}", env!("CARGO_PKG_VERSION")),
        command: Some(std::env::args().skip(1).fold("flexbeam".to_string(), |line, word| line + " " + &word)),
        time: None,
        parents: parents.iter().map(|parent| Parent::of(parent, child)).collect::<Result<_, _>>()?,
    })
}

/// A progress bar on standard error, drawn only on a terminal and only when the work takes longer than a blink.
pub fn progress(steps: u64, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr_with_hz(10));
    let style = ProgressStyle::with_template("{msg:32} {bar:32} {pos}/{len} {elapsed}").expect("a fixed template");
    bar.with_style(style).with_message(what)
}
