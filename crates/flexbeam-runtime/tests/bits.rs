//! Same controller, same seed: the real-time run in the process gives the bits of the simulation.

mod scripted;

use flexbeam_kernel::{Controller, Law, Settings};
use flexbeam_rig::{RigParameters, SimulatedRig, closed_loop};
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::{
    ControllerData, Live, LiveControl, Monotonic, Phase, Reference, Sample, Session, Setup, Shape, SimulatedBackEnd,
};
use scripted::{Ear, Scripted, Virtual, armed, simulated};
use std::sync::mpsc;

/// A stable controller with memory: a filtered proportional feedback whose model follows v.
fn controller() -> ControllerData {
    let (a, b, c, d) =
        ([0.9, 0.0, 0.05, 0.8], [0.1, 0.2, -0.1, -0.2, 0.01, 0.02], [1.5, 0.1, -0.7, 0.2], [4.0, 0.3, -4.0, 0.0]);
    ControllerData { order: 2, coefficients: a.into_iter().chain(b).chain(c).chain(d).collect() }
}

fn setup(samples: u64, period_s: f64) -> Setup {
    let settings = Settings {
        law: Law::Inverse,
        u_p_plus_v: 0.26,
        u_p_minus_v: 0.09,
        eps_u_v: 0.01,
        smooth_ticks: 200.0,
        ..Settings::default()
    };
    let reference = Reference { amplitude_rad: 30f64.to_radians(), ..Reference::default() };
    let live = Live { revision: 0, settings, reference };
    Setup { duration_s: Some(samples as f64 * period_s), ..Setup::new(controller(), live, period_s) }
}

/// The running samples against `closed_loop`, to the last bit.
fn assert_same_bits(samples: &[Sample], rig: &RigParameters, seed: u64, setup: &Setup) {
    let running: Vec<&Sample> = samples.iter().filter(|s| s.phase == Phase::Running).collect();
    let controller = Controller::new(setup.controller.order, &setup.controller.coefficients).unwrap();
    let step = |time_s: f64| if time_s < 0.1 { 0.0 } else { 30f64.to_radians() };
    let mut rig = SimulatedRig::new(rig, seed).unwrap();
    let record = closed_loop(&mut rig, &setup.live.settings, &controller, step, running.len());
    assert!(running.len() > 1000);
    for (k, sample) in running.iter().enumerate() {
        let found = [
            sample.reference_rad,
            sample.commanded.reference_rad,
            sample.commanded.voltage_v,
            sample.commanded.u_v,
            sample.measured.theta_rad,
            sample.measured.alpha_rad,
            sample.commanded.y_model_rad,
        ];
        let expected = [
            record.reference_rad[k],
            record.smoothed_rad[k],
            record.voltage_v[k],
            record.u_v[k],
            record.theta_measured_rad[k],
            record.alpha_measured_rad[k],
            record.y_model_rad[k],
        ];
        assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "tick {k}: {found:?} {expected:?}");
    }
    assert!(record.theta_rad.last().unwrap().abs() > 0.1, "the rig has moved");
}

#[test]
fn on_a_virtual_clock() {
    for computing_delay_periods in [1, 3] {
        let parameters = RigParameters { computing_delay_periods, ..RigParameters::default() };
        let rig = SimulatedRig::new(&parameters, 9).unwrap();
        let setup = setup(3000, 1e-3);
        let (session, ear) = armed(SimulatedBackEnd::new(rig).unwrap(), setup.clone(), Virtual::default());
        session.finish();
        assert_same_bits(&ear.0.lock().unwrap().samples, &parameters, 9, &setup);
    }
}

/// A stall that costs periods is no failure of the loop; then the run is made again.
#[test]
fn on_the_real_clock() {
    for attempt in 0..10 {
        let setup = Setup { hold_s: 10.0, ..setup(1500, 1e-3) };
        let ear = Ear::default();
        let rig = Box::new(SimulatedBackEnd::new(simulated(attempt)).unwrap());
        let outcome = Session::arm_on(Monotonic, rig, setup.clone(), vec![Box::new(ear.clone())]).unwrap().finish();
        if outcome.report.meter.missed == 0 {
            assert_same_bits(&ear.0.lock().unwrap().samples, &RigParameters::default(), attempt, &setup);
            return;
        }
    }
    eprintln!("!!! LEFT OUT: in ten attempts this machine never held 1 kHz for 1.5 s !!!");
}

/// A change every 20 ticks, made from the rig's side so that the tick of each is known.
fn changing(samples: u64, change: impl Fn(u64, &mut Live) + Send + 'static) -> Ear {
    let (hand, wanted) = mpsc::channel::<LiveControl>();
    let mut control = None;
    let mut rig = SimulatedBackEnd::new(simulated(1)).unwrap();
    let scripted = Scripted::with_voltage(move |instant, voltage_v| {
        let control = control.get_or_insert_with(|| wanted.recv().unwrap());
        if instant > 0 && instant % 20 == 0 {
            control.change(|live| change(instant, live)).unwrap();
        }
        rig.exchange(instant, voltage_v)
    });
    let (session, ear) = armed(scripted, setup(samples, 1e-3), Virtual::default());
    hand.send(session.live.clone()).unwrap();
    session.finish();
    ear
}

/// Each change is in force whole with its tick, marked by its revision; and the reference that the controller gets stays smooth,
/// whatever was changed: from rest 15/8 of the way in 200 ticks, the way at most two amplitudes, and four times that for a path
/// that is sent elsewhere on the way.
#[test]
fn settings_change_whole_and_without_a_bump() {
    let ear = changing(3000, |instant, live| {
        live.settings.u_p_plus_v = 0.2 + 1e-5 * instant as f64;
        live.reference.shape = [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Step][instant as usize / 20 % 4];
        live.reference.period_s = 1.0 + (instant % 7) as f64;
    });
    let heard = ear.0.lock().unwrap();
    let found: Vec<(u64, u32)> = heard.settings.iter().map(|(instant, live)| (*instant, live.revision)).collect();
    let expected: Vec<(u64, u32)> = (0..150).map(|k| (20 * k, k as u32)).collect();
    assert_eq!(found, expected);
    assert!(heard.settings[1..].iter().all(|(k, live)| live.settings.u_p_plus_v == 0.2 + 1e-5 * *k as f64));
    let samples: Vec<&Sample> = heard.samples.iter().filter(|s| s.phase == Phase::Running).collect();
    assert!(samples.iter().all(|s| u64::from(s.revision) == s.instant / 20));
    let steps = samples.windows(2).map(|w| (w[1].commanded.reference_rad - w[0].commanded.reference_rad).abs());
    assert!(steps.fold(0.0, f64::max) < 4.0 * 2.0 * 30f64.to_radians() * 15.0 / 8.0 / 200.0);
}

/// Another compensation voltage moves the voltage by no more than that, and not the controller's state.
#[test]
fn a_new_compensation_voltage_moves_the_voltage_by_its_own_size_at_most() {
    let quiet = changing(1500, |_, _| {});
    let changed = changing(1500, |instant, live| {
        if instant == 700 {
            live.settings.u_p_plus_v = 0.25
        }
    });
    let (quiet, changed) = (quiet.0.lock().unwrap(), changed.0.lock().unwrap());
    let difference = |k: usize| (quiet.samples[k].commanded.voltage_v - changed.samples[k].commanded.voltage_v).abs();
    assert!((0..700).all(|k| difference(k) == 0.0));
    assert_eq!(quiet.samples[700].commanded.u_v.to_bits(), changed.samples[700].commanded.u_v.to_bits());
    assert!(difference(700) <= 0.26 - 0.25 + 1e-12);
}

/// Changing to what is in force already changes no bit.
#[test]
fn a_change_to_the_same_changes_no_bit() {
    let run = |touch: bool| {
        let setup = setup(2000, 1e-3);
        let (session, ear) = armed(SimulatedBackEnd::new(simulated(4)).unwrap(), setup, Virtual::default());
        (0..50).filter(|_| touch).for_each(|_| assert_eq!(session.live.change(|live| live.revision = 0), Ok(0)));
        session.finish();
        let heard = ear.0.lock().unwrap();
        heard.samples.iter().map(|s| s.commanded.voltage_v.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(run(false), run(true));
}
