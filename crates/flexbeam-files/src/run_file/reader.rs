//! A recording of a run, read from its beginning to its end or to where it was cut off.

use super::fault::RunFault;
use super::header::{RunHeader, metadata};
use super::messages::{LiveSettings, RunEvent};
use super::records::{Parts, attachment};
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
pub(super) const LONGEST_CHUNK: usize = 1 << 28;

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

impl CutOff {
    /// What a person should know: of a file with so many whole samples.
    pub(super) fn notice(&self, source: &Path, samples: usize) -> String {
        format!(
            "{} ends too early, as after a power loss: {samples} samples up to byte {} are whole, {} bytes after it are not used",
            source.display(),
            self.whole,
            self.unused
        )
    }
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
        self.header.period_s =
            agreed_period(&self.header, layout).map_err(|fault| Error::new(Tried::Read, &self.source, fault))?;
        Ok(self)
    }
}

/// A run's period, where what the user says of the run can be.
///
/// Errors: [`RunFault::Named`], [`RunFault::OnTime`], [`Fault::Period`], [`Fault::PeriodsDiffer`].
pub(super) fn agreed_period(header: &RunHeader, layout: &Layout) -> Result<f64, Fault> {
    match layout {
        Layout { columns: Some(_), .. } => Err(RunFault::Named.into()),
        Layout { resample_s: Some(_), .. } => Err(RunFault::OnTime.into()),
        Layout { period_s, .. } => agreed(header.period_s, *period_s),
    }
}

/// What has been read so far.
pub(super) struct Content {
    pub header: RunHeader,
    topics: HashMap<u16, String>,
    pub samples: RunColumns,
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
            let record = &bytes[part.offset..][..RECORD_HEAD + part.body.len()];
            let before = || crc32fast::hash(&bytes[..part.offset]);
            let Err(what) = content.part(part.opcode, record, before, &mut chunks) else { continue };
            let last = !file.parts[k + 1..].iter().any(|part| part.opcode == op::CHUNK);
            if file.finished || part.opcode != op::CHUNK || !last {
                return Err(RunFault::Damaged { byte: part.offset, what }.into());
            }
            return Ok((content, Some(part.offset)));
        }
        Ok((content, file.cut))
    }

    pub fn new(header: RunHeader) -> Content {
        Content {
            header,
            topics: HashMap::new(),
            samples: RunColumns::default(),
            settings: Vec::new(),
            events: Vec::new(),
            report: None,
        }
    }

    /// Takes a record with its head; `sum_before` is the check sum over everything before it.
    ///
    /// Errors: what is wrong with the record, in words.
    pub fn part(
        &mut self,
        opcode: u8,
        record: &[u8],
        sum_before: impl FnOnce() -> u32,
        chunks: &mut LinearReader,
    ) -> Result<(), String> {
        let body = &record[RECORD_HEAD..];
        match opcode {
            op::CHUNK => self.chunk(record, chunks),
            op::ATTACHMENT => self.attachment(body),
            op::DATA_END => data_end(body, sum_before()),
            opcode => self.record(opcode, body),
        }
    }

    /// The records in a chunk, once its check sum is found to be right.
    fn chunk(&mut self, record: &[u8], chunks: &mut LinearReader) -> Result<(), String> {
        each_record(record, chunks, |what| what, |opcode, data| self.record(opcode, data))
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

/// The records in `bytes`, those in chunks too; where the bytes end within one, it is left.
///
/// Errors: those of `take`; what the reader finds wrong, made an error by `wrong`.
pub(crate) fn each_record<E>(
    bytes: &[u8],
    reader: &mut LinearReader,
    wrong: impl Fn(String) -> E,
    mut take: impl FnMut(u8, &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let mut rest = bytes;
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| wrong(error.to_string()))? {
            LinearReadEvent::ReadRequest(_) if rest.is_empty() => return Ok(()),
            LinearReadEvent::ReadRequest(wanted) => {
                let (next, after) = rest.split_at(wanted.min(rest.len()));
                reader.insert(next.len()).copy_from_slice(next);
                reader.notify_read(next.len());
                rest = after;
            }
            LinearReadEvent::Record { opcode, data } => take(opcode, data)?,
        }
    }
    Ok(())
}

/// Kind and length before a record's body [bytes].
pub(super) const RECORD_HEAD: usize = 1 + size_of::<u64>();

pub(crate) fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LONGEST_CHUNK)
}

/// Compares the check sum over everything before the end of the data.
fn data_end(body: &[u8], found: u32) -> Result<(), String> {
    let saved = body.first_chunk().copied().map(u32::from_le_bytes).ok_or("an end without a check sum")?;
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
