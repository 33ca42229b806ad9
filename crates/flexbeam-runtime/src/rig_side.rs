//! The rig's side of the frame's protocol: which commands are obeyed, and when the rig goes to 0 V by itself.
//!
//! Enters: commands, the rig's clock, readings. Leaves: the voltage that stands, and what to answer. The same machine in C for a
//! microcontroller is `firmware/flexbeam_frame.c`; a test drives both with the same frames.
//! Deliberately absent: wires, sensors, the motor.
//!
//! A session begins when the rig is greeted: commands of an unknown session whose sequences lie in the upper half of 2^32,
//! which count up to 0. They carry no voltage, and nothing moves. The first sequence of the lower half begins the run. In a
//! run the newest sequence wins, by the sign of the difference modulo 2^32.

use flexbeam_files::frame::{Command, Measurement};

/// One rig, and whom it obeys.
#[derive(Clone, Copy, Debug)]
pub struct RigSide {
    boots: u32,
    session: u32,
    phase: Phase,
    /// The newest sequence of the session.
    sequence: u32,
    voltage_v: f64,
    hold_ms: u16,
    /// When the voltage was commanded, on the rig's clock [ms].
    since_ms: u32,
    reply: Option<Measurement>,
}

/// Where a rig is in its session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Nobody has greeted it since it started.
    Idle,
    /// Greeted, and not moving yet.
    Greeted,
    /// Holding voltages.
    Running,
    /// At 0 V since no command came in time.
    TimedOut,
    /// At 0 V since a stop command came.
    Stopped,
}

/// What to do about a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// Nothing: it is older than one that was obeyed.
    Older,
    /// Nothing: it belongs to another session, of an earlier run or of a host that has been replaced.
    Foreign,
    /// Send the same answer again: it came twice.
    Repeat(Measurement),
    /// Read the sensors and [`RigSide::answer`].
    Read(Passed),
}

/// What passed on the host's clock since the command before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passed {
    /// Nothing that counts: the rig does not run.
    Nothing,
    /// All that came before the run, which begins here; instants of it that are over already were spent at rest.
    Began,
    /// The voltage before stood for so many periods.
    Periods(u32),
}

impl RigSide {
    /// Real-time: yes. At 0 V. `boots` is a number that no earlier start of this rig has had.
    pub fn new(boots: u32) -> RigSide {
        RigSide {
            boots,
            session: 0,
            phase: Phase::Idle,
            sequence: 0,
            voltage_v: 0.0,
            hold_ms: 0,
            since_ms: 0,
            reply: None,
        }
    }

    /// Real-time: yes. The voltage that the motor is to have now [V].
    pub fn voltage_v(&self) -> f64 {
        self.voltage_v
    }

    /// Real-time: yes.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Real-time: yes. How long the voltage may stand [ms].
    pub fn hold_ms(&self) -> u16 {
        self.hold_ms
    }

    /// Real-time: yes. To be called at least every few milliseconds. `now_ms` is the rig's clock, modulo 2^32.
    pub fn on_tick(&mut self, now_ms: u32) {
        let stood_ms = now_ms.wrapping_sub(self.since_ms);
        if self.phase == Phase::Running && stood_ms > u32::from(self.hold_ms) {
            self.rest(Phase::TimedOut);
        }
    }

    /// Real-time: yes. Obeys the command or not, and says what to do about it.
    pub fn on_command(&mut self, command: &Command, now_ms: u32) -> Decision {
        self.on_tick(now_ms);
        let greets = command.sequence > i32::MAX as u32;
        if self.phase == Phase::Idle || command.session != self.session {
            return self.stranger(command, greets);
        }
        if command.stops() {
            self.rest(Phase::Stopped);
            return Decision::Read(Passed::Nothing);
        }
        match self.phase {
            Phase::Greeted if greets => Decision::Read(Passed::Nothing),
            Phase::Greeted => {
                self.phase = Phase::Running;
                self.obey(command, now_ms);
                Decision::Read(Passed::Began)
            }
            _ => self.known(command, now_ms),
        }
    }

    /// Real-time: yes. Only a greeting opens a session: a straggler of an earlier one neither moves the rig nor ends the run.
    /// A rig that nobody has greeted answers all the same, so that a host in its run learns that the rig has restarted.
    fn stranger(&mut self, command: &Command, greets: bool) -> Decision {
        if greets && !command.stops() {
            self.session = command.session;
            self.sequence = command.sequence;
            self.reply = None;
            self.rest(Phase::Greeted);
            return Decision::Read(Passed::Nothing);
        }
        if self.phase == Phase::Idle { Decision::Read(Passed::Nothing) } else { Decision::Foreign }
    }

    /// Real-time: yes. A command of a session that has begun, or has ended.
    fn known(&mut self, command: &Command, now_ms: u32) -> Decision {
        let ahead = command.sequence.wrapping_sub(self.sequence);
        if ahead > i32::MAX as u32 {
            return Decision::Older;
        }
        match (ahead, self.reply) {
            (0, Some(reply)) => Decision::Repeat(reply),
            _ if self.phase == Phase::Running => {
                self.obey(command, now_ms);
                Decision::Read(Passed::Periods(ahead))
            }
            _ => {
                self.sequence = command.sequence;
                Decision::Read(Passed::Nothing)
            }
        }
    }

    /// Real-time: yes. An undefined voltage is none.
    fn obey(&mut self, command: &Command, now_ms: u32) {
        self.sequence = command.sequence;
        self.voltage_v = if command.voltage_v.is_finite() { command.voltage_v } else { 0.0 };
        self.hold_ms = command.hold_ms;
        self.since_ms = now_ms;
    }

    /// Real-time: yes.
    fn rest(&mut self, phase: Phase) {
        self.phase = phase;
        self.voltage_v = 0.0;
    }

    /// Real-time: yes. The answer to a command that was to be read for; `sensor_fault` is 0 or
    /// [`Measurement::SENSOR_FAULT`].
    pub fn answer(&mut self, command: &Command, theta_rad: f64, alpha_rad: f64, sensor_fault: u32) -> Measurement {
        let reply = Measurement {
            session: command.session,
            sequence: command.sequence,
            status: self.status() | sensor_fault,
            theta_rad,
            alpha_rad,
            boots: self.boots,
        };
        if self.phase != Phase::Idle && command.sequence == self.sequence {
            self.reply = Some(reply);
        }
        reply
    }

    /// Real-time: yes. What a command of another version is answered with, so that its host learns ours; nothing while a run
    /// lasts.
    pub fn on_other_version(&self) -> Option<Measurement> {
        let answer = Measurement {
            session: 0,
            sequence: 0,
            status: self.status(),
            theta_rad: 0.0,
            alpha_rad: 0.0,
            boots: self.boots,
        };
        (self.phase != Phase::Running).then_some(answer)
    }

    /// Real-time: yes. A rig that nobody has greeted says so to a host that thinks otherwise, though it counts no starts.
    fn status(&self) -> u32 {
        match self.phase {
            Phase::Greeted | Phase::Running => 0,
            Phase::Idle | Phase::TimedOut => Measurement::TIMED_OUT,
            Phase::Stopped => Measurement::STOPPED,
        }
    }
}
