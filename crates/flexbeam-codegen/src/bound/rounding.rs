//! What one tick of the generated text can round away.
//!
//! Enters: the largest magnitudes of the loop's signals. Leaves: the largest error at each of the loop's inputs, by the standard
//! model fl(a op b) = (a op b)(1 + d) + e, |d| <= u, |e| <= half a subnormal step where something is multiplied.
//! Deliberately absent: how errors travel round the loop.

use super::nominal_loop::{Input, NominalLoop};
use flexbeam_kernel::{Law, Settings};

/// u, and the largest error of a product that underflows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    pub(super) roundoff: f64,
    pub(super) underflow: f64,
}

impl Unit {
    /// 2^-24, 2^-150.
    pub(super) const F32: Unit = Unit { roundoff: 0.5 * f32::EPSILON as f64, underflow: 7.1e-46 };
    /// 2^-53; half of 2^-1074 is no number, so twice as much.
    pub(super) const F64: Unit = Unit { roundoff: 0.5 * f64::EPSILON, underflow: 5e-324 };

    /// (1 + u)^count - 1.
    fn relative(self, count: i32) -> f64 {
        (f64::from(count) * self.roundoff.ln_1p()).exp_m1()
    }
}

/// What is known of the signals without an error in sight.
pub(super) struct Ranges {
    /// |r|, so |v| [rad].
    pub(super) reference_rad: f64,
    /// |alpha| behind its filter [rad].
    pub(super) deflection_rad: f64,
    /// |u| [V].
    pub(super) voltage_v: f64,
}

/// Largest magnitudes in the loop that rounds.
pub(super) struct Magnitudes<'a> {
    /// Of x, v, y, u.
    pub(super) z: &'a [f64],
    /// Of the filtered tip angle, of the tip angle, of their difference from one tick to the next.
    pub(super) filtered: f64,
    pub(super) psi: f64,
    pub(super) increment: f64,
    /// Of the sums on the way, for each row of [A B] and for u.
    pub(super) sums: &'a [Vec<f64>],
}

/// The largest error at each input of the loop.
pub(super) fn errors(
    unit: Unit,
    a: &NominalLoop,
    settings: &Settings,
    ranges: &Ranges,
    m: &Magnitudes<'_>,
) -> Vec<f64> {
    let mut errors = vec![0.0; a.inputs()];
    errors[Input::Reference as usize] = of_reference(unit, settings, ranges);
    errors[Input::Filter as usize] = of_filters(unit, settings, ranges, m);
    errors[Input::Sum as usize] = unit.roundoff * m.filtered;
    let rows = a.rows.iter().chain([&a.output]).zip(m.sums);
    let mut of_rows: Vec<f64> = rows.map(|(row, sums)| of_row(unit, row, m.z, sums)).collect();
    errors[Input::Voltage as usize] = of_rows.pop().unwrap_or(0.0);
    errors[Input::Actuator as usize] = of_law(unit, settings, ranges);
    errors[Input::State as usize..].copy_from_slice(&of_rows);
    errors
}

/// sum c_j z_j from left to right: each product rounds, each sum but the first rounds, and a coefficient of zero adds exactly
/// nothing. `sums` are the largest magnitudes of the partial sums from the second product on.
fn of_row(unit: Unit, row: &[f64], z: &[f64], sums: &[f64]) -> f64 {
    let products = row.iter().zip(z).filter(|(c, _)| **c != 0.0).map(|(c, z)| c.abs() * z);
    let rounded = products.map(|product| unit.roundoff * product + unit.underflow);
    let of_sums = std::iter::once(0.0).chain(sums.iter().map(|sum| unit.roundoff * sum));
    rounded.zip(of_sums).fold(0.0, |error, (product, sum)| {
        let before = error + product;
        if sum > 0.0 { before * (1.0 + unit.roundoff) + sum } else { before }
    })
}

/// A smooth step from rest, v = r2 + d s^3 (1 + 3 t + 6 t^2), s = 1 - t, d = r1 - r2, |d| <= 2 r: the references round once; d, 3, 6,
/// the Horner scheme of terms of one sign, the cube and its product: 12 roundings; t moves v by at most 1.04 |d| for each relative
/// error, since t times the slope, 30 t^3 (1 - t)^2, is at most 1.037.
fn of_reference(unit: Unit, settings: &Settings, ranges: &Ranges) -> f64 {
    let (u, r) = (unit.roundoff, ranges.reference_rad);
    if !(settings.smooth_ticks > 1.0) {
        return u * r;
    }
    let scaled = settings.smooth_step_rad > 0.0 && settings.smooth_step_rad < 2.0 * r;
    let of_ticks = if scaled { u * (5.0 + 2.0 * r / settings.smooth_step_rad) } else { u };
    let of_step = unit.relative(12) + 1.04 * (u + of_ticks) * SECOND_ORDER;
    (2.0 * u * r + 2.0 * r * of_step) * SECOND_ORDER
}

/// Products of errors, where they are not counted one by one.
const SECOND_ORDER: f64 = 1.0 + 1e-4;

/// Both channels: what the host hands over rounds once, calibration twice; the filter y - (1 - a)(y - y_f) rounds 1 - a, a difference,
/// a product, a difference.
fn of_filters(unit: Unit, settings: &Settings, ranges: &Ranges, m: &Magnitudes<'_>) -> f64 {
    let a = settings.theta.low_pass;
    let alpha_change = 2.0 * ranges.deflection_rad / a;
    let alpha = ranges.deflection_rad * (2.0 - a) / a;
    let of = |offset: f64, raw: f64, change: f64, filtered: f64| {
        let roundings = if offset == 0.0 { 1 } else { 3 };
        let of_input = unit.relative(roundings) * (raw + 2.0 * offset.abs()) + unit.underflow;
        let of_product = (1.0 - a) * change * unit.relative(3) + unit.underflow;
        let of_filter = if a == 1.0 { 0.0 } else { of_product + unit.roundoff * (filtered + of_product) };
        (a * of_input + of_filter) * SECOND_ORDER
    };
    let (theta, theta_change) = (m.psi + alpha, m.increment + alpha_change);
    of(settings.theta.offset_rad, theta, theta_change, m.filtered + ranges.deflection_rad)
        + of(settings.alpha.offset_rad, alpha, alpha_change, ranges.deflection_rad)
}

/// u + u_p sat(u/eps_u): u_p and eps_u round, a quotient, a product, a sum.
fn of_law(unit: Unit, settings: &Settings, ranges: &Ranges) -> f64 {
    let u_p = settings.u_p_plus_v.max(settings.u_p_minus_v);
    match settings.law {
        Law::Inverse if u_p > 0.0 => {
            unit.relative(1) * ranges.voltage_v + unit.relative(5) * u_p + 2.0 * unit.underflow
        }
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::single::Single;
    use flexbeam_kernel::{Channel, Controller, Measured, State, tick};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Never more than the bound, and at worst not much less.
    fn assert_between(found: f64, bound: f64, share: f64) {
        assert!(found <= bound && found >= share * bound, "{found:e}, bound {bound:e}");
    }

    #[test]
    fn sums_of_products_stay_below_their_bound() {
        let mut random = ChaCha8Rng::seed_from_u64(24);
        let mut worst = 0.0_f64;
        for _ in 0..200_000 {
            let mut draw = |scale: f64| f64::from(random.random_range(-1.0..1.0f64) as f32) * scale;
            let row = [draw(1.0), 0.0, draw(8.0), draw(0.125), 0.0, draw(1.0)];
            let z: Vec<f64> = row.iter().map(|_| draw(1.0)).collect();
            let products: Vec<f64> = row.iter().zip(&z).map(|(c, z)| c * z).collect();
            let single = row.iter().zip(&z).fold(0.0_f32, |sum, (c, z)| sum + *c as f32 * *z as f32);
            let sums: Vec<f64> = [2, 3, 5].map(|last| products[..=last].iter().sum::<f64>().abs()).to_vec();
            let sizes: Vec<f64> = z.iter().map(|z| z.abs()).collect();
            let bound = of_row(Unit::F32, &row, &sizes, &sums);
            let found = (f64::from(single) - products.iter().sum::<f64>()).abs();
            assert!(found <= bound, "{found:e}, bound {bound:e}");
            worst = worst.max(found / bound);
        }
        assert!(worst > 0.6, "{worst}");
    }

    /// Smoothed references and filtered measurements of the text, against the kernel's.
    #[test]
    fn smooth_steps_and_filters_stay_below_their_bounds() {
        let coefficients = [0.0; 4];
        let controller = Controller::new(0, &coefficients).unwrap();
        for (largest, smooth_step_rad, share) in [(0.8, f64::INFINITY, 0.1), (0.8, 0.3, 0.05)] {
            let channel = Channel { low_pass: 0.3, ..Channel::default() };
            let s =
                Settings { theta: channel, alpha: channel, smooth_ticks: 37.3, smooth_step_rad, ..Settings::default() };
            let (mut memory, mut single) = ([0.0; 3], Single::new(&controller));
            let mut double = State::new(&controller, &mut memory).unwrap();
            let mut random = ChaCha8Rng::seed_from_u64(37);
            let (mut reference_rad, mut off) = (0.0, [0.0_f64; 2]);
            for k in 0..400_000 {
                if k % 400 == 0 {
                    reference_rad = random.random_range(-largest..largest);
                }
                let (theta_rad, alpha_rad) = (random.random_range(-1.0..1.0), random.random_range(-0.5..0.5));
                let measured = Measured { reference_rad, theta_rad, alpha_rad };
                let (one, other) = (single.tick(&s, measured), tick(&s, &controller, &mut double, measured));
                off[0] = off[0].max((one.reference_rad - other.reference_rad).abs());
                off[1] = off[1].max((one.y_rad - other.y_rad).abs());
            }
            let ranges = Ranges { reference_rad: largest, deflection_rad: 0.5, voltage_v: 10.0 };
            assert_between(off[0], of_reference(Unit::F32, &s, &ranges), share);
            let m = Magnitudes { z: &[], filtered: 1.5, psi: 1.5, increment: 3.0, sums: &[] };
            let bound = of_filters(Unit::F32, &s, &ranges, &m) / channel.low_pass + Unit::F32.roundoff * m.filtered;
            assert_between(off[1], bound, 0.02);
        }
    }
}
