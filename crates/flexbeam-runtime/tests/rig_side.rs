//! The rig's side of the protocol: whatever the order in which commands arrive, the newest voltage stands, and none for too
//! long.

use flexbeam_files::frame::{Command, Measurement};
use flexbeam_runtime::rig_side::{Decision, Passed, Phase, RigSide};
use proptest::prelude::*;

const HOLD_MS: u16 = 20;

fn command(session: u32, sequence: u32, voltage_v: f64) -> Command {
    Command { session, sequence, hold_ms: HOLD_MS, flags: 0, voltage_v }
}

fn greeting(session: u32) -> Command {
    command(session, u32::MAX, 0.0)
}

fn stop(session: u32) -> Command {
    Command { flags: Command::STOP, ..command(session, 0, 0.0) }
}

/// Obeys, and answers with readings that tell the answers apart.
fn answered(side: &mut RigSide, command: &Command, now_ms: u32, reading: f64) -> Option<Measurement> {
    match side.on_command(command, now_ms) {
        Decision::Older | Decision::Foreign => None,
        Decision::Repeat(reply) => Some(reply),
        Decision::Read(_) => Some(side.answer(command, reading, -reading, 0)),
    }
}

fn running(session: u32) -> RigSide {
    let mut side = RigSide::new(1);
    assert_eq!(side.on_command(&greeting(session), 0), Decision::Read(Passed::Nothing));
    assert_eq!(side.phase(), Phase::Greeted);
    assert_eq!(side.on_command(&command(session, 0, 1.0), 0), Decision::Read(Passed::Began));
    side
}

#[test]
fn greetings_move_nothing_and_do_not_time_out() {
    let mut side = RigSide::new(1);
    for k in 0..10 {
        let greeting = Command { voltage_v: 9.0, ..command(5, k - 10, 0.0) };
        let answer = answered(&mut side, &greeting, 1000 * k, 0.0).unwrap();
        assert_eq!((side.phase(), side.voltage_v(), answer.status), (Phase::Greeted, 0.0, 0));
    }
}

#[test]
fn periods_are_counted_between_commands() {
    let mut side = running(5);
    assert_eq!(side.on_command(&command(5, 1, 2.0), 1), Decision::Read(Passed::Periods(1)));
    assert_eq!(side.on_command(&command(5, 7, 3.0), 7), Decision::Read(Passed::Periods(6)));
}

#[test]
fn a_time_out_lasts_until_the_next_session() {
    let mut side = running(5);
    side.on_tick(u32::from(HOLD_MS));
    assert_eq!(side.voltage_v(), 1.0, "it may stand for the whole of its hold");
    side.on_tick(u32::from(HOLD_MS) + 1);
    assert_eq!((side.voltage_v(), side.phase()), (0.0, Phase::TimedOut));
    let answer = answered(&mut side, &command(5, 21, 4.0), 22, 0.0).unwrap();
    assert_eq!((answer.status, side.voltage_v()), (Measurement::TIMED_OUT, 0.0));
    assert!(answered(&mut side, &greeting(6), 30, 0.0).is_some_and(|answer| answer.status == 0));
    assert_eq!(side.on_command(&command(6, 0, 4.0), 31), Decision::Read(Passed::Began));
    assert_eq!(side.voltage_v(), 4.0);
}

#[test]
fn a_command_that_comes_after_the_hold_is_too_late_even_without_a_tick() {
    let mut side = running(5);
    assert_eq!(side.on_command(&command(5, 1, 2.0), 100), Decision::Read(Passed::Nothing));
    assert_eq!((side.voltage_v(), side.phase()), (0.0, Phase::TimedOut));
}

#[test]
fn a_stop_holds_whatever_its_sequence_and_another_session_s_does_not_count() {
    let mut side = running(5);
    side.on_command(&command(5, 100, 2.0), 1);
    assert_eq!(side.on_command(&stop(4), 1), Decision::Foreign);
    assert_eq!(side.voltage_v(), 2.0);
    let answer = answered(&mut side, &stop(5), 2, 0.0).unwrap();
    assert_eq!((answer.status, side.voltage_v()), (Measurement::STOPPED, 0.0));
    let answer = answered(&mut side, &command(5, 101, 2.0), 3, 0.0).unwrap();
    assert_eq!((answer.status, side.voltage_v()), (Measurement::STOPPED, 0.0));
    assert_eq!(side.on_command(&greeting(5), 3), Decision::Older, "a greeting of the same session is a straggler");
}

#[test]
fn a_straggler_of_an_earlier_session_neither_moves_nor_ends_a_run() {
    let mut side = running(5);
    answered(&mut side, &greeting(6), 1, 0.0);
    side.on_command(&command(6, 0, 2.0), 2);
    assert_eq!(side.on_command(&command(5, 1, 9.0), 3), Decision::Foreign);
    assert_eq!((side.voltage_v(), side.phase()), (2.0, Phase::Running));
}

#[test]
fn a_restarted_rig_answers_a_run_that_it_does_not_know_and_obeys_nothing() {
    let mut side = RigSide::new(2);
    let answer = answered(&mut side, &command(5, 100, 9.0), 0, 0.0).unwrap();
    assert_eq!((answer.boots, answer.status, side.voltage_v()), (2, Measurement::TIMED_OUT, 0.0));
}

#[test]
fn an_undefined_voltage_is_none() {
    let mut side = running(5);
    for (k, voltage_v) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().enumerate() {
        side.on_command(&command(5, 2 * k as u32 + 1, 3.0), 1);
        assert_eq!(side.voltage_v(), 3.0);
        side.on_command(&command(5, 2 * k as u32 + 2, voltage_v), 1);
        assert_eq!(side.voltage_v(), 0.0);
    }
}

#[test]
fn a_host_of_another_version_is_answered_unless_a_run_lasts() {
    assert!(RigSide::new(1).on_other_version().is_some());
    assert_eq!(running(5).on_other_version(), None);
}

proptest! {
    /// Commands 0 to n - 1, shuffled and doubled: after each, the voltage is that of the largest instant so far, and what came
    /// twice is answered alike.
    #[test]
    fn the_newest_voltage_stands(
        mut order in Just((0..40_u32).collect::<Vec<_>>()).prop_shuffle(),
        again in proptest::collection::vec(0..40_u32, 20),
        first in prop_oneof![Just(1_u32), Just(i32::MAX as u32 - 5), Just(u32::MAX - 20)],
    ) {
        order.extend(again);
        let mut side = running(5);
        // To where the sequence is to begin, in steps of which each is ahead.
        for at in [first / 2, first] {
            side.on_command(&command(5, at.wrapping_sub(1), 0.5), 0);
        }
        let (mut newest, mut last) = (None, None);
        for (step, k) in order.into_iter().enumerate() {
            let command = command(5, first.wrapping_add(k), f64::from(k) + 1.0);
            let answer = answered(&mut side, &command, 1, step as f64);
            match newest {
                Some(n) if k < n => prop_assert_eq!(answer, None),
                Some(n) if k == n => prop_assert_eq!(answer, last),
                _ => {
                    prop_assert_eq!(answer.map(|answer| answer.theta_rad), Some(step as f64));
                    (newest, last) = (Some(k), answer);
                }
            }
            prop_assert_eq!(side.voltage_v(), f64::from(newest.unwrap()) + 1.0);
        }
    }

    /// Whatever comes, when nothing new comes for longer than the hold the voltage is 0, and a stop is final.
    #[test]
    fn silence_and_stops_end_in_0_v(
        commands in proptest::collection::vec((4..7_u32, any::<u32>(), any::<bool>(), 0..10_u32), 1..60),
    ) {
        let mut side = running(5);
        let mut now_ms = 0;
        let mut stopped = None;
        for (session, sequence, stops, after_ms) in commands {
            now_ms += after_ms;
            let flags = u16::from(stops);
            let command = Command { flags, ..command(session, sequence, 7.0) };
            let _ = answered(&mut side, &command, now_ms, 0.0);
            match side.phase() {
                Phase::Stopped => stopped = Some(()),
                Phase::Greeted => stopped = None,
                _ => {}
            }
            prop_assert!(stopped.is_none() || side.voltage_v() == 0.0);
        }
        side.on_tick(now_ms + u32::from(HOLD_MS) + 1);
        prop_assert_eq!(side.voltage_v(), 0.0);
    }
}
