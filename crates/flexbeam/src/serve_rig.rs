//! `flexbeam rig`: the simulated rig as a process of its own, behind UDP or a serial line.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use flexbeam_files::{ServeResult, json_text};
use flexbeam_rig::SimulatedRig;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::serial::SerialWire;
use flexbeam_runtime::served_rig::{OnSession, ServeOptions, ServedReport, serve};
use flexbeam_runtime::udp::UdpRigWire;
use flexbeam_runtime::wire::Wire;
use flexbeam_runtime::{LOOP_PRIORITY, Standing};

use crate::on_rig::asked_by_signal;
use crate::output::say;
use crate::port::{port, unlike_any_other};
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};

/// Below a loop on the same machine, so that the loop's clock comes first.
const RIG_PRIORITY: i32 = LOOP_PRIORITY - 10;

/// Thirty years, which a duration of the system holds.
const LONGEST_S: f64 = 1e9;

/// A duration that is none.
#[derive(Debug, thiserror::Error)]
#[error(
    "found --duration {0} s, needed a positive number, 10^9 at most\nhint: without --duration it serves until it is stopped"
)]
struct NoDuration(f64);

/// A place at which no rig can listen.
#[derive(Debug, thiserror::Error)]
#[error(
    "found --listen {0}, needed udp:ADDRESS:PORT, pty or serial:DEVICE[:BAUD]\nhint: --listen udp:127.0.0.1:4810 serves this machine"
)]
struct NoPlace(String);

/// Runs the command.
pub fn run(arguments: &cli::ServeRig) -> Result<(), Failure> {
    let parameters = rig_parameters(arguments.rig.as_deref())?;
    let rig = SimulatedRig::new(&parameters, arguments.seed).map_err(Failure::while_trying("simulate the rig"))?;
    let stop = asked_by_signal()?;
    match arguments.duration {
        Some(duration_s) if duration_s > 0.0 && duration_s <= LONGEST_S => stop_after(duration_s, stop.clone()),
        Some(duration_s) => return Err(Failure::while_trying("serve the rig")(NoDuration(duration_s))),
        None => {}
    }
    let report = if arguments.listen == "pty" {
        let (wire, device) = SerialWire::pseudo_terminal().map_err(Failure::while_trying("serve the rig"))?;
        served(rig, wire, &format!("serial:{}", device.display()), arguments, &stop)?
    } else {
        match port(&arguments.listen)? {
            Port::Udp { host, port } => {
                let wire =
                    UdpRigWire::bind(&format!("{host}:{port}")).map_err(Failure::while_trying("serve the rig"))?;
                served(rig, wire, &arguments.listen, arguments, &stop)?
            }
            Port::Serial { device, baud } => {
                let wire = SerialWire::open(&device, baud).map_err(Failure::while_trying("serve the rig"))?;
                served(rig, wire, &arguments.listen, arguments, &stop)?
            }
            _ => return Err(Failure::while_trying("serve the rig")(NoPlace(arguments.listen.clone()))),
        }
    };
    answer(arguments, &report);
    Ok(())
}

fn stop_after(duration_s: f64, stop: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs_f64(duration_s));
        stop.store(true, Ordering::Release);
    });
}

fn served(
    rig: SimulatedRig,
    mut wire: impl Wire,
    place: &str,
    arguments: &cli::ServeRig,
    stop: &AtomicBool,
) -> Result<ServedReport, Failure> {
    let on_session = if arguments.carry_on { OnSession::Carry } else { OnSession::Reset };
    let options = ServeOptions { on_session, boots: unlike_any_other() as u32 };
    // A rig that answers late looks like one that lost a frame. What is refused costs only that.
    Standing::claim(RIG_PRIORITY, None);
    say(format_args!("the rig listens at {place}; Ctrl-C ends it"));
    serve(rig, &mut wire, options, stop).map_err(|error| Failure::Fault(Box::new(error)))
}

fn answer(arguments: &cli::ServeRig, report: &ServedReport) {
    let counts = report.counts;
    if arguments.json {
        let truth = report.rig.truth();
        println!(
            "{}",
            json_text(&ServeResult {
                runs: counts.runs,
                answered: counts.answered,
                repeated: counts.repeated,
                ignored: counts.ignored,
                malformed: counts.malformed,
                timed_out: counts.timed_out,
                theta_rad: truth.theta_rad,
                alpha_rad: truth.alpha_rad,
            })
        );
    } else {
        println!(
            "{} runs, {} commands answered; {} twice, {} ignored, {} malformed; timed out {} times",
            counts.runs, counts.answered, counts.repeated, counts.ignored, counts.malformed, counts.timed_out
        );
    }
}
