//! Rigs behind boards, against stand-ins for the vendors' libraries that are compiled here. No board was at hand: what these
//! tests hold is what flexbeam asks of a board and does with its answers.

mod comedi;
mod hil;
mod stand_in;

use flexbeam_rig::Measurement;
use flexbeam_runtime::back_end::{Answer, BackEnd, LinkFault, Timing};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

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

/// Far longer than any test, so that no stall of the machine lets a watchdog expire.
const UNHURRIED: Timing = Timing { period_s: 0.001, wait_s: 0.001, hold_s: 3600.0 };

fn fresh(rig: &mut impl BackEnd, instant: u64, voltage_v: f64) -> Measurement {
    match rig.exchange(instant, voltage_v) {
        Ok(Answer::Fresh(measured)) => measured,
        other => panic!("{other:?} at {instant}"),
    }
}

/// Exchanges, a fault and 0 V, counted.
fn allocations_of(rig: &mut impl BackEnd, fail: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    assert!(before > 0, "the counter counts");
    for k in 0..100 {
        fresh(rig, k, 0.01 * k as f64);
    }
    let during = ALLOCATIONS.with(Cell::get) - before;
    fail();
    let before = ALLOCATIONS.with(Cell::get);
    assert!(matches!(rig.exchange(100, 1.0), Err(LinkFault::Board { .. })));
    rig.zero().unwrap();
    during + ALLOCATIONS.with(Cell::get) - before
}
