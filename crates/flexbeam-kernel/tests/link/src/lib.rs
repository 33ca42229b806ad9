//! What the loop calls, behind C symbols, with a panic handler that nothing defines: the linker is the proof.
#![no_std]

use flexbeam_kernel::{Commanded, Controller, Measured, Settings, State, tick, v_res};

unsafe extern "C" {
    /// Defined nowhere, so a reachable panic leaves it undefined.
    fn flexbeam_kernel_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never runs; a library in which it could does not link.
    unsafe { flexbeam_kernel_can_panic() }
}

/// Named by the unwinding tables of the precompiled core; nothing unwinds with `panic = "abort"`.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

#[unsafe(no_mangle)]
fn linked_tick(
    settings: &Settings,
    controller: &Controller<'_>,
    state: &mut State<'_>,
    measured: Measured,
) -> Commanded {
    tick(settings, controller, state, measured)
}

#[unsafe(no_mangle)]
fn linked_reset(state: &mut State<'_>) {
    state.reset();
}

/// Everything else without `fmt` in it: making the parts, asking them.
#[unsafe(no_mangle)]
fn linked_setup(settings: &Settings, order: usize, coefficients: &[f64], memory: &mut [f64]) -> f64 {
    let Ok(controller) = Controller::new(order, coefficients) else { return -1.0 };
    let Ok(state) = State::new(&controller, memory) else { return -2.0 };
    let sound = settings.first_unsound().is_none();
    state.x().iter().sum::<f64>() + v_res(settings.eps_u_v, settings.u_p_plus_v) + if sound { 0.0 } else { 1.0 }
}

#[cfg(feature = "planted")]
#[unsafe(no_mangle)]
fn linked_planted(coefficients: &[f64], index: usize) -> f64 {
    coefficients[index]
}
