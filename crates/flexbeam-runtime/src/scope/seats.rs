//! Who is there, who is in control, who asks for it: a state machine that is told the time.
//!
//! Enters: viewers that come, go and ask, each with the time since the server began. Leaves: who is in control. Deliberately absent:
//! tokens, connections, the run.

use flexbeam_files::{Asking, Attendance, Attendant, ViewerMay};
use std::time::Duration;

/// How long the one in control has for an answer; silence gives control away.
pub(super) const ANSWER: Duration = Duration::from_secs(15);
/// How long the seat of a lost connection stays free for it.
pub(super) const GRACE: Duration = Duration::from_secs(5);
/// Viewers at a time.
pub(super) const MOST_VIEWERS: usize = 32;

/// The viewers.
#[derive(Debug, Default)]
pub(super) struct Seats {
    viewers: Vec<Viewer>,
    next: u64,
    control: Option<Control>,
    ask: Option<Ask>,
}

#[derive(Clone, Debug, PartialEq)]
struct Viewer {
    id: u64,
    name: String,
    key: String,
    may: ViewerMay,
}

/// The one in control.
#[derive(Clone, Debug, PartialEq)]
struct Control {
    id: u64,
    name: String,
    key: String,
    /// Of a lost connection: until when its seat stays.
    lost_until: Option<Duration>,
}

#[derive(Clone, Debug, PartialEq)]
struct Ask {
    id: u64,
    until: Duration,
}

/// Why somebody does not get what they ask for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum NoSeat {
    /// The house is full.
    #[error("found {MOST_VIEWERS} viewers, needed a free place\nhint: close the page on another device")]
    Full,
    /// Without the token.
    #[error(
        "found a viewer without the run's token, needed it to steer\nhint: open the address that `flexbeam run` printed, with all that stands behind #"
    )]
    NoToken,
    /// Somebody asks already.
    #[error("found {0} asking for control, needed nobody who asks\nhint: wait for the answer, 15 s at most")]
    Asked(String),
    /// Not in control.
    #[error("found a viewer that is not in control, needed the one that is\nhint: take control first")]
    NotInControl,
    /// The answer to a question that nobody asked.
    #[error(
        "found an answer to viewer {0}, needed one to the viewer that asks\nhint: the question may be over already"
    )]
    NobodyAsks(u64),
}

impl Seats {
    /// What time has brought: silence that gives control, a lost connection that does not come back.
    pub(super) fn pass(&mut self, now: Duration) {
        let gone = |control: &Control| control.lost_until.is_some_and(|until| until <= now);
        if self.control.as_ref().is_some_and(gone) {
            self.free();
        }
        if let Some(ask) = self.ask.clone().filter(|ask| ask.until <= now) {
            self.seat(ask.id);
        }
    }

    /// A viewer comes. The key of the one in control whose connection was lost gets its seat back.
    ///
    /// Returns: its number. One who may steer always finds a place: an onlooker has to go.
    /// Errors: [`NoSeat::Full`].
    pub(super) fn enter(&mut self, now: Duration, name: &str, key: &str, may: ViewerMay) -> Result<u64, NoSeat> {
        self.pass(now);
        if self.viewers.len() >= MOST_VIEWERS {
            let onlooker = self.viewers.iter().position(|viewer| viewer.may == ViewerMay::Look);
            self.viewers.remove(onlooker.filter(|_| may == ViewerMay::Steer).ok_or(NoSeat::Full)?);
        }
        self.next += 1;
        let id = self.next;
        self.viewers.push(Viewer { id, name: name.into(), key: key.into(), may });
        self.come_back(id);
        Ok(id)
    }

    /// A viewer that is there has shown the token after all.
    pub(super) fn admit(&mut self, now: Duration, id: u64) {
        self.pass(now);
        self.viewers.iter_mut().filter(|viewer| viewer.id == id).for_each(|viewer| viewer.may = ViewerMay::Steer);
        self.come_back(id);
    }

    fn come_back(&mut self, id: u64) {
        let Some(viewer) = self.viewer(id).filter(|viewer| viewer.may == ViewerMay::Steer) else { return };
        let (name, key) = (viewer.name.clone(), viewer.key.clone());
        if let Some(control) = self
            .control
            .as_mut()
            .filter(|control| control.lost_until.is_some() && control.key == key && !key.is_empty())
        {
            *control = Control { id, name, key, lost_until: None };
        }
    }

    /// A viewer's connection is gone. What it asked for is forgotten.
    pub(super) fn leave(&mut self, now: Duration, id: u64) {
        self.pass(now);
        self.viewers.retain(|viewer| viewer.id != id);
        self.ask.take_if(|ask| ask.id == id);
        if let Some(control) = self.control.as_mut().filter(|control| control.id == id) {
            control.lost_until = Some(now + GRACE);
        }
    }

    /// A viewer asks for control, and gets it at once where nobody has it.
    ///
    /// Errors: [`NoSeat::NoToken`], [`NoSeat::Asked`].
    pub(super) fn take(&mut self, now: Duration, id: u64) -> Result<(), NoSeat> {
        self.pass(now);
        if self.viewer(id).is_none_or(|viewer| viewer.may != ViewerMay::Steer) {
            return Err(NoSeat::NoToken);
        }
        match (&self.control, &self.ask) {
            (None, _) => self.seat(id),
            (Some(control), _) if control.id == id => {}
            (_, Some(ask)) if ask.id != id => return Err(NoSeat::Asked(self.name(ask.id))),
            (_, Some(_)) => {}
            (_, None) => self.ask = Some(Ask { id, until: now + ANSWER }),
        }
        Ok(())
    }

    /// The one in control gives it up.
    ///
    /// Errors: [`NoSeat::NotInControl`].
    pub(super) fn release(&mut self, now: Duration, id: u64) -> Result<(), NoSeat> {
        self.check_control(now, id)?;
        self.free();
        Ok(())
    }

    /// The one in control answers the one who asks.
    ///
    /// Errors: [`NoSeat::NotInControl`], [`NoSeat::NobodyAsks`].
    pub(super) fn give(&mut self, now: Duration, id: u64, to: u64, yes: bool) -> Result<(), NoSeat> {
        self.check_control(now, id)?;
        self.ask.take_if(|ask| ask.id == to).ok_or(NoSeat::NobodyAsks(to))?;
        if yes {
            self.seat(to);
        }
        Ok(())
    }

    /// Errors: [`NoSeat::NoToken`], [`NoSeat::NotInControl`].
    pub(super) fn check_control(&mut self, now: Duration, id: u64) -> Result<(), NoSeat> {
        self.pass(now);
        self.check_token(id)?;
        let in_control = self.control.as_ref().is_some_and(|control| control.id == id);
        if in_control { Ok(()) } else { Err(NoSeat::NotInControl) }
    }

    /// Errors: [`NoSeat::NoToken`].
    pub(super) fn check_token(&self, id: u64) -> Result<(), NoSeat> {
        let may = self.viewer(id).is_some_and(|viewer| viewer.may == ViewerMay::Steer);
        if may { Ok(()) } else { Err(NoSeat::NoToken) }
    }

    /// Number and name of the one in control.
    pub(super) fn in_control(&self) -> Option<(u64, String)> {
        self.control.as_ref().map(|control| (control.id, control.name.clone()))
    }

    /// Whether this viewer is there still.
    pub(super) fn has(&self, id: u64) -> bool {
        self.viewer(id).is_some()
    }

    /// Number of viewers.
    pub(super) fn count(&self) -> usize {
        self.viewers.len()
    }

    /// The name of a viewer that is there; empty of any other.
    pub(super) fn name(&self, id: u64) -> String {
        self.viewer(id).map_or_else(String::new, |viewer| viewer.name.clone())
    }

    /// As every viewer sees it.
    pub(super) fn attendance(&mut self, now: Duration) -> Attendance {
        self.pass(now);
        let shown = |viewer: &Viewer| Attendant { id: viewer.id, name: viewer.name.clone(), may: viewer.may };
        let asking = self.ask.as_ref().map(|ask| Asking {
            viewer: ask.id,
            name: self.name(ask.id),
            seconds_left: ask.until.saturating_sub(now).as_millis().div_ceil(1000) as u64,
        });
        Attendance {
            viewers: self.viewers.iter().map(shown).collect(),
            in_control: self.control.as_ref().map(|control| control.id),
            asking,
        }
    }

    fn viewer(&self, id: u64) -> Option<&Viewer> {
        self.viewers.iter().find(|viewer| viewer.id == id)
    }

    /// Puts a viewer in control; whoever asked has their answer.
    fn seat(&mut self, id: u64) {
        let control =
            self.viewer(id).map(|v| Control { id, name: v.name.clone(), key: v.key.clone(), lost_until: None });
        self.control = control;
        self.ask = None;
    }

    /// Nobody is in control, or the one who asks.
    fn free(&mut self) {
        self.control = None;
        if let Some(ask) = self.ask.take() {
            self.seat(ask.id);
        }
    }
}
