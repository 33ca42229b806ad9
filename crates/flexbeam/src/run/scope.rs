//! The scope of a run: `--scope`.

use flexbeam_files::{CertificateFigure, CertificateSummary, Controller, RunHeader};
use flexbeam_runtime::scope::{About, ScopeServer, Token};
use flexbeam_runtime::{Session, Sink, Steering};

use crate::{Failure, cli};

/// A token that nobody will ask for.
#[derive(Debug, thiserror::Error)]
#[error(
    "found --scope-token-file without a scope, needed --scope, or a project that has one\nhint: --scope alone serves it at 127.0.0.1:8787"
)]
struct NothingToSteer;

/// Errors: a token file on the command line, and no scope.
pub fn check(scope: &cli::Scope, token_stated: bool) -> Result<(), Failure> {
    if token_stated && scope.scope.is_none() {
        return Err(said_itself(NothingToSteer));
    }
    Ok(())
}

/// Serves the scope, if it is asked for, and says where.
///
/// Errors: an address that is taken, or that this machine does not have; a token file that cannot be used.
pub fn open(arguments: &cli::Scope, about: About) -> Result<Option<ScopeServer>, Failure> {
    let Some(address) = &arguments.scope else { return Ok(None) };
    let token = arguments.scope_token_file.as_deref().map_or_else(Token::new, Token::of_file).map_err(said_itself)?;
    let server = ScopeServer::open(address, token, about).map_err(said_itself)?;
    eprintln!("scope: {}", server.url());
    if !server.address().is_loopback() {
        eprintln!("warning: whoever reaches this address sees the run; the token travels in clear");
    }
    Ok(Some(server))
}

/// The server's own errors say what was tried.
fn said_itself(refused: impl std::error::Error + Send + Sync + 'static) -> Failure {
    Failure::Input { tried: String::new(), error: Box::new(refused) }
}

/// The sinks, and the scope's behind them: the recording comes first.
pub fn with_sink(sinks: Vec<Box<dyn Sink>>, scope: Option<&ScopeServer>, header: &RunHeader) -> Vec<Box<dyn Sink>> {
    let sink = scope.map(|scope| Box::new(scope.sink(header)) as Box<dyn Sink>);
    sinks.into_iter().chain(sink).collect()
}

/// Lets viewers with the token at the run.
pub fn admit(scope: Option<&ScopeServer>, session: &Session, steering: &Steering) {
    if let Some(scope) = scope {
        scope.steer(steering.clone(), session.notes());
    }
}

/// The certificate of the loop that runs: the sampled one. `unverified` is why it runs although a figure broke.
pub fn certificate(file: &Controller, unverified: Option<&str>) -> CertificateSummary {
    let (whole, sampled) = (&file.certificate, &file.certificate.sampled);
    let figure = |label: &str, value: f64, unit: &str, note: &str| CertificateFigure {
        label: label.into(),
        value: Some(value).filter(|value| value.is_finite()),
        unit: unit.into(),
        note: note.into(),
    };
    let error = whole.stationary_error_rad.map(|error_rad| {
        figure("Stationary error", error_rad.to_degrees(), "°", "largest, under the residual voltage of the law")
    });
    let figures = [
        figure(
            "Robust radius",
            sampled.robust_radius.0,
            "",
            "in units of the uncertainty: some controller survives it",
        ),
        figure("Bound norm", sampled.bound_norm, "", "at most 1: this controller survives the whole uncertainty"),
        figure("Stability degree", sampled.stability_degree, "1/s", "every motion dies out at least so fast"),
        figure("Stiffness", sampled.stiffness.0, "V/rad", "voltage for a standing error"),
    ];
    let margins = [
        figure("Gain margin", sampled.gain_margin.0, "", "factor by which the gain may grow"),
        figure("Phase margin", sampled.phase_margin_rad.0.to_degrees(), "°", "by which the phase may lag"),
        figure("Delay margin", sampled.delay_margin_s.0 * 1e3, "ms", "that may be added"),
        figure("Disk margin", sampled.disk_margin.0, "", "gain and phase together"),
    ];
    CertificateSummary {
        holds: unverified.is_none(),
        note: unverified.map_or_else(String::new, |reason| format!("run unverified: {reason}")),
        figures: figures.into_iter().chain(error).chain(margins).collect(),
    }
}
