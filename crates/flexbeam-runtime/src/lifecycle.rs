//! The life of a run: configured, armed, running, stopped or faulted; nothing else, and no way back.
//!
//! A run that ended is not started again: arming anew is a new run, with its own zero and its own recording.

/// Where a run stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// Everything is chosen, nothing moves, no thread runs.
    #[default]
    Configured = 0,
    /// The loop runs on its clock and reads the sensors; the voltage is 0 V.
    Armed = 1,
    /// The controller drives the rig.
    Running = 2,
    /// Ended as asked for; 0 V.
    Stopped = 3,
    /// Ended by a fault; 0 V.
    Faulted = 4,
}

/// What may happen to a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The loop's thread starts.
    Arm,
    /// The controller takes over.
    Start,
    /// Asked to end, or its time is over.
    Stop,
    /// Something that ends every run at 0 V.
    Fault,
}

impl Phase {
    /// All of them, in the order of life.
    pub const ALL: [Phase; 5] = [Phase::Configured, Phase::Armed, Phase::Running, Phase::Stopped, Phase::Faulted];

    /// Real-time: yes. The phase after `event`; nothing where the event cannot happen.
    pub fn after(self, event: Event) -> Option<Phase> {
        match (self, event) {
            (Phase::Configured, Event::Arm) => Some(Phase::Armed),
            (Phase::Armed, Event::Start) => Some(Phase::Running),
            (Phase::Armed | Phase::Running, Event::Stop) => Some(Phase::Stopped),
            (Phase::Armed | Phase::Running, Event::Fault) => Some(Phase::Faulted),
            _ => None,
        }
    }

    /// Real-time: yes. Whether the loop's thread is at work.
    pub fn is_alive(self) -> bool {
        matches!(self, Phase::Armed | Phase::Running)
    }

    /// Real-time: yes. The phase with this number.
    pub fn of(number: u8) -> Option<Phase> {
        Phase::ALL.get(usize::from(number)).copied()
    }

    /// In a word, for people.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Configured => "configured",
            Phase::Armed => "armed",
            Phase::Running => "running",
            Phase::Stopped => "stopped",
            Phase::Faulted => "fault",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_transition_is_the_one_of_the_table() {
        use Event::{Arm, Fault, Start, Stop};
        use Phase::{Armed, Configured, Faulted, Running, Stopped};
        let none = None;
        let table = [
            (Configured, [Some(Armed), none, none, none]),
            (Armed, [none, Some(Running), Some(Stopped), Some(Faulted)]),
            (Running, [none, none, Some(Stopped), Some(Faulted)]),
            (Stopped, [none; 4]),
            (Faulted, [none; 4]),
        ];
        for (phase, after) in table {
            assert_eq!([Arm, Start, Stop, Fault].map(|event| phase.after(event)), after, "{phase:?}");
        }
        assert_eq!(table.map(|(phase, _)| phase), Phase::ALL);
    }

    #[test]
    fn numbers_and_phases_belong_together() {
        for (number, phase) in Phase::ALL.into_iter().enumerate() {
            assert_eq!((phase as usize, Phase::of(number as u8)), (number, Some(phase)));
        }
        assert_eq!(Phase::of(5), None);
    }
}
