//! Answers and files on their way out: data to standard output, talk to standard error.

use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use flexbeam_files::{Document, Error, Overwrite, Parent, Provenance, write_bytes};
use flexbeam_report::Figure;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::Failure;

/// A new file of our own kind may replace an older one of the same kind; anything else only with `--force`.
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

/// A sign of life on standard error during one step of unknown length; it goes when it is dropped.
pub fn waiting(what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}").expect("a fixed template");
    let target = ProgressDrawTarget::stderr_with_hz(10);
    let sign = ProgressBar::with_draw_target(None, target).with_style(style).with_message(what);
    sign.enable_steady_tick(Duration::from_millis(200));
    sign
}

/// A figure as NAME.svg and NAME.png in a folder; returns the names of the two files.
pub fn write_figure(folder: &Path, name: &str, figure: &Figure) -> Result<[String; 2], Failure> {
    let png = figure.png(PIXELS_PER_POINT).map_err(Failure::while_trying(format!("draw the figure {name}")))?;
    let files = [format!("{name}.svg"), format!("{name}.png")];
    write_bytes(&folder.join(&files[0]), figure.svg().as_bytes(), Overwrite::Allow)?;
    write_bytes(&folder.join(&files[1]), &png, Overwrite::Allow)?;
    Ok(files)
}

/// Sharp on today's screens and in print.
const PIXELS_PER_POINT: f64 = 2.0;

/// A line on standard error. Where that is gone (a terminal that hung up, a pipe that closed), nothing: what a rig is doing must
/// not end with its audience.
pub fn say(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// A folder for results, made when it is not there.
pub fn folder(path: &Path) -> Result<(), Failure> {
    let refused = |error| NoFolder { error };
    std::fs::create_dir_all(path)
        .map_err(refused)
        .map_err(Failure::while_trying(format!("make the folder {}", path.display())))
}

/// A folder that cannot be made.
#[derive(Debug, thiserror::Error)]
#[error(
    "{error}\nhint: a file of that name may stand there, or the place may be read-only; --out names another folder"
)]
struct NoFolder {
    error: std::io::Error,
}
