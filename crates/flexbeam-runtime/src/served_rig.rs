//! The simulated rig on the other side of a wire: what a real rig's firmware does, done by a process.
//!
//! Enters: a simulated rig, a wire. Leaves: answers, and at the end a report. While a run lasts, the rig's time is the host's:
//! the command of instant k is answered with the sensors of instant k, and then its voltage stands for a period, or for n of
//! them where the next command is that of k + n. Nothing lost, the loop over the wire gives the bits of
//! [`flexbeam_rig::closed_loop`]. While no run lasts, the beam swings on at 0 V by the wall clock.
//! Deliberately absent: which command is obeyed ([`crate::rig_side`]).

mod beam;

use crate::rig_side::{Decision, Passed, Phase, RigSide};
use crate::wire::{Broken, FrameBuffer, LONGEST_FRAME, Received, Wire, wait};
use beam::Beam;
use flexbeam_files::frame::{Command, FrameError, is_command};
use flexbeam_rig::SimulatedRig;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often the rig looks at its clock.
const TICK: Duration = Duration::from_millis(1);

/// Commands that are taken between two looks at the clock, at most: a flood must not hold up the time-out.
const MOST_PER_TICK: usize = 64;

/// How the served rig behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServeOptions {
    /// What a new session does to the beam. Default [`OnSession::Reset`].
    pub on_session: OnSession,
    /// The number by which a host tells this process from an earlier one. Default 0.
    pub boots: u32,
}

/// What happens to the beam when a run begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnSession {
    /// Back to rest, with the same noise as from the start, so that runs repeat.
    Reset,
    /// The beam goes on from where it is, as a real one does.
    Carry,
}

impl Default for ServeOptions {
    /// Real-time: no.
    fn default() -> ServeOptions {
        ServeOptions { on_session: OnSession::Reset, boots: 0 }
    }
}

/// What was done for hosts.
#[derive(Clone, Debug)]
pub struct ServedReport {
    /// The rig, as it stands at the end.
    pub rig: SimulatedRig,
    /// How often what was done.
    pub counts: Counts,
}

/// Counts of a served rig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Runs that began.
    pub runs: u64,
    /// Commands that were answered with new readings, greetings and stops among them.
    pub answered: u64,
    /// Commands that came twice.
    pub repeated: u64,
    /// Commands older than the newest, or of another session.
    pub ignored: u64,
    /// Frames that could not be read.
    pub malformed: u64,
    /// Times that the rig took itself to 0 V.
    pub timed_out: u64,
}

/// Why a served rig ended by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ServeError {
    /// The wire broke.
    #[error(
        "tried to read commands for the served rig, found its line broken (system error {errno}), needed a line that \
         stands\nhint: plug the device in again and start the rig anew"
    )]
    Line {
        /// The system's error number.
        errno: i32,
    },
}

impl From<Broken> for ServeError {
    /// Real-time: no.
    fn from(broken: Broken) -> ServeError {
        ServeError::Line { errno: broken.errno }
    }
}

/// Real-time: no. Serves hosts, one after the other, until `stop` is set.
///
/// Assumes: hosts run at the rig's sample period.
/// Errors: [`ServeError::Line`]; over UDP never.
pub fn serve(
    rig: SimulatedRig,
    wire: &mut impl Wire,
    options: ServeOptions,
    stop: &AtomicBool,
) -> Result<ServedReport, ServeError> {
    let mut served = Served::new(rig, options);
    let mut buffer = [0; LONGEST_FRAME];
    while !stop.load(Ordering::Acquire) {
        wait(wire.descriptor(), TICK);
        served.tick();
        served.take_in(wire, &mut buffer)?;
    }
    Ok(served.report())
}

/// A rig that is being served.
struct Served {
    on_session: OnSession,
    side: RigSide,
    beam: Beam,
    counts: Counts,
    started: Instant,
}

impl Served {
    /// Real-time: no.
    fn new(rig: SimulatedRig, options: ServeOptions) -> Served {
        Served {
            on_session: options.on_session,
            side: RigSide::new(options.boots),
            beam: Beam::new(rig),
            counts: Counts::default(),
            started: Instant::now(),
        }
    }

    /// Real-time: no.
    fn report(self) -> ServedReport {
        ServedReport { rig: self.beam.rig, counts: self.counts }
    }

    /// Real-time: no. The rig's clock [ms], modulo 2^32.
    fn now_ms(&self) -> u32 {
        self.started.elapsed().as_millis() as u32
    }

    /// Real-time: no.
    fn tick(&mut self) {
        let before = self.side.phase();
        self.side.on_tick(self.now_ms());
        self.rest_after(before);
        self.beam.follow_the_wall_clock();
    }

    /// Real-time: no. When a run has ended, whichever way, so has its voltage.
    fn rest_after(&mut self, before: Phase) {
        let now = self.side.phase();
        if before == Phase::Running && now != Phase::Running {
            self.counts.timed_out += u64::from(now == Phase::TimedOut);
            self.beam.rest();
        }
    }

    /// Real-time: no. Answers what lies in the wire.
    fn take_in(&mut self, wire: &mut impl Wire, buffer: &mut FrameBuffer) -> Result<(), ServeError> {
        for _ in 0..MOST_PER_TICK {
            let Received::Frame(length) = wire.receive(buffer)? else { break };
            let bytes = buffer.get(..length).unwrap_or_default();
            match Command::decode(bytes) {
                Ok(command) => self.on_command(&command, wire)?,
                Err(_) => self.on_malformed(bytes, wire)?,
            }
        }
        Ok(())
    }

    /// Real-time: no. Only a command of another version gets an answer.
    fn on_malformed(&mut self, bytes: &[u8], wire: &impl Wire) -> Result<(), ServeError> {
        self.counts.malformed += 1;
        match self.side.on_other_version().filter(|_| is_other_version(bytes)) {
            Some(answer) => Ok(wire.send(&answer.encode())?),
            None => Ok(()),
        }
    }

    /// Real-time: no. The answer goes out before the period that follows it is computed.
    fn on_command(&mut self, command: &Command, wire: &impl Wire) -> Result<(), ServeError> {
        let before = self.side.phase();
        let decision = self.side.on_command(command, self.now_ms());
        self.rest_after(before);
        match decision {
            Decision::Older | Decision::Foreign => self.counts.ignored += 1,
            Decision::Repeat(reply) => {
                self.counts.repeated += 1;
                wire.send(&reply.encode())?;
            }
            Decision::Read(passed) => {
                self.pass(passed);
                let sensors = self.beam.measure();
                let reply = self.side.answer(command, sensors.theta_rad, sensors.alpha_rad, 0);
                self.counts.answered += 1;
                wire.send(&reply.encode())?;
                self.hold(passed);
            }
        }
        Ok(())
    }

    /// Real-time: no. The periods up to this command, the first of which is over already.
    fn pass(&mut self, passed: Passed) {
        match passed {
            Passed::Nothing => {}
            Passed::Began => {
                self.counts.runs += 1;
                if self.on_session == OnSession::Reset {
                    self.beam.rig.reset();
                }
            }
            Passed::Periods(periods) => self.beam.stand(u64::from(periods).saturating_sub(1)),
        }
    }

    /// Real-time: no. The period that this command begins.
    fn hold(&mut self, passed: Passed) {
        if passed != Passed::Nothing {
            self.beam.hold(self.side.voltage_v(), self.side.hold_ms());
        }
    }
}

/// Real-time: no.
fn is_other_version(bytes: &[u8]) -> bool {
    matches!(Command::decode(bytes), Err(FrameError::Version { .. })) && is_command(bytes)
}
