//! A controller whose certificate does not match its numbers does not run, unless somebody says why it may.

use flexbeam_files::Controller;

use crate::Failure;
use crate::output::say;
use crate::verify::broken_figures;

/// The figures that broke.
#[derive(Debug, thiserror::Error)]
#[error(
    "found a certificate that does not match the controller's numbers:\n  {}\nneeded every figure as it is claimed\nhint: design it again, or see `flexbeam verify`; --unverified REASON runs it all the same, and the recording keeps the reason",
    .0.join("\n  ")
)]
struct NotCertified(Vec<String>);

/// Recomputes the certificate's figures.
///
/// Returns: the override, in words, where one was needed and given.
/// Errors: a figure that broke, without a reason to run all the same.
pub fn check(file: &Controller, tried: &str, unverified: Option<&str>) -> Result<Option<String>, Failure> {
    let broken = broken_figures(file)?;
    match (broken.is_empty(), unverified) {
        (true, _) => Ok(None),
        (false, None) => Err(Failure::while_trying(tried)(NotCertified(broken))),
        (false, Some(reason)) => {
            let text = format!("the certificate does not match ({}); run all the same: {reason}", broken.join("; "));
            say(format_args!("warning: {text}"));
            Ok(Some(text))
        }
    }
}
