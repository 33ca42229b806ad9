//! Scopes and control panels: what a person watches and turns, saved with a project and shown in the browser.

use crate::misfit::Misfit;
use crate::model::out_of_range;
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

fn ten_seconds() -> f64 {
    10.0
}

fn a_tenth() -> f64 {
    0.1
}

impl Screen {
    /// Errors: [`Fault::Range`](crate::Fault::Range).
    pub fn check(&self) -> Result<(), Misfit> {
        for (k, scope) in self.scopes.iter().enumerate() {
            scope.check().map_err(|misfit| misfit.in_entry(k).under("scope"))?;
        }
        for (k, panel) in self.panels.iter().enumerate() {
            panel.check().map_err(|misfit| misfit.in_entry(k).under("panel"))?;
        }
        Ok(())
    }
}

impl Scope {
    fn check(&self) -> Result<(), Misfit> {
        if !(self.span_s > 0.0 && self.span_s.is_finite()) {
            return Err(out_of_range("span_s", self.span_s, "a positive number"));
        }
        self.range.map_or(Ok(()), |ends| check_ends("range", ends))?;
        let Some(trigger) = &self.trigger else { return Ok(()) };
        if !(0.0..=1.0).contains(&trigger.before) {
            return Err(out_of_range("before", trigger.before, "0 to 1").under("trigger"));
        }
        Ok(())
    }
}

impl Panel {
    fn check(&self) -> Result<(), Misfit> {
        let mut ranges = self.ranges.iter();
        ranges.try_for_each(|(key, ends)| check_ends(key, *ends).map_err(|misfit| misfit.under("ranges")))
    }
}

fn check_ends(key: &str, [low, high]: [f64; 2]) -> Result<(), Misfit> {
    if low < high { Ok(()) } else { Err(out_of_range(key, high, "an upper end above the lower one")) }
}
