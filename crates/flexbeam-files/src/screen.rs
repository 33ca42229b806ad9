//! Scopes and control panels: what a person watches and turns, saved with a project and shown in the browser.

use crate::misfit::Misfit;
use crate::model::out_of_range;
use crate::run_file::{LiveSettings, RunSample};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The scopes and panels of a project, in the order in which they stand on the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screen {
    /// Scopes.
    #[serde(default, rename = "scope")]
    pub scopes: Vec<Scope>,
    /// Control panels.
    #[serde(default, rename = "panel")]
    pub panels: Vec<Panel>,
}

/// One plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scope {
    /// What stands above it.
    pub title: String,
    /// What is drawn over what. Default `time`.
    #[serde(default)]
    pub kind: ScopeKind,
    /// Signals, by the names of a recording: `psi_rad`. Of an XY plot the first is x.
    pub signals: Vec<String>,
    /// Length of the time axis, or of the stretch that XY and spectrum are made of [s]. Default 10.
    #[serde(default = "ten_seconds")]
    pub span_s: f64,
    /// Ends of the value axis, in the unit of the first signal [rad, V, ...]. Left out: fits what is shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// How a spectrum shows amplitudes. Default `linear`.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub amplitude: AmplitudeAxis,
    /// How a spectrum shows frequencies. Default `logarithmic`.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub frequency: FrequencyAxis,
    /// Where the time axis stands still. Left out: it rolls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trigger: Option<Trigger>,
}

/// Kinds of plots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScopeKind {
    /// Signals over time.
    #[default]
    Time,
    /// Signals over the first one.
    Xy,
    /// Amplitude spectrum.
    Spectrum,
}

/// Amplitudes of a spectrum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AmplitudeAxis {
    /// In the signal's unit.
    #[default]
    Linear,
    /// 20 log10 of it.
    Decibels,
}

/// Frequencies of a spectrum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrequencyAxis {
    /// By decades.
    #[default]
    Logarithmic,
    /// By hertz.
    Linear,
}

/// The instant that stands still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trigger {
    /// Signal that is watched.
    pub signal: String,
    /// Direction of the crossing. Default `rising`.
    #[serde(default)]
    pub edge: Edge,
    /// Level that is crossed, in the signal's unit [rad, V, ...].
    pub level: f64,
    /// What happens without a crossing, and after one. Default `auto`.
    #[serde(default)]
    pub mode: TriggerMode,
    /// Share of the span that lies before the crossing, 0 to 1. Default 0.1.
    #[serde(default = "a_tenth")]
    pub before: f64,
}

/// Direction of a crossing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Edge {
    /// From below.
    #[default]
    Rising,
    /// From above.
    Falling,
    /// Either.
    Either,
}

/// What a trigger waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TriggerMode {
    /// Rolls while there is no crossing.
    #[default]
    Auto,
    /// Keeps the last crossing until there is another.
    Normal,
    /// Keeps the first crossing.
    Single,
}

/// Settings side by side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// What stands above it.
    pub title: String,
    /// Settings, by the keys of `flexbeam tell`: `eps_u_v`, `reference.amplitude_rad`.
    pub settings: Vec<String>,
    /// Ends of a slider, in the setting's unit, where they are narrower than the setting's own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ranges: BTreeMap<String, [f64; 2]>,
}

fn is_usual<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn ten_seconds() -> f64 {
    10.0
}

fn a_tenth() -> f64 {
    0.1
}

impl Screen {
    /// What is shown where nobody says otherwise.
    pub fn usual() -> Screen {
        let scope = |title: &str, signals: &[&str]| Scope {
            title: title.into(),
            kind: ScopeKind::Time,
            signals: signals.iter().map(|signal| (*signal).into()).collect(),
            span_s: ten_seconds(),
            range: None,
            amplitude: AmplitudeAxis::Linear,
            frequency: FrequencyAxis::Logarithmic,
            trigger: None,
        };
        let panel = |title: &str, settings: &[&str]| Panel {
            title: title.into(),
            settings: settings.iter().map(|key| (*key).into()).collect(),
            ranges: BTreeMap::new(),
        };
        let reference = ["shape", "amplitude_rad", "offset_rad", "period_s"].map(|key| format!("reference.{key}"));
        let reference: Vec<&str> = reference.iter().map(String::as_str).chain(["smooth_ticks"]).collect();
        Screen {
            scopes: vec![
                scope("Tip angle", &["reference_rad", "y_model_rad", "psi_rad"]),
                scope("Voltage", &["voltage_v", "u_v"]),
                scope("Deflection", &["alpha_rad"]),
            ],
            panels: vec![
                panel("Reference", &reference),
                panel("Law", &["law", "u_p_plus_v", "u_p_minus_v", "eps_u_v", "eps_e_rad"]),
                panel(
                    "Limits",
                    &["voltage_limit_v", "deflection_limit_rad", "theta_limit_rad", "theta_step_limit_rad"],
                ),
            ],
        }
    }

    /// Errors: [`Fault::Choice`](crate::Fault::Choice) for a signal or a setting that is gone,
    /// [`Fault::UnknownKey`](crate::Fault::UnknownKey), [`Fault::Range`](crate::Fault::Range).
    pub fn check(&self) -> Result<(), Misfit> {
        each(&self.scopes, Scope::check).map_err(|misfit| misfit.under("scope"))?;
        each(&self.panels, Panel::check).map_err(|misfit| misfit.under("panel"))
    }
}

fn each<T>(entries: &[T], check: impl Fn(&T) -> Result<(), Misfit>) -> Result<(), Misfit> {
    entries.iter().enumerate().try_for_each(|(k, entry)| check(entry).map_err(|misfit| misfit.in_entry(k)))
}

fn check_name(name: &str, known: &[&str]) -> Result<(), Misfit> {
    if known.contains(&name) { Ok(()) } else { Err(Misfit::not_among(name, known)) }
}

impl Scope {
    fn check(&self) -> Result<(), Misfit> {
        each(&self.signals, |name| check_name(name, RunSample::SIGNALS)).map_err(|misfit| misfit.under("signals"))?;
        if !(self.span_s > 0.0 && self.span_s.is_finite()) {
            return Err(out_of_range("span_s", self.span_s, "a positive number"));
        }
        self.range.map_or(Ok(()), |ends| check_ends("range", ends))?;
        self.trigger.as_ref().map_or(Ok(()), Trigger::check).map_err(|misfit| misfit.under("trigger"))
    }
}

impl Trigger {
    fn check(&self) -> Result<(), Misfit> {
        check_name(&self.signal, RunSample::SIGNALS).map_err(|misfit| misfit.under("signal"))?;
        if !self.level.is_finite() {
            return Err(out_of_range("level", self.level, "a finite number"));
        }
        if (0.0..=1.0).contains(&self.before) { Ok(()) } else { Err(out_of_range("before", self.before, "0 to 1")) }
    }
}

impl Panel {
    fn check(&self) -> Result<(), Misfit> {
        each(&self.settings, |key| check_name(key, LiveSettings::KEYS)).map_err(|misfit| misfit.under("settings"))?;
        let mut ranges = self.ranges.iter();
        ranges.try_for_each(|(key, ends)| check_range(key, *ends)).map_err(|misfit| misfit.under("ranges"))
    }
}

/// A slider has a number, not a word.
fn check_range(key: &str, ends: [f64; 2]) -> Result<(), Misfit> {
    let mut numbers = LiveSettings::KEYS.to_vec();
    numbers.retain(|key| !LiveSettings::WORDS.contains(key));
    if !numbers.contains(&key) {
        return Err(Misfit::unknown_key(key, &numbers));
    }
    check_ends(key, ends)
}

fn check_ends(key: &str, [low, high]: [f64; 2]) -> Result<(), Misfit> {
    let ends = low < high && low.is_finite() && high.is_finite();
    if ends { Ok(()) } else { Err(out_of_range(key, high, "an upper end above the lower one, both finite")) }
}
