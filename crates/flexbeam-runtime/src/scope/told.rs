//! What a viewer has been told: the next message is whatever it does not know yet.

use super::hall::Hall;
use super::history::{Cursor, MOST_IN_FRAME, Row};
use super::viewer::{End, Guest, text};
use axum::extract::ws::Message;
use flexbeam_files::{Attendance, Enter, Knob, ServerMessage};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// The state is told at least so often.
const STATE: Duration = Duration::from_millis(250);

/// A frame that took so long to go filled the line: what is behind it would come later still.
const LATE: Duration = Duration::from_secs(1);
/// A frame that went in this time leaves room for a larger one.
const PROMPT: Duration = Duration::from_millis(33);
/// Rows of a frame: at first, and on the slowest line.
const FIRST_ROWS: usize = 512;
const FEWEST_ROWS: usize = 32;

/// A viewer's place in everything that it is told.
pub(super) struct Told {
    /// Whether it has its hello, and the one of the armed run.
    hello: Option<Armed>,
    knobs: Vec<Knob>,
    /// Number of the next event.
    event: u64,
    attendance: Option<Attendance>,
    /// When, and phase and revision.
    state: Option<(Instant, String, u32)>,
    cursor: Cursor,
    rows: Vec<Row>,
    /// Rows of the next frame, at most: as many as the line carries.
    most_rows: usize,
    /// Whether a frame went out in this beat.
    frame: bool,
    over: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Armed {
    NotYet,
    Yes,
}

impl Told {
    pub(super) fn new(hall: &Hall, enter: &Enter) -> Told {
        let same = enter.run.as_ref().is_none_or(|run| *run == hall.start());
        Told {
            hello: None,
            knobs: Vec::new(),
            event: 0,
            attendance: None,
            state: None,
            cursor: hall.history.cursor(enter.after.filter(|_| same)),
            rows: Vec::new(),
            most_rows: FIRST_ROWS,
            frame: false,
            over: false,
        }
    }

    /// Another thirtieth of a second.
    pub(super) fn beat(&mut self) {
        self.frame = false;
    }

    /// The next message, if there is one in this beat.
    pub(super) fn next(&mut self, hall: &Hall, guest: &Guest) -> Option<Message> {
        let armed = if hall.steering().is_some() { Armed::Yes } else { Armed::NotYet };
        if self.hello != Some(armed) {
            if self.hello.replace(armed).is_some() {
                // To the page this is another run: it drops what it has, the first samples of this one among it.
                self.cursor = hall.history.cursor(None);
            }
            let hello = guest.hello(false);
            if let ServerMessage::Hello(hello) = &hello {
                self.knobs = hello.knobs.clone();
            }
            return Some(text(&hello));
        }
        let told = self.knobs(hall).or_else(|| self.event(hall)).or_else(|| self.viewers(hall));
        let told = told.or_else(|| self.state(hall));
        told.map(|message| text(&message)).or_else(|| self.samples(hall)).or_else(|| self.over(hall))
    }

    fn knobs(&mut self, hall: &Hall) -> Option<ServerMessage> {
        let knobs = hall.live().map(|live| hall.knobs(&live))?;
        if knobs == self.knobs {
            return None;
        }
        self.knobs = knobs.clone();
        Some(ServerMessage::Knobs { knobs })
    }

    fn event(&mut self, hall: &Hall) -> Option<ServerMessage> {
        let (event, next) = hall.chronicle().next(self.event)?;
        self.event = next;
        Some(ServerMessage::Event(event))
    }

    fn viewers(&mut self, hall: &Hall) -> Option<ServerMessage> {
        let attendance = hall.seats(|seats, now| seats.attendance(now));
        if self.attendance.as_ref() == Some(&attendance) {
            return None;
        }
        self.attendance = Some(attendance.clone());
        Some(ServerMessage::Viewers(attendance))
    }

    fn state(&mut self, hall: &Hall) -> Option<ServerMessage> {
        let now = (hall.phase(), hall.live().map_or(0, |live| live.revision));
        let known = self.state.as_ref().is_some_and(|(when, phase, revision)| {
            when.elapsed() < STATE && (phase.as_str(), *revision) == (now.0, now.1)
        });
        if known {
            return None;
        }
        let state = hall.state();
        self.state = Some((Instant::now(), state.phase.clone(), state.revision));
        Some(ServerMessage::State(state))
    }

    /// One frame a beat; at the end of the run whatever is left.
    fn samples(&mut self, hall: &Hall) -> Option<Message> {
        if self.frame && hall.chronicle().result.is_none() {
            return None;
        }
        self.frame = true;
        let frame = hall.history.frame(&mut self.cursor, &mut self.rows, self.most_rows);
        frame.map(|bytes| Message::Binary(bytes.into()))
    }

    /// A frame of samples took this long. On a slow line the newest samples and a state that is fresh are worth more than all samples
    /// late: frames become smaller, and what has waited for long is passed over.
    pub(super) fn took(&mut self, hall: &Hall, time: Duration) {
        if time > LATE {
            self.most_rows = (self.most_rows / 4).max(FEWEST_ROWS);
            hall.history.pass_over(&mut self.cursor);
        } else if time < PROMPT {
            self.most_rows = (self.most_rows * 2).min(MOST_IN_FRAME);
        }
    }

    fn over(&mut self, hall: &Hall) -> Option<Message> {
        let result = hall.chronicle().result.clone().filter(|_| !self.over)?;
        self.over = true;
        Some(text(&ServerMessage::Over { result: Box::new(result) }))
    }

    /// Why there is nothing more to tell.
    pub(super) fn end(&self, hall: &Hall, guest: &Guest) -> Option<End> {
        if self.over {
            Some(End::OVER)
        } else if !guest.is_there() {
            Some(End::FULL)
        } else if hall.closing.load(Ordering::Relaxed) && hall.steering().is_none() {
            Some(End::NOT_BEGUN)
        } else {
            None
        }
    }
}
