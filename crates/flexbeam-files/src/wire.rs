//! Messages of the local control socket: one JSON object a line, each request answered by one reply.

use crate::run_file::RunShape;
use crate::settings::Settings;
use serde::{Deserialize, Serialize};

/// What is asked of a run.
///
/// ```
/// use flexbeam_files::Request;
/// let request = Request::parse(r#"{"do":"set","settings":{"eps_u_v":0.02}}"#).unwrap();
/// assert!(matches!(request, Request::Set { .. }));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
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
        settings: Settings,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_replies_come_back() {
        let settings = Settings { eps_u_v: Some(0.02), ..Settings::default() };
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
