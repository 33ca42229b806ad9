//! A real rig before its run: where its zeroes are, and whether it turns the way the model does.

use std::sync::Arc;

use flexbeam_kernel as kernel;
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::{
    Cause, NotHomed, Outcome, Sample, Setup, SignWatch, Zero, drive, open_loop_setup, sign_check_voltages, signs_of,
    zero_of,
};

use crate::Failure;

/// Length of a look at the rig at rest [s].
const LOOK_S: f64 = 0.5;
/// How often it is looked at while it still moves.
const LOOKS: usize = 40;
/// Slope of the sign check's ramp [V/s].
const RATE_V_S: f64 = 2.0;

/// A run before the run that did not end well.
#[derive(Debug, thiserror::Error)]
#[error("found that {0}, needed a rig that can be homed\nhint: nothing but a few volts at most had been sent")]
struct EndedEarly(String);

/// Finds the zeroes and checks the signs; the zeroes go into the settings.
///
/// Errors: a rig that does not come to rest, whose signs are wrong, or that faults.
pub fn home(back_end: Box<dyn BackEnd>, setup: &mut Setup, highest_v: f64) -> Result<Box<dyn BackEnd>, Failure> {
    let (back_end, zero) = at_rest(back_end, setup)?;
    let settings = &mut setup.live.settings;
    (settings.theta.offset_rad, settings.alpha.offset_rad) = (zero.theta_rad, zero.alpha_rad);
    eprintln!(
        "homed: zero of the hub {:+.2}°, of the gauge {:+.3}° (noise {:.3}° rms)",
        zero.theta_rad.to_degrees(),
        zero.alpha_rad.to_degrees(),
        zero.alpha_noise_rad.to_degrees()
    );
    if highest_v > 0.0 { signs(back_end, setup, zero, highest_v) } else { Ok(back_end) }
}

/// Looks until the rig is still.
fn at_rest(mut back_end: Box<dyn BackEnd>, setup: &Setup) -> Result<(Box<dyn BackEnd>, Zero), Failure> {
    // Before the zeroes are known no limit on the angles means anything; the voltage is 0 V.
    let unlimited = kernel::Settings { deflection_limit_rad: f64::MAX, ..kernel::Settings::default() };
    let still: Arc<[f64]> = vec![0.0; (LOOK_S / setup.period_s).ceil() as usize].into();
    let mut left = LOOKS;
    loop {
        let (rig, samples) = driven(back_end, open_loop_setup(still.clone(), &unlimited, setup), |_| false)?;
        back_end = rig;
        left -= 1;
        match zero_of(&samples) {
            Ok(zero) => return Ok((back_end, zero)),
            Err(NotHomed::NotAtRest { .. }) if left > 0 => {
                if left + 1 == LOOKS {
                    eprintln!("the rig still moves; waiting for it");
                }
            }
            Err(error) => return Err(Failure::while_trying("home the rig")(error)),
        }
    }
}

fn signs(back_end: Box<dyn BackEnd>, setup: &Setup, zero: Zero, highest_v: f64) -> Result<Box<dyn BackEnd>, Failure> {
    let voltages = sign_check_voltages(highest_v, RATE_V_S, setup.period_s);
    let mut watch = SignWatch::new(zero, setup.period_s);
    let setup = open_loop_setup(voltages, &setup.live.settings, setup);
    let (back_end, samples) = driven(back_end, setup, move |sample| watch.enough(sample))?;
    let agree = signs_of(&samples, &zero).map_err(Failure::while_trying("check the signs of the rig"))?;
    let turned = agree.theta_rad.to_degrees();
    match agree.alpha_rad {
        Some(alpha) => {
            eprintln!(
                "signs agree: at {:+.2} V the hub turned {turned:+.2}°, the tip lagged {:+.2}°",
                agree.voltage_v,
                alpha.to_degrees()
            );
        }
        None => eprintln!("the hub turns with the voltage; the gauge's sign is not proven, its swing drowned in noise"),
    }
    Ok(back_end)
}

/// Errors: a rig that faulted on the way: status 3.
fn driven(
    back_end: Box<dyn BackEnd>,
    setup: Setup,
    enough: impl FnMut(&Sample) -> bool + Send + 'static,
) -> Result<(Box<dyn BackEnd>, Vec<Sample>), Failure> {
    let asked = setup.asked.clone();
    let (outcome, samples) = drive(back_end, setup, enough).map_err(Failure::while_trying("home the rig"))?;
    let Outcome { report, back_end, .. } = outcome;
    let stopped = asked.load(std::sync::atomic::Ordering::Acquire);
    match (report.cause, back_end) {
        (Cause::Over | Cause::Asked, Some(back_end)) if !stopped => Ok((back_end, samples)),
        (Cause::Over | Cause::Asked, _) => {
            Err(Failure::Fault(Box::new(EndedEarly("it was stopped while homing".into()))))
        }
        (Cause::Fault(_), _) => Err(Failure::Fault(Box::new(EndedEarly(report.text)))),
    }
}
