//! What a run says besides its samples: settings, events, a report. Each as JSON, with the schema that viewers are given.

use crate::settings::Settings;
use serde::{Deserialize, Serialize};

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
    /// The settings that are set, as `theta.low_pass` and its value.
    pub fn texts(&self) -> Vec<(String, String)> {
        let mut texts = Vec::new();
        if let Ok(settings) = serde_json::to_value(&self.settings) {
            collect(&settings, "", &mut texts);
        }
        texts
    }
}

fn collect(value: &serde_json::Value, name: &str, texts: &mut Vec<(String, String)>) {
    match value {
        serde_json::Value::Null => {}
        serde_json::Value::Object(object) => {
            let below = |key: &str| if name.is_empty() { key.to_string() } else { format!("{name}.{key}") };
            object.iter().for_each(|(key, value)| collect(value, &below(key), texts));
        }
        serde_json::Value::String(text) => texts.push((name.into(), text.clone())),
        other => texts.push((name.into(), other.to_string())),
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

/// A topic with JSON messages.
pub(super) struct JsonTopic {
    pub topic: &'static str,
    pub schema_name: &'static str,
    /// JSON Schema, in the part of it that viewers understand.
    pub schema: &'static str,
}

/// Topic and schema name of the samples.
pub(super) const SIGNALS: (&str, &str) = ("/signals", "flexbeam_msgs/msg/Signals");

pub(super) const SETTINGS: JsonTopic = JsonTopic {
    topic: "/settings",
    schema_name: "flexbeam.LiveSettings",
    schema: r#"{"type":"object","properties":{
"revision":{"type":"integer"},
"tick":{"type":"integer","description":"first period under these settings"},
"settings":{"type":"object","description":"by the names of the controller file","properties":{
"law":{"type":"string"},
"u_p_plus_v":{"type":"number"},"u_p_minus_v":{"type":"number"},
"eps_u_v":{"type":"number"},"eps_e_rad":{"type":"number"},
"hysteresis_u":{"type":"number"},"hysteresis_e":{"type":"number"},
"breakaway_plus_v":{"type":"number"},"breakaway_minus_v":{"type":"number"},
"voltage_limit_v":{"type":"number"},"deflection_limit_rad":{"type":"number"},
"theta_limit_rad":{"type":"number"},"theta_step_limit_rad":{"type":"number"},
"smooth_ticks":{"type":"number"},"smooth_step_rad":{"type":"number"},
"theta":{"type":"object","properties":{
"scale":{"type":"number"},"offset_rad":{"type":"number"},"low_pass":{"type":"number"}}},
"alpha":{"type":"object","properties":{
"scale":{"type":"number"},"offset_rad":{"type":"number"},"low_pass":{"type":"number"}}}}},
"reference":{"type":"object","properties":{
"shape":{"type":"string"},"amplitude_rad":{"type":"number"},"period_s":{"type":"number"},"offset_rad":{"type":"number"}}}}}"#,
};

pub(super) const EVENTS: JsonTopic = JsonTopic {
    topic: "/events",
    schema_name: "flexbeam.RunEvent",
    schema: r#"{"type":"object","properties":{
"tick":{"type":"integer"},"time_s":{"type":"number"},"kind":{"type":"string"},"text":{"type":"string"}}}"#,
};

pub(super) const REPORT: JsonTopic =
    JsonTopic { topic: "/report", schema_name: "flexbeam.RunReport", schema: r#"{"type":"object","properties":{}}"# };

/// JSON without the keys that hold nothing, which the schemas do not know.
///
/// Errors: those of the value's own `Serialize`.
pub(super) fn json_bytes(message: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
    let mut value = serde_json::to_value(message)?;
    drop_nulls(&mut value);
    serde_json::to_vec(&value)
}

fn drop_nulls(value: &mut serde_json::Value) {
    if let Some(object) = value.as_object_mut() {
        object.retain(|_, value| !value.is_null());
        object.values_mut().for_each(drop_nulls);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Channel, Law};
    use serde_json::Value;

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
        assert_same_keys(&serde_json::to_value(&live).unwrap(), &serde_json::from_str(SETTINGS.schema).unwrap());
        assert_same_keys(&serde_json::to_value(&event).unwrap(), &serde_json::from_str(EVENTS.schema).unwrap());
        assert_same_keys(&Value::Object(Default::default()), &serde_json::from_str(REPORT.schema).unwrap());
        assert_eq!(live.texts().len(), 15 + 2 * 3, "fifteen numbers and words, two channels of three");
        let back: LiveSettings = serde_json::from_slice(&json_bytes(&live).unwrap()).unwrap();
        assert_eq!(back, live);
    }

    fn assert_same_keys(value: &Value, schema: &Value) {
        let kind = match value {
            Value::Object(object) => {
                let properties = schema["properties"].as_object().expect("properties");
                let keys = |object: &serde_json::Map<String, Value>| {
                    object.keys().cloned().collect::<std::collections::BTreeSet<_>>()
                };
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
        let text = String::from_utf8(json_bytes(&live).unwrap()).unwrap();
        assert!(text.contains("\"settings\":{}") && text.contains("\"shape\":\"step\""), "{text}");
        assert_eq!(serde_json::from_str::<LiveSettings>(&text).unwrap(), live);
    }
}
