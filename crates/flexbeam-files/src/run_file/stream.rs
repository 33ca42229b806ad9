//! A run read from the disk record by record, in memory that does not depend on its length.

use super::fault::RunFault;
use super::header::{Metadata, RunHeader, metadata_in};
use super::reader::{Content, CutOff, LONGEST_CHUNK, RECORD_HEAD, agreed_period, options};
use super::sample::{RunColumns, RunSample};
use super::stretch::{Stretch, StretchSearch, signal_values};
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::recording::{FEWEST_ROWS, Layout};
use crate::table::Rows;
use crate::write::refused;
use mcap::MAGIC;
use mcap::records::op;
use mcap::sans_io::LinearReader;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The longest stretch of a run without a gap, sample after sample. The file is read twice: to find the stretch, and to give it.
pub(crate) struct RunChunks {
    stream: Stream,
    stretch: Stretch,
    period_s: f64,
    /// Samples that were read and not yet given, and how many of the file came before them.
    read: RunColumns,
    before: usize,
    given: usize,
    notice: Option<String>,
    source: PathBuf,
}

impl RunChunks {
    /// Errors: as [`Recording::parse`](crate::Recording::parse) of a run.
    pub fn open(path: &Path, layout: &Layout) -> Result<RunChunks, Error> {
        let error = |fault| Error::new(Tried::Read, path, fault);
        let mut survey = Stream::open(path)?;
        let period_s = agreed_period(&survey.content.header, layout).map_err(error)?;
        let mut search = StretchSearch::default();
        let mut samples = 0;
        while let Some(columns) = survey.next().map_err(error)? {
            (0..columns.samples()).for_each(|k| search.take(&columns, k));
            samples += columns.samples();
        }
        let stretch = search.found();
        stretch.check(FEWEST_ROWS).map_err(error)?;
        let cut = survey.cut.map(|whole| CutOff { whole: whole as usize, unused: (survey.length - whole) as usize });
        let notices = cut.map(|cut| cut.notice(path, samples)).into_iter().chain(stretch.notice(period_s));
        let notices: Vec<String> = notices.collect();
        Ok(RunChunks {
            stream: Stream::open(path)?,
            stretch,
            period_s,
            read: RunColumns::default(),
            before: 0,
            given: 0,
            notice: (!notices.is_empty()).then(|| notices.join("\n")),
            source: path.to_path_buf(),
        })
    }

    /// Names of the signals: every field but the tick.
    pub fn names() -> Vec<String> {
        RunSample::SIGNALS.iter().map(|name| name.to_string()).collect()
    }

    /// Appends up to `most` samples; how many there were. Fewer are there at the end only.
    ///
    /// Errors: those of a file that was changed since it was opened.
    pub fn fill(&mut self, most: usize, rows: &mut Rows) -> Result<usize, Error> {
        let mut count = 0;
        while count < most && self.given < self.stretch.samples.len() {
            let next = self.stretch.samples.start + self.given;
            match self.read.get(next - self.before) {
                Some(sample) => {
                    rows.signals.extend(signal_values(&sample));
                    count += 1;
                    self.given += 1;
                }
                None => {
                    self.before += self.read.samples();
                    let read = self.stream.next().map_err(|fault| Error::new(Tried::Read, &self.source, fault))?;
                    self.read = read.ok_or_else(|| self.changed())?;
                }
            }
        }
        Ok(count)
    }

    fn changed(&self) -> Error {
        let what = "it became shorter while it was read".into();
        Error::new(Tried::Read, &self.source, RunFault::Damaged { byte: self.stream.offset as usize, what }.into())
    }

    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Samples given so far.
    pub fn samples(&self) -> usize {
        self.given
    }

    /// Bytes of the file that were read.
    pub fn bytes_done(&self) -> u64 {
        self.stream.offset
    }

    pub fn notice(&self) -> Option<String> {
        self.notice.clone()
    }
}

/// The samples of a file, as many at a time as stand in one of its chunks.
struct Stream {
    source: BufReader<File>,
    /// Length of the file, and where the next record begins [bytes].
    length: u64,
    offset: u64,
    /// Whether the writer came to the file's end: then nothing may be missing.
    finished: bool,
    /// Where the file was cut off.
    cut: Option<u64>,
    over: bool,
    sum: crc32fast::Hasher,
    record: Vec<u8>,
    content: Content,
    chunks: LinearReader,
}

impl Stream {
    fn open(path: &Path) -> Result<Stream, Error> {
        let io = |error| refused(Tried::Read, path, &error);
        let fault = |fault| Error::new(Tried::Read, path, fault);
        let mut source = BufReader::new(File::open(path).map_err(io)?);
        let length = source.seek(SeekFrom::End(0)).map_err(io)?;
        let header = header(&mut source, length).map_err(io)?.ok_or_else(|| fault(RunFault::Foreign.into()))?;
        let header = RunHeader::of(&header).map_err(fault)?;
        let finished = ends_well(&mut source, length).map_err(io)?;
        source.seek(SeekFrom::Start(MAGIC.len() as u64)).map_err(io)?;
        let mut sum = crc32fast::Hasher::new();
        sum.update(MAGIC);
        Ok(Stream {
            source,
            length,
            offset: MAGIC.len() as u64,
            finished,
            cut: None,
            over: false,
            sum,
            record: Vec::new(),
            content: Content::new(header),
            chunks: LinearReader::new_with_options(options()),
        })
    }

    /// The next samples; nothing at the end, or where the file was cut off.
    ///
    /// Errors: [`RunFault::Damaged`], [`Fault::Io`].
    fn next(&mut self) -> Result<Option<RunColumns>, Fault> {
        while !self.over {
            let io = |error: io::Error| Fault::Io { kind: error.kind() };
            let Some(opcode) =
                next_record(&mut self.source, self.length - self.offset, &mut self.record).map_err(io)?
            else {
                self.over = true;
                if self.finished {
                    let what = "a record longer than the file".into();
                    return Err(RunFault::Damaged { byte: self.offset as usize, what }.into());
                }
                self.cut = Some(self.offset);
                break;
            };
            let sum = self.sum.clone();
            let part = self.content.part(opcode, &self.record, || sum.finalize(), &mut self.chunks);
            if let Err(what) = part {
                self.over = true;
                self.cut_here(opcode, what)?;
                break;
            }
            self.sum.update(&self.record);
            self.offset += self.record.len() as u64;
            self.over = opcode == op::DATA_END;
            if self.over && !self.finished {
                self.cut = Some(self.length);
            }
            if self.content.samples.samples() > 0 {
                return Ok(Some(std::mem::take(&mut self.content.samples)));
            }
        }
        let rest = std::mem::take(&mut self.content.samples);
        Ok((rest.samples() > 0).then_some(rest))
    }

    /// A last chunk that is wrong was cut off; anything else is damage.
    fn cut_here(&mut self, opcode: u8, what: String) -> Result<(), Fault> {
        let byte = self.offset as usize;
        let damaged = RunFault::Damaged { byte, what };
        if self.finished || opcode != op::CHUNK {
            return Err(damaged.into());
        }
        let mut at = self.offset + self.record.len() as u64;
        let io = |error: io::Error| Fault::Io { kind: error.kind() };
        while let Some(opcode) = next_record(&mut self.source, self.length - at, &mut self.record).map_err(io)? {
            if opcode == op::CHUNK {
                return Err(damaged.into());
            }
            at += self.record.len() as u64;
        }
        self.cut = Some(self.offset);
        Ok(())
    }
}

/// The metadata record `flexbeam` of a file; nothing where there is none.
pub(super) fn metadata_of_file(path: &Path) -> io::Result<Option<Metadata>> {
    let mut source = BufReader::new(File::open(path)?);
    let length = source.seek(SeekFrom::End(0))?;
    header(&mut source, length)
}

/// The metadata record `flexbeam`, wherever it is; nothing where there is none, or the file is no MCAP file.
fn header(source: &mut BufReader<File>, length: u64) -> io::Result<Option<Metadata>> {
    let (mut at, mut record) = (MAGIC.len() as u64, vec![0; MAGIC.len()]);
    source.rewind()?;
    if length < at {
        return Ok(None);
    }
    source.read_exact(&mut record)?;
    if record != MAGIC {
        return Ok(None);
    }
    while let Some(opcode) = next_record(source, length.saturating_sub(at), &mut record)? {
        if let Some(metadata) = metadata_in(opcode, &record[RECORD_HEAD..]) {
            return Ok(Some(metadata));
        }
        at += record.len() as u64;
    }
    Ok(None)
}

fn ends_well(source: &mut BufReader<File>, length: u64) -> io::Result<bool> {
    let mut end = [0; MAGIC.len()];
    if length <= 2 * MAGIC.len() as u64 {
        return Ok(false);
    }
    source.seek(SeekFrom::End(-(MAGIC.len() as i64)))?;
    source.read_exact(&mut end)?;
    Ok(end == MAGIC)
}

/// Reads the next record, its head too, and returns its kind; nothing where it is incomplete within the `rest` of the file or, as a
/// disk's untouched blocks are, all zero.
fn next_record(source: &mut impl Read, rest: u64, record: &mut Vec<u8>) -> io::Result<Option<u8>> {
    record.clear();
    if rest < RECORD_HEAD as u64 {
        return Ok(None);
    }
    record.resize(RECORD_HEAD, 0);
    source.read_exact(record)?;
    let length = record[1..].first_chunk().map_or(0, |length| u64::from_le_bytes(*length));
    let fits = length <= (rest - RECORD_HEAD as u64).min(LONGEST_CHUNK as u64);
    if record[0] == 0 || !fits {
        return Ok(None);
    }
    record.resize(RECORD_HEAD + length as usize, 0);
    source.read_exact(&mut record[RECORD_HEAD..])?;
    Ok(Some(record[0]))
}
