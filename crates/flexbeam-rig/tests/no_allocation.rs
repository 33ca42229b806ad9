//! A period of the simulated rig allocates nothing.

use flexbeam_rig::{RigParameters, SimulatedRig};
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

#[test]
fn measure_and_apply_allocate_nothing() {
    let mut rig = SimulatedRig::new(&RigParameters::default(), 5).unwrap();
    let before = ALLOCATIONS.with(Cell::get);
    assert!(before > 0, "the counter counts");
    for k in 0..2000 {
        let measurement = rig.measure();
        rig.apply((0.01 * f64::from(k)).sin() - measurement.theta_rad);
    }
    assert_eq!(ALLOCATIONS.with(Cell::get), before);
}
