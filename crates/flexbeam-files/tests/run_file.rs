//! Recordings of runs: every bit comes back, nothing that was flushed is lost, damage is told from a cut.

use flexbeam_files::*;
use std::collections::BTreeSet;
use std::fs;
use std::io::Cursor;
use std::path::Path;

const PERIOD_S: f64 = 0.001;
const FLUSH_TICKS: u64 = 100;

fn header() -> RunHeader {
    let parent =
        |path: &str, schema: &str| Parent { path: path.into(), sha256: "0".repeat(64), schema: Some(schema.into()) };
    RunHeader {
        period_s: PERIOD_S,
        start_unix_ns: 1_764_180_000_123_456_789,
        port: "udp:192.168.1.7:4810".into(),
        provenance: Provenance {
            tool: "flexbeam 0.1.0".into(),
            command: Some("flexbeam run controller.toml".into()),
            time: None,
            parents: vec![
                parent("controller.toml", "flexbeam.controller/1"),
                parent("../rig, the \"long\" one.toml", "flexbeam.rig/1"),
            ],
        },
        controller: Some(b"schema = \"flexbeam.controller/1\"\norder = 4\n".to_vec()),
        excitation: None,
    }
}

/// A sample whose numbers have no pattern; subnormal, infinite and undefined ones among them.
fn sample(tick: u64) -> RunSample {
    let mut state = tick.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    let mut angle = || f64::from_bits(next());
    RunSample {
        tick,
        voltage_v: angle(),
        commanded_v: angle(),
        u_v: if tick.is_multiple_of(7) { f64::NAN } else { -0.0 },
        reference_rad: angle(),
        smoothed_rad: angle(),
        theta_rad: angle(),
        alpha_rad: if tick.is_multiple_of(5) { f64::NEG_INFINITY } else { 5e-324 },
        psi_rad: angle(),
        y_model_rad: angle(),
        error_rad: angle(),
        lateness_ns: next() as u32,
        execution_ns: next() as u32,
        settings: (tick / 150) as u32,
        phase: RunPhase::Running as u8,
        fault: next() as u8,
        stale: 0,
    }
}

fn live(revision: u32, tick: u64) -> LiveSettings {
    let settings =
        Settings { law: Some(Law::Switched), eps_u_v: Some(0.1 + f64::from(revision)), ..Settings::default() };
    let reference = RunReference { shape: RunShape::Square, amplitude_rad: 0.1 + 0.2, period_s: 2.0, offset_rad: 0.0 };
    LiveSettings { revision, tick, settings, reference }
}

fn event(tick: u64, kind: &str) -> RunEvent {
    RunEvent { tick, time_s: tick as f64 * PERIOD_S, kind: kind.into(), text: "β of “a” beam".into() }
}

/// A run of so many ticks, flushed every hundred.
fn run(ticks: u64) -> Vec<u8> {
    let mut writer = RunWriter::new(Cursor::new(Vec::new()), &header()).unwrap();
    writer.event(&event(0, "started")).unwrap();
    for tick in 0..ticks {
        if tick % 150 == 0 {
            writer.settings(&live((tick / 150) as u32, tick)).unwrap();
        }
        writer.sample(&sample(tick)).unwrap();
        if (tick + 1) % FLUSH_TICKS == 0 {
            writer.flush().unwrap();
        }
    }
    writer.event(&event(ticks, "stopped")).unwrap();
    writer.finish(&serde_json::json!({"samples": ticks, "worst_us": 12.5})).unwrap().into_inner()
}

fn parse(bytes: &[u8]) -> Result<RunRecording, Error> {
    RunRecording::parse(bytes, Path::new("run.mcap"))
}

fn bits(samples: &RunColumns) -> Vec<Vec<u64>> {
    let sample = |k| samples.get(k).unwrap().values().map(f64::to_bits).to_vec();
    (0..samples.samples()).map(sample).collect()
}

#[test]
fn every_bit_comes_back() {
    let read = parse(&run(350)).unwrap();
    let mut written = RunColumns::default();
    (0..350).for_each(|tick| written.push(sample(tick)));
    assert_eq!(bits(&read.samples), bits(&written));
    assert_eq!(read.header, header());
    assert_eq!(read.settings, [live(0, 0), live(1, 150), live(2, 300)]);
    assert_eq!(read.events, [event(0, "started"), event(350, "stopped")]);
    assert_eq!(read.report, Some(serde_json::json!({"samples": 350, "worst_us": 12.5})));
    assert_eq!((read.cut_off, read.sha256), (None, sha256_hex(&run(350))));
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    assert_eq!(run(120), run(120));
}

#[test]
fn time_stamps_are_those_of_the_ticks() {
    let header = header();
    for (tick, since_start_ns) in [(0, 0), (1, 1_000_000), (9, 9_000_000), (86_400_000, 86_400_000_000_000)] {
        assert_eq!(header.log_time_ns(tick), header.start_unix_ns + since_start_ns);
    }
    let third = RunHeader { period_s: 1.0 / 3.0, ..header };
    assert_eq!(third.log_time_ns(2) - third.start_unix_ns, 666_666_667);
}

/// Where each chunk begins and ends, found without the reader's help.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut chunks = Vec::new();
    let mut at = mcap::MAGIC.len();
    while at + 9 <= bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        if bytes[at] == mcap::records::op::CHUNK {
            chunks.push((at, at + 9 + length));
        }
        at += 9 + length;
    }
    chunks
}

/// A power loss at any byte: the whole chunks before it are there, and the file says that it was cut off.
#[test]
fn a_file_cut_anywhere_keeps_what_was_flushed() {
    let bytes = run(450);
    let chunks = chunks(&bytes);
    assert_eq!(chunks.len(), 5, "a chunk for each flush, and the rest");
    let all = parse(&bytes).unwrap();
    let borders = chunks.iter().flat_map(|(start, end)| [*start, *end]).flat_map(|at| at - 12..at + 12);
    for cut in (0..bytes.len()).step_by(13).chain(borders) {
        let whole = chunks.iter().filter(|(_, end)| *end <= cut).count();
        let samples = (whole * FLUSH_TICKS as usize).min(450);
        match parse(&bytes[..cut]) {
            Ok(read) => {
                assert_eq!(read.samples.samples(), samples, "cut at {cut}");
                assert_eq!(bits(&read.samples), bits(&all.samples)[..samples]);
                let cut_off = read.cut_off.expect("a cut");
                assert_eq!(cut_off.whole + cut_off.unused, cut);
            }
            Err(error) => {
                assert!(cut < chunks[0].0, "cut at {cut}: {error}");
                assert_ne!(*error.fault, Fault::Io { kind: std::io::ErrorKind::Other });
            }
        }
    }
}

/// What a disk leaves of the last chunk when the length of the file was written before its content.
#[test]
fn a_last_chunk_that_fails_its_check_sum_is_a_cut() {
    let bytes = run(450);
    let (start, end) = chunks(&bytes)[2];
    let mut torn = bytes[..end].to_vec();
    torn[start + 200..].fill(0);
    let read = parse(&torn).unwrap();
    assert_eq!(read.samples.samples(), 200);
    assert_eq!(read.cut_off, Some(CutOff { whole: start, unused: end - start }));
    for k in (start + 100..end).step_by(97) {
        let mut flipped = bytes[..end].to_vec();
        flipped[k] ^= 0x10;
        let read = parse(&flipped).unwrap();
        assert_eq!((read.samples.samples(), read.cut_off.map(|cut| cut.whole)), (200, Some(start)), "byte {k}");
    }
    let zeros = [&bytes[..end], &[0; 4096]].concat();
    let read = parse(&zeros).unwrap();
    assert_eq!((read.samples.samples(), read.cut_off), (300, Some(CutOff { whole: end, unused: 4096 })));
}

/// Any byte changed: an error that names a byte at or before it, or, where the bytes are no part of what is read, the same
/// recording. Never other numbers.
#[test]
fn a_changed_byte_never_passes_for_data() {
    let bytes = run(250);
    let good = parse(&bytes).unwrap();
    let data_end = {
        let mut at = mcap::MAGIC.len();
        while bytes[at] != mcap::records::op::DATA_END {
            at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        }
        at
    };
    let mut offsets = BTreeSet::new();
    for k in (0..bytes.len()).step_by(11).chain(0..2500.min(bytes.len())) {
        let mut damaged = bytes.clone();
        damaged[k] ^= 0x24;
        match parse(&damaged) {
            Ok(read) => {
                assert!(k > data_end, "byte {k} of {data_end}");
                assert_eq!(bits(&read.samples), bits(&good.samples));
            }
            Err(error) => match *error.fault {
                Fault::Run(RunFault::Damaged { byte, .. }) => {
                    offsets.insert(byte);
                }
                Fault::Run(RunFault::Foreign) => assert!(k < 2500, "byte {k}"),
                ref other => assert!(k < 2500, "byte {k}: {other:?}"),
            },
        }
    }
    assert!(offsets.len() > 5, "{offsets:?}");
}

#[test]
fn damage_in_the_middle_of_an_unfinished_file_is_named_by_its_place() {
    let bytes = run(450);
    let (start, end) = chunks(&bytes)[1];
    let mut damaged = bytes[..bytes.len() - 20].to_vec();
    damaged[(start + end) / 2] ^= 1;
    let error = parse(&damaged).unwrap_err();
    let Fault::Run(RunFault::Damaged { byte, .. }) = *error.fault else { panic!("{error}") };
    assert_eq!(byte, start);
    assert!(error.to_string().starts_with(&format!("cannot read run.mcap: found damage at byte {start} (")), "{error}");
}

#[test]
fn an_mcap_file_of_somebody_else() {
    let mut writer = mcap::WriteOptions::new().compression(None).create(Cursor::new(Vec::new())).unwrap();
    let channel = writer.add_channel(0, "/signals", "json", &Default::default()).unwrap();
    let message = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&message, b"{}").unwrap();
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    for error in [parse(&bytes).unwrap_err(), parse(b"time_s,u\n").unwrap_err()] {
        assert_eq!(*error.fault, Fault::Run(RunFault::Foreign), "{error}");
    }
    let error = Recording::parse(&bytes, Path::new("other.dat"), &Layout::default()).unwrap_err();
    let there = "/signals (json, 1 messages)".into();
    assert_eq!(*error.fault, RunFault::NoNumbers { there }.into(), "{error}");
}

#[test]
fn another_version_is_refused_by_its_name() {
    let bytes = run(10);
    let at = bytes.windows(14).position(|window| window == b"flexbeam.run/1").unwrap();
    let mut newer = bytes[..bytes.len() - 9].to_vec();
    newer[at + 13] = b'7';
    let fault = *parse(&newer).unwrap_err().fault;
    assert_eq!(fault, Fault::Schema { found: "flexbeam.run/7".into(), needed: RUN_SCHEMA });
}

/// A run of which only parts are a recording: ticks and freshness by a rule.
fn patchy(describe: impl Fn(u64) -> Option<(RunPhase, bool)>) -> Vec<u8> {
    let mut writer = RunWriter::new(Cursor::new(Vec::new()), &header()).unwrap();
    for tick in 0..100 {
        if let Some((phase, stale)) = describe(tick) {
            let theta_rad = tick as f64;
            let sample = RunSample { tick, theta_rad, phase: phase as u8, stale: stale.into(), ..RunSample::default() };
            writer.sample(&sample).unwrap();
        }
    }
    writer.finish(&()).unwrap().into_inner()
}

fn recording(bytes: &[u8]) -> Result<Recording, Error> {
    Recording::parse(bytes, Path::new("run.dat"), &Layout::default())
}

#[test]
fn the_longest_stretch_without_a_gap_is_the_recording() {
    let bytes = patchy(|tick| match tick {
        0..10 => Some((RunPhase::Armed, false)),
        30 | 31 => None,
        60 => Some((RunPhase::Running, true)),
        90.. => Some((RunPhase::Stopped, false)),
        _ => Some((RunPhase::Running, false)),
    });
    let read = recording(&bytes).unwrap();
    let theta = read.select(&["theta_rad"]).unwrap();
    // Between the stale sample and the stop: ticks 61 to 89, against 10 to 29 and 32 to 59.
    assert_eq!(theta.data.iter().copied().collect::<Vec<_>>(), (61..90).map(f64::from).collect::<Vec<_>>());
    assert_eq!((theta.period_s, read.time_s.as_ref().map(|t| t[0])), (PERIOD_S, Some(0.061)));
    let notice = read.notice.expect("a notice");
    for words in ["of 78 samples", "29 of them", "ticks missing: 2", "stale measurements: 1"] {
        assert!(notice.contains(words), "{words}: {notice}");
    }
}

#[test]
fn a_run_without_gaps_is_taken_whole_and_silently() {
    let read =
        recording(&patchy(|tick| Some((if tick < 5 { RunPhase::Armed } else { RunPhase::Running }, false)))).unwrap();
    assert_eq!((read.signals.samples(), read.notice), (95, None));
    assert_eq!(read.signals.names[..3], ["voltage_v", "commanded_v", "u_v"]);
    assert_eq!(read.signals.units[5], "rad");
}

#[test]
fn too_short_a_stretch_is_refused() {
    let every_third = patchy(|tick| (tick % 3 != 0).then_some((RunPhase::Running, false)));
    let fault = *recording(&every_third).unwrap_err().fault;
    assert_eq!(fault, Fault::Run(RunFault::ShortStretch { found: 2, needed: FEWEST_ROWS }));
    let armed = patchy(|_| Some((RunPhase::Armed, false)));
    let fault = *recording(&armed).unwrap_err().fault;
    assert_eq!(fault, Fault::Run(RunFault::ShortStretch { found: 0, needed: FEWEST_ROWS }));
}

#[test]
fn what_the_user_says_of_a_run_must_agree() {
    let bytes = patchy(|_| Some((RunPhase::Running, false)));
    let with = |columns: Option<Vec<String>>, period_s| {
        Recording::parse(&bytes, Path::new("run.mcap"), &Layout { columns, period_s, resample_s: None })
            .map_err(|error| *error.fault)
    };
    assert_eq!(with(Some(vec!["u".into()]), None), Err(Fault::Run(RunFault::Named)));
    assert_eq!(with(None, Some(0.0010001)).unwrap().signals.period_s, 0.0010001);
    assert!(matches!(with(None, Some(0.002)), Err(Fault::PeriodsDiffer { .. })));
    assert_eq!(with(None, Some(-1.0)), Err(Fault::Period { period_s: -1.0 }));
}

fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn file_with(path: &Path, ticks: u64, overwrite: Overwrite) -> Result<Written, Error> {
    let mut file = RunFile::create(path, overwrite, &header())?;
    file.settings(&live(0, 0))?;
    (0..ticks).try_for_each(|tick| file.sample(&sample(tick)))?;
    file.event(&event(ticks, "stopped"))?;
    file.flush()?;
    file.finish(&())
}

#[test]
fn a_run_has_its_name_when_it_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut file = RunFile::create(&path, Overwrite::Refuse, &header()).unwrap();
    let begun = RunRecording::read(&RunFile::part_path(&path)).unwrap();
    assert_eq!((begun.header, begun.samples.samples()), (header(), 0));
    (0..50).for_each(|tick| file.sample(&sample(tick)).unwrap());
    file.flush().unwrap();
    assert_eq!(names(folder.path()), ["run.mcap.part".to_string()].into());
    let part = RunRecording::read(&RunFile::part_path(&path)).unwrap();
    assert_eq!(part.samples.samples(), 50, "as after a power loss");
    assert!(part.cut_off.is_some());
    assert_eq!(file.finish(&()).unwrap(), Written::New);
    assert_eq!(names(folder.path()), ["run.mcap".to_string()].into());
    assert_eq!(RunRecording::read(&path).unwrap().cut_off, None);
}

#[test]
fn a_part_that_stands_there_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let part = RunFile::part_path(&path);
    fs::write(&part, &run(200)[..3000]).unwrap();
    for overwrite in [Overwrite::Refuse, Overwrite::SameKind, Overwrite::Allow] {
        let error = file_with(&path, 10, overwrite).unwrap_err();
        assert_eq!(*error.fault, Fault::Run(RunFault::Unfinished { part: part.clone() }), "{error}");
    }
    assert_eq!(fs::read(&part).unwrap(), &run(200)[..3000]);
    // Two at a time: the second one is told of the first.
    fs::remove_file(&part).unwrap();
    let first = RunFile::create(&path, Overwrite::SameKind, &header()).unwrap();
    assert!(RunFile::create(&path, Overwrite::Allow, &header()).is_err());
    first.discard().unwrap();
    assert_eq!(names(folder.path()), BTreeSet::new());
}

#[test]
fn a_run_may_replace_a_run_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    assert_eq!(file_with(&path, 10, Overwrite::SameKind).unwrap(), Written::New);
    assert_eq!(file_with(&path, 20, Overwrite::SameKind).unwrap(), Written::Replaced);
    assert_eq!(RunRecording::read(&path).unwrap().samples.samples(), 20);
    assert_eq!(*file_with(&path, 30, Overwrite::Refuse).unwrap_err().fault, Fault::Exists);
    // Neither the other way round: a table does not take the place of the run that it was made from.
    assert_eq!(*check_free(&path, Overwrite::SameKind).unwrap_err().fault, Fault::Exists);
    for other in ["buy milk\n", "time_s,u\n0,1\n", "schema = \"flexbeam.model/1\"\n"] {
        fs::write(&path, other).unwrap();
        assert_eq!(*file_with(&path, 30, Overwrite::SameKind).unwrap_err().fault, Fault::Exists, "{other}");
        assert_eq!(fs::read_to_string(&path).unwrap(), other);
    }
    assert_eq!(file_with(&path, 40, Overwrite::Allow).unwrap(), Written::Replaced);
    assert_eq!(names(folder.path()), ["run.mcap".to_string()].into());
}

/// A file that came to stand there while the run went on is not lost, and neither is the run.
#[test]
fn a_name_that_was_taken_meanwhile_leaves_both() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    for overwrite in [Overwrite::Refuse, Overwrite::SameKind] {
        let mut file = RunFile::create(&path, overwrite, &header()).unwrap();
        file.sample(&sample(0)).unwrap();
        fs::write(&path, "buy milk\n").unwrap();
        assert_eq!(*file.finish(&()).unwrap_err().fault, Fault::Exists);
        assert_eq!(fs::read_to_string(&path).unwrap(), "buy milk\n");
        let part = RunFile::part_path(&path);
        assert_eq!(RunRecording::read(&part).unwrap().cut_off, None, "complete, under its other name");
        fs::remove_file(part).unwrap();
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_folder_that_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let error = RunFile::create(&folder.path().join("no/run.mcap"), Overwrite::Allow, &header()).err().unwrap();
    assert_eq!(*error.fault, Fault::NoFolder);
    assert_eq!(*RunFile::create(folder.path(), Overwrite::Allow, &header()).err().unwrap().fault, Fault::IsFolder);
}

/// A program that ends without finishing leaves a part that is complete but for its report.
#[test]
fn a_writer_that_is_dropped_closes_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut file = RunFile::create(&path, Overwrite::Refuse, &header()).unwrap();
    file.sample(&sample(0)).unwrap();
    drop(file);
    let read = RunRecording::read(&RunFile::part_path(&path)).unwrap();
    assert_eq!((read.samples.samples(), read.cut_off, read.report), (1, None, None));
}

/// model <- run.mcap <- controller and rig: the walk goes through the run's metadata.
#[test]
fn a_walk_goes_through_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, controller, run] =
        ["rig.toml", "controllers/c.toml", "runs/run.mcap"].map(|name| folder.path().join(name));
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::create_dir(folder.path().join("controllers")).unwrap();
    Rig::default().write(&rig, Overwrite::Refuse).unwrap();
    fs::write(&controller, "schema = \"flexbeam.controller/1\"\n").unwrap();
    let mut header = header();
    header.provenance.parents = [&controller, &rig].map(|path| Parent::of(path, &run).unwrap()).into();
    RunFile::create(&run, Overwrite::Refuse, &header).unwrap().finish(&()).unwrap();
    assert_eq!(schema_of(&run).unwrap().as_deref(), Some(RUN_SCHEMA));
    let parent = Parent::of(&run, &folder.path().join("model.toml")).unwrap();
    assert_eq!((parent.path.as_str(), parent.schema.as_deref()), ("runs/run.mcap", Some(RUN_SCHEMA)));
    let steps = trace(&run).unwrap();
    let found: Vec<_> = steps.iter().map(|step| (step.generation, step.schema.as_deref(), step.state)).collect();
    assert_eq!(
        found,
        [
            (0, Some(RUN_SCHEMA), State::Start),
            (1, Some("flexbeam.controller/1"), State::Same),
            (1, Some("flexbeam.rig/1"), State::Same),
        ]
    );
    assert_eq!(steps[0].command.as_deref(), Some("flexbeam run controller.toml"));
}

/// In chunks, from the disk: the stretch, its numbers and what is said are those of the whole reader, wherever the file was cut off.
#[test]
fn chunks_of_a_run_are_the_whole_reader_s() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = RunWriter::new(Cursor::new(Vec::new()), &header()).unwrap();
    for tick in (0..900).filter(|tick| *tick != 333) {
        let finite = RunSample { u_v: 1.0, alpha_rad: 0.5, ..sample(tick) };
        let phase = if tick < 20 { RunPhase::Armed } else { RunPhase::Running } as u8;
        writer.sample(&RunSample { phase, stale: u8::from(tick == 700), ..finite }).unwrap();
        if (tick + 1) % FLUSH_TICKS == 0 {
            writer.flush().unwrap();
        }
    }
    let bytes = writer.finish(&serde_json::json!({})).unwrap().into_inner();
    let chunked = |layout: &Layout| -> Result<_, Error> {
        let mut chunks = Chunks::open(&path, layout)?.of_width(64);
        let mut data = Vec::new();
        for chunk in chunks.by_ref() {
            data.extend(chunk?.iter().map(|x| x.to_bits()));
        }
        Ok((chunks.names().to_vec(), data, chunks.period_s(), chunks.notice()))
    };
    let mut read = 0;
    let wrong = [&bytes[..bytes.len() / 2], &[1], &bytes[bytes.len() / 2 + 1..]].concat();
    let cuts = (0..bytes.len()).step_by(331).chain([bytes.len() - 1, bytes.len()]);
    for file in cuts.map(|cut| &bytes[..cut]).chain([&wrong[..]]).filter(|file| file.len() > 8) {
        fs::write(&path, file).unwrap();
        let whole = Recording::parse(file, &path, &Layout::default()).map(|recording| {
            let bits: Vec<u64> = recording.signals.data.iter().map(|x| x.to_bits()).collect();
            (recording.signals.names, bits, Some(recording.signals.period_s), recording.notice)
        });
        read += usize::from(whole.is_ok());
        assert_eq!(chunked(&Layout::default()), whole, "{} bytes", file.len());
    }
    assert!(read > 20, "{read}");
    fs::write(&path, &bytes).unwrap();
    assert_eq!(chunked(&Layout::default()).unwrap().1.len(), (700 - 334) * RunSample::SIGNALS.len());
    let fault = |layout| *chunked(&layout).unwrap_err().fault;
    assert_eq!(fault(Layout { columns: Some(vec!["u".into()]), ..Layout::default() }), RunFault::Named.into());
    assert_eq!(fault(Layout { resample_s: Some(1e-3), ..Layout::default() }), RunFault::OnTime.into());
    let expected = Fault::PeriodsDiffer { in_file_s: 0.001, given_s: 0.002, tolerance: PERIOD_TOLERANCE };
    assert_eq!(fault(Layout { period_s: Some(0.002), ..Layout::default() }), expected);
}
