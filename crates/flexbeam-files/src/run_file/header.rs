//! Where a run came from: the metadata record `flexbeam` and the controller file.

use super::records::{Part, Parts};
use super::stream::metadata_of_file;
use crate::csv::instant;
use crate::excitation::Excitation;
use crate::fault::Fault;
use crate::hash::sha256_hex;
use crate::provenance::Provenance;
use mcap::records::{Record, op};
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

/// Text by name.
pub(super) type Metadata = BTreeMap<String, String>;

/// Kind and version of a recording of a run.
pub const RUN_SCHEMA: &str = "flexbeam.run/1";

/// Name of the metadata record.
const RECORD: &str = "flexbeam";

/// What is known of a run before its first tick.
#[derive(Clone, Debug, PartialEq)]
pub struct RunHeader {
    /// Sample period [s].
    pub period_s: f64,
    /// When tick 0 began, since 1970-01-01 UTC [ns].
    pub start_unix_ns: u64,
    /// The rig: `udp:192.168.1.7:4810`.
    pub port: String,
    /// Tool, command, and the files that the run was made of: controller, project, rig.
    pub provenance: Provenance,
    /// The controller file's bytes; nothing where the voltages were a list, as in a recording for identification.
    pub controller: Option<Vec<u8>>,
    /// The list of voltages as it was planned, where the run was a recording for identification.
    pub excitation: Option<Excitation>,
}

impl RunHeader {
    /// When a tick begins, since the run began [s].
    pub fn time_s(&self, tick: u64) -> f64 {
        instant(tick, self.period_s)
    }

    /// Time stamp of a tick, since 1970-01-01 UTC [ns].
    pub fn log_time_ns(&self, tick: u64) -> u64 {
        let since_start_ns = (self.time_s(tick) * 1e9).round();
        self.start_unix_ns.saturating_add(since_start_ns as u64)
    }

    /// As the metadata record: text by name.
    pub(super) fn record(&self) -> mcap::records::Metadata {
        let parents = serde_json::to_string(&self.provenance.parents).expect("parents have string keys only");
        let optional = [
            ("command", self.provenance.command.clone()),
            ("time", self.provenance.time.clone()),
            ("excitation", self.excitation.as_ref().map(Excitation::to_text)),
            ("controller_sha256", self.controller.as_deref().map(sha256_hex)),
        ];
        let optional = optional.into_iter().filter_map(|(key, text)| Some((key, text?)));
        let always = [
            ("schema", RUN_SCHEMA.to_string()),
            ("tool", self.provenance.tool.clone()),
            ("period_s", format!("{:?}", self.period_s)),
            ("start_unix_ns", self.start_unix_ns.to_string()),
            ("port", self.port.clone()),
            ("parents", parents),
        ];
        let metadata = always.into_iter().chain(optional).map(|(key, text)| (key.to_string(), text)).collect();
        mcap::records::Metadata { name: RECORD.into(), metadata }
    }

    /// The header without the controller file, which is an attachment.
    ///
    /// Errors: [`Fault::Schema`], [`Fault::MissingKey`], [`Fault::WrongType`], [`Fault::Period`].
    pub(super) fn of(metadata: &Metadata) -> Result<RunHeader, Fault> {
        let text = |key: &str| metadata.get(key).cloned().ok_or_else(|| Fault::MissingKey { key: key.into() });
        let schema = text("schema")?;
        if schema != RUN_SCHEMA {
            return Err(Fault::Schema { found: schema, needed: RUN_SCHEMA });
        }
        let period_s: f64 = number(text("period_s")?, "period_s", "a number")?;
        if !(period_s > 0.0 && period_s.is_finite()) {
            return Err(Fault::Period { period_s });
        }
        Ok(RunHeader {
            period_s,
            start_unix_ns: number(text("start_unix_ns")?, "start_unix_ns", "a whole number")?,
            port: text("port")?,
            provenance: provenance(metadata).ok_or_else(|| Fault::MissingKey { key: "parents".into() })?,
            controller: None,
            excitation: metadata.get("excitation").map(|text| Excitation::of_text(text)).transpose()?,
        })
    }
}

/// Errors: [`Fault::WrongType`].
fn number<T: FromStr>(text: String, key: &str, needed: &str) -> Result<T, Fault> {
    let wrong = || Fault::WrongType { key: key.into(), found: format!("the text {text:?}"), needed: needed.into() };
    text.parse().map_err(|_| wrong())
}

/// Tool, command and parents, in whatever version wrote them; nothing when they are not there.
fn provenance(metadata: &Metadata) -> Option<Provenance> {
    Some(Provenance {
        tool: metadata.get("tool")?.clone(),
        command: metadata.get("command").cloned(),
        time: metadata.get("time").cloned(),
        parents: serde_json::from_str(metadata.get("parents")?).ok()?,
    })
}

/// What a recording of a run says of itself, in whatever version; nothing when the bytes are no such recording.
pub(crate) struct RunOrigin {
    /// Kind and version.
    pub schema: String,
    /// Tool, command and parents, where they can be read.
    pub provenance: Option<Provenance>,
}

impl RunOrigin {
    pub(crate) fn of(bytes: &[u8]) -> Option<RunOrigin> {
        RunOrigin::said(&metadata(&Parts::of(bytes)?.parts)?)
    }

    /// Of a file, of whatever length.
    pub(crate) fn of_file(path: &Path) -> Option<RunOrigin> {
        RunOrigin::said(&metadata_of_file(path).ok()??)
    }

    fn said(metadata: &Metadata) -> Option<RunOrigin> {
        Some(RunOrigin { schema: metadata.get("schema")?.clone(), provenance: provenance(metadata) })
    }
}

/// The excitation that a run's metadata hold; nothing when the bytes are no run or do not say.
pub(crate) fn excitation_of_run(bytes: &[u8]) -> Option<Excitation> {
    let metadata = metadata(&Parts::of(bytes)?.parts)?;
    Excitation::of_text(metadata.get("excitation")?).ok()
}

/// The record `flexbeam`, where there is one.
pub(super) fn metadata(parts: &[Part<'_>]) -> Option<Metadata> {
    parts.iter().find_map(|part| metadata_in(part.opcode, part.body))
}

/// The record `flexbeam`, where this is it.
pub(super) fn metadata_in(opcode: u8, body: &[u8]) -> Option<Metadata> {
    match (opcode == op::METADATA).then(|| mcap::parse_record(opcode, body))? {
        Ok(Record::Metadata(record)) if record.name == RECORD => Some(record.metadata),
        _ => None,
    }
}
