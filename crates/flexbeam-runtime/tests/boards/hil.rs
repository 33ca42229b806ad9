//! Quanser's HIL library.

use crate::stand_in::{self, StandIn};
use crate::{UNHURRIED, allocations_of, fresh};
use flexbeam_runtime::back_end::{BackEnd, Counters, LinkFault, Timing};
use flexbeam_runtime::hil::{BoardWatchdog, HilPort, HilRig};
use std::f64::consts::TAU;
use std::time::Duration;

fn port(board: &StandIn) -> HilPort {
    HilPort { library: Some(board.path()), ..HilPort::new("q2_usb", "0") }
}

fn prepared(board: &StandIn, port: &HilPort) -> HilRig {
    let mut rig = HilRig::open(port).unwrap();
    rig.prepare(UNHURRIED).unwrap();
    assert_eq!(board.output_v(), 0.0);
    rig
}

fn rig(board: &StandIn) -> HilRig {
    prepared(board, &port(board))
}

/// What happened to the output, in order.
fn writes(board: &StandIn) -> Vec<String> {
    let log = board.log();
    let written =
        log.iter().filter_map(|line| line.strip_prefix("hil_read_write ").or(line.strip_prefix("hil_write_analog ")));
    written.map(String::from).collect()
}

#[track_caller]
fn assert_ends_at_rest(board: &StandIn) {
    assert_eq!(writes(board).last().unwrap(), "0:0");
    assert_eq!(board.output_v(), 0.0);
    assert_eq!(board.open_handles(), 0);
}

#[test]
fn a_whole_life_is_these_calls_in_this_order() {
    let board = StandIn::new("hil");
    let mut rig = rig(&board);
    for (k, voltage_v) in [1.5, -2.0].into_iter().enumerate() {
        fresh(&mut rig, k as u64, voltage_v);
    }
    rig.zero().unwrap();
    drop(rig);
    let expected = [
        // Open: whatever an earlier process left is taken to rest, the hub's angle is zero here, all channels answer.
        "hil_open q2_usb 0",
        "hil_watchdog_is_expired",
        "hil_watchdog_stop",
        "hil_write_analog 0:0",
        "hil_set_encoder_counts 0:0",
        "hil_read_write 0:0",
        // Prepare: to rest again, the state on expiry, a trial of the watchdog.
        "hil_watchdog_is_expired",
        "hil_watchdog_stop",
        "hil_write_analog 0:0",
        "hil_watchdog_set_analog_expiration_state 0:0",
        "hil_watchdog_start 3600",
        "hil_watchdog_is_expired",
        "hil_watchdog_stop",
        "hil_write_analog 0:0",
        "hil_read_write 0:0",
        // The run.
        "hil_watchdog_start 3600",
        "hil_read_write 0:1.5",
        "hil_watchdog_reload",
        "hil_read_write 0:-2",
        "hil_watchdog_reload",
        // Its end.
        "hil_write_analog 0:0",
        "hil_watchdog_stop",
        // Drop.
        "hil_write_analog 0:0",
        "hil_close",
    ];
    assert_eq!(board.log(), expected);
    assert_ends_at_rest(&board);
}

#[test]
fn counts_and_volts_become_angles_with_the_signs_of_the_port() {
    let board = StandIn::new("hil");
    let text =
        format!("q2_usb:0?theta=-1,alpha=-1,voltage=-1,rad_per_v=0.5,zero_v=0.25,gain=2,library={}", board.path());
    let mut rig = prepared(&board, &HilPort::parse(&text).unwrap());
    board.sensors(1024, 0.75);
    let measured = fresh(&mut rig, 0, 3.0);
    assert_eq!((measured.theta_rad, measured.alpha_rad), (-TAU / 4.0, -0.25));
    assert_eq!(writes(&board).last().unwrap(), "0:-1.5");
    // Ten counts a volt at each reading.
    assert_eq!(fresh(&mut rig, 1, 0.0).theta_rad, -(1024.0 - 15.0) * TAU / 4096.0);
}

#[test]
fn the_hub_s_angle_does_not_jump_where_the_counter_wraps() {
    for (bits, step) in [(16, 1 << 13), (24, 1 << 21), (32, 1 << 21)] {
        let board = StandIn::new("hil");
        let mut rig = prepared(&board, &HilPort { counter_bits: bits.min(24), ..port(&board) });
        let half = 1_i64 << (bits - 1);
        // As a counter of this width reports it: signed.
        let reported = |count: i64| ((count + half).rem_euclid(2 * half) - half) as i32;
        for (k, count) in (0..half + 3 * step).step_by(step as usize).enumerate() {
            board.sensors(reported(count), 0.0);
            assert_eq!(fresh(&mut rig, k as u64, 0.0).theta_rad, count as f64 * TAU / 4096.0, "{bits} bits, {count}");
        }
    }
}

#[test]
fn the_zero_is_the_board_s_opening_and_outlives_a_second_run() {
    let board = StandIn::new("hil");
    let mut rig = rig(&board);
    board.sensors(512, 0.0);
    fresh(&mut rig, 0, 0.0);
    rig.zero().unwrap();
    rig.prepare(UNHURRIED).unwrap();
    assert_eq!(fresh(&mut rig, 0, 0.0).theta_rad, TAU / 8.0);
}

#[test]
fn a_refused_call_is_a_fault_in_the_library_s_own_words() {
    for (call, code, words) in [
        ("hil_read_write", -105, "An argument is out of its range."),
        ("hil_watchdog_reload", -101, "not that of an open card"),
        ("hil_read_write", -999, "for which it has no text"),
    ] {
        let board = StandIn::new("hil");
        let mut rig = rig(&board);
        fresh(&mut rig, 0, 1.0);
        board.fail(call, 1, code);
        let fault = rig.exchange(1, 2.0).unwrap_err();
        assert_eq!(fault, LinkFault::Board { code });
        let told = rig.explain(fault);
        assert!(told.contains(words) && told.contains(&code.to_string()), "{told}");
        rig.zero().unwrap();
        assert_eq!(board.output_v(), 0.0);
        drop(rig);
        assert_ends_at_rest(&board);
    }
}

#[test]
fn where_0_v_does_not_go_out_the_watchdog_keeps_running() {
    let board = StandIn::new("hil");
    let mut rig = HilRig::open(&port(&board)).unwrap();
    rig.prepare(Timing { hold_s: 0.05, ..UNHURRIED }).unwrap();
    // A stall of the machine may let the watchdog expire before the failure that is meant here.
    let _ = rig.exchange(0, 4.0);
    board.fail("hil_write_analog", 1, -105);
    let _ = rig.zero();
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(board.output_v(), 0.0);
}

#[test]
fn dropped_or_unwound_it_leaves_0_v() {
    let board = StandIn::new("hil");
    let mut dropped = rig(&board);
    fresh(&mut dropped, 0, 5.0);
    drop(dropped);
    assert_ends_at_rest(&board);

    let board = StandIn::new("hil");
    let mut unwound = rig(&board);
    let thread = std::thread::spawn(move || {
        fresh(&mut unwound, 0, 5.0);
        panic!("the loop's own mistake");
    });
    assert!(thread.join().is_err());
    assert_ends_at_rest(&board);
    assert_eq!(board.logged("hil_watchdog_stop").len(), 4);
}

#[test]
fn a_hanging_exchange_is_ended_by_the_board_s_watchdog() {
    let board = StandIn::new("hil");
    let mut rig = HilRig::open(&port(&board)).unwrap();
    rig.prepare(Timing { hold_s: 0.25, ..UNHURRIED }).unwrap();
    assert!(rig.cutoff().is_none());
    board.stall("hil_read_write", 2);
    let thread = std::thread::spawn(move || {
        let first = rig.exchange(0, 4.0);
        (first, rig.exchange(1, 3.0), rig)
    });
    board.wait_for("hil_read_write 0:3");
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(board.output_v(), 0.0);
    board.release();
    let (_, second, mut rig) = thread.join().unwrap();
    assert_eq!(second, Err(LinkFault::RigTimedOut));
    assert!(rig.explain(LinkFault::RigTimedOut).contains("watchdog expired after 0.25 s"));
    rig.zero().unwrap();
    assert_eq!(board.output_v(), 0.0);

    // The next run opens the board again, and the voltage that stood when it expired does not come back.
    rig.prepare(UNHURRIED).unwrap();
    let log = board.log();
    let cleared = log.iter().rposition(|line| line == "hil_watchdog_clear").unwrap();
    assert_eq!(log[cleared + 1], "hil_write_analog 0:0");
    assert_eq!(board.output_v(), 0.0);
    fresh(&mut rig, 0, 1.0);
    assert_eq!(board.output_v(), 1.0);
}

#[test]
fn a_reload_that_comes_too_late_is_told_as_the_watchdog() {
    let board = StandIn::new("hil");
    let mut rig = rig(&board);
    board.stall("hil_watchdog_reload", 1);
    let thread = std::thread::spawn(move || rig.exchange(0, 4.0));
    board.wait_for("hil_watchdog_reload");
    board.expired_at(4.0);
    board.release();
    assert_eq!(thread.join().unwrap(), Err(LinkFault::RigTimedOut));
    assert_eq!(board.output_v(), 0.0);
}

#[test]
fn what_a_killed_process_left_is_taken_to_rest_when_the_board_opens() {
    let board = StandIn::new("hil");
    board.expired_at(7.0);
    let mut rig = rig(&board);
    assert_eq!(
        board.log()[1..5],
        ["hil_watchdog_is_expired", "hil_watchdog_stop", "hil_watchdog_clear", "hil_write_analog 0:0"]
    );
    fresh(&mut rig, 0, 1.0);
}

#[test]
fn a_board_without_watchdog_is_refused_unless_the_port_says_so() {
    let board = StandIn::new("hil");
    board.without_watchdog();
    let error = HilRig::open(&port(&board)).err().unwrap();
    assert!(error.hint.contains("watchdog=none"), "{error}");
    assert_eq!(board.open_handles(), 0);
    let mut rig = prepared(&board, &HilPort { watchdog: BoardWatchdog::Absent, ..port(&board) });
    fresh(&mut rig, 0, 1.0);
    drop(rig);
    assert_ends_at_rest(&board);
    let after = board.log().into_iter().skip_while(|line| line != "hil_set_encoder_counts 0:0");
    assert_eq!(after.filter(|line| line.contains("watchdog")).count(), 0);
}

#[test]
fn a_watchdog_that_does_not_stop_after_its_trial_is_refused() {
    let board = StandIn::new("hil");
    let mut rig = HilRig::open(&port(&board)).unwrap();
    board.fail("hil_watchdog_stop", 2, -105);
    let error = rig.prepare(UNHURRIED).unwrap_err();
    assert!(error.found.contains("An argument is out of its range."), "{error}");
}

#[test]
fn what_the_watchdog_is_told_follows_the_port() {
    let board = StandIn::new("hil");
    let fixed = HilPort { watchdog: BoardWatchdog::Fixed, tristate_lines: 8, ..port(&board) };
    drop(prepared(&board, &fixed));
    assert!(board.logged("hil_watchdog_set_analog").is_empty());
    assert_eq!(board.logged("hil_watchdog_set_digital"), ["hil_watchdog_set_digital_expiration_state 0..7:2"]);
}

#[test]
fn before_a_run_every_refusal_names_the_call_the_words_and_a_way_out() {
    for (text, found, hint) in [
        ("q8:0?", "hil_open(\"q8\", \"0\"): No such board was found.", "hil:q2_usb:0"),
        ("q2_usb:0?output=2,", "The board has no such channel.", "output=N"),
        ("q2_usb:0?encoder=2,", "hil_set_encoder_counts: The board has no such channel.", "encoder=N"),
        ("q2_usb:0?gauge=2,", "hil_read_write: The board has no such channel.", "gauge"),
    ] {
        let board = StandIn::new("hil");
        let port = HilPort::parse(&format!("{text}library={}", board.path())).unwrap();
        let error = HilRig::open(&port).err().unwrap();
        assert!(error.found.contains(found) && error.hint.contains(hint), "{error}");
        assert_eq!((board.open_handles(), board.output_v()), (0, 0.0));
    }
    let board = StandIn::new("hil");
    let mut rig = HilRig::open(&HilPort { tristate_lines: 9, ..port(&board) }).unwrap();
    let error = rig.prepare(UNHURRIED).unwrap_err();
    assert!(error.found.contains("digital_expiration_state") && error.hint.contains("tristate"), "{error}");
}

#[test]
fn a_missing_library_is_told_with_every_name_and_a_missing_function_by_its_own() {
    // A type that no board has: where Quanser's library is installed, the test must not touch one.
    let error = HilRig::open(&HilPort::new("no_such_board", "0")).err().unwrap();
    let told = error.to_string();
    assert!(told.contains("libhil.so.1") && told.contains("libhil.so (") || told.contains("hil_open"), "{told}");

    let named = HilPort { library: Some("/nowhere/libhil.so".into()), ..HilPort::new("q2_usb", "0") };
    let told = HilRig::open(&named).err().unwrap().to_string();
    assert!(
        told.contains("/nowhere/libhil.so") && told.contains("No such file") && told.contains("library="),
        "{told}"
    );

    let folder = tempfile::tempdir().unwrap();
    let old = folder.path().join("old.so");
    stand_in::compile("hil_stand_in.c", &["-Dhil_watchdog_reload=hil_watchdog_restart"], &old).unwrap();
    let named = HilPort { library: Some(old.to_str().unwrap().into()), ..HilPort::new("q2_usb", "0") };
    let error = HilRig::open(&named).err().unwrap();
    assert!(error.found.ends_with("without a function hil_watchdog_reload"), "{error}");
}

#[test]
fn a_library_without_texts_still_tells_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let mute = folder.path().join("mute.so");
    stand_in::compile("hil_stand_in.c", &["-Dmsg_get_error_messageA=msg_other"], &mute).unwrap();
    let named = HilPort { library: Some(mute.to_str().unwrap().into()), ..HilPort::new("q9", "0") };
    let error = HilRig::open(&named).err().unwrap();
    assert!(error.found.starts_with("-102 from hil_open") && error.found.contains("no text"), "{error}");
}

#[test]
fn a_bad_port_is_refused() {
    for (text, found) in [
        ("q2_usb", "\"q2_usb\""),
        (":0", "\":0\""),
        ("q2_usb:0?counter_bits=33", "counter_bits=33"),
        ("q2_usb:0?tristate=5000", "tristate=5000"),
        ("q2_usb:0?watchdog=off", "watchdog=off"),
        ("q2_usb:0?output_subdevice=1", "output_subdevice"),
    ] {
        let error = HilPort::parse(text).unwrap_err();
        assert!(error.found.contains(found), "{text}: {error}");
    }
    let port = HilPort::parse("q8_usb:1@tcpip://lab:17000?counter_bits=16,tristate=8,watchdog=fixed").unwrap();
    let expected = HilPort {
        counter_bits: 16,
        tristate_lines: 8,
        watchdog: BoardWatchdog::Fixed,
        ..HilPort::new("q8_usb", "1@tcpip://lab:17000")
    };
    assert_eq!(port, expected);
}

#[test]
fn an_exchange_allocates_nothing_and_loses_nothing() {
    let board = StandIn::new("hil");
    let mut rig = rig(&board);
    assert_eq!(allocations_of(&mut rig, || board.fail("hil_read_write", 1, -105)), 0);
    assert_eq!(rig.counters(), Counters::default());
    assert_eq!(rig.name(), "hil:q2_usb:0");
}
