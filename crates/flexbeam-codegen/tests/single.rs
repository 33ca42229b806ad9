//! What is stated of f32 holds for what the compiled C answers: its own vectors, and the kernel in f64 on the same inputs.

mod support;

use flexbeam_codegen::{Precision, rounded};
use flexbeam_kernel::{Controller, Fault, Law, Measured, Settings, State, tick};
use support::{Kernel, Language, compile, reproduced, settings_of, sources, succeeds, written};

/// Prints what each tick answers, beside its settings' number, reset and inputs; numbers in hexadecimal.
const PRINT: &str = r#"
#include "test_vectors.h"
#include <stdio.h>
int main(void)
{
    static struct beam_state state;
    for (int k = 0; k < BEAM_VECTORS; ++k) {
        const struct beam_vector *v = &beam_vectors[k];
        const struct beam_measured measured = {v->inputs[0], v->inputs[1], v->inputs[2]};
        if (v->reset) {
            beam_reset(&state);
        }
        const struct beam_commanded c = beam_tick(&beam_vector_settings[v->settings], &state, measured);
        printf("%d %d %.9g %.9g %.9g %.9g %.9g %d\n", v->settings, v->reset, (double)v->inputs[0], (double)v->inputs[1],
               (double)v->inputs[2], (double)c.voltage_v, (double)c.u_v, (int)c.fault);
    }
    return 0;
}
"#;

/// The vectors begin with the controller's own settings in a closed loop: these are run again in f64.
#[test]
fn the_stated_error_is_that_of_the_compiled_text() {
    let file = reproduced();
    let sources = sources(&file, Precision::F32, &Language::C);
    let stated = sources.single.as_ref().expect("f32 states its error").error;
    let folder = written("single", &sources);
    std::fs::write(folder.join("print.c"), PRINT).unwrap();
    let program = compile("clang", &["-O2"], &["beam.c", "test_vectors.c", "print.c"], "print", &folder);
    let said = succeeds(program, &[], &folder);
    let rows = said.lines().map(|line| line.split(' ').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>());
    let own: Vec<Vec<f64>> =
        rows.enumerate().take_while(|(k, row)| *k == 0 || row[1] == 0.0).map(|(_, row)| row).collect();
    assert!(own.len() >= 100 && own.iter().all(|row| row[0] == 0.0 && row[7] == 0.0));
    let (voltage_v, u_v) = largest_difference(&Kernel::of(&file, Precision::F64), &settings_of(&file), &own);
    assert!(0.0 < voltage_v && voltage_v <= stated.voltage_v * 1.001, "{voltage_v} V, stated {stated:?}");
    assert!(0.0 < u_v && u_v <= stated.u_v * 1.001, "{u_v} V, stated {stated:?}");
    assert!(stated.voltage_v < 1e-3 && stated.angle_rad < 1e-5, "f32 is good for six digits: {stated:?}");
}

fn largest_difference(kernel: &Kernel, settings: &Settings, rows: &[Vec<f64>]) -> (f64, f64) {
    assert_eq!(settings.law, Law::Inverse);
    let controller = Controller::new(kernel.order, &kernel.coefficients).unwrap();
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let mut differences = |row: &Vec<f64>| {
        let measured = Measured { reference_rad: row[2], theta_rad: row[3], alpha_rad: row[4] };
        let exact = tick(settings, &controller, &mut state, measured);
        assert_eq!(exact.fault, Fault::None);
        ((exact.voltage_v - row[5]).abs(), (exact.u_v - row[6]).abs())
    };
    rows.iter().map(&mut differences).fold((0.0, 0.0), |(v, u), (dv, du)| (v.max(dv), u.max(du)))
}

#[test]
fn what_f32_cannot_hold_is_refused_by_its_name() {
    let settings = settings_of(&reproduced());
    for (x, words) in [(1e39, "A[2][2] = 1e39, which overflows f32"), (-1e-40, "A[2][2] = -1e-40, which f32 keeps")] {
        let mut file = reproduced();
        file.A.0[1][1] = x;
        let message = rounded(&file, &settings).unwrap_err().to_string();
        assert!(message.contains(words) && message.contains("\nhint: "), "{message}");
    }
    let senseless = Settings { eps_u_v: 1e-50, ..settings };
    let message = rounded(&reproduced(), &senseless).unwrap_err().to_string();
    assert!(message.contains("settings.eps_u_v"), "{message}");
    let open = Settings { theta_limit_rad: f64::INFINITY, ..settings };
    assert_eq!(rounded(&reproduced(), &open).unwrap().1.theta_limit_rad, f64::INFINITY, "no limit stays none");
}
