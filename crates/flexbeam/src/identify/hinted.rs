//! What `flexbeam-ident` cannot do, with one hint on a line of its own.

use std::fmt;

use flexbeam_ident::Error;

/// An error of the identification as the face shows it.
#[derive(Debug)]
pub(crate) struct Hinted(pub Error);

impl fmt::Display for Hinted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.to_string();
        let (message, hint) = text.split_once("; hint: ").unwrap_or((&text, hint(&self.0)));
        write!(f, "{message}\nhint: {hint}")
    }
}

impl std::error::Error for Hinted {}

/// For an error that has no hint of its own.
fn hint(error: &Error) -> &'static str {
    match error {
        Error::Setting { .. } => "flexbeam identify --help lists the settings with their defaults",
        Error::Order { .. } => "a smaller --order, more --block-rows, or --order auto",
        Error::NoState => {
            "are these the right --inputs and --outputs? flexbeam show tells what the columns hold; a proportional controller \
             without external excitation leaves no state either"
        }
        Error::NotSettled { .. } => "the recording is hardly a flexible link's; compare the fits of other orders",
        Error::TooFewRamps { .. } => "slow ramps each way, each from rest: flexbeam rig test --repeats 3 drives them",
        Error::TooFewRuns { .. } => "hold the voltage for a second or more, beyond the breakaway, each way",
        Error::OneSpeed { .. } | Error::SpeedsAlike { .. } => {
            "runs at several voltages, the largest well above the smallest"
        }
        Error::NoCoast { .. } => "cut the voltage to 0 V while the hub turns fast, and record on for a second",
        _ => "flexbeam show tells what the recording holds",
    }
}
