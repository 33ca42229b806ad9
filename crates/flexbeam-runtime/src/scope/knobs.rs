//! Every live setting, for a person: name, unit, range. The ranges are what the run accepts, no wider and no narrower.

use crate::live::Live;
use crate::reference::Shape;
use flexbeam_files::Knob;
use flexbeam_kernel as kernel;

/// Least number above zero: where zero itself is refused.
pub(super) const ABOVE_ZERO: f64 = f64::from_bits(1);

/// Which numbers are accepted.
#[derive(Clone, Copy)]
enum Range {
    Any,
    NotNegative,
    Positive,
    /// From the first to the second.
    Within(f64, f64),
    /// One of the limits that may only be tightened: this field of the first settings is the widest; zero is accepted or not.
    Tighter(fn(&kernel::Settings) -> f64, Zero),
    /// As it was found at homing.
    Homed,
}

#[derive(Clone, Copy)]
enum Zero {
    Accepted,
    Refused,
}

/// What is shown.
#[derive(Clone, Copy)]
enum Unit {
    Degrees,
    Volts,
    Seconds,
    /// Periods, as seconds.
    Periods,
    /// An angle in a period, as degrees a second.
    Speed,
    Number,
}

impl Unit {
    fn name_and_factor(self, period_s: f64) -> (&'static str, f64) {
        match self {
            Unit::Degrees => ("°", 1f64.to_degrees()),
            Unit::Volts => ("V", 1.0),
            Unit::Seconds => ("s", 1.0),
            Unit::Periods => ("s", period_s),
            Unit::Speed => ("°/s", 1f64.to_degrees() / period_s),
            Unit::Number => ("", 1.0),
        }
    }
}

/// A setting that is a number: key, label, unit, range, step and decimals as shown.
struct Number(&'static str, &'static str, Unit, Range, f64, u8);

const REFERENCE: [Number; 2] = [
    Number("reference.offset_rad", "Offset", Unit::Degrees, Range::Any, 0.5, 2),
    Number("reference.period_s", "Period", Unit::Seconds, Range::Positive, 0.1, 2),
];
const SMOOTH: [Number; 2] = [
    Number("smooth_ticks", "Smooth step", Unit::Periods, Range::NotNegative, 0.01, 2),
    Number("smooth_step_rad", "Step at full length", Unit::Degrees, Range::Positive, 1.0, 1),
];
const LAW: [Number; 8] = [
    Number("u_p_plus_v", "u_p upwards", Unit::Volts, Range::NotNegative, 0.001, 4),
    Number("u_p_minus_v", "u_p downwards", Unit::Volts, Range::NotNegative, 0.001, 4),
    Number("eps_u_v", "Threshold of u", Unit::Volts, Range::NotNegative, 0.0005, 4),
    Number("eps_e_rad", "Threshold of the error", Unit::Degrees, Range::NotNegative, 0.01, 3),
    Number("hysteresis_u", "Hysteresis of u", Unit::Number, Range::NotNegative, 0.01, 2),
    Number("hysteresis_e", "Hysteresis of the error", Unit::Number, Range::Within(0.0, 1.0), 0.01, 2),
    Number("breakaway_plus_v", "Breakaway upwards", Unit::Volts, Range::NotNegative, 0.001, 4),
    Number("breakaway_minus_v", "Breakaway downwards", Unit::Volts, Range::NotNegative, 0.001, 4),
];
const LIMITS: [Number; 4] = [
    Number("voltage_limit_v", "Voltage", Unit::Volts, Range::Tighter(|s| s.voltage_limit_v, Zero::Accepted), 0.1, 2),
    Number(
        "deflection_limit_rad",
        "Deflection",
        Unit::Degrees,
        Range::Tighter(|s| s.deflection_limit_rad, Zero::Refused),
        0.1,
        2,
    ),
    Number("theta_limit_rad", "Hub angle", Unit::Degrees, Range::Tighter(|s| s.theta_limit_rad, Zero::Refused), 1.0, 1),
    Number(
        "theta_step_limit_rad",
        "Hub speed",
        Unit::Speed,
        Range::Tighter(|s| s.theta_step_limit_rad, Zero::Refused),
        10.0,
        0,
    ),
];
const SENSORS: [Number; 6] = [
    Number("theta.low_pass", "Hub filter", Unit::Number, Range::Within(ABOVE_ZERO, 1.0), 0.01, 3),
    Number("alpha.low_pass", "Gauge filter", Unit::Number, Range::Within(ABOVE_ZERO, 1.0), 0.01, 3),
    Number("theta.offset_rad", "Hub zero", Unit::Degrees, Range::Homed, 0.01, 3),
    Number("theta.scale", "Hub scale", Unit::Number, Range::Homed, 0.001, 4),
    Number("alpha.offset_rad", "Gauge zero", Unit::Degrees, Range::Homed, 0.01, 3),
    Number("alpha.scale", "Gauge scale", Unit::Number, Range::Homed, 0.001, 4),
];

/// Real-time: no. The table, for settings in force, those of the run's start, and its period [s].
pub fn knobs(live: &Live, first: &Live, period_s: f64) -> Vec<Knob> {
    let number = |group: &'static str| {
        move |Number(key, label, unit, range, step, decimals): &Number| {
            let (unit, factor) = unit.name_and_factor(period_s);
            let (low, high) = ends(*range, &first.settings);
            let homed = matches!(range, Range::Homed).then(|| "found at homing".to_string());
            Knob {
                key: (*key).into(),
                label: (*label).into(),
                group: group.into(),
                unit: unit.into(),
                factor,
                low,
                high,
                step: step / factor,
                decimals: *decimals,
                words: None,
                why_fixed: homed,
            }
        }
    };
    let reference =
        [word("reference.shape", "Shape", "Reference", shapes(live)), number("Reference")(&amplitude(live))];
    let law = word("law", "Law", "Law", &["none", "switched", "inverse"]);
    reference
        .into_iter()
        .chain(REFERENCE.iter().map(number("Reference")))
        .chain(SMOOTH.iter().map(number("Reference")))
        .chain([law])
        .chain(LAW.iter().map(number("Law")))
        .chain(LIMITS.iter().map(number("Limits")))
        .chain(SENSORS.iter().map(number("Sensors")))
        .collect()
}

/// A file has its own angles; the amplitude scales them.
fn amplitude(live: &Live) -> Number {
    let key = "reference.amplitude_rad";
    match live.reference.shape {
        Shape::File => Number(key, "Factor of the file", Unit::Number, Range::Any, 0.01, 2),
        _ => Number(key, "Amplitude", Unit::Degrees, Range::Any, 0.5, 2),
    }
}

fn shapes(live: &Live) -> &'static [&'static str] {
    let all = &["step", "square", "sine", "sawtooth", "file"];
    if live.reference.samples.is_empty() { &all[..4] } else { all }
}

fn ends(range: Range, first: &kernel::Settings) -> (Option<f64>, Option<f64>) {
    match range {
        Range::Any | Range::Homed => (None, None),
        Range::NotNegative => (Some(0.0), None),
        Range::Positive => (Some(ABOVE_ZERO), None),
        Range::Within(low, high) => (Some(low), Some(high)),
        Range::Tighter(widest, zero) => {
            let low = if matches!(zero, Zero::Accepted) { 0.0 } else { ABOVE_ZERO };
            (Some(low), Some(widest(first)).filter(|limit| limit.is_finite()))
        }
    }
}

fn word(key: &str, label: &str, group: &str, words: &[&str]) -> Knob {
    Knob {
        key: key.into(),
        label: label.into(),
        group: group.into(),
        unit: String::new(),
        factor: 1.0,
        low: None,
        high: None,
        step: 1.0,
        decimals: 0,
        words: Some(words.iter().map(|word| (*word).into()).collect()),
        why_fixed: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control_socket::change_reference;
    use crate::kernel_settings::with_table;
    use crate::live::{LiveControl, live};
    use crate::recording::run_settings;
    use crate::reference::Reference;
    use flexbeam_files::{Request, SettingValue, request_of_values};

    const PERIOD_S: f64 = 0.002;

    /// Every limit is finite; the reference repeats, because a step has no period that could be wrong.
    fn first(shape: Shape) -> Live {
        let settings = kernel::Settings {
            smooth_ticks: 200.0,
            smooth_step_rad: 1.0,
            theta_limit_rad: 3.0,
            theta_step_limit_rad: 0.05,
            voltage_limit_v: 8.0,
            ..kernel::Settings::default()
        };
        let reference = Reference { shape, samples: [0.5].into(), ..Reference::default() };
        Live { revision: 0, settings, reference }
    }

    fn table(control: &LiveControl) -> Vec<Knob> {
        knobs(&control.current(), &control.first(), PERIOD_S)
    }

    /// As a viewer would set it.
    fn is_accepted(first: &Live, key: &str, value: SettingValue) -> bool {
        let (control, _reader) = live(first.clone()).unwrap();
        let Ok(Request::Set { settings, reference }) = request_of_values(&[(key.into(), value)].into()) else {
            panic!()
        };
        let change = |live: &mut Live| {
            live.settings = with_table(&live.settings, &settings);
            change_reference(live, &reference);
        };
        control.change(change).is_ok()
    }

    #[test]
    fn every_live_setting_is_in_the_table_once() {
        let (control, _reader) = live(first(Shape::Sine)).unwrap();
        let mut found: Vec<String> = table(&control).into_iter().map(|knob| knob.key).collect();
        let mut all: Vec<String> =
            run_settings(0, &control.current()).by_key().into_iter().map(|(key, _)| key).collect();
        found.sort();
        all.sort();
        assert_eq!(found, all);
    }

    #[test]
    fn the_ends_are_those_of_the_loop() {
        let first = first(Shape::Sine);
        let (control, _reader) = live(first.clone()).unwrap();
        for knob in table(&control).into_iter().filter(|knob| knob.words.is_none() && knob.why_fixed.is_none()) {
            let takes = |value: f64| is_accepted(&first, &knob.key, SettingValue::Number(value));
            let key = &knob.key;
            match knob.low {
                Some(low) => assert!(takes(low) && !takes(low.next_down()), "{key}: {low}"),
                None => assert!(takes(-1e12), "{key}"),
            }
            match knob.high {
                Some(high) => assert!(takes(high) && !takes(high.next_up()), "{key}: {high}"),
                None => assert!(takes(1e12), "{key}"),
            }
        }
    }

    #[test]
    fn what_is_fixed_is_refused_and_every_word_is_taken() {
        let first = first(Shape::Sine);
        let (control, _reader) = live(first.clone()).unwrap();
        let (mut fixed, mut words) = (0, 0);
        for knob in table(&control) {
            if knob.why_fixed.is_some() {
                assert!(!is_accepted(&first, &knob.key, SettingValue::Number(0.123)), "{}", knob.key);
                fixed += 1;
            }
            for word in knob.words.unwrap_or_default() {
                assert!(is_accepted(&first, &knob.key, SettingValue::Word(word)), "{}", knob.key);
                words += 1;
            }
        }
        assert_eq!((fixed, words), (4, 3 + 5));
    }

    /// A limit that was tightened may be loosened again to what it was, so its knob keeps its end.
    #[test]
    fn a_tightened_limit_keeps_the_ends_of_the_start() {
        let (control, _reader) = live(first(Shape::Sine)).unwrap();
        let before = table(&control);
        control.change(|live| live.settings.voltage_limit_v = 3.0).unwrap();
        assert_eq!(table(&control), before);
        control.change(|live| live.settings.voltage_limit_v = 8.0).unwrap();
    }

    #[test]
    fn units_follow_the_period_and_the_shape() {
        let of = |live: &Live, key: &str| knobs(live, live, PERIOD_S).into_iter().find(|knob| knob.key == key).unwrap();
        let sine = first(Shape::Sine);
        let smooth = of(&sine, "smooth_ticks");
        assert_eq!((smooth.unit.as_str(), 200.0 * smooth.factor), ("s", 0.4));
        assert!((smooth.step * smooth.factor - 0.01).abs() < 1e-15);
        let speed = of(&sine, "theta_step_limit_rad");
        assert!((0.05 * speed.factor - 25f64.to_degrees()).abs() < 1e-9, "0.05 rad in 2 ms");
        assert_eq!(of(&sine, "reference.amplitude_rad").unit, "°");
        let file = of(&first(Shape::File), "reference.amplitude_rad");
        assert_eq!((file.unit.as_str(), file.factor), ("", 1.0));
        let no_file = Live { reference: Reference::default(), ..first(Shape::Step) };
        assert_eq!(of(&no_file, "reference.shape").words.unwrap().len(), 4, "nothing to play");
    }
}
