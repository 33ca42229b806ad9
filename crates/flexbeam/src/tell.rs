//! `flexbeam tell`: one request to a run, over its control socket.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use flexbeam_files::{Reply, Request, json_text, request_of_changes};
use flexbeam_report::significant;

use crate::{Failure, cli};

/// A run answers at once; without an answer in this time it hangs.
const PATIENCE: Duration = Duration::from_secs(5);

/// A run that cannot be told anything.
#[derive(Debug, thiserror::Error)]
enum NotTold {
    #[error(
        "found no run there ({0}), needed one started with --control\nhint: the socket's name is what `flexbeam run --control` was given"
    )]
    NoRun(std::io::Error),
    #[error(
        "found changes {0:?} with a request that takes none, needed them with set\nhint: flexbeam tell SOCKET set eps_u_v=0.02"
    )]
    Changes(String),
    #[error(
        "found set without a change, needed KEY=VALUE\nhint: flexbeam tell SOCKET set eps_u_v=0.02 reference.amplitude_rad=0.3"
    )]
    NoChange,
    #[error(
        "found {0}, needed KEY=VALUE with a key of the settings\nhint: the keys are those of a controller file's table settings, and reference.shape, .amplitude_rad, .period_s, .offset_rad"
    )]
    Change(String),
    #[error("found an answer that is none ({0}), needed one of a run\nhint: is it a run of this version?")]
    Answer(String),
}

/// The run says no.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Refused(String);

/// Runs the command.
pub fn run(arguments: &cli::Tell) -> Result<(), Failure> {
    let tried = || format!("tell {}", arguments.socket.display());
    let request = request(arguments).map_err(Failure::while_trying(tried()))?;
    let reply = asked(arguments, &request).map_err(Failure::while_trying(tried()))?;
    if arguments.json {
        println!("{}", json_text(&reply));
    } else if reply.ok {
        print!("{}", text(&reply));
    }
    match reply.error {
        None => Ok(()),
        Some(error) => Err(Failure::while_trying(tried())(Refused(error))),
    }
}

fn request(arguments: &cli::Tell) -> Result<Request, NotTold> {
    let changes = &arguments.changes;
    let plain = match arguments.what {
        cli::What::Status => Request::Status,
        cli::What::Start => Request::Start,
        cli::What::Stop => Request::Stop,
        cli::What::Emergency => Request::Emergency,
        cli::What::Set if changes.is_empty() => return Err(NotTold::NoChange),
        cli::What::Set => return request_of_changes(changes).map_err(NotTold::Change),
    };
    if changes.is_empty() { Ok(plain) } else { Err(NotTold::Changes(changes.join(" "))) }
}

fn asked(arguments: &cli::Tell, request: &Request) -> Result<Reply, NotTold> {
    let mut stream = UnixStream::connect(&arguments.socket).map_err(NotTold::NoRun)?;
    stream.set_read_timeout(Some(PATIENCE)).map_err(NotTold::NoRun)?;
    writeln!(stream, "{}", json_text(request)).map_err(NotTold::NoRun)?;
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).map_err(NotTold::NoRun)?;
    Reply::parse(&line).map_err(NotTold::Answer)
}

fn text(reply: &Reply) -> String {
    let mut text = format!("{}, settings {}\n", reply.phase, reply.revision);
    if let Some(last) = reply.last {
        let number = |x: f64| significant(x, 4);
        text += &format!(
            "{} s: reference {}°, tip {}°, deflection {}°, {} V\n",
            number(last.time_s),
            number(last.reference_rad.to_degrees()),
            number(last.psi_rad.to_degrees()),
            number(last.alpha_rad.to_degrees()),
            number(last.voltage_v)
        );
    }
    text
}
