//! What has happened in the run, for viewers who come later, too.

use flexbeam_files::{RunEvent, RunResult};
use std::collections::VecDeque;

/// Events that are kept: the newest.
const MOST_EVENTS: usize = 1024;

/// Beginning, events and end of a run.
#[derive(Default)]
pub(super) struct Chronicle {
    /// Tick 0, in ns since 1970-01-01 UTC; 0 before there is one.
    pub(super) start_unix_ns: u64,
    events: VecDeque<RunEvent>,
    /// Events ever.
    count: u64,
    pub(super) result: Option<RunResult>,
}

impl Chronicle {
    pub(super) fn push(&mut self, event: RunEvent) {
        if self.events.len() == MOST_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
        self.count += 1;
    }

    pub(super) fn end(&mut self, result: RunResult) {
        self.result = Some(result);
    }

    /// The event of this number, or the oldest that is left behind it; and the number after it.
    pub(super) fn next(&self, number: u64) -> Option<(RunEvent, u64)> {
        let oldest = self.count - self.events.len() as u64;
        let number = number.max(oldest);
        let event = self.events.get((number - oldest) as usize)?;
        Some((event.clone(), number + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_comes_late_hears_what_is_left_and_each_event_once() {
        let mut chronicle = Chronicle::default();
        let event = |tick| RunEvent { tick, time_s: 0.0, kind: "warning".into(), text: String::new() };
        let all = |chronicle: &Chronicle, from: u64| {
            let mut number = from;
            std::iter::from_fn(|| {
                let (event, next) = chronicle.next(number)?;
                number = next;
                Some(event.tick)
            })
            .collect::<Vec<_>>()
        };
        assert!(all(&chronicle, 0).is_empty());
        (0..1030).for_each(|tick| chronicle.push(event(tick)));
        assert_eq!(all(&chronicle, 0), (6..1030).collect::<Vec<_>>());
        assert_eq!(all(&chronicle, 1028), [1028, 1029]);
        assert!(all(&chronicle, 1030).is_empty());
    }
}
