//! comedi.

use crate::stand_in::{self, StandIn};
use crate::{UNHURRIED, allocations_of, fresh};
use flexbeam_runtime::back_end::{BackEnd, Counters, LinkFault};
use flexbeam_runtime::comedi::{ComediPort, ComediRig, Reference};
use std::f64::consts::TAU;
use std::sync::mpsc::channel;

/// A step of the stand-in's output [V].
const STEP_V: f64 = 20.0 / 4095.0;

/// The sample that stands for 0 V, or the nearest to it.
const ZERO: &str = "comedi_data_write 1.0 range 0 aref 0: 2048";

fn port(board: &StandIn) -> ComediPort {
    ComediPort { library: Some(board.path()), ..ComediPort::new("/dev/comedi0") }
}

fn prepared(port: &ComediPort) -> ComediRig {
    let mut rig = ComediRig::open(port).unwrap();
    rig.prepare(UNHURRIED).unwrap();
    rig
}

fn rig(board: &StandIn) -> ComediRig {
    prepared(&port(board))
}

#[track_caller]
fn assert_ends_at_rest(board: &StandIn) {
    assert_eq!(board.logged("comedi_data_write").last().unwrap(), ZERO);
    assert!(board.output_v().abs() <= 0.5 * STEP_V);
    assert_eq!(board.open_handles(), 0);
}

#[test]
fn a_whole_life_is_these_calls_in_this_order() {
    let board = StandIn::new("comedi");
    let mut rig = rig(&board);
    for (k, voltage_v) in [10.0, -5.0].into_iter().enumerate() {
        fresh(&mut rig, k as u64, voltage_v);
    }
    rig.zero().unwrap();
    drop(rig);
    let (counter, gauge) = ("comedi_data_read 3.0 range 0 aref 0", "comedi_data_read 0.0 range 1 aref 0");
    let expected = [
        // Open: at rest first, then the hub's zero, then the handle of the cutoff.
        "comedi_open /dev/comedi0",
        ZERO,
        counter,
        "comedi_open /dev/comedi0",
        // Prepare.
        ZERO,
        counter,
        gauge,
        // The run.
        "comedi_data_write 1.0 range 0 aref 0: 4095",
        counter,
        gauge,
        "comedi_data_write 1.0 range 0 aref 0: 1024",
        counter,
        gauge,
        // Its end.
        ZERO,
        // Drop.
        ZERO,
        "comedi_close",
        "comedi_close",
    ];
    assert_eq!(board.log(), expected);
    assert_ends_at_rest(&board);
}

#[test]
fn counts_and_volts_become_angles_with_the_signs_of_the_port() {
    let board = StandIn::new("comedi");
    let text = format!(
        "/dev/comedi0?theta=-1,alpha=-1,voltage=-1,rad_per_v=0.5,zero_v=0.25,gain=2,reference=diff,library={}",
        board.path()
    );
    let mut rig = prepared(&ComediPort::parse(&text).unwrap());
    assert_eq!(rig.reach_v(), 20.0);
    board.sensors(1024, 0.75);
    let measured = fresh(&mut rig, 0, 20.0);
    assert_eq!(measured.theta_rad, -TAU / 4.0);
    // Half a step of 16 bits over +-10 V.
    assert!((measured.alpha_rad + 0.25).abs() <= 0.5 * 0.5 * 20.0 / 65535.0, "{measured:?}");
    assert_eq!(board.output_v(), -10.0);
    assert_eq!(board.log().last().unwrap(), "comedi_data_read 0.0 range 1 aref 2");
    // Ten counts a volt at each reading.
    assert_eq!(fresh(&mut rig, 1, 0.0).theta_rad, -(1024.0 - 100.0) * TAU / 4096.0);
}

#[test]
fn the_hub_s_angle_does_not_jump_where_the_counter_wraps() {
    let board = StandIn::new("comedi");
    board.sensors(0xff_fff0, 0.0);
    let mut rig = rig(&board);
    for (k, (reading, counts)) in
        [(0xff_ffff, 15.0), (0, 16.0), (5, 21.0), (0xff_fff0, 0.0), (0xff_0000, -65_520.0)].into_iter().enumerate()
    {
        board.sensors(reading, 0.0);
        assert_eq!(fresh(&mut rig, k as u64, 0.0).theta_rad, counts * TAU / 4096.0, "{reading}");
    }
}

#[test]
fn a_gauge_at_the_end_of_its_range_reads_as_that_end() {
    let board = StandIn::new("comedi");
    let mut rig = rig(&board);
    board.sensors(0, 12.0);
    assert_eq!(fresh(&mut rig, 0, 0.0).alpha_rad, 10.0 * 0.0254 / 0.419);
}

#[test]
fn a_refused_call_is_a_fault_in_the_library_s_own_words() {
    for (call, errno, fault, words) in [
        ("comedi_data_write", libc_errno::EBUSY, LinkFault::Board { code: libc_errno::EBUSY }, "busy"),
        ("comedi_data_read", 0x1003, LinkFault::Board { code: 0x1003 }, "Invalid subdevice"),
        ("comedi_data_read", libc_errno::ENODEV, LinkFault::Gone { errno: libc_errno::ENODEV }, "No such device"),
    ] {
        let board = StandIn::new("comedi");
        let mut rig = rig(&board);
        fresh(&mut rig, 0, 1.0);
        board.fail(call, 1, errno);
        assert_eq!(rig.exchange(1, 2.0), Err(fault));
        assert!(rig.explain(fault).contains(words), "{}", rig.explain(fault));
        rig.zero().unwrap();
        drop(rig);
        assert_ends_at_rest(&board);
    }
}

/// Linux's numbers, written out: the test says which ones it means.
mod libc_errno {
    pub const EBUSY: i32 = 16;
    pub const ENODEV: i32 = 19;
}

#[test]
fn dropped_or_unwound_it_leaves_0_v() {
    let board = StandIn::new("comedi");
    let mut dropped = rig(&board);
    fresh(&mut dropped, 0, 5.0);
    drop(dropped);
    assert_ends_at_rest(&board);

    let board = StandIn::new("comedi");
    let mut unwound = rig(&board);
    let thread = std::thread::spawn(move || {
        fresh(&mut unwound, 0, 5.0);
        panic!("the loop's own mistake");
    });
    assert!(thread.join().is_err());
    assert_ends_at_rest(&board);
}

/// The loop hangs in a call with 5 V out or on its way; another thread cuts; then the call goes on.
#[track_caller]
fn cut_while_hanging(call: &str, hangs_at: &str) -> (StandIn, ComediRig) {
    let board = StandIn::new("comedi");
    let mut rig = rig(&board);
    let cutoff = rig.cutoff().unwrap();
    board.stall(call, 1);
    let (send, receive) = channel();
    let thread = std::thread::spawn(move || {
        send.send(rig.exchange(0, 5.0)).unwrap();
        rig
    });
    board.wait_for(hangs_at);
    cutoff.cut();
    assert!(board.output_v().abs() <= 0.5 * STEP_V);
    board.release();
    assert_eq!(receive.recv().unwrap(), Err(LinkFault::CutOff));
    assert!(board.output_v().abs() <= 0.5 * STEP_V);
    assert_eq!(board.logged("comedi_data_write").last().unwrap(), ZERO);
    (board, thread.join().unwrap())
}

#[test]
fn cut_off_while_it_reads_nothing_but_0_v_goes_out_until_it_is_prepared_again() {
    let (board, mut rig) = cut_while_hanging("comedi_data_read", "comedi_data_read 3.0 range 0 aref 0");
    let before = board.log().len();
    assert_eq!(rig.exchange(1, 5.0), Err(LinkFault::CutOff));
    assert_eq!(board.log().len(), before, "the board is not asked");
    rig.zero().unwrap();
    rig.prepare(UNHURRIED).unwrap();
    fresh(&mut rig, 0, 5.0);
    assert!(board.output_v() > 4.9);
    drop(rig);
    assert_ends_at_rest(&board);
}

#[test]
fn a_voltage_that_was_on_its_way_when_the_cut_came_is_taken_back() {
    let (board, rig) = cut_while_hanging("comedi_data_write", "comedi_data_write 1.0 range 0 aref 0: 3071");
    let written = board.logged("comedi_data_write");
    // Logged when they begin: ours, the cut's, and the loop's own 0 V after ours had come through.
    assert_eq!(written[written.len() - 3..], ["comedi_data_write 1.0 range 0 aref 0: 3071", ZERO, ZERO]);
    drop(rig);
    assert_ends_at_rest(&board);
}

#[test]
fn a_cutoff_outlives_its_rig() {
    let board = StandIn::new("comedi");
    let rig = rig(&board);
    let cutoff = rig.cutoff().unwrap();
    drop(rig);
    cutoff.cut();
    drop(cutoff);
    assert_ends_at_rest(&board);
}

#[test]
fn before_a_run_every_refusal_names_what_there_is_and_a_way_out() {
    for (text, found, needed) in [
        ("/dev/comedi7?", "/dev/comedi7: No such file or directory", "a comedi device that opens"),
        ("/dev/comedi0?output=2,", "output=2 on subdevice 1 with 2 channels", "counted from 0"),
        ("/dev/comedi0?encoder=9,", "encoder=9 on subdevice 3 with 2 channels", "counted from 0"),
        ("/dev/comedi0?gauge=8,", "gauge=8 on subdevice 0 with 8 channels", "counted from 0"),
        ("/dev/comedi0?encoder_subdevice=0,", "encoder_subdevice=0, which is no counter", "counter"),
        ("/dev/comedi0?output_subdevice=9,", "output_subdevice=9, which is no analogue output", "analogue output"),
        ("/dev/comedi0?output_range=1,", "an output from 0 V to 20 V", "0 V inside"),
        ("/dev/comedi0?gauge_range=2,", "2 ranges of gauge=0", "range 2 in volts"),
    ] {
        let board = StandIn::new("comedi");
        let port = ComediPort::parse(&format!("{text}library={}", board.path())).unwrap();
        let error = ComediRig::open(&port).err().unwrap();
        assert!(
            error.found.contains(found) && error.needed.contains(needed) && !error.hint.is_empty(),
            "{text}: {error}"
        );
        assert_eq!(board.open_handles(), 0);
    }
}

#[test]
fn a_board_without_counter_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let timers = folder.path().join("timers.so");
    stand_in::compile("comedi_stand_in.c", &["-DFOURTH_KIND=7"], &timers).unwrap();
    let named = ComediPort { library: Some(timers.to_str().unwrap().into()), ..ComediPort::new("/dev/comedi0") };
    let error = ComediRig::open(&named).err().unwrap();
    assert_eq!(error.found, "/dev/comedi0: 4 subdevices, none of them counter");
}

#[test]
fn a_missing_library_is_told_with_its_name_and_a_missing_function_by_its_own() {
    let named = ComediPort { library: Some("/nowhere/libcomedi.so.0".into()), ..ComediPort::new("/dev/comedi0") };
    let told = ComediRig::open(&named).err().unwrap().to_string();
    assert!(told.contains("/nowhere/libcomedi.so.0") && told.contains("No such file"), "{told}");

    let folder = tempfile::tempdir().unwrap();
    let old = folder.path().join("old.so");
    stand_in::compile("comedi_stand_in.c", &["-Dcomedi_data_write=comedi_trig"], &old).unwrap();
    let named = ComediPort { library: Some(old.to_str().unwrap().into()), ..ComediPort::new("/dev/comedi0") };
    let error = ComediRig::open(&named).err().unwrap();
    assert!(error.found.ends_with("without a function comedi_data_write"), "{error}");
}

#[test]
fn a_bad_port_is_refused() {
    for (text, found) in [
        ("", "no device"),
        ("?output=0", "no device"),
        ("/dev/comedi0?reference=differential", "reference=differential"),
        ("/dev/comedi0?gauge_range=wide", "gauge_range=wide"),
        ("/dev/comedi0?watchdog=none", "watchdog"),
    ] {
        let error = ComediPort::parse(text).unwrap_err();
        assert!(error.found.contains(found), "{text}: {error}");
    }
    let text = "/dev/comedi1?output_subdevice=1,encoder_subdevice=2,gauge_subdevice=3,output_range=4,gauge_range=5,reference=common";
    let expected = ComediPort {
        output_subdevice: Some(1),
        encoder_subdevice: Some(2),
        gauge_subdevice: Some(3),
        output_range: Some(4),
        gauge_range: Some(5),
        reference: Reference::Common,
        ..ComediPort::new("/dev/comedi1")
    };
    assert_eq!(ComediPort::parse(text).unwrap(), expected);
}

#[test]
fn an_exchange_allocates_nothing_and_loses_nothing() {
    let board = StandIn::new("comedi");
    let mut rig = rig(&board);
    assert_eq!(allocations_of(&mut rig, || board.fail("comedi_data_read", 1, 16)), 0);
    assert_eq!(rig.counters(), Counters::default());
    assert_eq!(rig.name(), "comedi:/dev/comedi0");
}

/// Whether comedilib's header is installed; says so where it is not.
fn header_is_installed() -> bool {
    let folder = tempfile::tempdir().unwrap();
    let probe = stand_in::compile("comedi_header_probe.c", &[], &folder.path().join("probe.so"));
    if let Err(said) = &probe {
        eprintln!("comedilib.h is not installed (Debian: libcomedi-dev); nothing compared with it\n{said}");
    }
    probe.is_ok()
}

#[test]
fn the_stand_in_has_the_prototypes_of_the_header() {
    if header_is_installed() {
        let folder = tempfile::tempdir().unwrap();
        stand_in::compile("comedi_stand_in.c", &["-DWITH_HEADER"], &folder.path().join("checked.so")).unwrap();
    }
}
