#![no_std]
#![forbid(unsafe_code)]
//! @TITLE@
//!
@BANNER@
//!
//! One call of [`tick`] a period, from measurement to voltage: scale, filter, limits on the measurements, smooth reference,
//! controller, variable-structure law, voltage limit, u_applied, state update, non-finite check. No allocation, no panic, no
//! dependencies, no state but the [`State`] that the caller owns. It has an answer for any numbers.
//!
//! rustc never contracts products and sums, so the answers have the same bits on every machine with IEEE 754 arithmetic.
//! [`selfcheck`] finds a processor that flushes subnormal numbers; call it once at start.

mod law;
mod settings;
mod tick;

pub use settings::{Channel, Law, Settings};
pub use tick::{Commanded, Fault, Measured, State};

/// Precision of all arithmetic.
pub type Real = @REAL@;

/// Number of states n of the controller.
pub const ORDER: usize = @ORDER@;

/// Sample period [s]: how often [`tick`] is to be called.
pub const PERIOD_S: f64 = @PERIOD@;

/// SHA-256 of the controller file that this was made from.
pub const SHA256: &str = "@SHA256@";

/// The settings of the controller file.
pub const DEFAULT_SETTINGS: Settings = @SETTINGS@;

type Memory = [Real; ORDER + 3];

impl State {
    /// At rest at 0 rad, x = 0, no fault.
    pub fn new() -> Self {
        Self::at_rest([0.0; ORDER + 3], [0.0; ORDER + 3])
    }

    /// The controller's state x.
    pub fn x(&self) -> &[Real] {
        self.z.get(..ORDER).unwrap_or_default()
    }
}

impl Default for State {
    fn default() -> Self {
        Self::new()
    }
}

/// One period. A missed tick is not made up for: the next one runs with the state as it stands.
pub fn tick(settings: &Settings, state: &mut State, measured: Measured) -> Commanded {
    tick::tick(tick::Gains { order: ORDER, ab: &AB, cd: &CD }, settings, state, measured)
}

/// Runs a few ticks whose answers are known to the last bit.
///
/// Returns: the number of the first wrong one, counted from 1. Then do not run the controller.
pub fn selfcheck() -> Option<usize> {
    let mut state = State::new();
    let is_wrong = |(inputs, right): (&[Real; 3], &[Real; 6])| {
        // Hidden, so that nothing is computed before the machine that is checked does.
        let [reference_rad, theta_rad, alpha_rad] = core::hint::black_box(*inputs);
        let found = tick(&CHECKED_SETTINGS, &mut state, Measured { reference_rad, theta_rad, alpha_rad });
        let Commanded { voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad, .. } = found;
        let found = [voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad];
        // Not by ==: a processor that flushes subnormal numbers takes them for zero there, too.
        found.map(Real::to_bits) != right.map(Real::to_bits)
    };
    CHECKED_INPUTS.iter().zip(&CHECKED_ANSWERS).position(is_wrong).map(|k| k + 1)
}

/// [A B], column by column.
static AB: [Real; ORDER * (ORDER + 3)] = [
@AB@
];

/// [C D], column by column: u, y_model.
static CD: [Real; 2 * (ORDER + 2)] = [
@CD@
];

const CHECKED_SETTINGS: Settings = @CHECKED_SETTINGS@;

/// reference, theta, alpha [rad].
static CHECKED_INPUTS: [[Real; 3]; @CHECKED_TICKS@] = [
@CHECKED_INPUTS@
];

/// voltage, u [V], v, y, y_model, e [rad].
static CHECKED_ANSWERS: [[Real; 6]; @CHECKED_TICKS@] = [
@CHECKED_ANSWERS@
];
