//! Every way in which a run ends, by doing it: the rig is at 0 V within the period in which the end began.

mod scripted;

use flexbeam_kernel::Fault;
use flexbeam_rig::Measurement;
use flexbeam_runtime::back_end::{Answer, LinkFault};
use flexbeam_runtime::{Cause, Controls, EventKind, FrozenLimit, Outcome, Phase, RunFault, Session, Setup};
use scripted::{DRY_SLEEPS, Ear, Log, Scripted, Virtual, alive, armed, open_loop, still};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// Runs to the end on a virtual clock.
fn run(rig: Scripted, setup: Setup, late_ns: Vec<(u64, u64)>) -> (Outcome, Ear, Vec<(Option<u64>, f64)>) {
    let log = rig.log.clone();
    let (session, ear) = armed(rig, setup, Virtual { late_ns, ..Virtual::default() });
    let outcome = session.finish();
    let log = log.lock().unwrap().clone();
    (outcome, ear, log)
}

/// 0 V was the last that the rig heard, and nothing but 0 V came after `instant`.
fn assert_zero_from(log: &[(Option<u64>, f64)], instant: u64) {
    assert_eq!(log.last(), Some(&(None, 0.0)), "the last word is 0 V");
    let later = log.iter().filter(|(k, _)| k.is_some_and(|k| k > instant));
    assert_eq!(later.count(), 0, "no exchange after instant {instant}: {log:?}");
}

fn fault_of(outcome: &Outcome) -> RunFault {
    match outcome.report.cause {
        Cause::Fault(fault) => fault,
        cause => panic!("needed a fault, found {cause:?}"),
    }
}

/// A rig that at instant 7 asks for something through the controls; it is met there, before or after the exchange.
fn asking(act: fn(&Controls)) -> (Outcome, Vec<(Option<u64>, f64)>, Ear) {
    let (hand, wanted) = mpsc::channel::<Controls>();
    let mut controls = None;
    let rig = Scripted::new(move |instant| {
        let controls = controls.get_or_insert_with(|| wanted.recv().unwrap());
        if instant == 7 {
            act(controls);
        }
        Ok(alive(instant))
    });
    let log = rig.log.clone();
    let (session, ear) = armed(rig, open_loop(2.0), Virtual::default());
    hand.send(session.controls.clone()).unwrap();
    let outcome = session.finish();
    let log = log.lock().unwrap().clone();
    (outcome, log, ear)
}

#[test]
fn over() {
    let setup = Setup { duration_s: Some(0.01), ..open_loop(2.0) };
    let (outcome, ear, log) = run(Scripted::new(|k| Ok(alive(k))), setup, vec![]);
    assert_eq!(outcome.report.cause, Cause::Over);
    let sent: Vec<f64> = log.iter().filter(|(k, _)| k.is_some()).map(|(_, v)| *v).collect();
    assert_eq!(sent, [0.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0], "one period of delay, ten ticks");
    assert_zero_from(&log, 9);
    let heard = ear.0.lock().unwrap();
    let kinds: Vec<&str> = heard.events.iter().map(|event| event.kind.name()).collect();
    assert_eq!(kinds, ["started", "stopped"], "armed and started with the same tick");
    let last = heard.samples.last().unwrap();
    assert_eq!((heard.samples.len(), last.phase, last.voltage_v, last.fault), (11, Phase::Stopped, 0.0, None));
    assert!(outcome.back_end.is_some() && heard.reports.len() == 1);
}

#[test]
fn stop_key_signal_or_socket() {
    let (outcome, log, ear) = asking(Controls::stop);
    assert_eq!(outcome.report.cause, Cause::Asked);
    assert_zero_from(&log, 7);
    assert_eq!(ear.0.lock().unwrap().samples.last().unwrap().phase, Phase::Stopped);
}

#[test]
fn a_real_signal() {
    let (hand, wanted) = mpsc::channel::<()>();
    let mut go = Some(wanted);
    let rig = Scripted::new(move |instant| {
        if let Some(go) = go.take() {
            go.recv().unwrap();
        }
        if instant == 7 {
            nix::sys::signal::raise(nix::sys::signal::Signal::SIGUSR1).unwrap();
        }
        Ok(alive(instant))
    });
    let log = rig.log.clone();
    let asked = Arc::<AtomicBool>::default();
    let setup = Setup { asked: asked.clone(), ..open_loop(2.0) };
    let (session, _ear) = armed(rig, setup, Virtual::default());
    let id = signal_hook::flag::register(signal_hook::consts::SIGUSR1, asked.clone()).unwrap();
    hand.send(()).unwrap();
    assert_eq!(session.finish().report.cause, Cause::Asked);
    signal_hook::low_level::unregister(id);
    assert_zero_from(&log.lock().unwrap(), 7);
}

#[test]
fn emergency() {
    let (outcome, log, ear) = asking(Controls::emergency);
    assert_eq!(fault_of(&outcome), RunFault::Emergency);
    assert_zero_from(&log, 7);
    let heard = ear.0.lock().unwrap();
    let last = heard.samples.last().unwrap();
    assert_eq!((last.phase, last.fault, last.voltage_v), (Phase::Faulted, Some(RunFault::Emergency), 0.0));
    assert_eq!(heard.events.last().unwrap().kind.name(), "fault");
}

#[test]
fn emergency_and_stop_end_an_armed_run_too() {
    for (act, end) in [(Controls::emergency as fn(&Controls), Phase::Faulted), (Controls::stop, Phase::Stopped)] {
        let rig = Scripted::new(|k| Ok(alive(k)));
        let log = rig.log.clone();
        let (session, _ear) = armed(rig, Setup { autostart: false, ..open_loop(2.0) }, Virtual::default());
        act(&session.controls);
        let controls = session.controls.clone();
        session.finish();
        assert_eq!(controls.phase(), end);
        assert!(log.lock().unwrap().iter().all(|(_, v)| *v == 0.0), "an armed rig never got a volt");
    }
}

#[test]
fn the_kernel_s_limits_and_a_reading_that_is_no_number() {
    let readings = [
        (Measurement { theta_rad: 0.0, alpha_rad: 0.6 }, Fault::Deflection),
        (Measurement { theta_rad: f64::NAN, alpha_rad: 0.0 }, Fault::NonFinite),
        (Measurement { theta_rad: 0.0, alpha_rad: f64::INFINITY }, Fault::NonFinite),
        (Measurement { theta_rad: 3.5, alpha_rad: 0.0 }, Fault::Angle),
        (Measurement { theta_rad: 0.4, alpha_rad: 0.0 }, Fault::Speed),
    ];
    for (bad, fault) in readings {
        let rig = Scripted::new(move |k| Ok(if k == 5 { Answer::Fresh(bad) } else { alive(k) }));
        let mut setup = open_loop(2.0);
        setup.live.settings.theta_limit_rad = 3.0;
        setup.live.settings.theta_step_limit_rad = if fault == Fault::Speed { 0.1 } else { f64::INFINITY };
        let (outcome, ear, log) = run(rig, setup, vec![]);
        assert_eq!(fault_of(&outcome), RunFault::Kernel(fault));
        assert_zero_from(&log, 5);
        assert_eq!(ear.0.lock().unwrap().samples.last().unwrap().commanded.voltage_v, 0.0);
    }
}

/// A hub at 10 rad/s turns 0.01 rad a period: within a limit of 0.02 whatever is missed, beyond one of 0.005 in any case.
#[test]
fn the_speed_limit_knows_of_missed_periods_and_lost_measurements() {
    let run_with = |limit: f64| {
        let rig = Scripted::new(|k| {
            let turning = Measurement { theta_rad: 0.01 * k as f64, alpha_rad: 0.0 };
            Ok(if (20..30).contains(&k) { Answer::Lost } else { Answer::Fresh(turning) })
        });
        let mut setup = Setup { duration_s: Some(0.1), ..open_loop(2.0) };
        setup.live.settings.theta_step_limit_rad = limit;
        run(rig, setup, vec![(DRY_SLEEPS + 6, 8_000_000)]).0
    };
    assert_eq!(run_with(0.02).report.cause, Cause::Over);
    assert_eq!(fault_of(&run_with(0.005)), RunFault::Kernel(Fault::Speed));
}

#[test]
fn a_lost_back_end() {
    for fault in [LinkFault::Gone { errno: 111 }, LinkFault::RigTimedOut, LinkFault::Version { found: 2, known: 1 }] {
        let rig = Scripted::new(move |k| if k == 5 { Err(fault) } else { Ok(alive(k)) });
        let (outcome, _ear, log) = run(rig, open_loop(2.0), vec![]);
        assert_eq!(fault_of(&outcome), RunFault::Link(fault));
        assert_eq!(outcome.report.text, fault.to_string());
        assert_zero_from(&log, 5);
    }
}

#[test]
fn silence_longer_than_one_voltage_may_stand() {
    let silent_for = |ticks: u64| {
        let rig = Scripted::new(move |k| Ok(if (5..5 + ticks).contains(&k) { Answer::Lost } else { alive(k) }));
        run(rig, Setup { duration_s: Some(0.1), hold_s: 0.02, ..open_loop(2.0) }, vec![])
    };
    let (outcome, ear, _) = silent_for(20);
    assert_eq!(outcome.report.cause, Cause::Over, "as long as it may be");
    assert_eq!(outcome.report.meter.stale, 20);
    let heard = ear.0.lock().unwrap();
    let stale: Vec<u64> = heard.samples[..100].iter().filter(|s| s.stale).map(|s| s.instant).collect();
    assert_eq!(stale, (5..25).collect::<Vec<_>>(), "each is marked in the recording");
    let (outcome, _, log) = silent_for(21);
    assert_eq!(fault_of(&outcome), RunFault::Silent { for_ns: 21_000_000 });
    assert_zero_from(&log, 25);
}

#[test]
fn an_overrun() {
    let late = |ns| vec![(DRY_SLEEPS + 6, ns)];
    let setup = || Setup { duration_s: Some(0.1), hold_s: 0.02, ..open_loop(2.0) };
    let (outcome, ear, log) = run(Scripted::new(|k| Ok(alive(k))), setup(), late(19_500_000));
    assert_eq!((outcome.report.cause, outcome.report.meter.missed), (Cause::Over, 19));
    let instants: Vec<u64> = ear.0.lock().unwrap().samples[..8].iter().map(|s| s.instant).collect();
    assert_eq!(instants, [0, 1, 2, 3, 4, 5, 25, 26], "missed periods are a gap, not made up for");
    assert_eq!(log.last(), Some(&(None, 0.0)));
    let (outcome, _, log) = run(Scripted::new(|k| Ok(alive(k))), setup(), late(20_500_000));
    assert_eq!(fault_of(&outcome), RunFault::Overrun { late_ns: 20_500_000 });
    assert_zero_from(&log, 5);
}

#[test]
fn frozen_sensors() {
    let limit = FrozenLimit { voltage_v: 1.0, time_s: 0.05 };
    let setup = |volts| Setup { duration_s: Some(0.2), frozen: limit, ..open_loop(volts) };
    let (outcome, _, log) = run(Scripted::new(|_| Ok(still())), setup(2.0), vec![]);
    assert_eq!(fault_of(&outcome), RunFault::Frozen { for_ns: 51_000_000 });
    assert_zero_from(&log, 51);
    let (outcome, ..) = run(Scripted::new(|_| Ok(still())), setup(0.9), vec![]);
    assert_eq!(outcome.report.cause, Cause::Over, "a voltage that need not move the hub proves nothing");
}

#[test]
fn a_back_end_that_hangs_is_cut_off_by_the_watchdog() {
    let rig = Scripted::new(move |k| {
        if k == 5 {
            std::thread::sleep(Duration::from_millis(300));
        }
        Ok(alive(k))
    });
    let (outcome, _, log) = run(rig, Setup { hold_s: 0.005, ..open_loop(2.0) }, vec![]);
    assert_eq!(fault_of(&outcome), RunFault::Watchdog);
    let fifth = log.iter().position(|(k, _)| *k == Some(5)).unwrap();
    assert_eq!(log[fifth + 1], (None, 0.0), "cut off while the exchange hung");
    assert_zero_from(&log, 5);
}

#[test]
fn a_loop_that_never_comes_back_is_left_behind_at_zero() {
    let rig = Scripted::new(move |k| {
        if k == 5 {
            std::thread::sleep(Duration::from_secs(3600));
        }
        Ok(alive(k))
    });
    let (outcome, ear, log) = run(rig, Setup { hold_s: 0.005, ..open_loop(2.0) }, vec![]);
    assert_eq!(fault_of(&outcome), RunFault::Watchdog);
    assert!(outcome.back_end.is_none());
    assert_zero_from(&log, 5);
    assert_eq!(ear.0.lock().unwrap().reports.len(), 1, "the recording is closed all the same");
}

#[test]
fn a_panic_in_the_loop_s_thread() {
    let rig = Scripted::new(|k| if k == 5 { panic!("planted") } else { Ok(alive(k)) });
    let (outcome, _, log) = run(rig, open_loop(2.0), vec![]);
    assert_eq!(fault_of(&outcome), RunFault::Panicked);
    assert_zero_from(&log, 5);
}

#[test]
fn a_dropped_session_does_not_run_on() {
    let rig = Scripted::new(|k| Ok(alive(k)));
    let log: Log = rig.log.clone();
    let (session, _ear): (Session, Ear) = armed(rig, open_loop(2.0), Virtual::default());
    drop(session);
    for _ in 0..1000 {
        if log.lock().unwrap().last() == Some(&(None, 0.0)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("the loop runs on without anybody who could stop it");
}

/// Whoever may still note something does not keep the recorder of a session that nobody holds any more.
#[test]
fn notes_do_not_keep_a_recorder() {
    let (session, ear) = armed(Scripted::new(|k| Ok(alive(k))), open_loop(2.0), Virtual::default());
    let notes = session.notes();
    notes.note(EventKind::Warning, "in time");
    drop(session);
    let patience = Instant::now();
    while Arc::strong_count(&ear.0) > 1 {
        assert!(patience.elapsed() < Duration::from_secs(60), "the recorder has not ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    notes.note(EventKind::Warning, "too late");
    let heard = ear.0.lock().unwrap();
    let noted: Vec<&str> =
        heard.events.iter().filter(|e| e.kind == EventKind::Warning).map(|e| e.text.as_str()).collect();
    assert!(noted.contains(&"in time") && !noted.contains(&"too late"), "{noted:?}");
}
