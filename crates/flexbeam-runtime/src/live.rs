//! What may change while the loop runs: the kernel's settings and the reference, swapped whole between two ticks.
//!
//! Enters: new settings from any thread. Leaves: the newest whole set, read by the loop without waiting. A change cannot bump the
//! loop by itself: controller and filters keep their states, the reference goes on from its phase, and a reference that jumps is
//! smoothed by the kernel. Zeroes and scales of the sensors stay as they were found at homing.

use crate::reference::{Reference, Shape};
use flexbeam_kernel as kernel;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use triple_buffer::{Input, Output, triple_buffer};

/// Sets that are kept for the recorder, which asks within milliseconds: nobody changes faster than this.
const MOST_RECENT: usize = 4096;

/// One whole set.
#[derive(Clone, Debug, PartialEq)]
pub struct Live {
    /// Counts the sets of a run, from 0.
    pub revision: u32,
    /// The kernel's settings.
    pub settings: kernel::Settings,
    /// The reference.
    pub reference: Reference,
}

/// A set that makes no sense, or that may not be changed in a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// A number that makes no sense.
    #[error(
        "found a senseless {name}, needed {needed}\nhint: nothing was changed; the book lists each key with its range"
    )]
    Senseless {
        /// The key.
        name: &'static str,
        /// What would make sense.
        needed: &'static str,
    },
    /// A limit that stops the rig, looser than it was when the run began.
    #[error(
        "found {name} of {found}, needed at most {limit}, as when the run began\nhint: limits may be tightened in a run, and loosened between runs only"
    )]
    Loosened {
        /// The key.
        name: &'static str,
        /// What was asked for.
        found: f64,
        /// What it was when the run began.
        limit: f64,
    },
    /// A zero or a scale.
    #[error(
        "found a change of {name}, needed the one found at homing\nhint: zeroes and scales change between runs only"
    )]
    Fixed {
        /// The key.
        name: &'static str,
    },
}

impl Live {
    /// Errors: [`Refused::Senseless`] for the first number that makes no sense.
    pub fn check(&self) -> Result<(), Refused> {
        if let Some(name) = self.settings.first_unsound() {
            return Err(Refused::Senseless { name, needed: "a number in the range that the book gives" });
        }
        let r = &self.reference;
        let finite = [("reference.amplitude_rad", r.amplitude_rad), ("reference.offset_rad", r.offset_rad)];
        if let Some((name, _)) = finite.iter().find(|(_, x)| !x.is_finite()) {
            return Err(Refused::Senseless { name, needed: "a finite number" });
        }
        let periodic = matches!(r.shape, Shape::Square | Shape::Sine | Shape::Sawtooth);
        if periodic && !(r.period_s > 0.0 && r.period_s.is_finite()) {
            return Err(Refused::Senseless { name: "reference.period_s", needed: "a positive number" });
        }
        if r.shape == Shape::File && r.samples.is_empty() {
            return Err(Refused::Senseless {
                name: "reference.shape",
                needed: "a reference file, given when the run began",
            });
        }
        Ok(())
    }

    fn check_limits(&self, first: &Live) -> Result<(), Refused> {
        let limits = |s: &kernel::Settings| {
            [
                ("voltage_limit_v", s.voltage_limit_v),
                ("deflection_limit_rad", s.deflection_limit_rad),
                ("theta_limit_rad", s.theta_limit_rad),
                ("theta_step_limit_rad", s.theta_step_limit_rad),
            ]
        };
        let mut pairs = limits(&self.settings).into_iter().zip(limits(&first.settings));
        match pairs.find(|((_, found), (_, limit))| found > limit) {
            Some(((name, found), (_, limit))) => Err(Refused::Loosened { name, found, limit }),
            None => Ok(()),
        }
    }

    fn check_fixed(&self, before: &Live) -> Result<(), Refused> {
        let calibration = |s: &kernel::Settings| [s.theta.scale, s.theta.offset_rad, s.alpha.scale, s.alpha.offset_rad];
        let names = ["theta.scale", "theta.offset_rad", "alpha.scale", "alpha.offset_rad"];
        let pairs = calibration(&self.settings).into_iter().zip(calibration(&before.settings));
        match names.into_iter().zip(pairs).find(|(_, (new, old))| new != old) {
            Some((name, _)) => Err(Refused::Fixed { name }),
            None => Ok(()),
        }
    }
}

/// The writing side: any number of holders, one set in force.
#[derive(Clone)]
pub struct LiveControl(Arc<Mutex<Writer>>);

struct Writer {
    input: Input<Live>,
    /// The set at the start, whose limits are the widest.
    first: Live,
    current: Live,
    /// Sets that the loop may still take into force, or has, and that nobody has asked for yet.
    recent: VecDeque<Live>,
}

/// The reading side: the loop's.
pub struct LiveReader(Output<Live>);

/// Both sides of a first set.
///
/// Errors: those of [`Live::check`].
pub fn live(first: Live) -> Result<(LiveControl, LiveReader), Refused> {
    first.check()?;
    let (input, output) = triple_buffer(&first);
    let writer = Writer { input, recent: [first.clone()].into(), current: first.clone(), first };
    Ok((LiveControl(Arc::new(Mutex::new(writer))), LiveReader(output)))
}

impl LiveControl {
    /// Real-time: no. The set in force, or about to be.
    pub fn current(&self) -> Live {
        self.lock().current.clone()
    }

    /// Real-time: no. The set at the start of the run, whose limits are the widest.
    pub fn first(&self) -> Live {
        self.lock().first.clone()
    }

    /// Real-time: no. The set of this revision, for the one who records it; older ones are forgotten, because the loop never goes
    /// back to them.
    pub(crate) fn recorded(&self, revision: u32) -> Option<Live> {
        let mut writer = self.lock();
        writer.recent.retain(|live| live.revision >= revision);
        writer.recent.front().filter(|live| live.revision == revision).cloned()
    }

    /// Real-time: no. Changes the set; it takes effect at the next tick. Returns its revision, the old one when nothing changed.
    ///
    /// Errors: those of [`Live::check`]; [`Refused::Fixed`], [`Refused::Loosened`]. Then the old set stays.
    pub fn change(&self, change: impl FnOnce(&mut Live)) -> Result<u32, Refused> {
        let mut writer = self.lock();
        let mut next = writer.current.clone();
        change(&mut next);
        if next == writer.current {
            return Ok(next.revision);
        }
        next.check()?;
        next.check_fixed(&writer.current)?;
        next.check_limits(&writer.first)?;
        next.revision = writer.current.revision + 1;
        writer.input.write(next.clone());
        writer.recent.push_back(next.clone());
        if writer.recent.len() > MOST_RECENT {
            writer.recent.pop_front();
        }
        writer.current = next;
        Ok(writer.current.revision)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Writer> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LiveReader {
    /// Real-time: yes. The newest whole set, which is in force from now on; never waits.
    pub fn newest(&mut self) -> &Live {
        self.0.read()
    }

    /// Real-time: yes. The set that [`LiveReader::newest`] gave last.
    pub fn in_force(&self) -> &Live {
        self.0.output_buffer()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first() -> Live {
        Live { revision: 0, settings: kernel::Settings::default(), reference: Reference::default() }
    }

    #[test]
    fn a_change_arrives_whole_and_counts() {
        let (control, mut reader) = live(first()).unwrap();
        assert_eq!(reader.newest(), &first());
        let change = |live: &mut Live| {
            live.settings.u_p_plus_v = 0.2;
            live.reference.amplitude_rad = 0.5;
        };
        assert_eq!(control.change(change), Ok(1));
        let found = reader.newest().clone();
        assert_eq!((found.revision, found.settings.u_p_plus_v, found.reference.amplitude_rad), (1, 0.2, 0.5));
        assert_eq!(control.change(change), Ok(1), "the same once more is no change");
        assert_eq!(control.recorded(0), Some(first()));
        assert_eq!(control.recorded(1).map(|live| live.revision), Some(1));
        assert_eq!(control.recorded(0), None, "forgotten");
    }

    #[test]
    fn what_makes_no_sense_is_refused_and_the_old_set_stays() {
        let (control, mut reader) = live(first()).unwrap();
        type Change = fn(&mut Live);
        let changes: [(Change, &str); 7] = [
            (|l| l.settings.voltage_limit_v = 11.0, "voltage_limit_v"),
            (|l| l.settings.eps_u_v = f64::NAN, "eps_u_v"),
            (|l| l.settings.voltage_limit_v = -1.0, "voltage_limit_v"),
            (|l| l.reference.amplitude_rad = f64::INFINITY, "reference.amplitude_rad"),
            (
                |l| l.reference = Reference { shape: Shape::Sine, period_s: 0.0, ..Reference::default() },
                "reference.period_s",
            ),
            (|l| l.reference.shape = Shape::File, "reference.shape"),
            (|l| l.settings.theta.offset_rad = 0.1, "theta.offset_rad"),
        ];
        for (change, name) in changes {
            let refused = control.change(change).unwrap_err();
            let (Refused::Senseless { name: found, .. }
            | Refused::Fixed { name: found }
            | Refused::Loosened { name: found, .. }) = refused;
            assert_eq!(found, name);
        }
        assert_eq!(reader.newest(), &first());
        assert_eq!(control.current(), first());
    }

    /// A slider that is dragged for an hour with nobody who records.
    #[test]
    fn sets_that_nobody_asks_for_are_forgotten() {
        let (control, _reader) = live(first()).unwrap();
        (1..20_000)
            .for_each(|k| assert_eq!(control.change(|live| live.reference.amplitude_rad = f64::from(k)), Ok(k as u32)));
        assert_eq!(control.lock().recent.len(), MOST_RECENT);
        assert_eq!(control.recorded(19_999).map(|live| live.revision), Some(19_999));
        assert_eq!(control.lock().recent.len(), 1);
    }

    /// A writer that never rests: the reader sees sets whose two numbers belong together, and only newer ones.
    #[test]
    fn no_set_is_ever_seen_half() {
        let (control, mut reader) = live(first()).unwrap();
        let writer = std::thread::spawn(move || {
            for k in 1..20_000 {
                let change = |live: &mut Live| {
                    live.settings.u_p_plus_v = f64::from(k);
                    live.reference.amplitude_rad = f64::from(k);
                };
                control.change(change).unwrap();
            }
        });
        let mut last = 0;
        while last < 19_999 {
            let set = reader.newest();
            assert_eq!(set.settings.u_p_plus_v, set.reference.amplitude_rad);
            assert!(set.revision >= last);
            last = set.revision;
        }
        writer.join().unwrap();
    }
}
