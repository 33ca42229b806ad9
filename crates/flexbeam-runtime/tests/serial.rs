//! A rig behind a serial line: over a pseudo-terminal, on a good line, on a bad one, and gone.

mod support;

use flexbeam_runtime::back_end::{Answer, BackEnd, Counters, LinkFault, Timing};
use flexbeam_runtime::serial::{DEFAULT_BAUD, SerialRig, SerialWire};
use flexbeam_runtime::served_rig::ServeOptions;
use flexbeam_runtime::wire::{HostWire, LONGEST_FRAME, Received, Wire};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use support::relay::{Mischief, Relay, replayed};
use support::{PATIENT, Serving, bits, exchanges, in_process};

/// For lines that lose: short enough that the losses do not make the test long.
const BRIEF: Timing = Timing { wait_s: 0.005, ..PATIENT };

fn served() -> (Serving, PathBuf) {
    let (wire, device) = SerialWire::pseudo_terminal().unwrap();
    (Serving::start(wire, ServeOptions::default()), device)
}

fn opened(device: &Path) -> SerialRig {
    SerialRig::open(device, DEFAULT_BAUD, 1).unwrap()
}

#[test]
fn two_thousand_exchanges_give_the_bits_of_a_rig_in_the_process() {
    let (serving, device) = served();
    let mut host = opened(&device);
    host.prepare(PATIENT).unwrap();
    for (k, (answer, expected)) in exchanges(&mut host, 2000).into_iter().zip(in_process(2000)).enumerate() {
        let Ok(Answer::Fresh(found)) = answer else { panic!("{k}: {answer:?}") };
        assert_eq!(bits(found), bits(expected), "instant {k}");
    }
    assert_eq!(host.counters(), Counters::default());
    serving.end();
}

#[test]
fn a_second_host_opens_the_line_after_the_first_and_not_beside_it() {
    let (serving, device) = served();
    let mut first = opened(&device);
    first.prepare(PATIENT).unwrap();
    assert!(SerialRig::open(&device, DEFAULT_BAUD, 2).is_err_and(|error| error.needed.contains("no other program")));
    first.zero().unwrap();
    drop(first);
    let mut second = SerialRig::open(&device, DEFAULT_BAUD, 2).unwrap();
    second.prepare(PATIENT).unwrap();
    assert!(matches!(second.exchange(0, 0.0), Ok(Answer::Fresh(_))));
    serving.end();
}

#[test]
fn bytes_that_are_lost_or_damaged_cost_their_own_frames() {
    let (serving, rig_device) = served();
    let mischief = Mischief { loses: 0.0005, doubles: 0.0002, damages: 0.0005, spares: 80, ..Mischief::default() };
    let (relay, device) = Relay::serial(&rig_device, mischief);
    let mut host = opened(&device);
    host.prepare(BRIEF).unwrap();
    let answers = exchanges(&mut host, 2000);
    let counters = host.counters();
    host.zero().unwrap();
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
    assert!(counters.corrupt > 10 && report.counts.malformed > 10, "{counters:?}, {:?}", report.counts);
    assert!(lost < 1000, "{lost} of 2000 lost: the line does not find its frames again");
}

#[test]
fn a_line_that_is_hung_up_is_gone() {
    let (serving, device) = served();
    let mut host = opened(&device);
    host.prepare(BRIEF).unwrap();
    assert!(host.exchange(0, 1.0).is_ok());
    serving.end();
    assert_eq!(host.exchange(1, 1.0), Err(LinkFault::Gone { errno: libc::EIO }));
    assert_eq!(host.zero(), Err(LinkFault::Gone { errno: libc::EIO }));
}

#[test]
fn the_watchdog_s_cut_reaches_the_rig() {
    let (serving, device) = served();
    let mut host = opened(&device);
    host.prepare(PATIENT).unwrap();
    let cutoff = host.cutoff().unwrap();
    assert!((0..50).all(|k| host.exchange(k, 5.0).is_ok()));
    cutoff.cut();
    assert_eq!(host.exchange(50, 5.0), Err(LinkFault::CutOff));
    host.prepare(PATIENT).unwrap();
    assert!(matches!(host.exchange(0, 5.0), Ok(Answer::Fresh(_))));
    let counts = serving.end().counts;
    assert_eq!((counts.runs, counts.malformed), (2, 0));
}

/// Everything that lies on the line, broken frames as empty ones.
fn read_all(wire: &mut SerialWire) -> Vec<Vec<u8>> {
    let mut buffer = [0; LONGEST_FRAME];
    let mut frames = Vec::new();
    let mut last = Instant::now();
    loop {
        match wire.receive(&mut buffer).unwrap() {
            Received::Frame(length) => {
                frames.push(buffer[..length].to_vec());
                last = Instant::now();
            }
            Received::Nothing if last.elapsed() > Duration::from_millis(300) => break,
            Received::Nothing => {}
        }
    }
    frames
}

#[test]
fn a_second_sender_closes_what_the_first_had_begun() {
    let (mut rig, device) = SerialWire::pseudo_terminal().unwrap();
    let host = SerialWire::open(&device, DEFAULT_BAUD).unwrap();
    std::fs::File::options().write(true).open(&device).unwrap().write_all(&[9, 1, 2]).unwrap();
    host.second().send(&[7; 32]).unwrap();
    assert_eq!(read_all(&mut rig), [vec![], vec![7; 32]]);
}

#[test]
fn a_frame_that_went_out_by_half_costs_only_itself() {
    let (mut rig, device) = SerialWire::pseudo_terminal().unwrap();
    let host = SerialWire::open(&device, DEFAULT_BAUD).unwrap();
    // Nobody reads: the line fills up, and what does not fit whole is closed by the next, or left at the end.
    (0..20_000).for_each(|_| host.send(&[7; 32]).unwrap());
    let first = read_all(&mut rig);
    assert!(first.len() < 20_000 && first.iter().all(|frame| frame.is_empty() || *frame == [7; 32]), "{first:?}");
    host.send(&[8; 32]).unwrap();
    let rest = read_all(&mut rig);
    assert_eq!(rest.last(), Some(&vec![8; 32]), "{rest:?}");
}

#[test]
fn what_is_no_line_is_refused_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    for device in [Path::new("/dev/flexbeam-none"), &file] {
        let error = SerialRig::open(device, DEFAULT_BAUD, 1).err().unwrap();
        assert!(error.found.contains(&device.display().to_string()), "{error}");
    }
    let (_wire, device) = SerialWire::pseudo_terminal().unwrap();
    let error = SerialRig::open(&device, 1234, 1).err().unwrap();
    assert!(error.found.contains("1234") && error.needed.contains("921600"), "{error}");
    let error = SerialRig::open(&device, DEFAULT_BAUD, 1).unwrap().prepare(PATIENT).unwrap_err();
    assert!(error.found.contains("no answer"), "{error}");
}
