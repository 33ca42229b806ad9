//! What viewers ask for: who may, and what becomes of it.

use super::hall::Hall;
use super::knobs::ABOVE_ZERO;
use super::seats::NoSeat;
use crate::control_socket::Steering;
use crate::recording::run_settings;
use flexbeam_files::{Deed, Knob, PageMessage, Request, Screen, SettingValue, request_of_values};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

/// Of keys that nobody knows, in an answer [characters].
const LONGEST_KEYS: usize = 200;

/// Why nothing was done.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum NotDone {
    /// Token, control.
    #[error(transparent)]
    Seat(#[from] NoSeat),
    /// Too early.
    #[error("found a viewer's request before the run was armed, needed an armed one\nhint: wait until the traces move")]
    NotArmed,
    /// What the table of settings has to say.
    #[error(
        "found a change of {keys} that no setting takes ({reason}), needed keys and values of settings\nhint: a word for law and reference.shape, a number for all others"
    )]
    NoSetting {
        /// What was to be changed.
        keys: String,
        /// In serde's words.
        reason: String,
    },
    /// A message with a number, and nothing else that is known.
    #[error("found a message that is none ({0}), needed one of the scope's protocol\nhint: load the page again")]
    NoMessage(String),
    /// A number outside its range.
    #[error(
        "found {key} of {found}, needed {needed}\nhint: nothing was changed; limits may be tightened in a run, and loosened between runs only"
    )]
    Outside {
        /// The setting.
        key: String,
        /// What was asked for.
        found: f64,
        /// The range.
        needed: String,
    },
    /// Nowhere to save.
    #[error(
        "found a run without a project, needed one to save scopes and panels\nhint: `flexbeam new` makes one, `flexbeam run FOLDER --scope` runs it"
    )]
    NoProject,
    /// Scopes and panels that make no sense.
    #[error(
        "found scopes or panels that make no sense ({0}), needed ones as the book describes\nhint: nothing was saved"
    )]
    Screen(String),
    /// The run's own words, or the project's.
    #[error("{0}")]
    Refused(String),
}

impl Hall {
    /// Does what viewer `id` asks for; what is refused goes into the recording.
    pub(super) fn obey(&self, id: u64, message: &PageMessage) -> Result<(), NotDone> {
        let done = match message {
            PageMessage::Enter(_) => Ok(()),
            PageMessage::Do { request, .. } => self.act(id, request.deed),
            PageMessage::Set { values, .. } => self.set(id, values),
            PageMessage::Take { .. } => self.seats(|seats, now| seats.take(now, id)).map_err(NotDone::from),
            PageMessage::Release { .. } => self.seats(|seats, now| seats.release(now, id)).map_err(NotDone::from),
            PageMessage::Give { to, yes, .. } => {
                self.seats(|seats, now| seats.give(now, id, *to, *yes)).map_err(NotDone::from)
            }
            PageMessage::Save { screen, .. } => self.save(id, screen),
        };
        if let Err(refused) = &done {
            self.note_refusal(&refused.to_string());
        }
        done
    }

    /// To stop needs the token; to start needs control, too. Before the run is armed a stop ends the homing.
    fn act(&self, id: u64, deed: Deed) -> Result<(), NotDone> {
        if deed == Deed::Start {
            self.seats(|seats, now| seats.check_control(now, id))?;
            self.armed()?.controls.start();
            return Ok(());
        }
        self.seats(|seats, _| seats.check_token(id))?;
        match (self.steering(), deed) {
            (None, _) => self.about.asked.store(true, Ordering::Release),
            (Some(steering), Deed::Emergency) => steering.controls.emergency(),
            (Some(steering), _) => steering.controls.stop(),
        }
        Ok(())
    }

    /// All of the changes, or none.
    fn set(&self, id: u64, values: &BTreeMap<String, SettingValue>) -> Result<(), NotDone> {
        self.seats(|seats, now| seats.check_control(now, id))?;
        let steering = self.armed()?;
        let keys =
            || values.keys().map(String::as_str).collect::<Vec<_>>().join(", ").chars().take(LONGEST_KEYS).collect();
        let request: Request =
            request_of_values(values).map_err(|reason| NotDone::NoSetting { keys: keys(), reason })?;
        let live = steering.live.current();
        self.knobs(&live).iter().try_for_each(|knob| within(knob, values.get(&knob.key)))?;
        let reply = steering.obey(&request);
        match reply.error {
            Some(error) => return Err(NotDone::Refused(error)),
            None if reply.revision != live.revision => self.note_change(&self.seats(|seats, _| seats.name(id)), values),
            None => {}
        }
        Ok(())
    }

    fn save(&self, id: u64, screen: &Screen) -> Result<(), NotDone> {
        self.seats(|seats, now| seats.check_control(now, id))?;
        screen.check().map_err(|misfit| NotDone::Screen(misfit.to_string()))?;
        let save = self.about.save.as_ref().ok_or(NotDone::NoProject)?;
        let live = self.armed()?.live.current();
        save(screen, &run_settings(0, &live)).map_err(NotDone::Refused)?;
        *self.screen() = screen.clone();
        Ok(())
    }

    fn armed(&self) -> Result<&Steering, NotDone> {
        self.steering().ok_or(NotDone::NotArmed)
    }
}

/// Errors: [`NotDone::Outside`], with the range, which the loop's own words leave to the book.
fn within(knob: &Knob, value: Option<&SettingValue>) -> Result<(), NotDone> {
    let Some(SettingValue::Number(found)) = value else { return Ok(()) };
    let (low, high) = (knob.low.unwrap_or(f64::NEG_INFINITY), knob.high.unwrap_or(f64::INFINITY));
    if (low..=high).contains(found) {
        return Ok(());
    }
    let least = knob.low.map(|low| if low == ABOVE_ZERO { "more than 0".into() } else { format!("at least {low}") });
    let most = knob.high.map(|high| format!("at most {high}"));
    let needed = least.into_iter().chain(most).collect::<Vec<String>>().join(" and ");
    Err(NotDone::Outside { key: knob.key.clone(), found: *found, needed })
}
