//! The uncertainty bound alpha(s) from a recording: |G(jw - beta) - G0(jw - beta)| < |alpha(jw)|, (19).
//!
//! Data live on s = jw; the bound is needed left of it. Weighting the signals with e^(beta t) would move the line, but the noise
//! grows with it: at beta = 1.5 a tail of ten seconds, which a mode damped by 2 needs, weighs e^15. So a model carries the data
//! over: a full model, of an order that leaves nothing in the recording that the input explains, and a band around it on the
//! shifted line.
//!
//!   |G - G0| <= |full - G0| + |G - full| <= |full - G0| + band
//!
//! The first term is computed. The second is a statement with a probability, if the beam is linear and of the full model's order.
//! That the recording does not contradict this is tested (see [`full`]); that it holds left of the imaginary axis is assumed.
//!
//! Enters: nominal plant, full model, band. Leaves: alpha(s). Absent: the design that uses it.

mod band;
mod full;
mod recording;
mod replicate;

pub use band::{Band, line};
pub use full::{Full, full, unexplained};
pub use recording::{FromRecording, Settings, from_recording};
pub use replicate::{Source, replicates};

use flexbeam_lti::cover::{Uncovered, cover};
use flexbeam_lti::response::Hessenberg;
use flexbeam_lti::{C64, StateSpace, Zpk};

use crate::Error;

/// A bound, and what it is made of.
#[derive(Clone, Debug)]
pub struct Bound {
    /// alpha(s) in the shifted plane: stable, minimum phase, one zero and one pole.
    pub alpha: Zpk,
    /// Largest |full - G0| on the line.
    pub difference: f64,
    /// Largest radius of the band on the line.
    pub radius: f64,
}

/// alpha(s) above |full(jw - beta) - nominal(jw - beta)| + band.
///
/// Shapes: one input and one output, continuous; the band on s = jw - beta.
/// Errors: [`Error::Setting`] unless beta is positive; [`Error::PoleBeyond`] where the full model has more or fewer poles right of
/// the line than the nominal plant.
/// Numerics: see [`flexbeam_lti::cover::cover`].
pub fn bound(full: &StateSpace, nominal: &StateSpace, band: &Band, beta: f64) -> Result<Bound, Error> {
    if !(beta > 0.0 && beta.is_finite()) {
        return Err(Error::Setting {
            setting: "the stability degree beta [1/s]",
            found: beta,
            needed: "a positive number",
        });
    }
    expect_equal_poles(full, nominal, beta)?;
    let (G, G0) = (Hessenberg::new(full), Hessenberg::new(nominal));
    let difference = |omega: f64| {
        let s = C64::new(-beta, omega);
        (G.at(s)[(0, 0)] - G0.at(s)[(0, 0)]).norm()
    };
    let fastest = full.poles().iter().fold(0.0_f64, |most, p| most.max(p.im));
    let alpha = cover(|omega| difference(omega) + band.radius_at(omega), beta, fastest)
        .map_err(|Uncovered { omega_rad_s, .. }| Error::PoleBeyond { beta, re: -beta, im: omega_rad_s })?;
    let largest = |f: &dyn Fn(f64) -> f64| band.omega_rad_s.iter().map(|w| f(*w)).fold(0.0, f64::max);
    Ok(Bound { alpha, difference: largest(&difference), radius: largest(&|w| band.radius_at(w)) })
}

/// Poles right of the line Re s = -beta.
pub(crate) fn poles_beyond(system: &StateSpace, beta: f64) -> Vec<C64> {
    system.poles().into_iter().filter(|p| p.re > -beta).collect()
}

fn expect_equal_poles(full: &StateSpace, nominal: &StateSpace, beta: f64) -> Result<(), Error> {
    let (ours, theirs) = (poles_beyond(full, beta), poles_beyond(nominal, beta));
    if ours.len() == theirs.len() {
        return Ok(());
    }
    // The one that has no partner: farthest from all poles of the other model.
    let (more, fewer) = if ours.len() > theirs.len() { (&ours, nominal.poles()) } else { (&theirs, full.poles()) };
    let apart = |p: &C64| fewer.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
    let lone = more.iter().max_by(|a, b| apart(a).total_cmp(&apart(b))).expect("one has more poles than the other");
    Err(Error::PoleBeyond { beta, re: lone.re, im: lone.im.abs() })
}
