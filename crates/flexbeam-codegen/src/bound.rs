//! How far the loop with the text in f32 can be from the loop in f64, for all references and all times.
//!
//! Enters: the controller as it was verified and as it is rounded, its nominal plant. Leaves: bounds, or why there is none.
//! Deliberately absent: saturation, faults, the switched law, and any plant but the nominal one.
//!
//! Alone, an integrator of the controller would sum its rounding without end; in the loop it does not. So the bound follows each
//! error round the nominal loop: |difference| <= sum over the errors of (l1 norm of the loop from there) (largest error). The errors
//! grow with the signals, and the signals with the errors; the bound is where both agree.

mod nominal_loop;
mod rounding;

use crate::numbers::Numbers;
use crate::{Error, Precision, Subject};
use flexbeam_kernel::{Law, Settings};
use flexbeam_lti::peak_to_peak::l1_norms;
use flexbeam_lti::{Mat, StateSpace};
use nominal_loop::{NominalLoop, Signal, combined};
use rounding::{Magnitudes, Ranges, Unit, errors};
use std::fmt;

/// Bounds of the difference between the loop that runs the f32 text and the one that runs f64, each with the nominal plant.
///
/// Assumes: references within `reference_rad`, each step at rest before the next where steps are smooth; |alpha| within
/// `deflection_rad`; the voltage limit not reached, no fault; the law cancels the actuator's dead zone, or there is neither.
/// Numerics: the norms are sums in f64, good to ten digits, and rounded up by 1e-4; roundings of the plant do not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleBound {
    /// Largest reference [rad].
    pub reference_rad: f64,
    /// Largest deflection behind its filter [rad].
    pub deflection_rad: f64,
    /// Of the voltage sent [V].
    pub voltage_v: f64,
    /// Of the controller's u [V].
    pub u_v: f64,
    /// Of the tip angle [rad].
    pub tip_rad: f64,
}

/// Why there is no bound.
#[derive(Clone, Debug, PartialEq)]
pub enum NoBound {
    /// Its switches may close a tick earlier or later.
    Switched,
    /// The inverse law has no ramp.
    Jump,
    /// The channels' filters or gains are not those of the design.
    Channels,
    /// psi answers a voltage in the same tick.
    Direct,
    /// The loop has no finite gains.
    Loop(flexbeam_lti::Error),
    /// Errors feed errors faster than the loop forgets them.
    Grows,
}

impl fmt::Display for NoBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoBound::Switched => write!(f, "the switched law jumps, and may do so a tick earlier or later"),
            NoBound::Jump => write!(f, "the inverse law jumps: eps_u_v is 0"),
            NoBound::Channels => write!(f, "the channels' scales and filters are not those of the certified loop"),
            NoBound::Direct => write!(f, "the nominal plant answers a voltage at once"),
            NoBound::Loop(error) => write!(f, "the nominal loop has no finite gains: {error}"),
            NoBound::Grows => write!(f, "rounding feeds itself faster than the loop forgets it"),
        }
    }
}

/// |alpha| where the settings know no limit [rad].
const DEFLECTION_RAD: f64 = 0.5;
/// |r| where the design knows no largest step [rad].
const REFERENCE_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Rounds until errors and signals agree; each shrinks what is wrong by some 1e-5.
const ROUNDS: usize = 40;
/// Above a fixed point, so that one more round ends below.
const ABOVE: f64 = 1.0 + 1e-9;

/// The bound, or why there is none.
///
/// Errors: those of [`Numbers::new`].
pub(crate) fn single_bound(subject: &Subject<'_>, single: &Numbers) -> Result<Result<SingleBound, NoBound>, Error> {
    let double = Numbers::new(subject, Precision::F64)?;
    if subject.controller.plant.D.0.iter().flatten().any(|d| *d != 0.0) {
        return Ok(Err(NoBound::Direct));
    }
    Ok(covered(&double.settings).and_then(|()| bound(subject, single, &double).map_err(NoBound::Loop)?))
}

fn covered(settings: &Settings) -> Result<(), NoBound> {
    let channels = [settings.theta, settings.alpha];
    let has_jump = settings.eps_u_v <= 0.0 && settings.u_p_plus_v.max(settings.u_p_minus_v) > 0.0;
    match settings.law {
        _ if channels.iter().any(|c| c.scale != 1.0 || c.low_pass != channels[0].low_pass) => Err(NoBound::Channels),
        Law::Switched => Err(NoBound::Switched),
        Law::Inverse if has_jump => Err(NoBound::Jump),
        _ => Ok(()),
    }
}

fn bound(
    subject: &Subject<'_>,
    single: &Numbers,
    double: &Numbers,
) -> Result<Result<SingleBound, NoBound>, flexbeam_lti::Error> {
    let settings = &double.settings;
    let ranges = Ranges {
        reference_rad: subject.controller.design.max_step_rad.unwrap_or(REFERENCE_RAD),
        deflection_rad: settings.deflection_limit_rad.min(DEFLECTION_RAD),
        voltage_v: settings.voltage_limit_v,
    };
    let of = |numbers: &Numbers| {
        NominalLoop::new(subject.controller, &numbers.coefficients, numbers.settings.theta.low_pass)
    };
    let loops = [of(single)?, of(double)?];
    let [Some(of_single), Some(of_double)] = [
        Travelled::new(&loops[0], settings, &ranges, Unit::F32)?,
        Travelled::new(&loops[1], settings, &ranges, Unit::F64)?,
    ] else {
        return Ok(Err(NoBound::Grows));
    };
    // The coefficients, then the arithmetic of either loop.
    let gap = l1_norms(&difference(&loops)?)? * ranges.reference_rad;
    let u_v = gap[0] + of_single.u_v + of_double.u_v;
    Ok(Ok(SingleBound {
        reference_rad: ranges.reference_rad,
        deflection_rad: ranges.deflection_rad,
        voltage_v: slope(settings) * u_v + of_single.law_v + of_double.law_v,
        u_v,
        tip_rad: gap[1] + of_single.tip_rad + of_double.tip_rad,
    }))
}

/// The steepest part of the law.
fn slope(settings: &Settings) -> f64 {
    let u_p = settings.u_p_plus_v.max(settings.u_p_minus_v);
    if settings.law == Law::Inverse && u_p > 0.0 { 1.0 + u_p / settings.eps_u_v } else { 1.0 }
}

/// u and psi of the first loop less those of the second, from the reference.
fn difference(loops: &[NominalLoop; 2]) -> Result<StateSpace, flexbeam_lti::Error> {
    let of = |one: &NominalLoop| one.system(&[&one.z[one.z.len() - 1], &one.psi], 1);
    let mut second = of(&loops[1])?;
    (second.C, second.D) = (-second.C, -second.D);
    flexbeam_lti::connections::parallel(&of(&loops[0])?, &second)
}

/// The errors of one precision, having gone round the loop.
struct Travelled {
    u_v: f64,
    tip_rad: f64,
    law_v: f64,
}

impl Travelled {
    /// None when errors grow without end.
    fn new(
        a: &NominalLoop,
        settings: &Settings,
        ranges: &Ranges,
        unit: Unit,
    ) -> Result<Option<Travelled>, flexbeam_lti::Error> {
        let signals: Vec<&Signal> = a.z.iter().chain([&a.filtered, &a.psi, &a.increment]).collect();
        let gains = l1_norms(&a.system(&signals, a.inputs())?)?;
        let partial: Vec<Vec<Signal>> = a.rows.iter().chain([&a.output]).map(|row| partial_sums(row, &a.z)).collect();
        let all: Vec<&Signal> = partial.iter().flatten().collect();
        let of_sums = l1_norms(&a.system(&all, 1)?)?;
        let mut found = Mat::zeros(a.inputs(), 1);
        for _ in 0..ROUNDS {
            let differences = &gains * &found;
            let next = Mat::from_vec(a.inputs(), 1, local(a, settings, ranges, unit, (&gains, &of_sums), &differences));
            if next.iter().zip(&found).all(|(next, found)| next <= found) {
                let (u, psi) = (a.z.len() - 1, a.z.len() + 1);
                let law_v = found[nominal_loop::Input::Actuator as usize];
                return Ok(Some(Travelled { u_v: differences[u], tip_rad: differences[psi], law_v }));
            }
            found = next * ABOVE;
        }
        Ok(None)
    }
}

/// The errors of a tick when the loop's signals are off by `differences`.
fn local(
    a: &NominalLoop,
    settings: &Settings,
    ranges: &Ranges,
    unit: Unit,
    (gains, of_sums): (&Mat, &Mat),
    differences: &Mat,
) -> Vec<f64> {
    let mut largest: Vec<f64> =
        (0..gains.nrows()).map(|i| gains[(i, 0)] * ranges.reference_rad + differences[i]).collect();
    let m = a.z.len();
    largest[m - 1] = largest[m - 1].min(ranges.voltage_v);
    let mut sums = of_sums.iter().map(|gain| gain * ranges.reference_rad);
    let mut of_row = |row: &Vec<f64>| -> Vec<f64> {
        let terms = row.iter().enumerate().filter(|(_, c)| **c != 0.0);
        let mut off = terms.scan(0.0, |off, (j, c)| {
            *off += c.abs() * differences[j];
            Some(*off)
        });
        off.next();
        off.map(|off| sums.next().unwrap_or(f64::INFINITY) + off).collect()
    };
    let sums: Vec<Vec<f64>> = a.rows.iter().chain([&a.output]).map(&mut of_row).collect();
    let (z, filtered, psi, increment) = (&largest[..m], largest[m], largest[m + 1], largest[m + 2]);
    errors(unit, a, settings, ranges, &Magnitudes { z, filtered, psi, increment, sums: &sums })
}

/// The sums from the second product that is not zero on.
fn partial_sums(row: &[f64], z: &[Signal]) -> Vec<Signal> {
    let terms: Vec<usize> = (0..row.len()).filter(|&j| row[j] != 0.0).collect();
    terms.iter().skip(1).map(|&last| combined(&row[..=last], z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::single::Single;
    use flexbeam_files::{Controller, Document};
    use flexbeam_kernel::{self as kernel, Channel, Fault, Measured, State, tick};
    use flexbeam_lti::{Vector, sampling};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The controller of `flexbeam reproduce --seed 1`.
    fn reproduced() -> Controller {
        Controller::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reproduce.toml")).unwrap()
    }

    fn settings(law: Law, smooth_ticks: f64, voltage_limit_v: f64) -> Settings {
        let channel = |offset_rad| Channel { low_pass: reproduced().design.low_pass, offset_rad, ..Channel::default() };
        let (u_p_plus_v, u_p_minus_v, eps_u_v) = if law == Law::Inverse { (0.27, 0.1, 0.011) } else { (0.0, 0.0, 0.1) };
        let (theta, alpha) = (channel(0.0), channel(0.01));
        Settings {
            theta,
            alpha,
            law,
            smooth_ticks,
            voltage_limit_v,
            u_p_plus_v,
            u_p_minus_v,
            eps_u_v,
            ..Settings::default()
        }
    }

    fn with_subject<T>(file: &Controller, settings: &Settings, ask: impl FnOnce(&Subject<'_>) -> T) -> T {
        let figures = &file.certificate.sampled;
        ask(&Subject { controller: file, settings, sha256: "", figures, unverified: None })
    }

    fn bound_of(file: &Controller, settings: &Settings) -> Result<SingleBound, NoBound> {
        with_subject(file, settings, |subject| {
            single_bound(subject, &Numbers::new(subject, Precision::F32).unwrap()).unwrap()
        })
    }

    /// The nominal plant behind its hold and its delay.
    struct Beam {
        plant: StateSpace,
        x: Vector,
    }

    impl Beam {
        fn psi(&self) -> f64 {
            (&self.plant.C * &self.x)[0]
        }

        fn advance(&mut self, voltage_v: f64) {
            self.x = &self.plant.A * &self.x + self.plant.B.column(0) * voltage_v;
        }
    }

    /// A dead zone that the inverse law cancels: f^-1 by bisection, since f grows.
    fn through_dead_zone(s: &Settings, voltage_v: f64) -> f64 {
        let f = |u: f64| u + if u > 0.0 { s.u_p_plus_v } else { s.u_p_minus_v } * (u / s.eps_u_v).clamp(-1.0, 1.0);
        let (mut low, mut high) = (-40.0, 40.0);
        for _ in 0..70 {
            let middle = 0.5 * (low + high);
            if f(middle) < voltage_v { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// Largest differences of voltage, u and tip angle between two loops, one in f32, one in f64.
    fn run(
        file: &Controller,
        s: &Settings,
        ticks: usize,
        mut reference: impl FnMut(&mut ChaCha8Rng, usize) -> f64,
    ) -> [f64; 3] {
        let (single, double) = with_subject(file, s, |subject| {
            let of = |precision| Numbers::new(subject, precision).unwrap();
            (of(Precision::F32), of(Precision::F64))
        });
        let (of_single, of_double) = (single.controller().unwrap(), double.controller().unwrap());
        let mut memory = vec![0.0; of_double.state_len()];
        let (mut in_single, mut in_double) = (Single::new(&of_single), State::new(&of_double, &mut memory).unwrap());
        let plant =
            sampling::zoh_with_delay(&file.plant_state_space().unwrap(), file.period_s, file.design.delay_s).unwrap();
        let at_rest = || Beam { x: Vector::zeros(plant.order()), plant: plant.clone() };
        let (mut first, mut second) = (at_rest(), at_rest());
        let mut random = ChaCha8Rng::seed_from_u64(32);
        let mut largest = [0.0_f64; 3];
        let mut deflection = 0.0;
        for k in 0..ticks {
            if k % 37 == 0 {
                deflection = random.random_range(-0.45..0.45);
            }
            let reference_rad = reference(&mut random, k);
            let measured = |beam: &Beam| Measured {
                reference_rad,
                theta_rad: beam.psi() - deflection,
                alpha_rad: deflection + s.alpha.offset_rad,
            };
            let c = [
                in_single.tick(&single.settings, measured(&first)),
                tick(s, &of_double, &mut in_double, measured(&second)),
            ];
            assert!(c.iter().all(|c| c.fault == Fault::None && c.voltage_v.abs() < s.voltage_limit_v), "{k}: {c:?}");
            let off = [c[0].voltage_v - c[1].voltage_v, c[0].u_v - c[1].u_v, first.psi() - second.psi()];
            (0..3).for_each(|i| largest[i] = largest[i].max(off[i].abs()));
            let heard = |c: &kernel::Commanded| {
                if s.law == Law::Inverse { through_dead_zone(s, c.voltage_v) } else { c.voltage_v }
            };
            first.advance(heard(&c[0]));
            second.advance(heard(&c[1]));
        }
        largest
    }

    /// Random targets, each held for long enough to come to rest on.
    fn held(random: &mut ChaCha8Rng, now: &mut f64, left: &mut usize, largest: f64, least_ticks: usize) -> f64 {
        if *left == 0 {
            *left = least_ticks + random.random_range(0..3 * least_ticks);
            *now = random.random_range(-largest..largest);
        }
        *left -= 1;
        *now
    }

    #[test]
    fn a_million_ticks_stay_below_the_bound() {
        let file = reproduced();
        let r = file.design.max_step_rad.unwrap();
        let infinite = f64::INFINITY;
        for (law, smooth_ticks, limit_v, largest, least_ticks, ticks) in [
            (Law::None, 200.0, 20.0, r, 200, 1_000_000),
            (Law::None, 0.0, infinite, r, 5, 300_000),
            (Law::Inverse, 200.0, 20.0, r, 200, 300_000),
        ] {
            let s = settings(law, smooth_ticks, limit_v);
            let bound = bound_of(&file, &s).unwrap();
            assert_eq!((bound.reference_rad, bound.deflection_rad), (r, 0.5));
            let (mut now, mut left) = (0.0, 0);
            let found = run(&file, &s, ticks, |random, _| held(random, &mut now, &mut left, largest, least_ticks));
            for (name, found, bound) in
                [("voltage", found[0], bound.voltage_v), ("u", found[1], bound.u_v), ("tip", found[2], bound.tip_rad)]
            {
                println!(
                    "{law:?}, smooth {smooth_ticks}: {name}: {found:.2e}, bound {bound:.2e}: {:.1} times",
                    bound / found
                );
                assert!(found > 0.0 && found <= bound, "{law:?}: {name}: {found:e} beyond {bound:e}");
                assert!(bound < 1000.0 * found, "{law:?}: {name}: {found:e}, bound {bound:e} says nothing");
            }
        }
    }

    /// u of the kernel in f64, with these numbers, round the nominal loop.
    fn voltages(file: &Controller, numbers: &Numbers, references: &[f64]) -> Vec<f64> {
        let controller = numbers.controller().unwrap();
        let mut memory = vec![0.0; controller.state_len()];
        let mut state = State::new(&controller, &mut memory).unwrap();
        let plant =
            sampling::zoh_with_delay(&file.plant_state_space().unwrap(), file.period_s, file.design.delay_s).unwrap();
        let mut beam = Beam { x: Vector::zeros(plant.order()), plant };
        let answer = |&reference_rad: &f64| {
            let measured = Measured { reference_rad, theta_rad: beam.psi(), alpha_rad: 0.0 };
            let c = tick(&numbers.settings, &controller, &mut state, measured);
            assert_eq!((c.fault, c.voltage_v), (Fault::None, c.u_v));
            beam.advance(c.voltage_v);
            c.u_v
        };
        references.iter().map(answer).collect()
    }

    /// Rounded coefficients, exact arithmetic: here the bound is no estimate, there is a reference that reaches it.
    #[test]
    fn the_worst_reference_reaches_what_the_coefficients_contribute() {
        const TICKS: usize = 6000;
        let file = reproduced();
        let open = Settings { theta_limit_rad: f64::INFINITY, ..settings(Law::None, 0.0, f64::INFINITY) };
        let s = Settings { alpha: open.theta, ..open };
        let numbers = [Precision::F32, Precision::F64]
            .map(|p| with_subject(&file, &s, |subject| Numbers::new(subject, p).unwrap()));
        let of = |n: &Numbers| NominalLoop::new(&file, &n.coefficients, n.settings.theta.low_pass).unwrap();
        let bound = l1_norms(&difference(&[of(&numbers[0]), of(&numbers[1])]).unwrap()).unwrap()[0];
        let apart = |references: &[f64]| -> Vec<f64> {
            let [single, double] = [0, 1].map(|k| voltages(&file, &numbers[k], references));
            single.iter().zip(double).map(|(a, b)| a - b).collect()
        };
        let impulse: Vec<f64> = (0..TICKS).map(|k| f64::from(u8::from(k == 0))).collect();
        let worst: Vec<f64> = apart(&impulse).iter().rev().map(|h| h.signum()).collect();
        let reached = apart(&worst)[TICKS - 1];
        assert!(reached <= bound && reached >= 0.99 * bound, "{reached:e} of {bound:e}");
    }

    #[test]
    fn where_the_text_jumps_or_the_loop_forgets_nothing_there_is_no_bound() {
        let file = reproduced();
        let s = settings(Law::Inverse, 200.0, 10.0);
        assert_eq!(bound_of(&file, &Settings { law: Law::Switched, ..s }), Err(NoBound::Switched));
        assert_eq!(bound_of(&file, &Settings { eps_u_v: 0.0, ..s }), Err(NoBound::Jump));
        let other = Channel { low_pass: 0.5, ..s.alpha };
        assert_eq!(bound_of(&file, &Settings { alpha: other, ..s }), Err(NoBound::Channels));
        let mut unstable = file.clone();
        unstable.plant.B.0.iter_mut().for_each(|row| row[0] *= -1.0);
        assert!(matches!(bound_of(&unstable, &s), Err(NoBound::Loop(flexbeam_lti::Error::WrongSide { .. }))));
        // States of 1e8 whose products cancel: rounding moves u by volts, which move the states.
        let mut large = file.clone();
        large.C.0[0].iter_mut().for_each(|c| *c *= 1e8);
        large.B.0.iter_mut().flatten().for_each(|b| *b *= 1e-8);
        let same = [bound_of(&file, &s), bound_of(&large, &s)].map(|bound| bound.unwrap().u_v);
        assert!((same[1] / same[0] - 1.0).abs() < 0.3, "a change of units changes little: {same:?}");
        let mut fragile = file.clone();
        let (first, last) = (fragile.C.0[0][0], 3e7);
        fragile.order += 2;
        fragile.A.0.iter_mut().for_each(|row| row.extend([0.0, 0.0]));
        for _ in 0..2 {
            let mut row = vec![0.0; fragile.order];
            row[0] = first;
            fragile.A.0.push(row);
            fragile.B.0.push(vec![0.0; 3]);
        }
        fragile.C.0[0].extend([last, -last]);
        fragile.C.0[1].extend([0.0, 0.0]);
        assert_eq!(bound_of(&fragile, &s), Err(NoBound::Grows));
    }
}
