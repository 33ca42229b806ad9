//! The channels of the binary frames: what each is called, and where it stands in a recording's sample.

use flexbeam_files::{RunSample, ScopeSignal, SignalKind};

/// A channel.
pub(super) struct Signal {
    pub(super) key: &'static str,
    label: &'static str,
    symbol: &'static str,
    unit: Unit,
    kind: SignalKind,
    pub(super) of: fn(&RunSample) -> f64,
}

/// What is shown of a value in SI, or in nanoseconds.
enum Unit {
    Degrees,
    Volts,
    Microseconds,
    Number,
}

impl Unit {
    fn name_and_factor(&self) -> (&'static str, f64) {
        match self {
            Unit::Degrees => ("°", 1f64.to_degrees()),
            Unit::Volts => ("V", 1.0),
            Unit::Microseconds => ("µs", 1e-3),
            Unit::Number => ("", 1.0),
        }
    }
}

/// Number of channels.
pub(super) const CHANNELS: usize = SIGNALS.len();

/// All channels, in the order of the frames.
pub(super) const SIGNALS: [Signal; 16] = [
    angle("reference_rad", "Reference", "r", |s| s.reference_rad),
    angle("smoothed_rad", "Smoothed reference", "r_s", |s| s.smoothed_rad),
    angle("psi_rad", "Tip angle", "psi", |s| s.psi_rad),
    angle("y_model_rad", "Reference model", "y_m", |s| s.y_model_rad),
    angle("theta_rad", "Hub angle", "theta", |s| s.theta_rad),
    angle("alpha_rad", "Deflection", "alpha", |s| s.alpha_rad),
    angle("error_rad", "Error", "e", |s| s.error_rad),
    voltage("voltage_v", "Voltage", "v", |s| s.voltage_v),
    voltage("commanded_v", "Next voltage", "v_next", |s| s.commanded_v),
    voltage("u_v", "Controller output", "u", |s| s.u_v),
    time("lateness_ns", "Lateness", "t_late", |s| s.lateness_ns.into()),
    time("execution_ns", "Work in a period", "t_work", |s| s.execution_ns.into()),
    flag("phase", "Phase", |s| s.phase.into()),
    flag("stale", "No fresh measurement", |s| s.stale.into()),
    flag("fault", "Fault", |s| s.fault.into()),
    flag("settings", "Revision of the settings", |s| s.settings.into()),
];

const fn angle(key: &'static str, label: &'static str, symbol: &'static str, of: fn(&RunSample) -> f64) -> Signal {
    Signal { key, label, symbol, unit: Unit::Degrees, kind: SignalKind::Line, of }
}

const fn voltage(key: &'static str, label: &'static str, symbol: &'static str, of: fn(&RunSample) -> f64) -> Signal {
    Signal { key, label, symbol, unit: Unit::Volts, kind: SignalKind::Line, of }
}

const fn time(key: &'static str, label: &'static str, symbol: &'static str, of: fn(&RunSample) -> f64) -> Signal {
    Signal { key, label, symbol, unit: Unit::Microseconds, kind: SignalKind::Line, of }
}

const fn flag(key: &'static str, label: &'static str, of: fn(&RunSample) -> f64) -> Signal {
    Signal { key, label, symbol: key, unit: Unit::Number, kind: SignalKind::Flag, of }
}

/// The channels, for a page.
pub(super) fn signals() -> Vec<ScopeSignal> {
    let told = |signal: &Signal| {
        let (unit, factor) = signal.unit.name_and_factor();
        ScopeSignal {
            key: signal.key.into(),
            label: signal.label.into(),
            symbol: signal.symbol.into(),
            unit: unit.into(),
            factor,
            kind: signal.kind,
        }
    };
    SIGNALS.iter().map(told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample whose every field has a number of its own.
    fn sample() -> RunSample {
        RunSample {
            tick: 1,
            voltage_v: 2.0,
            commanded_v: 3.0,
            u_v: 4.0,
            reference_rad: 5.0,
            smoothed_rad: 6.0,
            theta_rad: 7.0,
            alpha_rad: 8.0,
            psi_rad: 9.0,
            y_model_rad: 10.0,
            error_rad: 11.0,
            lateness_ns: 12,
            execution_ns: 13,
            settings: 14,
            phase: 15,
            fault: 16,
            stale: 17,
        }
    }

    #[test]
    fn each_channel_is_the_field_of_its_name_and_none_is_left_out() {
        let (sample, values) = (sample(), sample().values());
        let mut found: Vec<&str> = SIGNALS.iter().map(|signal| signal.key).collect();
        for signal in &SIGNALS {
            let at = RunSample::NAMES.iter().position(|name| *name == signal.key).unwrap();
            assert_eq!((signal.of)(&sample), values[at], "{}", signal.key);
        }
        let mut all: Vec<&str> = RunSample::NAMES.iter().copied().filter(|name| *name != "tick").collect();
        found.sort_unstable();
        all.sort_unstable();
        assert_eq!(found, all);
    }
}
