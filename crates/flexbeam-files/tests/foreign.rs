//! MCAP files of other programs: numbers in JSON are read, anything else is refused with what is there.

use flexbeam_files::{Chunks, Error, Fault, Layout, Recording, RunFault};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

/// Messages on a topic: encoding, and time [ns] and bytes of each.
type Topic<'a> = (&'a str, &'a str, Vec<(u64, String)>);

fn file(topics: &[Topic]) -> Vec<u8> {
    let mut writer = WriteOptions::new().compression(Some(Compression::Lz4)).create(Cursor::new(Vec::new())).unwrap();
    for (topic, encoding, messages) in topics {
        let channel = writer.add_channel(0, topic, encoding, &BTreeMap::new()).unwrap();
        for (k, (time, data)) in messages.iter().enumerate() {
            let header =
                MessageHeader { channel_id: channel, sequence: k as u32, log_time: *time, publish_time: *time };
            writer.write_to_known_channel(&header, data.as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn parse(bytes: &[u8], layout: &Layout) -> Result<Recording, Error> {
    Recording::parse(bytes, Path::new("foreign.mcap"), layout)
}

/// Ten messages 2 ms apart.
fn messages(data: impl Fn(u64) -> String) -> Vec<(u64, String)> {
    (0..10).map(|k| (1_764_180_000_000_000_000 + 2_000_000 * k, data(k))).collect()
}

fn state(k: u64) -> String {
    format!("{{\"u\":{k}.5,\"name\":\"rig\",\"pose\":{{\"theta\":-{k},\"force\":[1,{k}e-3]}},\"on\":true,\"a.b\":1}}")
}

#[test]
fn numbers_in_json_are_columns() {
    let talk = ("/talk", "json", messages(|_| "{\"text\":\"hi\"}".into()));
    let bytes = file(&[("/state", "json", messages(state)), talk, ("/image", "cdr", messages(|_| "xyz".into()))]);
    let read = parse(&bytes, &Layout::default()).unwrap();
    assert_eq!(read.signals.names, ["pose.force.0", "pose.force.1", "pose.theta", "u"]);
    assert_eq!((read.signals.period_s, read.signals.samples()), (0.002, 10));
    assert_eq!(read.signals.data.column(3).as_slice(), [1.0, 3e-3, -3.0, 3.5]);
    assert!(read.notice.unwrap().contains("messages of /state; time axis the time at which each was logged"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("foreign.mcap");
    std::fs::write(&path, &bytes).unwrap();
    let chunks: Vec<_> = Chunks::open(&path, &Layout::default()).unwrap().of_width(4).map(Result::unwrap).collect();
    assert_eq!(chunks.iter().map(|chunk| chunk.ncols()).collect::<Vec<_>>(), [4, 4, 2]);
    assert_eq!(chunks[1].column(1), read.signals.data.column(5));
}

#[test]
fn a_time_of_its_own_counts_before_the_log_s() {
    let own = file(&[("/s", "json", messages(|k| format!("{{\"time_ms\":{},\"u\":{k}}}", 5 * k)))]);
    let read = parse(&own, &Layout::default()).unwrap();
    assert_eq!((read.signals.period_s, read.signals.names.join(" ")), (0.005, "u".into()));
}

#[test]
fn what_cannot_be_read_is_named() {
    let fault = |bytes: &[u8]| *parse(bytes, &Layout::default()).unwrap_err().fault;
    let there = |there: &str| there.to_string();
    let cdr = file(&[("/imu", "cdr", messages(|_| "xyz".into())), ("/p", "protobuf", messages(|_| "x".into()))]);
    let none = RunFault::NoNumbers { there: there("/imu (cdr, 10 messages), /p (protobuf, 10 messages)") };
    assert_eq!(fault(&cdr), none.into());
    assert_eq!(fault(&file(&[])), RunFault::NoNumbers { there: there("no messages") }.into());
    let two = file(&[("/a", "json", messages(state)), ("/b", "json", messages(state))]);
    assert_eq!(fault(&two), RunFault::Topics { there: there("/a (json, 10 messages), /b (json, 10 messages)") }.into());
    let missing =
        file(&[("/a", "json", messages(|k| if k == 6 { "{\"u\":null}".into() } else { format!("{{\"u\":{k}}}") }))]);
    let error = parse(&missing, &Layout::default()).unwrap_err();
    assert_eq!((*error.fault, error.place.line), (Fault::MissingValue { name: "u".into() }, Some(7)));
    let broken =
        file(&[("/a", "json", messages(|k| if k == 3 { "{\"u\":".into() } else { format!("{{\"u\":{k}}}") }))]);
    let error = parse(&broken, &Layout::default()).unwrap_err();
    assert!(matches!((&*error.fault, error.place.line), (Fault::NotANumber { .. }, Some(4))), "{error}");
    let mut late = messages(|k| format!("{{\"u\":{k}}}"));
    late[5].0 += 500_000;
    let error = parse(&file(&[("/a", "json", late.clone())]), &Layout::default()).unwrap_err();
    assert!(error.to_string().contains("2 of 9 steps are off") && error.place.line == Some(6), "{error}");
    let resampled =
        parse(&file(&[("/a", "json", late)]), &Layout { resample_s: Some(0.002), ..Layout::default() }).unwrap();
    assert_eq!((resampled.signals.samples(), resampled.signals.period_s), (10, 0.002));
    assert!(resampled.notice.unwrap().contains("resampled to 10 samples every 0.002 s"));
    let bytes = file(&[("/a", "json", messages(state))]);
    assert!(matches!(fault(&bytes[..bytes.len() / 2]), Fault::Run(RunFault::Unreadable { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, rng_seed: prop::test_runner::RngSeed::Fixed(4), ..Default::default() })]

    #[test]
    fn a_file_with_bytes_changed_is_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
    ) {
        let mut bytes = file(&[("/a", "json", messages(state))]);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Err(error) = parse(&bytes, &Layout::default()) {
            prop_assert!(error.to_string().starts_with("cannot read foreign.mcap"), "{}", error);
        }
    }
}
