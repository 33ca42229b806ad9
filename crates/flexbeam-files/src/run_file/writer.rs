//! A run on its way into a file.

use super::header::RunHeader;
use super::messages::{LiveSettings, RunEvent, json_bytes};
use super::reader::CONTROLLER;
use super::sample::RunSample;
use super::topics::RunTopic;
use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::sync::{Arc, OnceLock};

/// Writes a run as it happens; for the thread that records, not for the loop's.
///
/// What came before a [`RunWriter::flush`] can be read whatever happens afterwards. After the first error nothing more is
/// written, and every further call answers with that error's kind. Dropped without [`RunWriter::finish`], the file is closed
/// properly, without a report.
pub struct RunWriter<W: Write + Seek> {
    writer: Writer<Guard<W>>,
    failed: Failed,
    header: RunHeader,
    signals: u16,
    settings: u16,
    events: u16,
    report: u16,
    last_tick: u64,
}

impl<W: Write + Seek> RunWriter<W> {
    /// Begins the file: header, controller file, topics.
    ///
    /// Errors: the kind with which `w` refused.
    pub fn new(w: W, header: &RunHeader) -> Result<RunWriter<W>, ErrorKind> {
        let failed = Failed::default();
        RunWriter::begun(Guard { inner: w, failed: failed.clone() }, header, &failed).map_err(|error| failed.of(&error))
    }

    fn begun(w: Guard<W>, header: &RunHeader, failed: &Failed) -> Result<RunWriter<W>, McapError> {
        let mut writer = options(header).create(w)?;
        writer.write_metadata(&header.record())?;
        if let Some(controller) = &header.controller {
            writer.attach(&Attachment {
                log_time: header.start_unix_ns,
                create_time: header.start_unix_ns,
                name: CONTROLLER.into(),
                media_type: "application/toml".into(),
                data: controller.as_slice().into(),
            })?;
        }
        Ok(RunWriter {
            signals: channel(&mut writer, &RunTopic::SIGNALS)?,
            settings: channel(&mut writer, &RunTopic::SETTINGS)?,
            events: channel(&mut writer, &RunTopic::EVENTS)?,
            report: channel(&mut writer, &RunTopic::REPORT)?,
            writer,
            failed: failed.clone(),
            header: header.clone(),
            last_tick: 0,
        })
    }

    /// Appends a sample.
    ///
    /// Errors: the kind with which the first failing write was refused; likewise below.
    pub fn sample(&mut self, sample: &RunSample) -> Result<(), ErrorKind> {
        self.message(self.signals, sample.tick, &sample.to_cdr())
    }

    /// Appends settings that are in force from their tick on.
    pub fn settings(&mut self, settings: &LiveSettings) -> Result<(), ErrorKind> {
        self.json(self.settings, settings.tick, settings)
    }

    /// Appends an event.
    pub fn event(&mut self, event: &RunEvent) -> Result<(), ErrorKind> {
        self.json(self.events, event.tick, event)
    }

    /// Ends the chunk and flushes: everything up to here can be read after a power loss.
    pub fn flush(&mut self) -> Result<(), ErrorKind> {
        self.failed.check()?;
        self.writer.flush().map_err(|error| self.failed.of(&error))
    }

    /// Appends the report, at the latest tick that was written, and ends the file.
    pub fn finish(mut self, report: &impl Serialize) -> Result<W, ErrorKind> {
        self.json(self.report, self.last_tick, report)?;
        self.writer.finish().map_err(|error| self.failed.of(&error))?;
        Ok(self.writer.into_inner().inner)
    }

    /// Errors: besides, [`ErrorKind::InvalidData`] for what is no JSON; the file stays as good as it was.
    fn json(&mut self, channel: u16, tick: u64, message: &impl Serialize) -> Result<(), ErrorKind> {
        let bytes = json_bytes(message).map_err(|_| ErrorKind::InvalidData)?;
        self.message(channel, tick, &bytes)
    }

    fn message(&mut self, channel_id: u16, tick: u64, data: &[u8]) -> Result<(), ErrorKind> {
        self.failed.check()?;
        self.last_tick = self.last_tick.max(tick);
        let log_time = self.header.log_time_ns(tick);
        // The counter shows gaps to viewers; its low half does as well as the whole.
        let header = MessageHeader { channel_id, sequence: tick as u32, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, data).map_err(|error| self.failed.of(&error))
    }
}

/// Whole chunks go out at once, so that a file that is cut off holds whole records up to its last one.
fn options(header: &RunHeader) -> WriteOptions {
    WriteOptions::new()
        .compression(Some(Compression::Lz4))
        .disable_seeking(true)
        .library(header.provenance.tool.clone())
}

fn channel<W: Write + Seek>(writer: &mut Writer<W>, topic: &RunTopic) -> Result<u16, McapError> {
    let schema = writer.add_schema(topic.schema_name, topic.schema_encoding, topic.schema.as_bytes())?;
    writer.add_channel(schema, topic.topic, topic.message_encoding, &BTreeMap::new())
}

/// The kind of the first error, if there was one.
#[derive(Clone, Default)]
struct Failed(Arc<OnceLock<ErrorKind>>);

impl Failed {
    fn check(&self) -> Result<(), ErrorKind> {
        self.0.get().map_or(Ok(()), |kind| Err(*kind))
    }

    /// What the stream said, where it was the stream; remembered in any case.
    fn of(&self, error: &McapError) -> ErrorKind {
        let kind = if let McapError::Io(error) = error { error.kind() } else { ErrorKind::Other };
        *self.0.get_or_init(|| kind)
    }
}

/// A stream that takes nothing more after its first error: what the writer does when it is dropped must not mend half a
/// record.
struct Guard<W> {
    inner: W,
    failed: Failed,
}

impl<W> Guard<W> {
    fn guarded<T>(&mut self, act: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        self.failed.check()?;
        let result = act(&mut self.inner);
        if let Err(error) = &result
            && error.kind() != ErrorKind::Interrupted
        {
            self.failed.0.get_or_init(|| error.kind());
        }
        result
    }
}

impl<W: Write> Write for Guard<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.guarded(|w| w.write(bytes))? {
            0 if !bytes.is_empty() => self.guarded(|_| Err(ErrorKind::WriteZero.into())),
            written => Ok(written),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.guarded(W::flush)
    }
}

impl<W: Seek> Seek for Guard<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.guarded(|w| w.seek(to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::provenance::Provenance;
    use std::io::Cursor;

    /// Takes so many bytes, then reports a full disk until there is room again.
    struct Disk {
        bytes: Cursor<Vec<u8>>,
        room: usize,
        full: usize,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.room == 0 {
                self.full += 1;
                return Err(ErrorKind::StorageFull.into());
            }
            let taken = self.bytes.write(&bytes[..bytes.len().min(self.room)])?;
            self.room -= taken;
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Disk {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.bytes.seek(to)
        }
    }

    fn header() -> RunHeader {
        RunHeader {
            period_s: 1e-3,
            start_unix_ns: 1_700_000_000_000_000_000,
            port: "sim".into(),
            provenance: Provenance { tool: "flexbeam test".into(), ..Provenance::default() },
            controller: Some(b"order = 4\n".to_vec()),
            excitation: None,
        }
    }

    fn run(disk: &mut Disk) -> Result<(), ErrorKind> {
        let mut writer = RunWriter::new(disk, &header())?;
        for tick in 0..200 {
            writer.sample(&RunSample { tick, theta_rad: (tick as f64).sin(), ..RunSample::default() })?;
            if tick % 50 == 49 {
                writer.flush()?;
            }
        }
        writer.finish(&()).map(|_| ())
    }

    /// Wherever the disk becomes full: the error's kind, no panic on dropping, and what was flushed is read.
    #[test]
    fn a_full_disk_is_reported_and_what_was_flushed_stays() {
        let disk = |room| Disk { bytes: Cursor::new(Vec::new()), room, full: 0 };
        let mut whole = disk(usize::MAX);
        run(&mut whole).unwrap();
        let length = whole.bytes.get_ref().len();
        for room in (0..length).step_by(37).chain([length - 1]) {
            let mut disk = disk(room);
            assert_eq!(run(&mut disk), Err(ErrorKind::StorageFull), "room for {room} of {length} bytes");
            assert_eq!(disk.full, 1, "asked once, and left alone afterwards");
            let bytes = disk.bytes.into_inner();
            assert_eq!(bytes, whole.bytes.get_ref()[..room], "nothing was mended");
            let flushed = super::super::RunRecording::parse(&bytes, "full.mcap".as_ref());
            if let Ok(read) = flushed {
                assert!(read.samples.samples() % 50 == 0 && read.cut_off.is_some(), "{:?}", read.cut_off);
            } else {
                assert!(room < 2000, "room for {room} bytes holds the header");
            }
        }
    }

    #[test]
    fn after_an_error_every_call_answers_with_it() {
        let mut disk = Disk { bytes: Cursor::new(Vec::new()), room: 20_000, full: 0 };
        let mut writer = RunWriter::new(&mut disk, &header()).unwrap();
        let sample =
            |tick| RunSample { tick, u_v: (tick as f64).cos(), psi_rad: (tick as f64).sin(), ..Default::default() };
        let refused = (0..100_000).find_map(|tick| writer.sample(&sample(tick)).and_then(|()| writer.flush()).err());
        assert_eq!(refused, Some(ErrorKind::StorageFull));
        assert_eq!(writer.sample(&sample(0)), Err(ErrorKind::StorageFull));
        assert_eq!(writer.flush(), Err(ErrorKind::StorageFull));
        let event = RunEvent { tick: 0, time_s: 0.0, kind: "fault".into(), text: String::new() };
        assert_eq!(writer.event(&event), Err(ErrorKind::StorageFull));
        assert_eq!(writer.finish(&()).err(), Some(ErrorKind::StorageFull));
        disk.room = usize::MAX;
        assert_eq!(disk.full, 1);
    }

    /// The thread that records is not the one that opens the file.
    #[test]
    fn a_writer_can_be_handed_to_a_thread() {
        fn handed<T: Send>() {}
        handed::<RunWriter<Cursor<Vec<u8>>>>();
        handed::<crate::RunFile>();
    }

    #[test]
    fn what_is_no_json_does_no_harm() {
        let mut writer = RunWriter::new(Cursor::new(Vec::new()), &header()).unwrap();
        let unsuitable = std::collections::HashMap::from([((1, 2), 3)]);
        assert_eq!(writer.json(writer.report, 0, &unsuitable), Err(ErrorKind::InvalidData));
        assert!(writer.finish(&"done").is_ok());
    }
}
