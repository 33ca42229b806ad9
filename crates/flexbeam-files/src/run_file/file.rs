//! A run's file on disk: written beside its place, renamed when it is complete.

use super::fault::RunFault;
use super::header::RunHeader;
use super::messages::{LiveSettings, RunEvent};
use super::sample::RunSample;
use super::writer::RunWriter;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::write::{Overwrite, Written, check_free_for_run, rename_run};
use serde::Serialize;
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A recording of a run that is being written to `NAME.mcap.part` and becomes `NAME.mcap` at [`RunFile::finish`].
///
/// After a power loss the part stays and can be read. A part that stands there already is never written over, `--force` or
/// not: it is all that is left of another run, or another program is writing it.
pub struct RunFile {
    writer: RunWriter<Durable>,
    path: PathBuf,
    overwrite: Overwrite,
}

impl RunFile {
    /// Where the run at `path` is written until it is complete.
    pub fn part_path(path: &Path) -> PathBuf {
        let mut part = path.as_os_str().to_os_string();
        part.push(".part");
        part.into()
    }

    /// Whether a run could be recorded at `path`: ask before a rig moves.
    ///
    /// Errors: those of [`RunFile::create`] that can be known before.
    pub fn check_free(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
        check_free_for_run(path, overwrite)?;
        let part = RunFile::part_path(path);
        match part.exists() {
            true => Err(Error::new(Tried::Write, path, RunFault::Unfinished { part }.into())),
            false => Ok(()),
        }
    }

    /// Begins the file.
    ///
    /// Errors: [`Fault::Exists`] when `overwrite` refuses what stands at `path`; [`Fault::Run`] with [`RunFault::Unfinished`]
    /// when a part stands there; [`Fault::IsFolder`]; [`Fault::NoFolder`]; [`Fault::Io`].
    pub fn create(path: &Path, overwrite: Overwrite, header: &RunHeader) -> Result<RunFile, Error> {
        check_free_for_run(path, overwrite)?;
        let part = RunFile::part_path(path);
        let refused = |kind: ErrorKind| {
            let fault = match kind {
                ErrorKind::AlreadyExists => RunFault::Unfinished { part: part.clone() }.into(),
                ErrorKind::NotFound => Fault::NoFolder,
                kind => Fault::Io { kind },
            };
            Error::new(Tried::Write, path, fault)
        };
        let file = File::create_new(&part).map_err(|error| refused(error.kind()))?;
        let begun = RunWriter::new(Durable(BufWriter::new(file)), header).and_then(|mut writer| {
            // A part says what it is from the beginning, and a full disk shows before the run.
            writer.flush()?;
            Ok(writer)
        });
        let begun = begun.inspect_err(|_| {
            // Nothing of the run is in it yet.
            let _ = fs::remove_file(&part);
        });
        Ok(RunFile { writer: begun.map_err(refused)?, path: path.to_path_buf(), overwrite })
    }

    /// Appends a sample.
    ///
    /// Errors: [`Fault::Io`], of the first write that failed; likewise below.
    pub fn sample(&mut self, sample: &RunSample) -> Result<(), Error> {
        self.writer.sample(sample).map_err(|kind| refused(&self.path, kind))
    }

    /// Appends settings that are in force from their tick on.
    pub fn settings(&mut self, settings: &LiveSettings) -> Result<(), Error> {
        self.writer.settings(settings).map_err(|kind| refused(&self.path, kind))
    }

    /// Appends an event.
    pub fn event(&mut self, event: &RunEvent) -> Result<(), Error> {
        self.writer.event(event).map_err(|kind| refused(&self.path, kind))
    }

    /// Everything up to here goes to the disk itself, which may take tens of milliseconds.
    pub fn flush(&mut self) -> Result<(), Error> {
        self.writer.flush().map_err(|kind| refused(&self.path, kind))
    }

    /// Ends the file with a report and gives it its name.
    ///
    /// Errors: besides, [`Fault::Exists`] when a file has come to stand at the path meanwhile that may not be replaced. The
    /// part then stays.
    pub fn finish(self, report: &impl Serialize) -> Result<Written, Error> {
        let RunFile { writer, path, overwrite } = self;
        let part = RunFile::part_path(&path);
        // Closed before it is renamed, as some systems demand.
        drop(writer.finish(report).map_err(|kind| refused(&path, kind))?);
        rename_run(&part, &path, overwrite)
    }

    /// Takes the part away: nothing in it is worth keeping, as when the run never began.
    ///
    /// Errors: [`Fault::Io`].
    pub fn discard(self) -> Result<(), Error> {
        let RunFile { writer, path, .. } = self;
        drop(writer);
        fs::remove_file(RunFile::part_path(&path)).map_err(|error| refused(&path, error.kind()))
    }
}

fn refused(path: &Path, kind: ErrorKind) -> Error {
    Error::new(Tried::Write, path, Fault::Io { kind })
}

/// A file whose flush reaches the disk.
struct Durable(BufWriter<File>);

impl Write for Durable {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()?;
        self.0.get_ref().sync_data()
    }
}

impl Seek for Durable {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }

    /// Without the flush that seeking takes.
    fn stream_position(&mut self) -> io::Result<u64> {
        self.0.stream_position()
    }
}
