//! What all viewers of a run share.

use super::chronicle::Chronicle;
use super::history::History;
use super::seats::Seats;
use super::signals::signals;
use super::token::Token;
use super::{About, knobs};
use crate::control_socket::Steering;
use crate::lifecycle::Phase;
use crate::live::Live;
use crate::printable::fit_to_print;
use crate::recording::run_settings;
use crate::session::Notes;
use crate::sink::EventKind;
use flexbeam_files::{
    Hello, Knob, SCOPE_PROTOCOL, ScopeRun, ScopeState, ScopeTiming, Screen, SettingValue, TokenFound, ViewerMay,
};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Refusals that go into the recording; a viewer that is refused for ever must not fill it.
const MOST_REFUSALS: usize = 100;
/// Changes of hands that do.
const MOST_HANDOVERS: usize = 1000;
/// Said with the last one of a kind.
const LAST: &str = "; further ones are not noted";
/// Changes are told in the recording at most this often; its settings hold every single one.
const GATHER: Duration = Duration::from_secs(1);

/// The run, its past, its viewers.
pub(super) struct Hall {
    pub(super) about: About,
    pub(super) token: Token,
    /// The host's name in the server's address.
    pub(super) host: String,
    pub(super) history: History,
    chronicle: Mutex<Chronicle>,
    /// None before the run is armed.
    run: OnceLock<(Steering, Notes)>,
    seats: Mutex<Seats>,
    screen: Mutex<Screen>,
    refusals: AtomicUsize,
    handovers: AtomicUsize,
    changes: Mutex<Changes>,
    began: Instant,
    /// The server is about to go.
    pub(super) closing: AtomicBool,
}

/// What the one in control has changed and the recording has not been told.
#[derive(Default)]
struct Changes {
    viewer: String,
    since: Option<Duration>,
    values: BTreeMap<String, SettingValue>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hall {
    pub(super) fn new(about: About, token: Token, host: String) -> Hall {
        Hall {
            history: History::new(about.period_s),
            screen: Mutex::new(about.screen.clone()),
            about,
            token,
            host,
            chronicle: Mutex::default(),
            run: OnceLock::new(),
            seats: Mutex::default(),
            refusals: AtomicUsize::new(0),
            handovers: AtomicUsize::new(0),
            changes: Mutex::default(),
            began: Instant::now(),
            closing: AtomicBool::new(false),
        }
    }

    pub(super) fn chronicle(&self) -> MutexGuard<'_, Chronicle> {
        locked(&self.chronicle)
    }

    pub(super) fn screen(&self) -> MutexGuard<'_, Screen> {
        locked(&self.screen)
    }

    /// The first run stays: its sink and its settings belong together.
    pub(super) fn steer(&self, steering: Steering, notes: Notes) {
        let _ = self.run.set((steering, notes));
    }

    pub(super) fn steering(&self) -> Option<&Steering> {
        self.run.get().map(|(steering, _)| steering)
    }

    /// Does something to the seats; the recording hears of a new hand at the wheel.
    pub(super) fn seats<R>(&self, what: impl FnOnce(&mut Seats, Duration) -> R) -> R {
        let mut seats = locked(&self.seats);
        let before = seats.in_control();
        let done = what(&mut seats, self.began.elapsed());
        let after = seats.in_control();
        drop(seats);
        if before != after {
            self.note_handover(after);
        }
        done
    }

    /// Who steers now; what the one before has changed comes first.
    fn note_handover(&self, to: Option<(u64, String)>) {
        let so_far = self.handovers.fetch_add(1, Ordering::Relaxed);
        if so_far < MOST_HANDOVERS {
            self.tell_changes();
            let who = to.map_or("no viewer".into(), |(id, name)| format!("viewer {id} {name:?}"));
            let last = if so_far + 1 == MOST_HANDOVERS { LAST } else { "" };
            self.note(EventKind::Control, &format!("{who} is in control{last}"));
        }
    }

    /// An event of the recording, where there is one.
    fn note(&self, kind: EventKind, text: &str) {
        if let Some((_, notes)) = self.run.get() {
            notes.note(kind, fit_to_print(text));
        }
    }

    /// A refusal, in the recording; so many of them.
    pub(super) fn note_refusal(&self, refused: &str) {
        let first = refused.lines().next().unwrap_or_default();
        let so_far = self.refusals.fetch_add(1, Ordering::Relaxed);
        if so_far < MOST_REFUSALS {
            let last = if so_far + 1 == MOST_REFUSALS { LAST } else { "" };
            self.note(EventKind::Warning, &format!("a viewer's request was refused: {first}{last}"));
        }
    }

    /// A change that was made.
    pub(super) fn note_change(&self, viewer: &str, values: &BTreeMap<String, SettingValue>) {
        let mut changes = locked(&self.changes);
        changes.viewer = viewer.into();
        changes.since.get_or_insert(self.began.elapsed());
        changes.values.extend(values.clone());
    }

    /// Tells the recording of changes, when the first of them is a second old.
    pub(super) fn gather(&self) {
        let due = locked(&self.changes).since.is_some_and(|since| since + GATHER <= self.began.elapsed());
        if due {
            self.tell_changes();
        }
    }

    fn tell_changes(&self) {
        let Changes { viewer, since, values } = std::mem::take(&mut *locked(&self.changes));
        if since.is_some() {
            let values: Vec<String> = values.iter().map(|(key, value)| format!("{key} = {value}")).collect();
            self.note(EventKind::Control, &format!("viewer {viewer:?} set {}", values.join(", ")));
        }
    }

    /// The answer to a viewer that entered.
    pub(super) fn hello(&self, viewer: u64, may: ViewerMay, token: TokenFound) -> Hello {
        let About { controller, project, port, period_s, certificate, save, .. } = &self.about;
        Hello {
            protocol: SCOPE_PROTOCOL,
            version: env!("CARGO_PKG_VERSION").into(),
            viewer,
            may,
            token,
            run: ScopeRun {
                controller: controller.clone(),
                project: project.clone(),
                port: port.clone(),
                period_s: *period_s,
                start_unix_ns: self.start(),
                can_save: save.is_some(),
            },
            signals: signals(),
            knobs: self.live().map(|live| self.knobs(&live)).unwrap_or_default(),
            certificate: certificate.clone(),
            screen: self.screen().clone(),
        }
    }

    /// Since the server began [ms].
    pub(super) fn now_ms(&self) -> u64 {
        self.began.elapsed().as_millis() as u64
    }

    /// By which runs are told apart; `0` before there is one to steer.
    pub(super) fn start(&self) -> String {
        self.steering().map_or(0, |_| self.chronicle().start_unix_ns).to_string()
    }

    pub(super) fn live(&self) -> Option<Live> {
        self.steering().map(|steering| steering.live.current())
    }

    pub(super) fn knobs(&self, live: &Live) -> Vec<Knob> {
        let first = self.steering().map_or_else(|| live.clone(), |steering| steering.live.first());
        knobs::knobs(live, &first, self.about.period_s)
    }

    /// Where the run stands, in a word.
    pub(super) fn phase(&self) -> &'static str {
        self.steering().map_or(Phase::Configured, |steering| steering.controls.phase()).name()
    }

    pub(super) fn state(&self) -> ScopeState {
        let Some(steering) = self.steering() else {
            let phase = self.phase().into();
            return ScopeState {
                phase,
                time_s: 0.0,
                revision: 0,
                values: BTreeMap::new(),
                timing: ScopeTiming::default(),
            };
        };
        let (live, timing) = (steering.live.current(), steering.latest.timing());
        let seconds = |ns: u64| ns as f64 * 1e-9;
        ScopeState {
            phase: steering.controls.phase().name().into(),
            time_s: steering.latest.get().map_or(0.0, |sample| sample.instant as f64 * self.about.period_s),
            revision: live.revision,
            values: run_settings(0, &live).by_key().into_iter().collect(),
            timing: ScopeTiming {
                ticks: timing.ticks,
                median_s: seconds(timing.median_ns),
                p99_s: seconds(timing.p99_ns),
                max_s: seconds(timing.max_ns),
                missed: timing.missed,
                stale: timing.stale,
            },
        }
    }
}
