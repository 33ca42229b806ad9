//! What stands between the loop and a rig: one trait, the faults that may come through it, and its counters.
//!
//! Enters: a voltage once a period. Leaves: the sensors of the same instant. Deliberately absent: the clock of the loop;
//! who decides the voltage.

use flexbeam_rig::Measurement;

/// A rig, as the loop sees it.
///
/// The loop has one period of delay: [`BackEnd::exchange`] at instant k sends the voltage that tick k - 1 computed, which acts
/// from now on, and reads the sensors of now. Only the loop's thread calls these functions, so there is one writer of voltages;
/// the watchdog holds a [`Cutoff`], which can only take the voltage away.
pub trait BackEnd: Send {
    /// Real-time: yes. `voltage_v` goes out, the sensors come in. `instant` counts periods since the run began; it grows by more
    /// than one where the loop missed periods, during which the last voltage stood.
    ///
    /// Returns within `wait_s` of [`BackEnd::prepare`], with [`Answer::Lost`] when no valid answer came in that time.
    /// Errors: what ends the run. The loop then calls [`BackEnd::zero`] at once.
    fn exchange(&mut self, instant: u64, voltage_v: f64) -> Result<Answer, LinkFault>;

    /// Real-time: yes. 0 V, now, whatever the state. Called at the end of every run, at every fault, and once more when the
    /// loop's thread unwinds. Must not block longer than `wait_s`.
    ///
    /// Errors: the rig could not be reached; its own watchdog then decides.
    fn zero(&mut self) -> Result<(), LinkFault>;

    /// Real-time: no. Before the first exchange of a run: the period, how long one exchange may wait for an answer, and for how
    /// long one voltage may stand before the rig (or its board) is to take itself to 0 V.
    ///
    /// Errors: the rig does not answer, or answers as something else ([`OpenError`]).
    fn prepare(&mut self, timing: Timing) -> Result<(), OpenError>;

    /// Real-time: no. A handle by which another thread takes the voltage to zero when the loop's thread hangs inside
    /// [`BackEnd::exchange`]; nothing where the board has its own watchdog or the rig its own time-out and no second road.
    fn cutoff(&self) -> Option<Box<dyn Cutoff>>;

    /// Real-time: yes. What was counted since [`BackEnd::prepare`].
    fn counters(&self) -> Counters;

    /// Real-time: no. The largest motor voltage that it can send, either way [V].
    fn reach_v(&self) -> f64 {
        f64::INFINITY
    }

    /// Real-time: no. For messages and recordings: `udp:192.168.1.7:4810`.
    fn name(&self) -> String;

    /// Real-time: no. A fault in the words of whoever reported it (a board's own error text).
    fn explain(&self, fault: LinkFault) -> String {
        fault.to_string()
    }
}

/// Takes the voltage to zero, and can do nothing else.
pub trait Cutoff: Send {
    /// 0 V; afterwards the back end refuses every other voltage ([`LinkFault::CutOff`]) until it is prepared again.
    fn cut(&self);
}

/// The clock of a run, as a back end needs to know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Sample period [s].
    pub period_s: f64,
    /// Longest wait for an answer in one exchange [s].
    pub wait_s: f64,
    /// Longest time that one voltage may stand without a new command [s].
    pub hold_s: f64,
}

/// What came back at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The sensors of this instant.
    Fresh(Measurement),
    /// Nothing valid in time.
    Lost,
}

/// Why a back end ends a run. Plain numbers, so that it is made without allocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkFault {
    /// The other side is gone: connection refused, device unplugged.
    #[error("the rig is gone: its port is closed or its device was unplugged (system error {errno})")]
    Gone {
        /// The system's error number.
        errno: i32,
    },
    /// A frame of another version.
    #[error("the rig speaks frame version {found}, this program version {known}")]
    Version {
        /// Version found.
        found: u8,
        /// Version of this program.
        known: u8,
    },
    /// The rig says that it took itself to 0 V because no command came in time.
    #[error("the rig took itself to 0 V: it had waited too long for a command")]
    RigTimedOut,
    /// The rig says that it restarted within the run: its zero is not the one that was homed.
    #[error("the rig restarted within the run, so its zero is no longer the one that was found")]
    RigRestarted,
    /// The board's library refused a call.
    #[error("the board's library answered {code}")]
    Board {
        /// Its error code.
        code: i32,
    },
    /// The voltage was cut off: by the watchdog, or by another hand at the rig.
    #[error("the voltage was cut off, by the watchdog or by another hand at the rig")]
    CutOff,
}

/// A back end that cannot be opened or prepared. Text, because nothing moves yet.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found}, needed {needed}\nhint: {hint}")]
pub struct OpenError {
    /// What was found.
    pub found: String,
    /// What was needed.
    pub needed: String,
    /// What to do about it.
    pub hint: String,
}

/// What a link lost or threw away. All zero for a rig in the process and for boards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Exchanges without a valid answer in time.
    pub lost: u64,
    /// Answers that came for an earlier instant, thrown away.
    pub late: u64,
    /// Answers that came twice, the second thrown away.
    pub duplicate: u64,
    /// Frames whose check sum or length was wrong.
    pub corrupt: u64,
    /// Frames of another run or another program.
    pub foreign: u64,
}
