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
            let key = control.key.clone();
            // A page notices a dead link long before the server does: it may be back already.
            let back: Vec<u64> =
                self.viewers.iter().filter(|viewer| viewer.key == key).map(|viewer| viewer.id).collect();
            back.into_iter().for_each(|id| self.come_back(id));
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

#[cfg(test)]
mod tests {
    use super::*;
    use ViewerMay::{Look, Steer};
    use proptest::prelude::*;

    const fn s(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn holder(seats: &Seats) -> Option<u64> {
        seats.in_control().map(|(id, _)| id)
    }

    fn two() -> (Seats, u64, u64) {
        let mut seats = Seats::default();
        let one = seats.enter(s(0), "laptop", "k1", Steer).unwrap();
        let other = seats.enter(s(0), "tablet", "k2", Steer).unwrap();
        (seats, one, other)
    }

    #[test]
    fn a_free_seat_is_taken_at_once_and_silence_gives_a_taken_one() {
        let (mut seats, one, other) = two();
        assert_eq!(seats.check_control(s(0), one), Err(NoSeat::NotInControl), "nobody has it by coming first");
        seats.take(s(0), one).unwrap();
        seats.take(s(1), other).unwrap();
        assert_eq!(holder(&seats), Some(one));
        let asking = Some(Asking { viewer: other, name: "tablet".into(), seconds_left: 15 });
        assert_eq!(seats.attendance(s(1)).asking, asking);
        assert_eq!(seats.attendance(Duration::from_millis(15_999)).asking.map(|a| a.seconds_left), Some(1));
        assert_eq!(holder(&seats), Some(one));
        seats.take(s(9), other).unwrap();
        assert_eq!(seats.attendance(s(16)).in_control, Some(other), "asking twice does not start anew");
        assert_eq!(seats.check_control(s(16), one), Err(NoSeat::NotInControl));
    }

    #[test]
    fn an_answer_is_the_holder_s_to_the_one_who_asks() {
        let (mut seats, one, other) = two();
        seats.take(s(0), one).unwrap();
        assert_eq!(seats.give(s(0), one, other, true), Err(NoSeat::NobodyAsks(other)));
        seats.take(s(0), other).unwrap();
        assert_eq!(seats.give(s(1), other, other, true), Err(NoSeat::NotInControl), "nobody gives to himself");
        seats.give(s(1), one, other, false).unwrap();
        assert_eq!((holder(&seats), seats.attendance(s(100)).asking), (Some(one), None));
        seats.take(s(100), other).unwrap();
        seats.give(s(101), one, other, true).unwrap();
        assert_eq!(holder(&seats), Some(other));
        let third = seats.enter(s(102), "phone", "k3", Steer).unwrap();
        seats.take(s(102), one).unwrap();
        assert_eq!(seats.take(s(103), third), Err(NoSeat::Asked("laptop".into())));
        seats.release(s(104), other).unwrap();
        assert_eq!(holder(&seats), Some(one), "who asks is next");
    }

    #[test]
    fn a_lost_connection_keeps_its_seat_for_five_seconds() {
        let (mut seats, one, other) = two();
        seats.take(s(0), one).unwrap();
        seats.leave(s(10), one);
        seats.take(s(11), other).unwrap();
        assert_eq!(holder(&seats), Some(one), "its seat waits");
        let back = seats.enter(s(14), "laptop", "k1", Steer).unwrap();
        assert_eq!(holder(&seats), Some(back));
        seats.leave(s(14), back);
        assert_eq!(seats.attendance(s(19)).in_control, Some(other), "who asked has it after the grace");
        let late = seats.enter(s(20), "laptop", "k1", Steer).unwrap();
        assert_eq!(holder(&seats), Some(other));
        assert_ne!(late, back);
    }

    #[test]
    fn a_seat_waits_for_its_key_and_its_token_alone() {
        for (key, may) in [("k2", Steer), ("", Steer), ("k1", Look)] {
            let (mut seats, one, _) = two();
            seats.take(s(0), one).unwrap();
            seats.leave(s(1), one);
            let stranger = seats.enter(s(2), "laptop", key, may).unwrap();
            assert_ne!(holder(&seats), Some(stranger), "{key} {may:?}");
            if may == Look {
                seats.admit(s(3), stranger);
                assert_eq!(holder(&seats), Some(stranger), "with the token after all");
            }
        }
        let mut seats = Seats::default();
        let nameless = seats.enter(s(0), "", "", Steer).unwrap();
        seats.take(s(0), nameless).unwrap();
        seats.leave(s(1), nameless);
        let another = seats.enter(s(2), "", "", Steer).unwrap();
        assert_ne!(holder(&seats), Some(another), "no key is no key");
        let (mut seats, one, _) = two();
        seats.take(s(0), one).unwrap();
        let copy = seats.enter(s(1), "laptop", "k1", Steer).unwrap();
        assert_ne!(holder(&seats), Some(copy), "a copied tab does not take a seat that is not lost");
    }

    #[test]
    fn who_is_back_before_the_loss_is_noticed_gets_its_seat() {
        let (mut seats, one, other) = two();
        seats.take(s(0), one).unwrap();
        let onlooker = seats.enter(s(1), "laptop", "k1", Look).unwrap();
        let back = seats.enter(s(2), "laptop", "k1", Steer).unwrap();
        assert_eq!(holder(&seats), Some(one));
        seats.take(s(3), other).unwrap();
        seats.leave(s(10), one);
        assert_eq!(holder(&seats), Some(back), "and not {onlooker}");
        assert!(seats.attendance(s(10)).asking.is_some(), "who asks still asks");
    }

    #[test]
    fn without_the_token_nobody_steers() {
        let (mut seats, one, _) = two();
        let onlooker = seats.enter(s(0), "phone", "k3", Look).unwrap();
        assert_eq!(seats.take(s(0), onlooker), Err(NoSeat::NoToken));
        assert_eq!(seats.check_control(s(0), onlooker), Err(NoSeat::NoToken));
        assert_eq!(seats.check_token(onlooker), Err(NoSeat::NoToken));
        assert_eq!(seats.check_token(99), Err(NoSeat::NoToken), "who is not there");
        seats.check_token(one).unwrap();
        seats.admit(s(1), onlooker);
        seats.take(s(1), onlooker).unwrap();
        seats.check_control(s(1), onlooker).unwrap();
    }

    #[test]
    fn a_full_house_has_a_place_for_the_token_while_somebody_only_looks() {
        let mut seats = Seats::default();
        let onlookers: Vec<u64> =
            (0..MOST_VIEWERS).map(|k| seats.enter(s(0), "o", &format!("k{k}"), Look).unwrap()).collect();
        assert_eq!(seats.enter(s(0), "one more", "k", Look), Err(NoSeat::Full));
        for gone in onlookers {
            let id = seats.enter(s(0), "owner", "", Steer).unwrap();
            assert!(seats.has(id) && !seats.has(gone));
            assert_eq!(seats.count(), MOST_VIEWERS);
        }
        assert_eq!(seats.enter(s(0), "owner", "", Steer), Err(NoSeat::Full));
    }

    /// What may happen; viewers are by number of their coming.
    #[derive(Clone, Copy, Debug)]
    enum Act {
        Enter(u8, ViewerMay),
        Leave(u8),
        Take(u8),
        Release(u8),
        Give(u8, u8, bool),
        Pass(u64),
    }

    /// The seats beside what a judge remembers of them: since when somebody asks, since when the holder is lost.
    #[derive(Default)]
    struct Judged {
        seats: Seats,
        now: Duration,
        ids: Vec<(u64, u8, ViewerMay)>,
        asked: Option<(u64, Duration)>,
        lost: Option<(u64, u8, Duration)>,
    }

    impl Judged {
        fn id(&self, k: u8) -> Option<u64> {
            self.ids.iter().find(|(_, key, _)| *key == k).map(|(id, ..)| *id)
        }

        /// Does it, and asks whether there was a reason for whatever changed.
        fn act(&mut self, act: Act) {
            let before = holder(&self.seats);
            let mut granted = None;
            match act {
                Act::Enter(k, may) if self.id(k).is_none() => {
                    let id = self.seats.enter(self.now, "v", &format!("key {k}"), may).unwrap();
                    self.ids.push((id, k, may));
                    granted = self.lost.filter(|(_, key, at)| *key == k && self.now < *at + GRACE).map(|_| id);
                }
                Act::Leave(k) => {
                    if let Some(id) = self.id(k) {
                        self.seats.leave(self.now, id);
                        self.ids.retain(|(other, ..)| *other != id);
                        if before == Some(id) && holder(&self.seats) == Some(id) {
                            self.lost = Some((id, k, self.now));
                        }
                    }
                }
                Act::Take(k) => {
                    let id = self.id(k).unwrap_or(999);
                    let taken = self.seats.take(self.now, id);
                    let may = self.ids.iter().any(|(other, _, may)| *other == id && *may == Steer);
                    assert!(may || taken == Err(NoSeat::NoToken));
                    granted = before.is_none().then_some(id).filter(|_| taken.is_ok());
                }
                Act::Release(k) => {
                    let id = self.id(k).unwrap_or(999);
                    if self.seats.release(self.now, id).is_ok() {
                        assert_ne!(holder(&self.seats), Some(id));
                        granted = self.asked.map(|(id, _)| id);
                        self.judge(Some(id), granted, true);
                        return;
                    }
                }
                Act::Give(k, to, yes) => {
                    let (id, to) = (self.id(k).unwrap_or(999), self.id(to).unwrap_or(998));
                    if self.seats.give(self.now, id, to, yes).is_ok() {
                        assert_eq!(self.asked.map(|(id, _)| id), Some(to));
                        granted = yes.then_some(to);
                    }
                }
                Act::Pass(ms) => {
                    self.now += Duration::from_millis(ms);
                    self.seats.pass(self.now);
                }
                Act::Enter(..) => {}
            }
            self.judge(before, granted, false);
        }

        fn judge(&mut self, before: Option<u64>, granted: Option<u64>, released: bool) {
            let shown = self.seats.attendance(self.now);
            let after = shown.in_control;
            if before != after {
                let silence = self.asked.filter(|(id, at)| after == Some(*id) && self.now >= *at + ANSWER);
                let free =
                    released || self.lost.is_some_and(|(id, _, at)| before == Some(id) && self.now >= at + GRACE);
                let next = after.is_none() || after == self.asked.map(|(id, _)| id);
                assert!(
                    silence.is_some() || (free && next) || (after.is_some() && after == granted),
                    "{before:?} -> {after:?}"
                );
            }
            let is = |id: u64, may: ViewerMay| shown.viewers.iter().any(|viewer| viewer.id == id && viewer.may == may);
            let waits = self.lost.filter(|(id, _, at)| after == Some(*id) && self.now < *at + GRACE);
            assert!(after.is_none_or(|id| is(id, Steer) || waits.is_some()), "the holder has the token, or a grace");
            self.lost = waits;
            let asking = shown.asking.map(|asking| asking.viewer);
            assert!(asking.is_none_or(|id| is(id, Steer) && after.is_some() && after != Some(id)));
            let since = self.asked.filter(|(id, _)| asking == Some(*id)).map_or(self.now, |(_, at)| at);
            self.asked = asking.map(|id| (id, since));
            assert!(self.asked.is_none_or(|(_, at)| self.now < at + ANSWER), "an answer is never late");
        }
    }

    fn acts() -> Vec<Act> {
        let of = |k: u8| [Act::Leave(k), Act::Take(k), Act::Release(k), Act::Give(k, 1 - k, true)];
        let others = [Act::Enter(0, Steer), Act::Enter(1, Steer), Act::Give(0, 1, false), Act::Pass(5000)];
        [0, 1].into_iter().flat_map(of).chain(others).collect()
    }

    /// Two viewers, six acts: every order.
    #[test]
    fn every_short_story_of_two_viewers_has_reasons() {
        let all = acts();
        for story in 0..all.len().pow(5) {
            let mut judged = Judged::default();
            judged.act(Act::Enter(0, Steer));
            let mut rest = story;
            for _ in 0..5 {
                judged.act(all[rest % all.len()]);
                rest /= all.len();
            }
        }
    }

    fn any_act() -> impl Strategy<Value = Act> {
        let who = 0u8..4;
        let may = prop_oneof![3 => Just(Steer), 1 => Just(Look)];
        prop_oneof![
            (who.clone(), may).prop_map(|(k, may)| Act::Enter(k, may)),
            who.clone().prop_map(Act::Leave),
            who.clone().prop_map(Act::Take),
            who.clone().prop_map(Act::Release),
            (who.clone(), who, any::<bool>()).prop_map(|(a, b, yes)| Act::Give(a, b, yes)),
            (0u64..8000).prop_map(Act::Pass),
        ]
    }

    proptest! {
        #[test]
        fn every_long_story_of_four_viewers_has_reasons(story in prop::collection::vec(any_act(), 0..80)) {
            let mut judged = Judged::default();
            story.into_iter().for_each(|act| judged.act(act));
        }
    }
}
