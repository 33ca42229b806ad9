//! An exchange allocates nothing: with an answer, without one, and with frames that are thrown away.

mod support;

use flexbeam_runtime::back_end::{Answer, BackEnd, Timing};
use flexbeam_runtime::serial::{DEFAULT_BAUD, SerialRig, SerialWire};
use flexbeam_runtime::served_rig::ServeOptions;
use flexbeam_runtime::udp::{UdpRig, UdpRigWire};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use support::relay::{Mischief, Relay};
use support::{PATIENT, Serving, delayed_voltage_v};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's contract is the system allocator's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's contract is the system allocator's.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const MISCHIEF: Mischief =
    Mischief { loses: 0.02, doubles: 0.02, swaps: 0.02, damages: 0.02, silent_after: None, spares: 2 };

/// Fresh and lost exchanges of this thread, with all that ends a run.
fn without_allocation(mut host: impl BackEnd) -> (u64, u64) {
    host.prepare(Timing { wait_s: 0.003, ..PATIENT }).unwrap();
    let before = ALLOCATIONS.with(Cell::get);
    assert!(before > 0, "the counter counts");
    let mut fresh = 0;
    for k in 0..500 {
        fresh += u64::from(matches!(host.exchange(k, delayed_voltage_v(k)), Ok(Answer::Fresh(_))));
    }
    let lost = host.counters().lost;
    host.zero().unwrap();
    assert_eq!(ALLOCATIONS.with(Cell::get), before);
    (fresh, lost)
}

#[test]
fn an_exchange_over_udp_allocates_nothing() {
    let wire = UdpRigWire::bind("127.0.0.1:0").unwrap();
    let rig_address = wire.address().unwrap().to_string();
    let serving = Serving::start(wire, ServeOptions::default());
    let (relay, address) = Relay::udp(&rig_address, MISCHIEF);
    let (fresh, lost) = without_allocation(UdpRig::open(&address, 1).unwrap());
    assert!(fresh > 0 && lost > 0, "{fresh} fresh, {lost} lost");
    relay.end();
    serving.end();
}

#[test]
fn an_exchange_over_a_serial_line_allocates_nothing() {
    let (wire, rig_device) = SerialWire::pseudo_terminal().unwrap();
    let serving = Serving::start(wire, ServeOptions::default());
    let by_byte = Mischief { loses: 0.001, damages: 0.001, spares: 80, ..Mischief::default() };
    let (relay, device) = Relay::serial(&rig_device, by_byte);
    let (fresh, lost) = without_allocation(SerialRig::open(&device, DEFAULT_BAUD, 1).unwrap());
    assert!(fresh > 0 && lost > 0, "{fresh} fresh, {lost} lost");
    relay.end();
    serving.end();
}
