//! The host's side of the frame's protocol, without any wire: what to send, and what an answer is worth.
//!
//! Enters: instants, voltages, frames as they came. Leaves: commands, readings, faults, counts.
//! Deliberately absent: sockets, lines, the clock.

use crate::back_end::{Counters, LinkFault};
use flexbeam_files::frame::{self, Command, FrameError, VERSION, is_sealed};
use flexbeam_rig::Measurement;

/// Greetings of a session carry the sequences that lead up to 0: the last of them 2^32 - 1.
pub const GREETINGS: u32 = 50;

/// How many instants back an answer is told from its double.
const REMEMBERED: u32 = u64::BITS;

/// One session of a host with a rig.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exchange {
    session: u32,
    hold_ms: u16,
    boots: u32,
    /// Instant of the last command.
    instant: u64,
    /// Bit b: the command of b instants before the last was answered.
    answered: u64,
    counters: Counters,
}

/// What came back on a greeting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Greeted {
    /// The rig is there.
    Answered,
    /// Something of another version is.
    Version(u8),
    /// Bytes that cannot be read.
    Unreadable,
    /// A frame of another session.
    Foreign,
}

impl Exchange {
    /// Real-time: no. A session that has not greeted its rig yet.
    pub fn new(session: u32, hold_ms: u16) -> Exchange {
        Exchange { session, hold_ms, ..Exchange::default() }
    }

    /// Real-time: no. 0 V, `left` greetings before instant 0.
    pub fn greeting(&self, left: u32) -> Command {
        self.frame(0_u32.wrapping_sub(left), 0, 0.0)
    }

    /// Real-time: no. Judges what came while greetings were out; an answer tells how often the rig has started.
    pub fn greeted(&mut self, bytes: &[u8]) -> Greeted {
        match frame::Measurement::decode(bytes) {
            Ok(answer) if answer.session == self.session => {
                self.boots = answer.boots;
                Greeted::Answered
            }
            Ok(_) | Err(FrameError::Kind { .. }) => Greeted::Foreign,
            Err(FrameError::Version { found }) if is_sealed(bytes) => Greeted::Version(found),
            Err(_) => Greeted::Unreadable,
        }
    }

    /// Real-time: yes. The command of this instant.
    pub fn command(&mut self, instant: u64, voltage_v: f64) -> Command {
        let passed = u32::try_from(instant.saturating_sub(self.instant)).unwrap_or(REMEMBERED);
        self.answered = self.answered.checked_shl(passed).unwrap_or(0);
        self.instant = instant;
        self.frame(instant as u32, 0, voltage_v)
    }

    /// Real-time: yes. What holds the rig at 0 V until the next session.
    pub fn stop(&self) -> Command {
        stop(self.session, self.instant as u32)
    }

    /// Real-time: yes.
    fn frame(&self, sequence: u32, flags: u16, voltage_v: f64) -> Command {
        Command { session: self.session, sequence, hold_ms: self.hold_ms, flags, voltage_v }
    }

    /// Real-time: yes. The readings, when this frame is the first answer to the last command; otherwise it is counted.
    ///
    /// Errors: what the rig says of itself, or a version that this program does not speak.
    pub fn hear(&mut self, bytes: &[u8]) -> Result<Option<Measurement>, LinkFault> {
        match frame::Measurement::decode(bytes) {
            Ok(answer) if answer.session == self.session => {
                self.state_of_rig(&answer)?;
                Ok(self.is_awaited(answer.sequence).then(|| readings(&answer)))
            }
            Ok(_) | Err(FrameError::Kind { .. }) => {
                self.counters.foreign += 1;
                Ok(None)
            }
            // One flipped bit in the version byte must not end a run: the check sum says which it is.
            Err(FrameError::Version { found }) if is_sealed(bytes) => Err(LinkFault::Version { found, known: VERSION }),
            Err(_) => {
                self.counters.corrupt += 1;
                Ok(None)
            }
        }
    }

    /// Real-time: yes. A restarted rig knows of no time-out, so the restart is looked for first.
    fn state_of_rig(&self, answer: &frame::Measurement) -> Result<(), LinkFault> {
        let says = |bit: u32| answer.status & bit != 0;
        if answer.boots != self.boots {
            Err(LinkFault::RigRestarted)
        } else if says(frame::Measurement::TIMED_OUT) {
            Err(LinkFault::RigTimedOut)
        } else if says(frame::Measurement::STOPPED) {
            Err(LinkFault::CutOff)
        } else {
            Ok(())
        }
    }

    /// Real-time: yes. Whether `sequence` is the last command's and comes for the first time; the rest is counted.
    fn is_awaited(&mut self, sequence: u32) -> bool {
        let back = (self.instant as u32).wrapping_sub(sequence);
        if back > i32::MAX as u32 {
            // An answer to what was not asked yet.
            self.counters.foreign += 1;
            return false;
        }
        if u64::from(back) > self.instant {
            // A greeting's, from before the run.
            return false;
        }
        let bit = 1_u64.checked_shl(back).unwrap_or(0);
        let again = self.answered & bit != 0;
        self.answered |= bit;
        self.counters.duplicate += u64::from(again);
        self.counters.late += u64::from(!again && back > 0);
        !again && back == 0
    }

    /// Real-time: yes.
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Real-time: yes. An exchange has ended without its answer.
    pub fn lost(&mut self) {
        self.counters.lost += 1;
    }

    /// Real-time: yes.
    pub fn counters(&self) -> Counters {
        self.counters
    }
}

/// Real-time: yes. Stops the rig in this session.
pub(crate) fn stop(session: u32, sequence: u32) -> Command {
    Command { session, sequence, hold_ms: 0, flags: Command::STOP, voltage_v: 0.0 }
}

/// Real-time: yes. A broken sensor's angles are made undefined, so that the kernel stops on them.
fn readings(answer: &frame::Measurement) -> Measurement {
    if answer.status & frame::Measurement::SENSOR_FAULT != 0 {
        return Measurement { theta_rad: f64::NAN, alpha_rad: f64::NAN };
    }
    Measurement { theta_rad: answer.theta_rad, alpha_rad: answer.alpha_rad }
}
