//! The viewers of a run: `--foxglove`.

use flexbeam_files::RunHeader;
use flexbeam_runtime::foxglove::{ViewerOptions, Viewers, ViewersMay};
use flexbeam_runtime::{EventKind, Session, Sink, Steering};

use crate::{Failure, cli};

/// Serves viewers, if any are asked for, and says where.
///
/// Errors: an address that is taken, or that this machine does not have; a rate that makes no sense.
pub fn open(arguments: &cli::Viewers) -> Result<Option<Viewers>, Failure> {
    let Some(address) = &arguments.foxglove else { return Ok(None) };
    let may = if arguments.foxglove_set { ViewersMay::Set } else { ViewersMay::Look };
    let options = ViewerOptions { most_per_s: arguments.foxglove_rate, may };
    let viewers = Viewers::open(address, options)
        .map_err(|refused| Failure::Input { tried: String::new(), error: Box::new(refused) })?;
    eprintln!("viewers connect to ws://{}", viewers.address());
    if !address.is_loopback() {
        eprintln!("warning: whoever reaches this address sees the run");
    }
    Ok(Some(viewers))
}

/// The sinks, and one for viewers behind them: the recording comes first.
pub fn with_sink(sinks: Vec<Box<dyn Sink>>, viewers: Option<&Viewers>, header: &RunHeader) -> Vec<Box<dyn Sink>> {
    let sink = viewers.map(|viewers| Box::new(viewers.sink(header)) as Box<dyn Sink>);
    sinks.into_iter().chain(sink).collect()
}

/// Lets viewers at the settings, as far as they may; the recording says so where they may change them.
pub fn admit(viewers: Option<&Viewers>, session: &Session, steering: &Steering) {
    let Some(viewers) = viewers else { return };
    viewers.steer(steering.clone(), session.notes());
    if viewers.may() == ViewersMay::Set {
        let text = format!("--foxglove-set: whoever reaches {} may change settings without a token", viewers.address());
        session.note(EventKind::Override, text);
    }
}
