//! What the scope's page and the run's server say to each other, as text frames of one JSON object each.
//!
//! Values are in SI. Samples go in binary frames, which are not here.

use crate::run_file::{RunEvent, SettingValue};
use crate::run_result::RunResult;
use crate::screen::Screen;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the messages; server and page must have the same.
pub const SCOPE_PROTOCOL: u32 = 1;

/// From the page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub enum PageMessage {
    /// The first message: who comes.
    Enter(Enter),
    /// Start or stop.
    Do {
        /// Comes back with the reply.
        id: u64,
        /// What.
        request: DeedRequest,
    },
    /// Other settings: all of them or none.
    Set {
        /// Comes back with the reply.
        id: u64,
        /// By the keys of `flexbeam tell`.
        values: BTreeMap<String, SettingValue>,
    },
    /// Asks for control.
    Take {
        /// Comes back with the reply.
        id: u64,
    },
    /// Gives control up.
    Release {
        /// Comes back with the reply.
        id: u64,
    },
    /// The answer of the one in control to the one who asks for it.
    Give {
        /// Comes back with the reply.
        id: u64,
        /// Who asked.
        to: u64,
        /// Whether they get it.
        yes: bool,
    },
    /// Saves scopes, panels and the settings in force.
    Save {
        /// Comes back with the reply.
        id: u64,
        /// Scopes and panels.
        screen: Screen,
    },
}

/// Who comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Enter {
    /// [`SCOPE_PROTOCOL`] of the page.
    pub protocol: u32,
    /// Without one the page may look.
    pub token: Option<String>,
    /// As the other viewers see it: `tablet`.
    pub name: String,
    /// By which a viewer that lost its connection gets its seat back; nobody else is told.
    pub key: String,
    /// Newest tick that the page has; nothing: it has none.
    pub after: Option<u64>,
    /// The run that `after` belongs to, by its start as in [`ScopeRun`]; left out: this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
}

/// A deed that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeedRequest {
    /// Which.
    #[serde(rename = "do")]
    pub deed: Deed,
}

/// What a viewer with the token may do to a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Deed {
    /// From armed to running.
    Start,
    /// To 0 V and to the end.
    Stop,
    /// The emergency stop: the run ends as a fault.
    Emergency,
}

/// From the server.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum ServerMessage {
    /// The answer to `enter`; once more when the run is armed.
    Hello(Box<Hello>),
    /// The table of settings, when it changed.
    Knobs {
        /// The whole table.
        knobs: Vec<Knob>,
    },
    /// How the run stands.
    State(ScopeState),
    /// Something that happened.
    Event(RunEvent),
    /// Who is there.
    Viewers(Attendance),
    /// The answer to whatever had an id.
    Reply {
        /// Of the question.
        id: u64,
        /// Whether it was done.
        ok: bool,
        /// Why not: found, needed, hint.
        #[serde(skip_serializing_if = "Option::is_none")]
        error: Option<String>,
    },
    /// The run has ended; nothing comes after it.
    Over {
        /// How it went.
        result: Box<RunResult>,
    },
}

/// The answer to `enter`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hello {
    /// [`SCOPE_PROTOCOL`] of the server.
    pub protocol: u32,
    /// Version of flexbeam.
    pub version: String,
    /// The viewer's number.
    pub viewer: u64,
    /// What the viewer may.
    pub may: ViewerMay,
    /// What became of the token.
    pub token: TokenFound,
    /// The run.
    pub run: ScopeRun,
    /// Channels of the binary frames, in their order.
    pub signals: Vec<ScopeSignal>,
    /// Settings; none before the run is armed.
    pub knobs: Vec<Knob>,
    /// The controller's certificate in short.
    pub certificate: Option<CertificateSummary>,
    /// Scopes and panels.
    pub screen: Screen,
}

/// What a viewer may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ViewerMay {
    /// Look.
    Look,
    /// Besides: stop the run, and ask for control.
    Steer,
}

/// What became of the token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TokenFound {
    /// There was none.
    None,
    /// The run's.
    Good,
    /// Another one.
    Wrong,
}

/// The run that is shown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScopeRun {
    /// The controller's file.
    pub controller: String,
    /// The project's name.
    pub project: Option<String>,
    /// The rig.
    pub port: String,
    /// Sample period [s].
    pub period_s: f64,
    /// Tick 0, in ns since 1970-01-01 UTC, as a text because it is above 2^53; `0` before the run is armed.
    pub start_unix_ns: String,
    /// Whether there is a project to save into.
    pub can_save: bool,
}

/// One channel of the binary frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScopeSignal {
    /// As in a recording: `psi_rad`.
    pub key: String,
    /// For a person.
    pub label: String,
    /// In a formula.
    pub symbol: String,
    /// Of what is shown.
    pub unit: String,
    /// What is shown, for each unit of what comes.
    pub factor: f64,
    /// Kind.
    pub kind: SignalKind,
}

/// Kinds of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SignalKind {
    /// A quantity.
    Line,
    /// A code or a count.
    Flag,
}

/// One setting that may change in the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Knob {
    /// As `flexbeam tell` takes it.
    pub key: String,
    /// For a person.
    pub label: String,
    /// Settings of one kind.
    pub group: String,
    /// Of what is shown.
    pub unit: String,
    /// What is shown, for each unit of the value.
    pub factor: f64,
    /// The least value that is accepted; nothing: there is none.
    pub low: Option<f64>,
    /// The largest value that is accepted; nothing: there is none.
    pub high: Option<f64>,
    /// A step of a slider.
    pub step: f64,
    /// Decimals of what is shown.
    pub decimals: u8,
    /// The words to choose from, of a setting that is no number.
    pub words: Option<Vec<String>>,
    /// Why it cannot change in a run.
    pub why_fixed: Option<String>,
}

/// A certificate in short.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CertificateSummary {
    /// Whether every figure was found again before the run.
    pub holds: bool,
    /// Why the run goes on all the same, where it does not hold; else empty.
    pub note: String,
    /// The figures.
    pub figures: Vec<CertificateFigure>,
}

/// One figure of a certificate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CertificateFigure {
    /// What it is.
    pub label: String,
    /// Nothing: infinite.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// What a person should know of it.
    pub note: String,
}

/// How the run stands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScopeState {
    /// `configured` while the rig is brought to rest, then `armed`, `running`, `stopped`, `fault`.
    pub phase: String,
    /// Since the run was armed [s].
    pub time_s: f64,
    /// Revision of the settings.
    pub revision: u32,
    /// Settings, by the keys of the knobs. A limit that is left out is infinite.
    pub values: BTreeMap<String, SettingValue>,
    /// How the clock was kept.
    pub timing: ScopeTiming,
}

/// How the clock was kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ScopeTiming {
    /// Ticks.
    pub ticks: u64,
    /// Lateness: median [s].
    pub median_s: f64,
    /// Lateness below which 99 % of the ticks lie [s].
    pub p99_s: f64,
    /// Largest lateness [s].
    pub max_s: f64,
    /// Periods without a tick.
    pub missed: u64,
    /// Ticks without a fresh measurement.
    pub stale: u64,
}

/// Who is there.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Attendance {
    /// All viewers.
    pub viewers: Vec<Attendant>,
    /// Who is in control; one whose connection was lost a moment ago has its seat still, and is not among the viewers.
    pub in_control: Option<u64>,
    /// Who asks for control.
    pub asking: Option<Asking>,
}

/// A viewer, as the others see it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attendant {
    /// Its number.
    pub id: u64,
    /// Its name.
    pub name: String,
    /// What it may.
    pub may: ViewerMay,
}

/// A viewer that asks for control.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Asking {
    /// Its number.
    pub viewer: u64,
    /// Its name.
    pub name: String,
    /// Until silence gives it control [s].
    pub seconds_left: u64,
}

impl PageMessage {
    /// The message in a text frame.
    ///
    /// Errors: what serde says, with the column.
    pub fn parse(text: &str) -> Result<PageMessage, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    /// The number of a text that is no message, when it has one.
    pub fn id_of(text: &str) -> Option<u64> {
        #[derive(Deserialize)]
        struct Numbered {
            id: u64,
        }
        serde_json::from_str(text).ok().map(|Numbered { id }| id)
    }

    /// By which the reply is told from others; `enter` has none.
    pub fn id(&self) -> Option<u64> {
        match self {
            PageMessage::Enter(_) => None,
            PageMessage::Do { id, .. }
            | PageMessage::Set { id, .. }
            | PageMessage::Take { id }
            | PageMessage::Release { id }
            | PageMessage::Give { id, .. }
            | PageMessage::Save { id, .. } => Some(*id),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_page_says_is_read_and_what_it_does_not_say_is_refused() {
        let enter = r#"{"type":"enter","protocol":1,"token":null,"name":"tablet","key":"k","after":null}"#;
        let found = PageMessage::parse(enter).unwrap();
        assert!(matches!(&found, PageMessage::Enter(enter) if enter.name == "tablet" && enter.run.is_none()));
        let set = r#"{"type":"set","id":4,"values":{"reference.amplitude_rad":0.5,"law":"inverse"}}"#;
        let PageMessage::Set { id: 4, values } = PageMessage::parse(set).unwrap() else { panic!() };
        assert_eq!(values["law"], SettingValue::Word("inverse".into()));
        assert_eq!(values["reference.amplitude_rad"], SettingValue::Number(0.5));
        let deed = PageMessage::parse(r#"{"type":"do","id":1,"request":{"do":"emergency"}}"#);
        assert_eq!(deed, Ok(PageMessage::Do { id: 1, request: DeedRequest { deed: Deed::Emergency } }));
        for refused in [
            r#"{"type":"do","id":1,"request":{"do":"status"}}"#,
            r#"{"type":"do","id":1,"request":{"do":"start","now":true}}"#,
            r#"{"type":"take"}"#,
            r#"{"type":"take","id":-1}"#,
            r#"{"type":"take","id":1,"please":true}"#,
            r#"{"type":"set","id":1,"values":{"law":true}}"#,
            r#"{"type":"set","id":1,"values":{"law":[1]}}"#,
            r#"{"type":"jump","id":1}"#,
            r#"{"type":"enter","protocol":1,"token":null,"name":"a","key":"k","after":null,"admin":true}"#,
            r#"{"type":"save","id":1,"screen":{"scopes":[]}}"#,
            "[]",
            "",
        ] {
            assert!(PageMessage::parse(refused).is_err(), "{refused}");
        }
    }

    #[test]
    fn each_message_comes_back_with_its_id() {
        let values = BTreeMap::from([("eps_u_v".to_string(), SettingValue::Number(0.02))]);
        for message in [
            PageMessage::Do { id: 7, request: DeedRequest { deed: Deed::Start } },
            PageMessage::Set { id: 7, values },
            PageMessage::Take { id: 7 },
            PageMessage::Release { id: 7 },
            PageMessage::Give { id: 7, to: 3, yes: false },
            PageMessage::Save { id: 7, screen: Screen::default() },
        ] {
            assert_eq!(message.id(), Some(7));
            assert_eq!(PageMessage::parse(&crate::json_text(&message)), Ok(message));
        }
    }
}
