//! Runs a generated controller through the ticks of a file (see harness.c). `harness check FILE` compares every answer to the bit;
//! `harness answer FILE OUT` writes FILE with the answers found here.

use NAME::{Channel, Fault, Law, Measured, Real, Settings, State, selfcheck, tick};
use std::io::{BufReader, BufWriter, Read, Write};

const SETTING: usize = 21;

fn settings(x: &[f64]) -> Settings {
    let channel = |at: usize| Channel { scale: x[at] as Real, offset_rad: x[at + 1] as Real, low_pass: x[at + 2] as Real };
    Settings {
        theta: channel(0),
        alpha: channel(3),
        smooth_ticks: x[6] as Real,
        smooth_step_rad: x[7] as Real,
        law: [Law::None, Law::Switched, Law::Inverse][x[8] as usize],
        u_p_plus_v: x[9] as Real,
        u_p_minus_v: x[10] as Real,
        eps_u_v: x[11] as Real,
        eps_e_rad: x[12] as Real,
        hysteresis_u: x[13] as Real,
        hysteresis_e: x[14] as Real,
        breakaway_plus_v: x[15] as Real,
        breakaway_minus_v: x[16] as Real,
        voltage_limit_v: x[17] as Real,
        deflection_limit_rad: x[18] as Real,
        theta_limit_rad: x[19] as Real,
        theta_step_limit_rad: x[20] as Real,
    }
}

fn numbers<const N: usize>(file: &mut impl Read) -> Option<[f64; N]> {
    let mut bytes = vec![0; 8 * N];
    file.read_exact(&mut bytes).ok()?;
    Some(std::array::from_fn(|k| f64::from_le_bytes(bytes[8 * k..8 * k + 8].try_into().unwrap())))
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let mut file = BufReader::with_capacity(1 << 20, std::fs::File::open(&arguments[2]).unwrap());
    let mut out = arguments.get(3).map(|path| BufWriter::with_capacity(1 << 20, std::fs::File::create(path).unwrap()));
    let mut write = |numbers: &[f64]| {
        if let Some(out) = &mut out {
            numbers.iter().for_each(|x| out.write_all(&x.to_le_bytes()).unwrap());
        }
    };
    let [many] = numbers(&mut file).unwrap();
    write(&[many]);
    let mut choices = Vec::new();
    for _ in 0..many as usize {
        let x: [f64; SETTING] = numbers(&mut file).unwrap();
        write(&x);
        choices.push(settings(&x));
    }
    assert_eq!(selfcheck(), None);
    let mut state = State::new();
    let mut ticks = 0;
    while let Some(row) = numbers::<12>(&mut file) {
        if row[1] != 0.0 {
            state.reset();
        }
        let measured = Measured { reference_rad: row[2] as Real, theta_rad: row[3] as Real, alpha_rad: row[4] as Real };
        let c = tick(&choices[row[0] as usize], &mut state, measured);
        let fault = match c.fault {
            Fault::None => 0.0,
            Fault::Deflection => 1.0,
            Fault::Angle => 2.0,
            Fault::Speed => 3.0,
            Fault::NonFinite => 4.0,
        };
        let numbers = [c.voltage_v, c.u_v, c.reference_rad, c.y_rad, c.y_model_rad, c.error_rad];
        let [voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad] = numbers.map(|x: Real| x as f64);
        let found = [voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad, fault];
        if arguments[1] == "check" {
            assert_eq!(found.map(f64::to_bits)[..], row.map(f64::to_bits)[5..], "tick {ticks}");
        }
        write(&row[..5]);
        write(&found);
        ticks += 1;
    }
    println!("{ticks} ticks");
}
