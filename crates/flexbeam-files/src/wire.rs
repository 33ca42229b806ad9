//! Messages of the local control socket: one JSON object a line, each request answered by one reply.

use crate::run_file::{RunShape, SettingValue};
use crate::settings::Settings;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// No key has more parts. A key of many thousands would make a tree whose very end, part by part, overflows a small stack.
const MOST_PARTS: usize = 3;

/// What is asked of a run.
///
/// ```
/// use flexbeam_files::Request;
/// let request = Request::parse(r#"{"do":"set","settings":{"eps_u_v":0.02}}"#).unwrap();
/// assert!(matches!(request, Request::Set { .. }));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
#[allow(clippy::large_enum_variant, reason = "there is one at a time")]
pub enum Request {
    /// How it stands.
    Status,
    /// From armed to running.
    Start,
    /// To 0 V and to the end.
    Stop,
    /// The emergency stop.
    Emergency,
    /// Other settings; what is left out stays.
    Set {
        /// The kernel's settings, by the names of a controller file.
        #[serde(default)]
        settings: Box<Settings>,
        /// The reference.
        #[serde(default)]
        reference: ReferenceChange,
    },
}

/// A change of the reference; what is left out stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceChange {
    /// Shape.
    pub shape: Option<RunShape>,
    /// Amplitude [rad].
    pub amplitude_rad: Option<f64>,
    /// Period of a repeating shape [s].
    pub period_s: Option<f64>,
    /// What the amplitude is added to [rad].
    pub offset_rad: Option<f64>,
}

/// The answer to a request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether it was done.
    pub ok: bool,
    /// Why not: found, needed, hint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Where the run stands: `armed`, `running`, `stopped`, `fault`.
    pub phase: String,
    /// Revision of the settings in force.
    pub revision: u32,
    /// The last tick, when the status was asked for and there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last: Option<Reading>,
    /// The settings in force, when the status was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settings: Option<Settings>,
    /// The reference in force, when the status was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceChange>,
}

/// The last tick, for a status.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Time since the run was armed [s].
    pub time_s: f64,
    /// Reference [rad].
    pub reference_rad: f64,
    /// Tip angle [rad].
    pub psi_rad: f64,
    /// Deflection angle [rad].
    pub alpha_rad: f64,
    /// Voltage [V].
    pub voltage_v: f64,
}

impl Request {
    /// The request in one line.
    ///
    /// Errors: what serde says, with the column.
    pub fn parse(line: &str) -> Result<Request, String> {
        serde_json::from_str(line).map_err(|error| error.to_string())
    }
}

impl Reply {
    /// The reply in one line.
    ///
    /// Errors: what serde says, with the column.
    pub fn parse(line: &str) -> Result<Reply, String> {
        serde_json::from_str(line).map_err(|error| error.to_string())
    }
}

/// A request that sets each KEY=VALUE: keys of the table `settings`, and `reference.KEY`.
///
/// Errors: what is wrong with the first that is none, in words.
///
/// ```
/// use flexbeam_files::{Request, request_of_changes};
/// let request = request_of_changes(&["eps_u_v=0.02", "theta.low_pass=0.5", "reference.shape=sine"]).unwrap();
/// let Request::Set { settings, .. } = request else { panic!() };
/// assert_eq!(settings.eps_u_v, Some(0.02));
/// ```
pub fn request_of_changes<S: AsRef<str>>(changes: &[S]) -> Result<Request, String> {
    let mut request = empty();
    for change in changes {
        let change = change.as_ref();
        let (key, value) = change.split_once('=').ok_or_else(|| format!("{change:?} without ="))?;
        put(&mut request, key, serde_json::from_str(value.trim()).unwrap_or_else(|_| value.trim().into()))?;
    }
    serde_json::from_value(request).map_err(|error| error.to_string())
}

/// A request that sets each key, as [`request_of_changes`] names them.
///
/// Errors: what is wrong with the first that is none, in words.
pub fn request_of_values(values: &BTreeMap<String, SettingValue>) -> Result<Request, String> {
    let mut request = empty();
    for (key, value) in values {
        put(&mut request, key, json!(value))?;
    }
    serde_json::from_value(request).map_err(|error| error.to_string())
}

fn empty() -> Value {
    json!({ "do": "set", "settings": {}, "reference": {} })
}

fn put(request: &mut Value, key: &str, value: Value) -> Result<(), String> {
    let parts: Vec<&str> = key.trim().splitn(MOST_PARTS + 1, '.').collect();
    let path = if parts[0] == "reference" { parts } else { [&["settings"], parts.as_slice()].concat() };
    if path.len() > MOST_PARTS {
        return Err(format!("a key of more than {MOST_PARTS} parts"));
    }
    *place(request, &path).ok_or_else(|| format!("{key:?} below a value"))? = value;
    Ok(())
}

/// Where a path leads, made on the way; nothing where a value stands in it.
fn place<'a>(request: &'a mut Value, path: &[&str]) -> Option<&'a mut Value> {
    path.iter().try_fold(request, |value, step| match value {
        Value::Object(_) | Value::Null => Some(&mut value[*step]),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_keys_with_values() {
        let reference = ReferenceChange { shape: Some(RunShape::Sine), ..ReferenceChange::default() };
        let settings = Settings { law: Some(crate::Law::Switched), eps_u_v: Some(0.1), ..Settings::default() };
        let settings = Box::new(settings);
        let found = request_of_changes(&["law=switched", "reference.shape=sine", " eps_u_v = 0.1 "]);
        assert_eq!(found, Ok(Request::Set { settings, reference }));
        for (change, named) in
            [("eps_u_v", "without ="), ("epsilon=1", "epsilon"), ("eps_u_v=many", "many"), ("reference.a.b=1", "a")]
        {
            let error = request_of_changes(&[change]).unwrap_err();
            assert!(error.contains(named), "{error}");
        }
        let deep = format!("a{}=1", ".a".repeat(200_000));
        assert!(request_of_changes(&[deep]).unwrap_err().contains("parts"));
        let twice = request_of_changes(&["eps_u_v=1", "eps_u_v.deeper=2"]);
        assert_eq!(twice, Err("\"eps_u_v.deeper\" below a value".into()));
    }

    #[test]
    fn values_by_key_are_the_same_request() {
        let values = [
            ("law", SettingValue::Word("switched".into())),
            ("theta.low_pass", SettingValue::Number(0.5)),
            ("reference.offset_rad", SettingValue::Number(-0.1)),
        ];
        let values: BTreeMap<String, SettingValue> = values.map(|(key, value)| (key.to_string(), value)).into();
        let changes = ["law=switched", "theta.low_pass=0.5", "reference.offset_rad=-0.1"];
        assert_eq!(request_of_values(&values), request_of_changes(&changes));
        for key in ["epsilon", "reference", "eps_u_v.deeper", "a.b.c.d"] {
            assert!(request_of_values(&[(key.into(), SettingValue::Number(1.0))].into()).is_err(), "{key}");
        }
    }

    #[test]
    fn requests_and_replies_come_back() {
        let settings = Settings { eps_u_v: Some(0.02), ..Settings::default() };
        let settings = Box::new(settings);
        let reference = ReferenceChange { amplitude_rad: Some(0.5), ..ReferenceChange::default() };
        for request in
            [Request::Status, Request::Start, Request::Stop, Request::Emergency, Request::Set { settings, reference }]
        {
            assert_eq!(Request::parse(&crate::json_text(&request)), Ok(request));
        }
        let reply = Reply { ok: true, phase: "running".into(), revision: 3, ..Reply::default() };
        let line = crate::json_text(&reply);
        assert_eq!(line, r#"{"ok":true,"phase":"running","revision":3}"#);
        assert_eq!(Reply::parse(&line), Ok(reply));
    }

    #[test]
    fn a_key_that_nobody_knows_is_named() {
        for (line, named) in [
            (r#"{"do":"set","settings":{"epsilon":1}}"#, "epsilon"),
            (r#"{"do":"jump"}"#, "jump"),
            (r#"{"do":"set","reference":{"shape":"cosine"}}"#, "cosine"),
            ("", "EOF"),
        ] {
            let error = Request::parse(line).unwrap_err();
            assert!(error.contains(named), "{error}");
        }
    }
}
