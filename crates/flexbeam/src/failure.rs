//! How a command ends when it does not succeed: the message and the exit status of DESIGN section 10.

use std::error::Error;
use std::fmt;
use std::process::ExitCode;

/// Why a command did not succeed.
#[derive(Debug)]
pub enum Failure {
    /// The question was answered, and the answer is no: exit status 1.
    No(Box<dyn Error>),
    /// Bad input or usage: exit status 2.
    Input {
        /// What was tried: "design a controller for model.toml"; empty when the error says so itself.
        tried: String,
        /// What was found and needed, with a hint.
        error: Box<dyn Error>,
    },
    /// The rig faulted and was stopped: exit status 3.
    Fault(Box<dyn Error>),
}

impl Failure {
    /// Bad input met while trying something.
    pub fn while_trying<E: Error + 'static>(tried: impl Into<String>) -> impl FnOnce(E) -> Failure {
        |error| Failure::Input { tried: tried.into(), error: Box::new(error) }
    }

    /// 1: the answer is no. 2: bad input. 3: the rig was stopped.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Failure::No(_) => 1,
            Failure::Input { .. } => 2,
            Failure::Fault(_) => 3,
        })
    }
}

/// A file's error says itself what was tried, and where.
impl From<flexbeam_files::Error> for Failure {
    fn from(error: flexbeam_files::Error) -> Failure {
        Failure::Input { tried: String::new(), error: Box::new(error) }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::No(answer) | Failure::Fault(answer) => write!(f, "{answer}"),
            Failure::Input { tried, error } if tried.is_empty() => write!(f, "{error}"),
            Failure::Input { tried, error } => write!(f, "cannot {tried}: {error}"),
        }
    }
}
