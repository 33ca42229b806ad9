//! A rig's port as text, opened as a back end.

use std::path::Path;
use std::process;
use std::time::{SystemTime, UNIX_EPOCH};

use flexbeam_rig::{RigParameters, SimulatedRig};
use flexbeam_runtime::SimulatedBackEnd;
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::comedi::{ComediPort, ComediRig};
use flexbeam_runtime::hil::{HilPort, HilRig};
use flexbeam_runtime::port::Port;
use flexbeam_runtime::serial::SerialRig;
use flexbeam_runtime::udp::UdpRig;

use crate::Failure;

/// The port that the command line names.
///
/// Errors: a text that names no port.
pub fn port(text: &str) -> Result<Port, Failure> {
    text.parse().map_err(Failure::while_trying(format!("use --port {text}")))
}

/// The rig at a port; a simulated one of these parameters, with this seed.
///
/// Errors: a rig that is not there, a library that is not there, a port that another program has.
pub fn open(port: &Port, rig: &RigParameters, seed: u64) -> Result<Box<dyn BackEnd>, Failure> {
    let refused = || Failure::while_trying(format!("open {port}"));
    Ok(match port {
        Port::Simulated => {
            let rig = SimulatedRig::new(rig, seed).map_err(Failure::while_trying("simulate the rig"))?;
            Box::new(SimulatedBackEnd::new(rig).map_err(refused())?)
        }
        Port::Udp { host, port } => {
            Box::new(UdpRig::open(&format!("{host}:{port}"), unlike_any_other()).map_err(refused())?)
        }
        Port::Serial { device, baud } => {
            Box::new(SerialRig::open(Path::new(device), *baud, unlike_any_other()).map_err(refused())?)
        }
        Port::Hil(text) => Box::new(HilPort::parse(text).and_then(|port| HilRig::open(&port)).map_err(refused())?),
        Port::Comedi(text) => {
            Box::new(ComediPort::parse(text).and_then(|port| ComediRig::open(&port)).map_err(refused())?)
        }
    })
}

/// A number by which a run or a process is told from every other: the time, and this process.
pub fn unlike_any_other() -> u64 {
    now_unix_ns() ^ (u64::from(process::id()) << 40)
}

/// Now, since 1970 [ns].
pub fn now_unix_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}
