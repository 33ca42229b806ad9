//! What the vectors ask: ticks that visit saturation, both switches, every fault, changes of the settings, resets.
//!
//! Enters: the numbers of the text, the nominal plant. Leaves: settings and inputs that the precision holds exactly.
//! Deliberately absent: the rig. The beam here need not be true, only beam-like and the same to the last bit everywhere: sums and
//! products in a fixed order, no exponential, no sine.

use crate::numbers::Numbers;
use crate::{Error, Precision};
use flexbeam_files::Matrices;
use flexbeam_kernel::{Channel, Law, Measured, Settings, State, tick};

/// One tick, with the reset that may come before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Which of the settings.
    pub(crate) settings: usize,
    pub(crate) reset: bool,
    pub(crate) measured: Measured,
    /// A loop as it should run, in which f32 may be held against f64; without this mark it is abuse.
    pub(crate) fair: bool,
}

/// Settings of each part, beginning with the controller's own. Without rounding.
pub(crate) fn settings(own: &Settings) -> Vec<Settings> {
    let open = Settings {
        deflection_limit_rad: f64::INFINITY,
        theta_limit_rad: f64::INFINITY,
        theta_step_limit_rad: f64::INFINITY,
        ..*own
    };
    let channel = |scale, offset_rad, low_pass| Channel { scale, offset_rad, low_pass };
    vec![
        *own,
        Settings { law: Law::Inverse, voltage_limit_v: 0.75, u_p_plus_v: 0.28, u_p_minus_v: 0.1, eps_u_v: 0.2, ..open },
        Settings {
            law: Law::Switched,
            u_p_plus_v: 0.3,
            u_p_minus_v: 0.12,
            eps_u_v: 0.25,
            eps_e_rad: 0.02,
            hysteresis_u: 0.2,
            hysteresis_e: 0.5,
            breakaway_plus_v: 0.2,
            breakaway_minus_v: 0.02,
            smooth_ticks: 0.0,
            ..open
        },
        Settings {
            law: Law::None,
            theta: channel(1.015625, 0.0078125, 0.3),
            alpha: channel(-0.96875, -0.015625, 0.7),
            smooth_ticks: 17.0,
            smooth_step_rad: 0.25,
            ..open
        },
        Settings { deflection_limit_rad: 0.25, theta_limit_rad: 2.0, theta_step_limit_rad: 0.5, ..open },
        Settings { law: Law::Inverse, eps_u_v: 0.0, u_p_plus_v: 0.5, u_p_minus_v: 0.25, smooth_ticks: 0.0, ..open },
        Settings { voltage_limit_v: f64::NAN, ..open },
        Settings { theta_limit_rad: f64::NAN, ..open },
    ]
}

const OWN: usize = 0;
const SATURATED: usize = 1;
const SWITCHED: usize = 2;
const FILTERED: usize = 3;
const LIMITED: usize = 4;
const JUMPING: usize = 5;
const NO_VOLTAGE: usize = 6;
const NO_LIMIT: usize = 7;

/// All ticks of the vectors.
///
/// Errors: those of the kernel.
pub(crate) fn script(
    numbers: &Numbers,
    plant: &Matrices,
    period_s: f64,
    precision: Precision,
) -> Result<Vec<Step>, Error> {
    let mut loops = Loops { numbers, plant, period_s, precision, steps: Vec::new() };
    let step = |after: usize, first: f64, second: f64| move |k: usize| if k < after { first } else { second };
    loops.closed(100, |_| OWN, step(60, 0.5, -0.25))?;
    loops.closed(60, |_| SATURATED, step(40, 1.0, -0.5))?;
    loops.closed(80, |_| SWITCHED, |k| if (k / 16).is_multiple_of(2) { 0.03125 } else { -0.0625 })?;
    loops.closed(50, |_| FILTERED, step(9, 0.75, 0.25))?;
    loops.closed(70, |k| [OWN, SATURATED, SWITCHED, FILTERED, JUMPING][k / 7 % 5], step(35, 0.125, -0.25))?;
    loops.faults();
    Ok(loops.steps)
}

struct Loops<'a> {
    numbers: &'a Numbers,
    plant: &'a Matrices,
    period_s: f64,
    precision: Precision,
    steps: Vec<Step>,
}

impl Loops<'_> {
    /// A closed loop from rest.
    fn closed(
        &mut self,
        ticks: usize,
        settings_at: impl Fn(usize) -> usize,
        reference_rad: impl Fn(usize) -> f64,
    ) -> Result<(), Error> {
        let choices = settings(&self.numbers.settings);
        let controller = self.numbers.controller()?;
        let mut memory = vec![0.0; controller.state_len()];
        let mut state = State::new(&controller, &mut memory)?;
        let mut beam = Beam::at_rest(self.plant);
        for k in 0..ticks {
            let (theta_rad, alpha_rad) = beam.angles();
            let measured = Measured { reference_rad: reference_rad(k), theta_rad, alpha_rad };
            self.steps.push(Step { settings: settings_at(k), reset: k == 0, measured, fair: true });
            let commanded = tick(&choices[settings_at(k)], &controller, &mut state, measured);
            beam.advance(commanded.voltage_v, self.period_s);
        }
        Ok(())
    }

    /// Each fault, the ticks behind it, and numbers that nobody should send.
    fn faults(&mut self) {
        let (rest, large, tiny) = ([0.125, 0.0, 0.0], 2f64.powi(100), self.precision.subnormal());
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        let parts: [(usize, &[[f64; 3]]); 11] = [
            (LIMITED, &[rest, [0.125, 0.125, 0.25], [0.125, 0.125, 0.25078125], rest, rest]),
            (LIMITED, &[rest, [0.125, -0.5, 0.0], [0.125, -0.125, -0.5], rest]),
            (LIMITED, &[[0.0, 1.75, 0.0], [0.0, 2.0, 0.0], [0.0, 2.0625, 0.0], rest]),
            (LIMITED, &[rest, [0.125, 0.5, 0.0], [0.125, 1.0625, 0.0], rest]),
            (LIMITED, &[rest, [0.125, nan, 0.125], [0.125, 0.25, 0.125], [0.125, 0.25, infinite]]),
            (OWN, &[rest, [0.125, 0.0, -infinite], rest]),
            (OWN, &[rest, [nan, 0.0, 0.0], rest]),
            (JUMPING, &[rest, [large, large, -large], [-large, large, large], rest]),
            (JUMPING, &[[tiny, 2.0 * tiny, tiny], [-tiny, 3.0 * tiny, tiny], [0.0, -0.0, 0.0], rest]),
            (NO_VOLTAGE, &[rest, rest]),
            (NO_LIMIT, &[rest, rest]),
        ];
        for (settings, inputs) in parts {
            for (k, &[reference_rad, theta_rad, alpha_rad]) in inputs.iter().enumerate() {
                let measured = Measured { reference_rad, theta_rad, alpha_rad };
                self.steps.push(Step { settings, reset: k == 0, measured, fair: false });
            }
        }
    }
}

/// The nominal plant by Euler's rule, and a deflection that follows the tip's motion.
struct Beam<'a> {
    plant: &'a Matrices,
    x: Vec<f64>,
    psi: f64,
    slow: f64,
}

impl Beam<'_> {
    /// Small enough for poles of 60 rad/s at 1 kHz.
    const STEPS_PER_PERIOD: u32 = 8;
    /// A beam that goes further starts again at rest [rad].
    const FURTHEST_RAD: f64 = 4.0;
    /// Angles are whole multiples of this one, so that f32 holds them, too [rad].
    const GRID_RAD: f64 = 1.0 / 16384.0;

    fn at_rest(plant: &Matrices) -> Beam<'_> {
        Beam { plant, x: vec![0.0; plant.A.0.len()], psi: 0.0, slow: 0.0 }
    }

    fn advance(&mut self, voltage_v: f64, period_s: f64) {
        let h = period_s / f64::from(Self::STEPS_PER_PERIOD);
        for _ in 0..Self::STEPS_PER_PERIOD {
            let rows = self.plant.A.0.iter().zip(&self.plant.B.0);
            let slopes = rows.map(|(a, b)| product(a, &self.x) + b.first().map_or(0.0, |b| b * voltage_v));
            let next = slopes.zip(&self.x).map(|(slope, x)| x + h * slope);
            self.x = next.collect();
        }
        self.psi = self.plant.C.0.first().map_or(0.0, |c| product(c, &self.x));
        if !(-Self::FURTHEST_RAD..=Self::FURTHEST_RAD).contains(&self.psi) {
            *self = Beam::at_rest(self.plant);
        }
        self.slow += 0.125 * (self.psi - self.slow);
    }

    fn angles(&self) -> (f64, f64) {
        let on_grid = |x: f64| (x / Self::GRID_RAD).round() * Self::GRID_RAD;
        let alpha = on_grid((0.5 * (self.psi - self.slow)).clamp(-0.2, 0.2));
        (on_grid(self.psi) - alpha, alpha)
    }
}

fn product(row: &[f64], x: &[f64]) -> f64 {
    row.iter().zip(x).fold(0.0, |sum, (a, x)| sum + a * x)
}

/// Inputs and settings of the self-check: digits to the last place, so that a contracted product shows.
pub(crate) fn check(precision: Precision) -> (Settings, Vec<Measured>) {
    let channel = |scale, low_pass| Channel { scale, offset_rad: 1.0 / 3.0 - 0.25, low_pass };
    let settings = Settings {
        theta: channel(1.1, 0.37),
        alpha: channel(0.9, 0.61),
        smooth_ticks: 5.3,
        smooth_step_rad: 0.17,
        law: Law::Inverse,
        u_p_plus_v: 0.28,
        u_p_minus_v: 0.13,
        eps_u_v: 10.0,
        eps_e_rad: 0.005,
        hysteresis_u: 0.2,
        hysteresis_e: 0.5,
        breakaway_plus_v: 0.0,
        breakaway_minus_v: 0.0,
        voltage_limit_v: 10.0,
        deflection_limit_rad: f64::INFINITY,
        theta_limit_rad: f64::INFINITY,
        theta_step_limit_rad: f64::INFINITY,
    };
    let tiny = precision.subnormal();
    let at_rest = |theta_rad, alpha_rad| Measured { reference_rad: 0.0, theta_rad, alpha_rad };
    let offset = precision.nearest(settings.theta.offset_rad);
    // The first measurements pass the filters whatever they are; the ones behind stay small while the numbers are subnormal.
    let mut ticks = vec![Measured { reference_rad: tiny, ..at_rest(offset, offset) }];
    let mut bits = 2009_u32;
    let mut drawn = || {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        precision.nearest(f64::from(bits) / f64::from(u32::MAX) * 0.7 / 3.0 - 0.1)
    };
    ticks.extend((1..CHECKED_TICKS).map(|_| Measured { reference_rad: drawn(), ..at_rest(drawn(), drawn()) }));
    (settings, ticks)
}

/// Ticks of the self-check: the first finds flushed subnormal numbers, the others contraction.
pub(crate) const CHECKED_TICKS: usize = 10;
