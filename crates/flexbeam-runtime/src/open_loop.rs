//! A list of voltages through the loop: recordings, rig tests, homing and the sign check all drive the rig this way.
//!
//! The voltages are the reference of a controller that passes it on, so the kernel's limits, the watchdog and the fault handling
//! are those of every other run, and there is one writer of voltages.

use crate::back_end::BackEnd;
use crate::controls::Controls;
use crate::live::Live;
use crate::reference::{Reference, Shape};
use crate::sample::Sample;
use crate::session::{ControllerData, NotArmed, Outcome, Session, Setup};
use crate::sink::{Sink, SinkError};
use flexbeam_kernel as kernel;
use std::sync::{Arc, Mutex, PoisonError};

/// A run in which `voltages_v` go out one a period, behind these limits; everything else as in `like`.
///
/// Shapes: one voltage [V] a tick. The voltage of tick k acts from instant k + 1 on, so one more tick follows the last.
pub fn open_loop_setup(voltages_v: Arc<[f64]>, limits: &kernel::Settings, like: &Setup) -> Setup {
    let settings = kernel::Settings { law: kernel::Law::None, smooth_ticks: 0.0, ..*limits };
    let ticks = voltages_v.len() + 1;
    let zero_after: Arc<[f64]> = voltages_v.iter().copied().chain([0.0]).collect();
    let reference = Reference { shape: Shape::File, amplitude_rad: 1.0, samples: zero_after, ..Reference::default() };
    Setup {
        controller: ControllerData::pass_through(),
        live: Live { revision: 0, settings, reference },
        duration_s: Some(ticks as f64 * like.period_s),
        autostart: true,
        ..like.clone()
    }
}

/// Drives these voltages and keeps every sample, beside other sinks, until they are over or `enough` says so.
///
/// Real-time: no; it waits for the end.
/// Errors: [`NotArmed`].
pub fn drive(
    back_end: Box<dyn BackEnd>,
    setup: Setup,
    mut sinks: Vec<Box<dyn Sink>>,
    enough: impl FnMut(&Sample) -> bool + Send + 'static,
) -> Result<(Outcome, Vec<Sample>), NotArmed> {
    let kept = Kept { samples: Arc::default(), controls: Arc::default(), enough: Box::new(enough) };
    let (samples, controls) = (kept.samples.clone(), kept.controls.clone());
    sinks.push(Box::new(kept));
    let session = Session::arm(back_end, setup, sinks)?;
    *lock(&controls) = Some(session.controls.clone());
    let outcome = session.finish();
    let samples = std::mem::take(&mut *lock(&samples));
    Ok((outcome, samples))
}

/// Keeps samples, and stops the run when it has enough.
struct Kept {
    samples: Arc<Mutex<Vec<Sample>>>,
    /// Known once the run is armed.
    controls: Arc<Mutex<Option<Controls>>>,
    enough: Box<dyn FnMut(&Sample) -> bool + Send>,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Sink for Kept {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if (self.enough)(sample)
            && let Some(controls) = &*lock(&self.controls)
        {
            controls.stop();
        }
        lock(&self.samples).push(*sample);
        Ok(())
    }
}
