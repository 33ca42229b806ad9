//! `--refine`: the descent with a sign of life, ended by Ctrl-C with what it has reached.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use flexbeam_files as files;
use flexbeam_files::Rows;
use flexbeam_ident::refine::{Errors, Progress, Reason, Refined, Settings, refine_identified};
use flexbeam_ident::{Error, Feedthrough, Identified, Options};
use indicatif::ProgressBar;
use signal_hook::consts::SIGINT;

use super::Experiment;
use crate::cli;

/// Status of a program that a second Ctrl-C ends, as shells count it.
const INTERRUPTED: i32 = 130;

/// A refinement and what it took.
pub(crate) struct Refinement {
    /// What came of it.
    pub refined: Refined,
    /// Which errors were made small.
    pub errors: cli::Refinement,
    /// Time that it took [s].
    pub refine_s: f64,
}

/// Refines until it settles, or until Ctrl-C.
///
/// Errors: those of [`refine_identified`].
pub(crate) fn refined(
    errors: cli::Refinement,
    experiment: &Experiment,
    identified: &Identified,
    options: &Options,
    sign: &ProgressBar,
) -> Result<(Identified, Refinement), Error> {
    let settings = Settings {
        errors: match errors {
            cli::Refinement::Simulated => Errors::Simulated,
            cli::Refinement::Predicted => Errors::Predicted(None),
        },
        integrators: options.integrators,
        feedthrough: if options.integrators > 0 { Feedthrough::Zero } else { options.feedthrough },
        poles: options.poles,
        offset: options.remove_mean,
        ..Settings::default()
    };
    let start = Instant::now();
    let listening = Listening::start();
    let mut watch = |progress: &Progress| {
        if progress.missed.is_finite() {
            let percent = 100.0 * progress.missed;
            sign.set_message(format!("refining: step {}, {percent:.3} % of the outputs missed", progress.iterations));
        }
        if listening.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let (identified, refined) =
        refine_identified(identified, &experiment.inputs, &experiment.outputs, &settings, &mut watch)?;
    Ok((identified, Refinement { refined, errors, refine_s: start.elapsed().as_secs_f64() }))
}

impl Refinement {
    /// The object of the answer and the table of the model file.
    pub fn file(&self) -> files::Refinement {
        let Refined { K, parameters, iterations, missed_before, missed_after, reason, .. } = &self.refined;
        files::Refinement {
            errors: self.errors.name().into(),
            iterations: *iterations,
            parameters: *parameters,
            missed_before: Some(*missed_before).filter(|missed| missed.is_finite()),
            missed_after: *missed_after,
            reason: reason_name(*reason).into(),
            K: K.as_ref().map(Rows::from),
        }
    }

    /// A line for a person.
    pub fn text(&self) -> String {
        let Refined { parameters, iterations, missed_before, missed_after, reason, .. } = &self.refined;
        format!(
            "refined by the {} errors, {parameters} parameters: {:.4} % of the outputs missed before, {:.4} % after {iterations} steps; {}",
            self.errors.name(),
            100.0 * missed_before,
            100.0 * missed_after,
            reason_text(*reason),
        )
    }

    /// What a person should know besides.
    pub fn note(&self) -> Option<String> {
        match self.refined.reason {
            Reason::Asked => Some(format!(
                "the refinement was ended by Ctrl-C after {} steps: the model is the best until then",
                self.refined.iterations
            )),
            Reason::Iterations => Some(format!(
                "the refinement was still going down after {} steps\nhint: a smaller --order: the data do not tell so many poles",
                self.refined.iterations
            )),
            _ => None,
        }
    }
}

fn reason_name(reason: Reason) -> &'static str {
    match reason {
        Reason::Settled => "settled",
        Reason::Rounding => "rounding",
        Reason::NoDescent => "no_descent",
        Reason::Slow => "slow",
        Reason::Iterations => "iterations",
        Reason::Asked => "asked",
    }
}

fn reason_text(reason: Reason) -> &'static str {
    match reason {
        Reason::Settled => "settled",
        Reason::Rounding => "nothing is left but rounding",
        Reason::NoDescent => "no step goes farther down",
        Reason::Slow => "what is left is a flat valley",
        Reason::Iterations => "still going down",
        Reason::Asked => "ended by Ctrl-C",
    }
}

/// Ctrl-C sets a flag while this lives; a second one ends the program.
struct Listening {
    asked: Arc<AtomicBool>,
    ids: Vec<signal_hook::SigId>,
}

impl Listening {
    fn start() -> Listening {
        let asked = Arc::<AtomicBool>::default();
        // In this order: the first Ctrl-C finds the flag unset, the second finds it set. Where signals cannot be had, Ctrl-C ends
        // the program as it always did.
        let second = signal_hook::flag::register_conditional_shutdown(SIGINT, INTERRUPTED, asked.clone());
        let first = signal_hook::flag::register(SIGINT, asked.clone());
        Listening { asked, ids: [second, first].into_iter().flatten().collect() }
    }

    fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        self.ids.iter().for_each(|id| {
            signal_hook::low_level::unregister(*id);
        });
    }
}
