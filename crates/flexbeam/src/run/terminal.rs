//! The live view of a run on the terminal: numbers, bars, the last seconds, and keys.
//!
//! Enters: what the recorder has seen, keys. Leaves: pictures on standard error, wishes to the loop. It runs on the program's main
//! thread and talks to the loop through [`Steering`] alone: a slow or broken terminal costs the picture, not the run.

mod bar;
mod guard;
mod keyboard;
mod keys;
mod panel;
mod picture;
mod screen;
mod strip;

use std::io::{self, BufWriter, IsTerminal, Stderr, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use flexbeam_runtime::{Live, Refused, RunEvent, Sample, Session, Steering};
use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;

use guard::Guard;
use keyboard::Keyboard;
use keys::{Act, act_of, apply};
use panel::Panel;
use picture::{Ends, Picture, Reading};
use strip::{Point, Strip};

/// From one picture to the next: 16 a second.
const PICTURE: Duration = Duration::from_millis(60);
/// How often the newest sample is looked at for the strip.
const LOOK: Duration = Duration::from_millis(20);

/// What the view shows of the run's plan.
#[derive(Clone, Debug)]
pub struct About {
    /// The controller's file.
    pub controller: String,
    /// The rig.
    pub port: String,
    /// Where the scope is, with its token.
    pub scope: Option<String>,
}

/// Whether there is a terminal to draw on and to read keys from; a dumb one is none.
pub fn is_there() -> bool {
    let draws = std::env::var_os("TERM").is_some_and(|name| name != "dumb");
    draws && io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Shows the run until it is over, or until the view breaks; the terminal is as it was before.
pub fn watch(session: &Session, steering: &Steering, about: About) {
    match catch_unwind(AssertUnwindSafe(|| on_screen(session, steering, about))) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => say(&format!("the view ended ({error}); the run goes on")),
        Err(_) => say("the view ended, which is a bug of flexbeam; the run goes on"),
    }
}

/// A line on standard error, where that is still there.
fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

fn on_screen(session: &Session, steering: &Steering, about: About) -> io::Result<()> {
    let mut view = View::new(steering, about);
    // Before the terminal, so that it goes after it: the picture is flushed before the screen is left.
    let _guard = Guard::take()?;
    let mut terminal = Terminal::new(CrosstermBackend::new(BufWriter::new(io::stderr())))?;
    view.stop_if_asked_early()?;
    while !session.is_over() {
        view.show(&mut terminal)?;
        let next = Instant::now() + PICTURE;
        while Instant::now() < next && !session.is_over() {
            view.obey(LOOK)?;
            view.look();
        }
    }
    Ok(())
}

/// All that the view knows from one picture to the next.
struct View<'a> {
    steering: &'a Steering,
    about: About,
    keyboard: Keyboard,
    panel: Panel,
    strip: Strip,
    events: Vec<(f64, String)>,
    /// Events of the run that are in `events`; refusals are among them, too.
    told: usize,
}

impl<'a> View<'a> {
    fn new(steering: &'a Steering, about: About) -> View<'a> {
        let panel = Panel::new(&steering.live.current());
        let (keyboard, strip, events) = (Keyboard::default(), Strip::default(), Vec::new());
        View { steering, about, keyboard, panel, strip, events, told: 0 }
    }

    /// Keys that were hit before the view was there: they may stop the rig, but start and change nothing.
    fn stop_if_asked_early(&mut self) -> io::Result<()> {
        let early = self.keyboard.pressed(Duration::ZERO)?;
        early.into_iter().filter_map(act_of).filter(|act| act.stops()).for_each(|act| self.act(act));
        Ok(())
    }

    /// Does what keys ask for, the first of which may take `patience` to come.
    fn obey(&mut self, patience: Duration) -> io::Result<()> {
        let keys = self.keyboard.pressed(patience)?;
        keys.into_iter().filter_map(act_of).for_each(|act| self.act(act));
        Ok(())
    }

    fn act(&mut self, act: Act) {
        if let Err(refused) = apply(act, self.steering, &mut self.panel) {
            self.note(&refused);
        }
    }

    fn note(&mut self, refused: &Refused) {
        let instant = self.steering.latest.get().map_or(0, |sample| sample.instant);
        self.events.push((self.time_s(instant), format!("refused: {refused}")));
    }

    fn look(&mut self) {
        let live = self.steering.live.current();
        if let Some(reading) = self.steering.latest.get().map(|sample| self.reading(&sample, &live)) {
            let Reading { time_s, reference_rad, psi_rad, .. } = reading;
            self.strip.push(Point { time_s, reference_rad, psi_rad });
        }
        for RunEvent { instant, kind, text } in self.steering.latest.events_after(self.told) {
            self.told += 1;
            self.events.push((self.time_s(instant), format!("{}: {text}", kind.name())));
        }
    }

    fn reading(&self, sample: &Sample, live: &Live) -> Reading {
        Reading::of(sample, live, self.steering.period_s)
    }

    fn time_s(&self, instant: u64) -> f64 {
        instant as f64 * self.steering.period_s
    }

    fn show(&mut self, terminal: &mut Terminal<CrosstermBackend<BufWriter<Stderr>>>) -> io::Result<()> {
        let picture = self.picture();
        terminal.draw(|frame| screen::draw(frame, &picture)).map(drop)
    }

    fn picture(&self) -> Picture {
        let Steering { controls, live, latest, period_s } = self.steering;
        let live = live.current();
        let (settings, selected) = picture::settings(&live, &self.panel, *period_s);
        Picture {
            controller: self.about.controller.clone(),
            port: self.about.port.clone(),
            scope: self.about.scope.clone(),
            period_s: *period_s,
            phase: controls.phase(),
            reading: latest.get().map(|sample| self.reading(&sample, &live)),
            ends: Ends::of(&live),
            settings,
            selected,
            timing: latest.timing(),
            strip: self.strip.clone(),
            events: self.events.clone(),
        }
    }
}
