//! A recording of a run, read from its beginning to its end or to where it was cut off.

use super::fault::RunFault;
use super::header::{RunHeader, metadata};
use super::messages::{LiveSettings, RunEvent};
use super::records::{Part, Parts, attachment};
use super::sample::{RunColumns, RunSample};
use super::topics::RunTopic;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::hash::sha256_hex;
use crate::recording::{Layout, agreed};
use crate::write::read_bytes;
use mcap::parse_record;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Name of the attachment that is the controller file.
pub(super) const CONTROLLER: &str = "controller.toml";

/// Longest chunk that is taken for one [bytes]; a hundred times what the writer makes. A damaged length must not fill
/// memory.
const LONGEST_CHUNK: usize = 1 << 28;

/// A recording of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRecording {
    /// What was known before the first tick.
    pub header: RunHeader,
    /// The samples, of every phase.
    pub samples: RunColumns,
    /// The settings at the start and each change.
    pub settings: Vec<LiveSettings>,
    /// What happened.
    pub events: Vec<RunEvent>,
    /// The report at the end, where the run came to one.
    pub report: Option<serde_json::Value>,
    /// Where the file ends too early, if it does. Everything before is whole.
    pub cut_off: Option<CutOff>,
    /// The file it was read from.
    pub source: PathBuf,
    /// SHA-256 of that file, in hexadecimal.
    pub sha256: String,
}

/// A file that ends too early, as after a power loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct CutOff {
    /// Up to here everything is whole [bytes].
    pub whole: usize,
    /// What stands after it and was not used [bytes].
    pub unused: usize,
}

impl RunRecording {
    /// Reads a recording of a run.
    ///
    /// Errors: those of [`read_bytes`] and of [`RunRecording::parse`].
    pub fn read(path: &Path) -> Result<RunRecording, Error> {
        RunRecording::parse(&read_bytes(path)?, path)
    }

    /// The recording in `bytes`; `source` is for messages.
    ///
    /// A file that ends within a record, or whose last chunk fails its check sum, was cut off: what stands before is used.
    ///
    /// Errors: [`Fault::Run`] with [`RunFault::Foreign`], or with [`RunFault::Damaged`] where bytes are wrong and intact ones
    /// follow; those of the header ([`Fault::Schema`], [`Fault::MissingKey`], [`Fault::WrongType`], [`Fault::Period`]).
    pub fn parse(bytes: &[u8], source: &Path) -> Result<RunRecording, Error> {
        let (content, cut) = Content::of(bytes).map_err(|fault| Error::new(Tried::Read, source, fault))?;
        Ok(RunRecording {
            header: content.header,
            samples: content.samples,
            settings: content.settings,
            events: content.events,
            report: content.report,
            cut_off: cut.map(|whole| CutOff { whole, unused: bytes.len() - whole }),
            source: source.to_path_buf(),
            sha256: sha256_hex(bytes),
        })
    }

    /// The same, where what the user says of it can be.
    ///
    /// Errors: [`Fault::Run`] with [`RunFault::Named`] for names of columns; [`Fault::Period`], [`Fault::PeriodsDiffer`] for a
    /// period that is not the recording's.
    pub fn agreeing_with(mut self, layout: &Layout) -> Result<RunRecording, Error> {
        let period_s = match layout.columns {
            Some(_) => Err(RunFault::Named.into()),
            None => agreed(self.header.period_s, layout.period_s),
        };
        self.header.period_s = period_s.map_err(|fault| Error::new(Tried::Read, &self.source, fault))?;
        Ok(self)
    }
}

/// What has been read so far.
struct Content {
    header: RunHeader,
    topics: HashMap<u16, String>,
    samples: RunColumns,
    settings: Vec<LiveSettings>,
    events: Vec<RunEvent>,
    report: Option<serde_json::Value>,
}

impl Content {
    /// The content, and where the file was cut off, if it was.
    fn of(bytes: &[u8]) -> Result<(Content, Option<usize>), Fault> {
        let file = Parts::of(bytes).ok_or(RunFault::Foreign)?;
        // First of all, because another version may hold other records.
        let metadata = metadata(&file.parts).ok_or(RunFault::Foreign)?;
        let mut content = Content::new(RunHeader::of(&metadata)?);
        if let Some(byte) = file.cut.filter(|_| file.finished) {
            return Err(RunFault::Damaged { byte, what: "a record longer than the file".into() }.into());
        }
        let mut chunks = LinearReader::new_with_options(options());
        for (k, part) in file.parts.iter().enumerate() {
            let Err(what) = content.part(part, bytes, &mut chunks) else { continue };
            let last = !file.parts[k + 1..].iter().any(|part| part.opcode == op::CHUNK);
            if file.finished || part.opcode != op::CHUNK || !last {
                return Err(RunFault::Damaged { byte: part.offset, what }.into());
            }
            return Ok((content, Some(part.offset)));
        }
        Ok((content, file.cut))
    }

    fn new(header: RunHeader) -> Content {
        Content {
            header,
            topics: HashMap::new(),
            samples: RunColumns::default(),
            settings: Vec::new(),
            events: Vec::new(),
            report: None,
        }
    }

    /// Errors: what is wrong with the record, in words.
    fn part(&mut self, part: &Part<'_>, bytes: &[u8], chunks: &mut LinearReader) -> Result<(), String> {
        match part.opcode {
            op::CHUNK => self.chunk(&bytes[part.offset..][..RECORD_HEAD + part.body.len()], chunks),
            op::ATTACHMENT => self.attachment(part.body),
            op::DATA_END => data_end(part, bytes),
            opcode => self.record(opcode, part.body),
        }
    }

    /// The records in a chunk, once its check sum is found to be right.
    fn chunk(&mut self, record: &[u8], chunks: &mut LinearReader) -> Result<(), String> {
        let mut rest = record;
        while let Some(event) = chunks.next_event() {
            match event.map_err(|error| error.to_string())? {
                LinearReadEvent::ReadRequest(_) if rest.is_empty() => return Ok(()),
                LinearReadEvent::ReadRequest(wanted) => {
                    let (next, after) = rest.split_at(wanted.min(rest.len()));
                    chunks.insert(next.len()).copy_from_slice(next);
                    chunks.notify_read(next.len());
                    rest = after;
                }
                LinearReadEvent::Record { opcode, data } => self.record(opcode, data)?,
            }
        }
        Ok(())
    }

    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<(), String> {
        if !matches!(opcode, op::CHANNEL | op::MESSAGE) {
            return Ok(());
        }
        match parse_record(opcode, body).map_err(|error| error.to_string())? {
            Record::Channel(channel) => {
                self.topics.insert(channel.id, channel.topic);
                Ok(())
            }
            Record::Message { header, data } => self.message(header.channel_id, &data),
            _ => Ok(()),
        }
    }

    fn message(&mut self, channel: u16, data: &[u8]) -> Result<(), String> {
        let topic = self.topics.get(&channel).ok_or("a message of an unknown channel")?;
        let wrong = |error: serde_json::Error| format!("a message on {topic}: {error}");
        match topic.as_str() {
            topic if topic == RunTopic::SIGNALS.topic => {
                self.samples.push(RunSample::from_cdr(data).ok_or("no sample")?)
            }
            topic if topic == RunTopic::SETTINGS.topic => {
                self.settings.push(serde_json::from_slice(data).map_err(wrong)?)
            }
            topic if topic == RunTopic::EVENTS.topic => self.events.push(serde_json::from_slice(data).map_err(wrong)?),
            topic if topic == RunTopic::REPORT.topic => {
                self.report = Some(serde_json::from_slice(data).map_err(wrong)?)
            }
            _ => {}
        }
        Ok(())
    }

    fn attachment(&mut self, body: &[u8]) -> Result<(), String> {
        let (name, data) = attachment(body).ok_or("an attachment that does not fit its check sum")?;
        if name == CONTROLLER.as_bytes() {
            self.header.controller = Some(data.to_vec());
        }
        Ok(())
    }
}

/// Kind and length before a record's body [bytes].
const RECORD_HEAD: usize = 1 + size_of::<u64>();

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LONGEST_CHUNK)
}

/// The check sum over everything before the end of the data.
fn data_end(part: &Part<'_>, bytes: &[u8]) -> Result<(), String> {
    let saved = part.body.first_chunk().copied().map(u32::from_le_bytes).ok_or("an end without a check sum")?;
    let found = crc32fast::hash(&bytes[..part.offset]);
    if saved != 0 && saved != found {
        return Err(format!("the check sum of all before is {found:08x}, not {saved:08x}"));
    }
    Ok(())
}

impl From<RunFault> for Fault {
    fn from(fault: RunFault) -> Fault {
        Fault::Run(fault)
    }
}
