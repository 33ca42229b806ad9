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

#[cfg(test)]
mod tests {
    use super::*;

    const SESSION: u32 = 9;
    const BOOTS: u32 = 4;

    fn answer(sequence: u32) -> frame::Measurement {
        let theta_rad = f64::from(sequence);
        frame::Measurement { session: SESSION, sequence, status: 0, theta_rad, alpha_rad: -theta_rad, boots: BOOTS }
    }

    fn greeted() -> Exchange {
        let mut exchange = Exchange::new(SESSION, 50);
        assert_eq!(exchange.greeted(&answer(exchange.greeting(7).sequence).encode()), Greeted::Answered);
        exchange
    }

    fn theta_rad(heard: Result<Option<Measurement>, LinkFault>) -> Option<f64> {
        heard.unwrap().map(|measurement| measurement.theta_rad)
    }

    #[test]
    fn an_answer_counts_once_and_only_for_its_instant() {
        let mut exchange = greeted();
        for instant in 0..3 {
            exchange.command(instant, 1.0);
        }
        assert_eq!(theta_rad(exchange.hear(&answer(0).encode())), None);
        assert_eq!(theta_rad(exchange.hear(&answer(2).encode())), Some(2.0));
        assert_eq!(theta_rad(exchange.hear(&answer(2).encode())), None);
        exchange.command(4, 1.0);
        for sequence in [0, 1, 2, 5] {
            assert_eq!(theta_rad(exchange.hear(&answer(sequence).encode())), None);
        }
        let counters = Counters { late: 2, duplicate: 3, foreign: 1, ..Counters::default() };
        assert_eq!(exchange.counters(), counters);
        assert_eq!(theta_rad(exchange.hear(&answer(4).encode())), Some(4.0));
    }

    #[test]
    fn a_late_answer_that_comes_twice_is_late_once() {
        let mut exchange = greeted();
        exchange.command(0, 0.0);
        exchange.command(63, 0.0);
        assert_eq!(theta_rad(exchange.hear(&answer(0).encode())), None);
        assert_eq!(theta_rad(exchange.hear(&answer(0).encode())), None);
        assert_eq!(exchange.counters(), Counters { late: 1, duplicate: 1, ..Counters::default() });
        exchange.command(1 << 40, 0.0);
        assert_eq!(theta_rad(exchange.hear(&answer(0).encode())), Some(0.0), "2^40 is sequence 0 again");
    }

    #[test]
    fn answers_to_greetings_are_no_part_of_the_run() {
        let mut exchange = greeted();
        exchange.command(0, 0.0);
        assert_eq!(theta_rad(exchange.hear(&answer(exchange.greeting(6).sequence).encode())), None);
        assert_eq!(exchange.counters(), Counters::default());
    }

    #[test]
    fn what_is_not_ours_is_counted_and_what_is_damaged_too() {
        let mut exchange = greeted();
        let own_command = exchange.command(0, 0.0).encode();
        let mut damaged = answer(0).encode();
        damaged[20] ^= 1;
        let mut seeming_version = answer(0).encode();
        seeming_version[2] = 3;
        let other_session = frame::Measurement { session: SESSION + 1, ..answer(0) }.encode();
        for bytes in [&own_command[..], &damaged, &seeming_version, &other_session, b"hello", b""] {
            assert_eq!(exchange.hear(bytes), Ok(None));
        }
        assert_eq!(exchange.counters(), Counters { corrupt: 4, foreign: 2, ..Counters::default() });
    }

    #[test]
    fn a_true_frame_of_another_version_ends_the_run() {
        let mut exchange = greeted();
        let mut bytes = vec![b'F', b'B', 2, 2, 1, 2, 3];
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        assert_eq!(exchange.hear(&bytes), Err(LinkFault::Version { found: 2, known: VERSION }));
        assert_eq!(exchange.greeted(&bytes), Greeted::Version(2));
    }

    #[test]
    fn the_rig_s_own_word_ends_the_run_even_when_it_is_late() {
        let faults = [
            (frame::Measurement { boots: BOOTS + 1, status: 1, ..answer(0) }, LinkFault::RigRestarted),
            (frame::Measurement { status: frame::Measurement::TIMED_OUT, ..answer(0) }, LinkFault::RigTimedOut),
            (frame::Measurement { status: frame::Measurement::STOPPED, ..answer(0) }, LinkFault::CutOff),
        ];
        for (answer, fault) in faults {
            for instant in [0, 1] {
                let mut exchange = greeted();
                exchange.command(instant, 0.0);
                assert_eq!(exchange.hear(&answer.encode()), Err(fault));
            }
        }
    }

    #[test]
    fn a_broken_sensor_s_angles_reach_the_kernel_undefined_and_others_as_they_are() {
        let mut exchange = greeted();
        exchange.command(0, 0.0);
        let broken = frame::Measurement { status: frame::Measurement::SENSOR_FAULT, ..answer(0) };
        let heard = exchange.hear(&broken.encode()).unwrap().unwrap();
        assert!(heard.theta_rad.is_nan() && heard.alpha_rad.is_nan());
        exchange.command(1, 0.0);
        let undefined = frame::Measurement { theta_rad: f64::NAN, ..answer(1) };
        let heard = exchange.hear(&undefined.encode()).unwrap().unwrap();
        assert!(heard.theta_rad.is_nan() && heard.alpha_rad == -1.0);
    }

    #[test]
    fn the_sequence_wraps_and_greetings_lead_up_to_it() {
        let mut exchange = greeted();
        assert_eq!(exchange.greeting(1).sequence, u32::MAX);
        exchange.command(u64::from(u32::MAX), 0.0);
        assert_eq!(exchange.command(1 << 32, 2.5).sequence, 0);
        assert_eq!(theta_rad(exchange.hear(&answer(u32::MAX).encode())), None);
        assert_eq!(exchange.counters().late, 1);
        assert_eq!(theta_rad(exchange.hear(&answer(0).encode())), Some(0.0));
    }
}
