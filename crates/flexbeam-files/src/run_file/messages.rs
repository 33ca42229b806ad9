//! What a run says besides its samples: settings and events, each as JSON.

use crate::settings::Settings;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt;

/// The settings in force from a tick on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LiveSettings {
    /// Counts the changes; [`RunSample::settings`](super::RunSample::settings) refers to it.
    pub revision: u32,
    /// First tick under these settings.
    pub tick: u64,
    /// By the names of the controller file. A setting that is left out has the kernel's default.
    pub settings: Settings,
    /// Where the reference comes from.
    pub reference: RunReference,
}

impl LiveSettings {
    /// The key of every setting, as in [`LiveSettings::by_key`].
    pub const KEYS: &[&str] = &[
        "law",
        "u_p_plus_v",
        "u_p_minus_v",
        "eps_u_v",
        "eps_e_rad",
        "hysteresis_u",
        "hysteresis_e",
        "breakaway_plus_v",
        "breakaway_minus_v",
        "voltage_limit_v",
        "deflection_limit_rad",
        "theta_limit_rad",
        "theta_step_limit_rad",
        "smooth_ticks",
        "smooth_step_rad",
        "theta.scale",
        "theta.offset_rad",
        "theta.low_pass",
        "alpha.scale",
        "alpha.offset_rad",
        "alpha.low_pass",
        "reference.shape",
        "reference.amplitude_rad",
        "reference.period_s",
        "reference.offset_rad",
    ];

    /// The keys whose values are words; all others are numbers.
    pub const WORDS: &[&str] = &["law", "reference.shape"];

    /// The settings that are set, as `theta.low_pass` and its value.
    pub fn texts(&self) -> Vec<(String, String)> {
        by_key(&self.settings, "").into_iter().map(|(key, value)| (key, value.to_string())).collect()
    }

    /// The settings that are set and the reference, by the keys that change them: `theta.low_pass`, `reference.shape`.
    pub fn by_key(&self) -> Vec<(String, SettingValue)> {
        [by_key(&self.settings, ""), by_key(&self.reference, "reference")].concat()
    }

    /// The message on the topic `/settings`.
    pub fn to_json(&self) -> Vec<u8> {
        json_bytes(self).expect("settings have string keys only")
    }
}

/// The value of one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SettingValue {
    /// In the unit that its key names.
    Number(f64),
    /// Of a few: a law, a shape.
    Word(String),
}

/// As JSON writes a number, and a word without quotes.
impl fmt::Display for SettingValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SettingValue::Number(number) => write!(f, "{}", Value::from(*number)),
            SettingValue::Word(word) => write!(f, "{word}"),
        }
    }
}

/// Words and numbers of a table and those below it, each by its full key.
pub(crate) fn by_key(table: &impl Serialize, name: &str) -> Vec<(String, SettingValue)> {
    let mut found = Vec::new();
    collect(&serde_json::to_value(table).expect("a table has string keys only"), name, &mut found);
    found
}

fn collect(value: &Value, name: &str, found: &mut Vec<(String, SettingValue)>) {
    let below = |key: &str| if name.is_empty() { key.to_string() } else { format!("{name}.{key}") };
    match value {
        Value::Object(object) => object.iter().for_each(|(key, value)| collect(value, &below(key), found)),
        Value::String(word) => found.push((name.into(), SettingValue::Word(word.clone()))),
        Value::Number(number) => {
            found.extend(number.as_f64().map(|number| (name.into(), SettingValue::Number(number))));
        }
        Value::Bool(truth) => found.push((name.into(), SettingValue::Word(truth.to_string()))),
        Value::Null | Value::Array(_) => {}
    }
}

/// The signal generator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunReference {
    /// Shape.
    pub shape: RunShape,
    /// Half of the way from the lowest to the highest value; of a step, its size [rad].
    pub amplitude_rad: f64,
    /// Period of a repeating shape [s].
    pub period_s: f64,
    /// Value in the middle; of a step, the value before it [rad].
    pub offset_rad: f64,
}

/// Shapes of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RunShape {
    /// One step.
    Step,
    /// Up and down.
    Square,
    /// Sine.
    Sine,
    /// Ramps.
    Sawtooth,
    /// Samples of a file.
    File,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunEvent {
    /// When, in periods since the run began.
    pub tick: u64,
    /// The same in seconds [s].
    pub time_s: f64,
    /// What kind: `armed`, `started`, `stopped`, `fault`, `warning`, `lost`, `override`.
    pub kind: String,
    /// For a person.
    pub text: String,
}

impl RunEvent {
    /// The message on the topic `/events`.
    pub fn to_json(&self) -> Vec<u8> {
        json_bytes(self).expect("an event has string keys only")
    }
}

/// JSON without the keys that hold nothing, which the schemas do not know.
///
/// Errors: those of the value's own `Serialize`.
pub(super) fn json_bytes(message: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
    let mut value = serde_json::to_value(message)?;
    drop_nulls(&mut value);
    serde_json::to_vec(&value)
}

fn drop_nulls(value: &mut Value) {
    if let Some(object) = value.as_object_mut() {
        object.retain(|_, value| !value.is_null());
        object.values_mut().for_each(drop_nulls);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RunTopic;
    use crate::settings::{Channel, Law};
    use std::collections::BTreeSet;

    /// Every key that can be written stands in the schema, and nothing else does.
    #[test]
    fn the_schemas_name_every_key() {
        let channel = || Some(Channel { scale: Some(1.0), offset_rad: Some(0.0), low_pass: Some(1.0) });
        let settings = Settings {
            law: Some(Law::Inverse),
            u_p_plus_v: Some(0.1),
            u_p_minus_v: Some(0.1),
            eps_u_v: Some(0.1),
            eps_e_rad: Some(0.1),
            hysteresis_u: Some(0.1),
            hysteresis_e: Some(0.1),
            breakaway_plus_v: Some(0.1),
            breakaway_minus_v: Some(0.1),
            voltage_limit_v: Some(0.1),
            deflection_limit_rad: Some(0.1),
            theta_limit_rad: Some(0.1),
            theta_step_limit_rad: Some(0.1),
            smooth_ticks: Some(0.1),
            smooth_step_rad: Some(0.1),
            theta: channel(),
            alpha: channel(),
        };
        let reference = RunReference { shape: RunShape::Sawtooth, amplitude_rad: 0.5, period_s: 2.0, offset_rad: 0.1 };
        let live = LiveSettings { revision: 3, tick: 7, settings, reference };
        let event = RunEvent { tick: 1, time_s: 0.001, kind: "lost".into(), text: "an answer".into() };
        assert_same_keys(
            &serde_json::to_value(&live).unwrap(),
            &serde_json::from_str(RunTopic::SETTINGS.schema).unwrap(),
        );
        assert_same_keys(
            &serde_json::to_value(&event).unwrap(),
            &serde_json::from_str(RunTopic::EVENTS.schema).unwrap(),
        );
        assert_same_keys(&Value::Object(Default::default()), &serde_json::from_str(RunTopic::REPORT.schema).unwrap());
        assert_eq!(live.texts().len(), 15 + 2 * 3, "fifteen numbers and words, two channels of three");
        let keys = live.by_key();
        let all: BTreeSet<&str> = keys.iter().map(|(key, _)| key.as_str()).collect();
        assert_eq!(all, LiveSettings::KEYS.iter().copied().collect());
        let is_word = |value: &SettingValue| matches!(value, SettingValue::Word(_));
        let words: BTreeSet<&str> = keys.iter().filter(|(_, v)| is_word(v)).map(|(key, _)| key.as_str()).collect();
        assert_eq!(words, LiveSettings::WORDS.iter().copied().collect());
        assert!(keys.contains(&("theta.low_pass".into(), SettingValue::Number(1.0))), "{keys:?}");
        assert!(keys.contains(&("reference.shape".into(), SettingValue::Word("sawtooth".into()))), "{keys:?}");
        let back: LiveSettings = serde_json::from_slice(&live.to_json()).unwrap();
        assert_eq!(back, live);
    }

    fn assert_same_keys(value: &Value, schema: &Value) {
        let kind = match value {
            Value::Object(object) => {
                let properties = schema["properties"].as_object().expect("properties");
                let keys = |object: &serde_json::Map<String, Value>| object.keys().cloned().collect::<BTreeSet<_>>();
                assert_eq!(keys(object), keys(properties));
                object.iter().for_each(|(key, value)| assert_same_keys(value, &properties[key]));
                "object"
            }
            Value::String(_) => "string",
            Value::Number(number) if number.is_f64() => "number",
            _ => "integer",
        };
        assert_eq!(schema["type"], kind, "{value}");
    }

    #[test]
    fn settings_left_out_are_not_written() {
        let reference = RunReference { shape: RunShape::Step, amplitude_rad: 0.5, period_s: 2.0, offset_rad: 0.0 };
        let live = LiveSettings { revision: 0, tick: 0, settings: Settings::default(), reference };
        let text = String::from_utf8(live.to_json()).unwrap();
        assert!(text.contains("\"settings\":{}") && text.contains("\"shape\":\"step\""), "{text}");
        assert_eq!(serde_json::from_str::<LiveSettings>(&text).unwrap(), live);
    }
}
