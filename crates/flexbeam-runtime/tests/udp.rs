//! A rig behind UDP on this machine: on a good road, on a bad one, and gone.

mod support;

use flexbeam_files::frame::{self, Command};
use flexbeam_runtime::back_end::{Answer, BackEnd, Counters, LinkFault, Timing};
use flexbeam_runtime::served_rig::{OnSession, ServeOptions};
use flexbeam_runtime::udp::{UdpRig, UdpRigWire};
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};
use support::relay::{Mischief, Relay, replayed};
use support::{PATIENT, Serving, bits, exchanges, in_process};

/// For roads that lose: short enough that the losses do not make the test long.
const BRIEF: Timing = Timing { wait_s: 0.004, ..PATIENT };

fn served(options: ServeOptions) -> (Serving, String) {
    let wire = UdpRigWire::bind("127.0.0.1:0").unwrap();
    let address = wire.address().unwrap().to_string();
    (Serving::start(wire, options), address)
}

fn prepared(address: &str, timing: Timing) -> UdpRig {
    let mut host = UdpRig::open(address, 1).unwrap();
    host.prepare(timing).unwrap();
    host
}

/// Exchanges on until the run ends, for as long as a machine that stalls may need.
fn end_of_run(host: &mut UdpRig, from: u64, pause: Duration) -> LinkFault {
    for k in from..from + 2000 {
        if let Err(fault) = host.exchange(k, 5.0) {
            return fault;
        }
        std::thread::sleep(pause);
    }
    panic!("the run goes on");
}

#[test]
fn two_thousand_exchanges_give_the_bits_of_a_rig_in_the_process() {
    let (serving, address) = served(ServeOptions::default());
    let expected = in_process(2000);
    let mut host = UdpRig::open(&address, 1).unwrap();
    // Twice, since a new session puts the rig back to rest.
    for _ in 0..2 {
        host.prepare(PATIENT).unwrap();
        for (k, (answer, expected)) in exchanges(&mut host, 2000).into_iter().zip(&expected).enumerate() {
            let Ok(Answer::Fresh(found)) = answer else { panic!("{k}: {answer:?}") };
            assert_eq!(bits(found), bits(*expected), "instant {k}");
        }
        host.zero().unwrap();
        assert_eq!(host.counters(), Counters::default());
    }
    assert_eq!(serving.end().counts.runs, 2);
}

#[test]
fn a_rig_that_carries_goes_on_from_where_the_last_run_left_it() {
    let (serving, address) = served(ServeOptions { on_session: OnSession::Carry, ..ServeOptions::default() });
    let mut host = prepared(&address, PATIENT);
    assert!((0..300).all(|k| host.exchange(k, 5.0).is_ok()));
    host.prepare(PATIENT).unwrap();
    let Ok(Answer::Fresh(found)) = host.exchange(0, 0.0) else { panic!("no answer") };
    assert!(found.theta_rad > 0.5, "{found:?}: 300 ms at 5 V turn the hub by more than a radian");
    serving.end();
}

/// Every exchange is fresh, with the very readings that the commands which reached the rig give for its instant, or it is
/// counted as lost.
fn nothing_is_mixed_up(mischief: Mischief) -> Counters {
    let (serving, rig_address) = served(ServeOptions::default());
    let (relay, address) = Relay::udp(&rig_address, Mischief { spares: 2, ..mischief });
    let mut host = prepared(&address, BRIEF);
    let answers = exchanges(&mut host, 2000);
    let counters = host.counters();
    drop(host);
    let delivered = relay.end();
    let report = serving.end();
    let expected = replayed(&delivered);
    let mut lost = 0;
    for (k, answer) in answers.into_iter().enumerate() {
        match answer.unwrap() {
            Answer::Lost => lost += 1,
            Answer::Fresh(found) => assert_eq!(bits(found), bits(expected[&(k as u32)]), "instant {k}"),
        }
    }
    assert_eq!(counters.lost, lost);
    assert!(lost < 1000, "{lost} of 2000 lost: the road is no road");
    assert_eq!(counters.foreign, 0);
    assert_eq!(report.counts.timed_out, 0);
    counters
}

#[test]
fn a_road_without_mischief_loses_nothing_by_itself() {
    let counters = nothing_is_mixed_up(Mischief::default());
    assert_eq!((counters.duplicate, counters.corrupt), (0, 0));
}

#[test]
fn losses_are_counted_and_nothing_else_happens() {
    let counters = nothing_is_mixed_up(Mischief { loses: 0.02, ..Mischief::default() });
    assert!(counters.lost > 20, "{counters:?}");
    assert_eq!((counters.duplicate, counters.corrupt), (0, 0));
}

#[test]
fn doubles_are_thrown_away() {
    let counters = nothing_is_mixed_up(Mischief { doubles: 0.1, ..Mischief::default() });
    assert!(counters.duplicate > 100, "{counters:?}");
}

#[test]
fn damaged_frames_are_none() {
    let counters = nothing_is_mixed_up(Mischief { damages: 0.05, ..Mischief::default() });
    assert!(counters.corrupt > 20 && counters.lost > 50, "{counters:?}");
}

#[test]
fn a_silence_of_fifty_milliseconds_costs_its_own_exchanges() {
    let counters = nothing_is_mixed_up(Mischief { silent_after: Some(1000), ..Mischief::default() });
    assert!(counters.lost >= 1, "{counters:?}");
}

#[test]
fn what_was_overtaken_is_late() {
    let counters = nothing_is_mixed_up(Mischief { swaps: 0.05, ..Mischief::default() });
    assert!(counters.late > 20, "{counters:?}");
}

#[test]
fn everything_at_once() {
    let counters = nothing_is_mixed_up(Mischief {
        loses: 0.02,
        doubles: 0.02,
        swaps: 0.02,
        damages: 0.02,
        silent_after: Some(3000),
        spares: 0,
    });
    assert!(counters.lost > 50 && counters.corrupt > 5 && counters.duplicate > 5 && counters.late > 5, "{counters:?}");
}

#[test]
fn a_rig_that_ends_is_gone() {
    let (serving, address) = served(ServeOptions::default());
    let mut host = prepared(&address, BRIEF);
    assert!(host.exchange(0, 1.0).is_ok());
    serving.end();
    let fault = end_of_run(&mut host, 1, Duration::ZERO);
    assert_eq!(fault, LinkFault::Gone { errno: libc::ECONNREFUSED });
}

#[test]
fn a_road_that_ends_is_gone_too() {
    let (serving, rig_address) = served(ServeOptions::default());
    let (relay, address) = Relay::udp(&rig_address, Mischief::default());
    let mut host = prepared(&address, BRIEF);
    relay.end();
    assert!(matches!(end_of_run(&mut host, 0, Duration::ZERO), LinkFault::Gone { .. }));
    serving.end();
}

#[test]
fn a_rig_without_commands_takes_itself_to_0_v() {
    let (serving, address) = served(ServeOptions::default());
    let mut host = prepared(&address, Timing { hold_s: 0.05, wait_s: 0.01, ..PATIENT });
    let driven = (0..200).try_for_each(|k| host.exchange(k, 5.0).map(drop));
    std::thread::sleep(Duration::from_millis(1000));
    let fault = driven.err().unwrap_or_else(|| end_of_run(&mut host, 200, Duration::ZERO));
    assert_eq!(fault, LinkFault::RigTimedOut);
    // The latch holds: voltages that come now are not obeyed.
    for k in 2200..2260 {
        assert!(!matches!(host.exchange(k, 5.0), Ok(Answer::Fresh(_))));
    }
    std::thread::sleep(Duration::from_millis(2500));
    let report = serving.end();
    let truth = report.rig.truth();
    assert_eq!(report.counts.timed_out, 1);
    assert!(truth.theta_rad > 0.0, "it was driven");
    assert!(truth.theta_rad_s.abs() < 0.05, "{truth:?}: at 5 V the hub turns at about 9 rad/s");
}

#[test]
fn the_watchdog_s_cut_goes_past_the_loop_and_lasts_until_prepared_again() {
    let (serving, address) = served(ServeOptions::default());
    let mut host = prepared(&address, PATIENT);
    let cutoff = host.cutoff().unwrap();
    assert!((0..50).all(|k| host.exchange(k, 5.0).is_ok()));
    std::thread::spawn(move || cutoff.cut()).join().unwrap();
    assert_eq!(host.exchange(50, 5.0), Err(LinkFault::CutOff));
    host.zero().unwrap();
    host.prepare(PATIENT).unwrap();
    assert!((0..50).all(|k| host.exchange(k, 5.0).is_ok()));
    // The cut reaches the rig itself: a host that did not hear of it learns it from the rig.
    host.zero().unwrap();
    assert_eq!(end_of_run(&mut host, 50, Duration::from_millis(1)), LinkFault::CutOff);
    serving.end();
}

#[test]
fn a_second_host_takes_over_and_the_first_is_not_heard() {
    let (serving, address) = served(ServeOptions::default());
    let mut first = prepared(&address, BRIEF);
    assert!((0..10).all(|k| first.exchange(k, 0.0).is_ok()));
    let mut second = UdpRig::open(&address, 2).unwrap();
    second.prepare(PATIENT).unwrap();
    for (k, expected) in in_process(100).into_iter().enumerate() {
        assert_eq!(first.exchange(10 + k as u64, 9.0), Ok(Answer::Lost));
        let Ok(Answer::Fresh(found)) = second.exchange(k as u64, support::delayed_voltage_v(k as u64)) else {
            panic!("{k}: no answer")
        };
        assert_eq!(bits(found), bits(expected));
    }
    assert_eq!(serving.end().counts.ignored, 100);
}

/// Something at an address that answers commands as `speaks` says.
fn impostor(mut speaks: impl FnMut(Command) -> Vec<u8> + Send, test: impl FnOnce(&str)) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
    let address = socket.local_addr().unwrap().to_string();
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut buffer = [0; 64];
            while !over.load(Ordering::Acquire) {
                let Ok((length, host)) = socket.recv_from(&mut buffer) else { continue };
                let answer = speaks(Command::decode(&buffer[..length]).unwrap());
                let _ = socket.send_to(&answer, host);
            }
        });
        let _ended = Raised(&over);
        test(&address);
    });
}

/// Raises its flag at the end of its scope, a failed assertion's too.
struct Raised<'a>(&'a AtomicBool);

impl Drop for Raised<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

fn frame_of_version(version: u8) -> Vec<u8> {
    let mut bytes = vec![b'F', b'B', version, 2, 0, 0, 0, 0, 0, 0];
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

fn answer_to(command: Command) -> frame::Measurement {
    let Command { session, sequence, .. } = command;
    frame::Measurement { session, sequence, status: 0, theta_rad: 0.5, alpha_rad: 0.0, boots: 3 }
}

/// A rig that answers on as if nothing were: what stops the host is the host's own gate.
#[test]
fn a_cut_stops_the_host_even_where_the_rig_does_not_hear_it() {
    let (stops, after_stop) = (AtomicU32::new(0), AtomicU32::new(0));
    let deaf = |command: Command| {
        let stopped = stops.fetch_add(u32::from(command.stops()), Ordering::AcqRel) > 0;
        let drives = stopped && command.voltage_v != 0.0;
        after_stop.fetch_add(u32::from(drives), Ordering::AcqRel);
        answer_to(command).encode().to_vec()
    };
    let all_arrive = |needed: u32| {
        let deadline = Instant::now() + Duration::from_secs(20);
        while stops.load(Ordering::Acquire) < needed {
            assert!(Instant::now() < deadline, "{stops:?} stops, needed {needed}");
            std::thread::sleep(Duration::from_millis(1));
        }
    };
    impostor(deaf, |address| {
        let mut host = prepared(address, PATIENT);
        assert!((0..5).all(|k| host.exchange(k, 1.0).is_ok()));
        host.cutoff().unwrap().cut();
        for k in 5..10 {
            assert_eq!(host.exchange(k, 1.0), Err(LinkFault::CutOff));
        }
        all_arrive(3);
        host.zero().unwrap();
        all_arrive(6);
    });
    assert_eq!((stops.into_inner(), after_stop.into_inner()), (6, 0));
}

#[test]
fn a_rig_of_another_version_is_named_before_the_run() {
    impostor(
        |_| frame_of_version(9),
        |address| {
            let error = UdpRig::open(address, 1).unwrap().prepare(PATIENT).unwrap_err();
            assert!(error.found.contains("frame version 9"), "{error}");
        },
    );
}

#[test]
fn a_rig_that_changes_its_version_or_restarts_within_the_run_ends_it() {
    let other = |command: Command| match command.sequence {
        3 => frame_of_version(9),
        _ => answer_to(command).encode().to_vec(),
    };
    let restarted = |command: Command| match command.sequence {
        3 => frame::Measurement { boots: 4, ..answer_to(command) }.encode().to_vec(),
        _ => answer_to(command).encode().to_vec(),
    };
    let ends_in = |fault: LinkFault| {
        move |address: &str| {
            let mut host = prepared(address, PATIENT);
            assert!((0..3).all(|k| matches!(host.exchange(k, 1.0), Ok(Answer::Fresh(_)))));
            assert_eq!(host.exchange(3, 1.0), Err(fault));
        }
    };
    impostor(other, ends_in(LinkFault::Version { found: 9, known: 1 }));
    impostor(restarted, ends_in(LinkFault::RigRestarted));
}

#[test]
fn a_served_rig_tells_hosts_of_another_version_its_own() {
    let (serving, address) = served(ServeOptions::default());
    let host = UdpSocket::bind("127.0.0.1:0").unwrap();
    host.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    let mut greeting = frame_of_version(2);
    greeting.truncate(greeting.len() - 4);
    greeting[3] = 1;
    greeting.extend(crc32fast::hash(&greeting).to_le_bytes());
    host.send_to(&greeting, &address).unwrap();
    let mut buffer = [0; 64];
    let length = host.recv(&mut buffer).unwrap();
    assert_eq!(frame::Measurement::decode(&buffer[..length]).unwrap().session, 0);
    assert_eq!(serving.end().counts.malformed, 1);
}

#[test]
fn where_nothing_answers_the_error_says_where_and_why() {
    let silent = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = silent.local_addr().unwrap().to_string();
    let error = UdpRig::open(&address, 1).unwrap().prepare(PATIENT).unwrap_err();
    assert!(error.found.contains(&address) && error.found.contains("no answer"), "{error}");
    drop(silent);
    let error = UdpRig::open(&address, 1).unwrap().prepare(PATIENT).unwrap_err();
    assert!(error.found.contains("refused"), "{error}");
    impostor(
        |_| b"220 mail.example ESMTP".to_vec(),
        |address| {
            let error = UdpRig::open(address, 1).unwrap().prepare(PATIENT).unwrap_err();
            assert!(error.found.contains("are no frames"), "{error}");
        },
    );
}

#[test]
fn what_cannot_be_opened_or_timed_is_refused() {
    assert!(UdpRig::open("no colon", 1).is_err());
    assert!(UdpRigWire::bind("192.0.2.1:4810").is_err_and(|error| error.found.contains("192.0.2.1")));
    let mut host = UdpRig::open("127.0.0.1:9", 1).unwrap();
    for hold_s in [f64::NAN, 0.0, 0.0005, 66.0] {
        let error = host.prepare(Timing { hold_s, ..PATIENT }).unwrap_err();
        assert!(error.found.contains("hold"), "{error}");
    }
    for wait_s in [f64::NAN, -1.0, 31.0] {
        let error = host.prepare(Timing { wait_s, ..PATIENT }).unwrap_err();
        assert!(error.found.contains("wait"), "{error}");
    }
}
