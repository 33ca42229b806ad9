//! Axes: the range that data need, where ticks stand and what they say.
//!
//! Ticks are multiples of 1, 2 or 5 times a power of ten (of 15, 30, 45 and 90 on an axis of degrees, of
//! 20, 40 and 60 on one of decibels). Large and small
//! numbers share one engineering exponent that stands at the end of the axis.

use crate::number::typographic;

/// How values become places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal ratios; values of zero and below have no place.
    Log,
    /// Equal steps that divide the circle: 15, 30, 45, 90, ...
    Degrees,
    /// Equal steps that gains are read in: 10, 20, 40, 60, ...
    Decibels,
    /// Equal steps of whole numbers: orders, indices.
    Integer,
}

/// An axis. Invariant: `low < high`, both finite, both positive on a logarithmic scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
}

/// A tick: where and what it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where, in the axis' own unit.
    pub value: f64,
    /// What it says; powers of ten have raised digits: `10⁻⁶`.
    pub label: String,
}

/// The ticks of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    /// Labelled, increasing.
    pub major: Vec<Tick>,
    /// Between them, unlabelled.
    pub minor: Vec<f64>,
    /// The labels are to be multiplied by 10 to this power, a multiple of 3.
    pub exponent: i32,
}

/// Values beyond this are drawn here: the square root of nothing in a report is larger, and differences stay finite.
const LARGEST: f64 = 1e300;
/// Margins end here, so that a factor beside the largest values still has a power of ten above it.
const LARGEST_END: f64 = 1e305;
/// A range narrower than this, relative to its ends, is a constant: its tick labels would need ten digits.
const NARROWEST: f64 = 1e-9;
/// A range of data that are all the same gets this much to either side, relative.
const AROUND_CONSTANT: f64 = 0.1;
/// Ticks this far outside, relative to the span, are still on the end: the ends come from rounded decimals.
const END_SLACK: f64 = 1e-9;
/// Labels of linear axes stay plain while the largest lies between these.
const PLAIN: std::ops::Range<f64> = 1e-3..1e5;
/// Labels of logarithmic axes stay plain while all ticks lie between these.
const PLAIN_DECADES: std::ops::RangeInclusive<f64> = 0.99e-3..=1.01e4;
/// Fewer ticks than this do not tell the scale.
const FEWEST: usize = 3;

impl Axis {
    /// The axis from one end to the other, in either order. Ends that no axis can have (not finite, equal, not positive
    /// on a logarithmic scale) are replaced by their nearest sensible ones.
    pub fn new(scale: Scale, from: f64, to: f64) -> Axis {
        Axis::fit(scale, [from, to], 0.0)
    }

    /// The axis that holds `values`, with `margin` times its span to either side. What is not finite, or not positive
    /// on a logarithmic scale, does not count. Without any value: 0 to 1, on a logarithmic scale 0.1 to 1.
    pub fn fit(scale: Scale, values: impl IntoIterator<Item = f64>, margin: f64) -> Axis {
        let counts = |v: &f64| v.is_finite() && (scale != Scale::Log || *v > 0.0);
        let ends = values.into_iter().filter(counts).fold(None, |ends, v| match ends {
            None => Some((v, v)),
            Some((low, high)) => Some((v.min(low), v.max(high))),
        });
        match (scale, ends) {
            (Scale::Log, None) => Axis { scale, low: 0.1, high: 1.0 },
            (Scale::Log, Some((low, high))) => Axis::log(low, high, margin),
            (_, None) => Axis { scale, low: 0.0, high: 1.0 },
            (_, Some((low, high))) => Axis::linear(scale, low, high, margin),
        }
    }

    fn linear(scale: Scale, low: f64, high: f64, margin: f64) -> Axis {
        let (low, high) = (low.clamp(-LARGEST, LARGEST), high.clamp(-LARGEST, LARGEST));
        let size = low.abs().max(high.abs());
        if size < 1.0 / LARGEST {
            return Axis { scale, low: -1.0, high: 1.0 };
        }
        let span = high - low;
        let beside = if span < NARROWEST * size { AROUND_CONSTANT * size } else { margin * span };
        Axis { scale, low: low - beside, high: high + beside }
    }

    fn log(low: f64, high: f64, margin: f64) -> Axis {
        let (low, high) = (low.clamp(1.0 / LARGEST, LARGEST), high.clamp(1.0 / LARGEST, LARGEST));
        let ratio = high / low;
        let beside = if ratio < 1.0 + NARROWEST { 3.0 } else { 10f64.powf(margin * decades(low, high)) };
        Axis { scale: Scale::Log, low: (low / beside).max(1.0 / LARGEST_END), high: (high * beside).min(LARGEST_END) }
    }

    /// The kind of axis.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Lower end.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// Upper end.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Place of a value: 0 at the lower end, 1 at the upper; NaN for what has no place (not finite, not positive on a
    /// logarithmic scale).
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            _ if !value.is_finite() => f64::NAN,
            Scale::Log if value <= 0.0 => f64::NAN,
            Scale::Log => decades(self.low, value) / decades(self.low, self.high),
            _ => (value / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0),
        }
    }

    /// Ticks: as many as possible, at most `most` where at least three can be had with so few, inside the axis and
    /// increasing. An axis of whole numbers may have fewer than three.
    pub fn ticks(&self, most: usize) -> Ticks {
        match self.scale {
            Scale::Log => self.log_ticks(most),
            _ => self.linear_ticks(most),
        }
    }

    fn inside(&self, value: f64) -> bool {
        (-END_SLACK..=1.0 + END_SLACK).contains(&self.place(value))
    }

    fn linear_ticks(&self, most: usize) -> Ticks {
        let step = self.step(most);
        let values = self.multiples(step);
        let largest = values.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
        let exponent = if largest == 0.0 || PLAIN.contains(&largest) { 0 } else { group_of_three(largest) };
        let decimals = (exponent - step.exponent).clamp(0, 17) as usize;
        let label = |value: f64| decimal(scaled(value, exponent), decimals);
        Ticks {
            major: values.into_iter().map(|value| Tick { value, label: label(value) }).collect(),
            minor: vec![],
            exponent,
        }
    }

    fn step(&self, most: usize) -> Step {
        let coarse = self.high / 2.0 - self.low / 2.0;
        let steps: Vec<Step> = Step::from_coarse(self.scale, coarse).collect();
        let counts: Vec<usize> = steps.iter().map(|step| self.count(*step)).collect();
        let enough = counts.iter().position(|n| *n >= FEWEST).unwrap_or(steps.len() - 1);
        let finest = counts.iter().rposition(|n| *n <= most).unwrap_or(0);
        steps[enough.max(finest)]
    }

    fn count(&self, step: Step) -> usize {
        let (first, last) = self.ends(step);
        (last - first + 1.0).max(0.0) as usize
    }

    /// First and last multiple of the step inside, counted in steps.
    fn ends(&self, step: Step) -> (f64, f64) {
        let slack = END_SLACK * (step.of(self.high) - step.of(self.low));
        ((step.of(self.low) - slack).ceil(), (step.of(self.high) + slack).floor())
    }

    fn multiples(&self, step: Step) -> Vec<f64> {
        let (first, last) = self.ends(step);
        let count = (last - first + 1.0).max(0.0) as usize;
        (0..count).map(|k| step.times(first + k as f64).clamp(self.low, self.high)).collect()
    }

    fn log_ticks(&self, most: usize) -> Ticks {
        let candidates: Vec<Vec<(u8, i32)>> = self.log_candidates(most);
        let enough = candidates.iter().position(|ticks| ticks.len() >= FEWEST);
        let finest = candidates.iter().rposition(|ticks| ticks.len() <= most).unwrap_or(0);
        let Some(enough) = enough else { return self.linear_ticks(most) };
        let chosen = &candidates[enough.max(finest)];
        let plain = chosen.iter().all(|(m, e)| PLAIN_DECADES.contains(&power(*m, *e)));
        let tick = |(mantissa, exponent): &(u8, i32)| {
            let value = power(*mantissa, *exponent).clamp(self.low, self.high);
            let label = match plain {
                true => decimal(value, (-exponent).max(0) as usize),
                false => typographic(&format!("{mantissa}e{exponent}")),
            };
            Tick { value, label }
        };
        let major: Vec<Tick> = chosen.iter().map(tick).collect();
        let minor = self.log_minor(&major);
        Ticks { major, minor, exponent: 0 }
    }

    /// Tick sets from coarse to fine: decades with wide steps down to one, then 1-2-5 or, where decades are too
    /// few and that is too much, 1-3.
    fn log_candidates(&self, most: usize) -> Vec<Vec<(u8, i32)>> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let set = |stride: i32, mantissas: &[u8]| -> Vec<(u8, i32)> {
            let exponents = (first..=last).filter(|e| e % stride == 0);
            let all = exponents.flat_map(|e| mantissas.iter().map(move |m| (*m, e)));
            all.filter(|(m, e)| self.inside(power(*m, *e))).collect()
        };
        let mut sets: Vec<_> = [100, 50, 20, 10, 5, 2, 1].iter().map(|stride| set(*stride, &[1])).collect();
        let (coarse, fine) = (set(1, &[1, 3]), set(1, &[1, 2, 5]));
        let few_decades = sets.last().is_none_or(|decades| decades.len() < FEWEST);
        sets.push(if few_decades && fine.len() > most && coarse.len() >= FEWEST { coarse } else { fine });
        sets
    }

    /// 2 to 9 of each decade; the decades alone when there are many.
    fn log_minor(&self, major: &[Tick]) -> Vec<f64> {
        const MANY_DECADES: f64 = 10.0;
        const FAR_TOO_MANY: f64 = 60.0;
        let span = decades(self.low, self.high);
        let mantissas: &[u8] = if span > MANY_DECADES { &[1] } else { &[1, 2, 3, 4, 5, 6, 7, 8, 9] };
        if span > FAR_TOO_MANY {
            return vec![];
        }
        let exponents = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all = exponents.flat_map(|e| mantissas.iter().map(move |m| power(*m, e)));
        let labelled = |v: &f64| major.iter().any(|tick| (tick.value / v - 1.0).abs() < END_SLACK);
        all.filter(|v| self.inside(*v) && !labelled(v)).collect()
    }
}

/// A step of `mantissa` x 10^`exponent`.
#[derive(Clone, Copy, Debug)]
struct Step {
    mantissa: f64,
    exponent: i32,
}

impl Step {
    /// Steps from about `coarse` down to a hundredth of it.
    fn from_coarse(scale: Scale, coarse: f64) -> Box<dyn Iterator<Item = Step>> {
        let top = coarse.log10().floor() as i32;
        let decimal = (top - 2..=top + 1)
            .rev()
            .flat_map(|exponent| [5.0, 2.0, 1.0].into_iter().map(move |mantissa| Step { mantissa, exponent }));
        const DEGREES: [f64; 7] = [360.0, 180.0, 90.0, 45.0, 30.0, 15.0, 10.0];
        const DECIBELS: [f64; 8] = [200.0, 100.0, 60.0, 40.0, 20.0, 10.0, 5.0, 2.0];
        const HALF_SPANS: std::ops::Range<f64> = 10.0..1000.0;
        let fixed = |steps: &'static [f64]| steps.iter().map(|mantissa| Step { mantissa: *mantissa, exponent: 0 });
        match scale {
            Scale::Degrees if HALF_SPANS.contains(&coarse) => Box::new(fixed(&DEGREES)),
            Scale::Decibels if HALF_SPANS.contains(&coarse) => Box::new(fixed(&DECIBELS)),
            Scale::Integer => {
                Box::new(decimal.filter(|step| step.exponent >= 0).chain([Step { mantissa: 1.0, exponent: 0 }]))
            }
            _ => Box::new(decimal),
        }
    }

    /// `count` steps. Negative powers divide, so that 3 steps of 0.1 are 0.3.
    fn times(self, count: f64) -> f64 {
        let value = scaled(count * self.mantissa, -self.exponent);
        if value == 0.0 { 0.0 } else { value }
    }

    /// How many steps make `value`.
    fn of(self, value: f64) -> f64 {
        scaled(value, self.exponent) / self.mantissa
    }
}

/// value / 10^exponent, by an exact power where there is one, in two parts where one would overflow.
fn scaled(value: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    match exponent {
        0..=22 => value / 10f64.powi(exponent),
        -22..0 => value * 10f64.powi(-exponent),
        _ => value / 10f64.powi(half) / 10f64.powi(exponent - half),
    }
}

fn power(mantissa: u8, exponent: i32) -> f64 {
    scaled(f64::from(mantissa), -exponent)
}

fn decades(low: f64, high: f64) -> f64 {
    high.log10() - low.log10()
}

fn group_of_three(size: f64) -> i32 {
    (size.log10() + END_SLACK).floor().div_euclid(3.0) as i32 * 3
}

/// Fixed decimals with a true minus sign and no negative zero.
fn decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.into(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(axis: Axis, most: usize) -> Vec<String> {
        axis.ticks(most).major.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn ticks_are_the_numbers_that_a_person_would_write() {
        assert_eq!(labels(Axis::new(Scale::Linear, 0.0, 1.0), 8), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Axis::new(Scale::Linear, -1.0, 34.0), 8), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(labels(Axis::new(Scale::Linear, -0.25, 0.25), 4), ["−0.2", "0.0", "0.2"]);
        assert_eq!(labels(Axis::new(Scale::Log, 0.1, 1000.0), 9), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels(Axis::new(Scale::Log, 1.0, 30.0), 9), ["1", "2", "5", "10", "20"]);
        assert_eq!(labels(Axis::new(Scale::Log, 1e-8, 1.0), 5), ["10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"]);
        assert_eq!(labels(Axis::new(Scale::Degrees, -370.0, 5.0), 8), ["−360", "−270", "−180", "−90", "0"]);
        assert_eq!(
            labels(Axis::new(Scale::Degrees, -100.0, 5.0), 8),
            ["−90", "−75", "−60", "−45", "−30", "−15", "0"][..]
        );
        assert_eq!(labels(Axis::new(Scale::Decibels, -170.0, 38.0), 8), ["−160", "−120", "−80", "−40", "0"]);
        assert_eq!(labels(Axis::new(Scale::Integer, 0.5, 4.5), 9), ["1", "2", "3", "4"]);
    }

    #[test]
    fn large_and_small_numbers_share_an_exponent() {
        let small = Axis::new(Scale::Linear, 0.0, 4e-7);
        assert_eq!(
            (labels(small, 5), small.ticks(5).exponent),
            (["0", "100", "200", "300", "400"].map(String::from).to_vec(), -9)
        );
        let large = Axis::new(Scale::Linear, 0.0, 3e6);
        assert_eq!((labels(large, 4), large.ticks(4).exponent), (["0", "1", "2", "3"].map(String::from).to_vec(), 6));
    }

    #[test]
    fn data_that_make_no_range_get_one() {
        for (values, low, high) in [
            (vec![], 0.0, 1.0),
            (vec![f64::NAN, f64::INFINITY], 0.0, 1.0),
            (vec![5.0], 4.5, 5.5),
            (vec![0.0, 0.0], -1.0, 1.0),
            (vec![-2.0; 9], -2.2, -1.8),
        ] {
            let axis = Axis::fit(Scale::Linear, values, 0.05);
            assert!((axis.low() - low).abs() < 1e-12 && (axis.high() - high).abs() < 1e-12, "{axis:?}");
        }
        let axis = Axis::fit(Scale::Log, [-1.0, 0.0], 0.05);
        assert_eq!((axis.low(), axis.high()), (0.1, 1.0));
        assert!(Axis::fit(Scale::Log, [2.0], 0.0).low() < 2.0);
    }

    #[test]
    fn what_has_no_place_is_not_a_number() {
        let axis = Axis::new(Scale::Log, 1.0, 100.0);
        assert!((axis.place(10.0) - 0.5).abs() < 1e-15);
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(axis.place(value).is_nan());
        }
    }

    fn holds(axis: Axis, most: usize) -> Result<(), TestCaseError> {
        let ticks = axis.ticks(most);
        let count = ticks.major.len();
        prop_assert!((FEWEST..=12).contains(&count), "{count} ticks on {axis:?}");
        for tick in &ticks.major {
            prop_assert!(axis.low() <= tick.value && tick.value <= axis.high(), "{tick:?} outside {axis:?}");
        }
        for pair in ticks.major.windows(2) {
            prop_assert!(pair[0].value < pair[1].value, "{pair:?}");
            prop_assert!(pair[0].label != pair[1].label, "{pair:?} on {axis:?}");
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn linear_ticks_lie_inside_and_increase(a in -1.0f64..1.0, b in -1.0f64..1.0, e in -299i32..300, most in 3usize..=12) {
            for scale in [Scale::Linear, Scale::Degrees, Scale::Decibels] {
                holds(Axis::new(scale, a * 10f64.powi(e), b * 10f64.powi(e)), most)?;
            }
        }

        #[test]
        fn narrow_ranges_far_from_zero_keep_distinct_ticks(centre in 1.0f64..10.0, width in 2e-9f64..1e-3, e in -290i32..290) {
            let size = 10f64.powi(e);
            holds(Axis::new(Scale::Linear, centre * size, (centre + centre * width) * size), 8)?;
        }

        #[test]
        fn log_ticks_lie_inside_and_increase(a in -300.0f64..300.0, b in -300.0f64..300.0, near in 1e-6f64..2.0, most in 3usize..=12) {
            holds(Axis::new(Scale::Log, 10f64.powf(a), 10f64.powf(b)), most)?;
            let low = a.min(299.0 - near);
            holds(Axis::new(Scale::Log, 10f64.powf(low), 10f64.powf(low + near)), most)?;
        }

        #[test]
        fn margins_keep_the_axis_finite(a in -300.0f64..300.0, b in -300.0f64..300.0, margin in 0.0f64..0.5) {
            let axis = Axis::fit(Scale::Log, [10f64.powf(a), 10f64.powf(b)], margin);
            prop_assert!(axis.low() > 0.0 && axis.high().is_finite());
            holds(axis, 9)?;
        }

        #[test]
        fn places_run_from_zero_to_one(a in -1e300f64..1e300, b in -1e300f64..1e300) {
            let axis = Axis::new(Scale::Linear, a, b);
            prop_assert!(axis.place(axis.low()).abs() < 1e-12 && (axis.place(axis.high()) - 1.0).abs() < 1e-12);
        }
    }
}
