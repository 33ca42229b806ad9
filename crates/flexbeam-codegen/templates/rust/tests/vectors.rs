//! Holds `tick` against the vectors of flexbeam's @MADE_BY@, bit for bit.

use NAME::{Channel, Commanded, Fault, Law, Measured, Real, Settings, State, selfcheck, tick};

/// First a reset, if there is one, then a tick with these settings and inputs, and what it must answer. Numbers by their bits:
/// reference, theta, alpha [rad]; voltage, u [V], v, y, y_model, e [rad].
struct Vector(usize, bool, Fault, [@BITS@; 3], [@BITS@; 6]);

#[test]
fn every_bit_is_as_flexbeam_computes_it() {
    let mut state = State::new();
    for (k, Vector(settings, reset, fault, inputs, answers)) in VECTORS.iter().enumerate() {
        if *reset {
            state.reset();
        }
        let [reference_rad, theta_rad, alpha_rad] = inputs.map(Real::from_bits);
        let found = tick(&SETTINGS[*settings], &mut state, Measured { reference_rad, theta_rad, alpha_rad });
        let Commanded { voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad, fault: found } = found;
        let bits = [voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad].map(Real::to_bits);
        assert_eq!((found, bits), (*fault, *answers), "tick {k}");
    }
}

#[test]
fn this_machine_computes_as_it_must() {
    assert_eq!(selfcheck(), None);
}

const SETTINGS: [Settings; @VECTOR_SETTINGS@] = [
@SETTINGS@
];

static VECTORS: [Vector; @VECTORS@] = [
@ROWS@
];
