//! Homing and the sign check on simulated rigs: right ones, and ones that are wired the wrong way round.

mod scripted;

use flexbeam_kernel::Settings;
use flexbeam_rig::{Gauge, Measurement, RigParameters, Sensors, SimulatedRig};
use flexbeam_runtime::back_end::{Answer, BackEnd};
use flexbeam_runtime::{
    ControllerData, Live, NotHomed, Reference, Sample, Setup, SignWatch, SignsAgree, SimulatedBackEnd, Zero, drive,
    open_loop_setup, sign_check_voltages, signs_of, zero_of,
};
use scripted::Scripted;
use std::sync::Arc;

/// How a rig is wired: factors of voltage, encoder and gauge.
type Wiring = [f64; 3];

fn wired([volts, theta, alpha]: Wiring, parameters: &RigParameters) -> Scripted {
    let mut rig = SimulatedBackEnd::new(SimulatedRig::new(parameters, 5).unwrap()).unwrap();
    Scripted::with_voltage(move |instant, voltage_v| {
        let answer = rig.exchange(instant, volts * voltage_v)?;
        let turn = |m: Measurement| Measurement { theta_rad: theta * m.theta_rad, alpha_rad: alpha * m.alpha_rad };
        Ok(match answer {
            Answer::Fresh(m) => Answer::Fresh(turn(m)),
            Answer::Lost => Answer::Lost,
        })
    })
}

fn base() -> Setup {
    let live = Live { revision: 0, settings: Settings::default(), reference: Reference::default() };
    Setup { hold_s: 10.0, ..Setup::new(ControllerData::pass_through(), live, 1e-3) }
}

fn at_rest(rig: Box<dyn BackEnd>) -> (Vec<Sample>, Box<dyn BackEnd>) {
    let still: Arc<[f64]> = vec![0.0; 300].into();
    let (outcome, samples) =
        drive(rig, open_loop_setup(still, &Settings::default(), &base()), Vec::new(), |_| false).unwrap();
    (samples, outcome.back_end.unwrap())
}

fn checked(wiring: Wiring, parameters: &RigParameters) -> (Result<SignsAgree, NotHomed>, f64) {
    let (samples, rig) = at_rest(Box::new(wired(wiring, parameters)));
    let zero = zero_of(&samples).unwrap();
    let mut watch = SignWatch::new(zero, 1e-3);
    let setup = open_loop_setup(sign_check_voltages(1.5, 2.0, 1e-3), &Settings::default(), &base());
    let (_, samples) = drive(rig, setup, Vec::new(), move |sample| watch.enough(sample)).unwrap();
    let furthest = samples.iter().fold(0.0_f64, |far, s| far.max((s.measured.theta_rad - zero.theta_rad).abs()));
    (signs_of(&samples, &zero), furthest)
}

#[test]
fn the_zeroes_are_where_the_rig_rests() {
    let gauge = Gauge { bias_rad: 0.03, ..Gauge::default() };
    let parameters = RigParameters { sensors: Sensors { gauge, ..Sensors::default() }, ..RigParameters::default() };
    let (samples, _) = at_rest(Box::new(wired([1.0; 3], &parameters)));
    let Zero { theta_rad, alpha_rad, alpha_noise_rad } = zero_of(&samples).unwrap();
    assert_eq!(theta_rad, 0.0);
    // Five standard deviations of the mean of 300 readings, and half a step of the converter.
    assert!((alpha_rad - 0.03).abs() < 5.0 * 2e-4 / 300f64.sqrt() + 0.74e-4, "{alpha_rad}");
    assert!((alpha_noise_rad / 2e-4 - 1.0).abs() < 0.25, "{alpha_noise_rad}");
}

#[test]
fn a_rig_that_swings_or_says_nothing_is_not_homed() {
    let swinging = Scripted::new(|k| {
        let alpha_rad = 0.02 * (k as f64 * 0.02).sin();
        Ok(Answer::Fresh(Measurement { theta_rad: 0.0, alpha_rad }))
    });
    assert!(matches!(zero_of(&at_rest(Box::new(swinging)).0), Err(NotHomed::NotAtRest { .. })));
    let turning = Scripted::new(|k| Ok(Answer::Fresh(Measurement { theta_rad: 1e-4 * k as f64, alpha_rad: 0.0 })));
    assert!(matches!(zero_of(&at_rest(Box::new(turning)).0), Err(NotHomed::NotAtRest { .. })));
    let silent = Scripted::new(|_| Ok(Answer::Lost));
    assert_eq!(zero_of(&at_rest(Box::new(silent)).0), Err(NotHomed::NoMeasurement));
}

#[test]
fn right_signs_agree_after_a_few_degrees() {
    for parameters in [RigParameters::default(), RigParameters::default().linear()] {
        let (found, furthest) = checked([1.0; 3], &parameters);
        let found = found.unwrap();
        assert!(found.theta_rad > 0.0 && found.alpha_rad.unwrap() < 0.0, "{found:?}");
        assert!(furthest < 10f64.to_radians(), "{} degree", furthest.to_degrees());
    }
    let (both, _) = checked([-1.0, -1.0, -1.0], &RigParameters::default());
    assert!(both.is_ok(), "all three turned round is the same rig seen from below");
}

#[test]
fn each_wrong_sign_is_found_before_it_can_hurt() {
    for (wiring, name) in [([-1.0, 1.0, 1.0], "hub"), ([1.0, -1.0, 1.0], "hub"), ([1.0, 1.0, -1.0], "gauge")] {
        let (found, furthest) = checked(wiring, &RigParameters::default());
        match (found, name) {
            (Err(NotHomed::HubAgainst { theta_deg, voltage_v }), "hub") => assert!(theta_deg < 0.0 && voltage_v > 0.0),
            (Err(NotHomed::GaugeAgainst { alpha_deg, .. }), "gauge") => assert!(alpha_deg > 0.0),
            other => panic!("{wiring:?}: {other:?}"),
        }
        assert!(furthest < 10f64.to_radians(), "{} degree", furthest.to_degrees());
    }
}

#[test]
fn an_amplifier_that_is_off_is_named() {
    let (found, _) = checked([0.0, 1.0, 1.0], &RigParameters::default());
    assert_eq!(found, Err(NotHomed::NeverMoved { voltage_v: 1.5 }));
}
