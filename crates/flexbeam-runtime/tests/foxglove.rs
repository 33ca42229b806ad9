//! Viewers over the Foxglove protocol, by a client that is not theirs: what they see is what the recording holds, what they may
//! change is what the run permits, and nothing that they do disturbs it.

mod scripted;
#[path = "support/viewer.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod viewer;

use flexbeam_files::{
    LiveSettings, Overwrite, RunEvent, RunFile, RunHeader, RunRecording, RunSample, RunTopic, SettingValue,
};
use flexbeam_runtime::foxglove::{NoViewers, ViewerOptions, Viewers, ViewersMay};
use flexbeam_runtime::{Latest, Live, RunContext, RunSink, Sample, Session, Setup, SimulatedBackEnd, Sink, Steering};
use scripted::{Ear, open_loop, simulated};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use tungstenite::Message;
use viewer::{Said, Viewer, handshake};

const PERIOD_S: f64 = 1e-3;

fn header() -> RunHeader {
    RunHeader {
        period_s: PERIOD_S,
        start_unix_ns: 1_764_000_000_123_456_789,
        port: "simulated".into(),
        provenance: Default::default(),
        controller: None,
        excitation: None,
    }
}

fn viewers(may: ViewersMay) -> Viewers {
    Viewers::open(&"0".parse().unwrap(), ViewerOptions { may, ..ViewerOptions::default() }).unwrap()
}

/// A run of the simulated rig in real time, armed at 0 V, that viewers look at.
struct Run {
    session: Session,
    viewers: Viewers,
    ear: Ear,
}

impl Run {
    fn armed(may: ViewersMay) -> Run {
        Run::recorded(may, None)
    }

    fn recorded(may: ViewersMay, path: Option<&Path>) -> Run {
        let (viewers, ear) = (viewers(may), Ear::default());
        let mut sinks: Vec<Box<dyn Sink>> = vec![Box::new(ear.clone()), Box::new(viewers.sink(&header()))];
        if let Some(path) = path {
            let context = RunContext { port: "simulated".into(), period_s: PERIOD_S };
            let file = RunFile::create(path, Overwrite::SameKind, &header()).unwrap();
            sinks.insert(0, Box::new(RunSink::new(file, path, context)));
        }
        // No stall of this machine is to end the run.
        let setup = Setup { hold_s: 60.0, autostart: false, ..open_loop(0.5) };
        let rig = SimulatedBackEnd::new(simulated(1)).unwrap();
        let session = Session::arm(Box::new(rig), setup, sinks).unwrap();
        let (controls, live) = (session.controls.clone(), session.live.clone());
        let steering = Steering { controls, live, latest: Latest::default(), period_s: PERIOD_S };
        viewers.steer(steering, session.notes());
        Run { session, viewers, ear }
    }

    fn viewer(&self) -> Viewer {
        Viewer::connect(&self.viewers.address().to_string())
    }

    fn live(&self) -> Live {
        self.session.live.current()
    }

    /// Warnings that came until the end.
    fn end(self) -> Vec<String> {
        self.session.controls.stop();
        self.session.finish();
        let heard = self.ear.0.lock().unwrap();
        heard.events.iter().filter(|event| event.kind.name() == "warning").map(|event| event.text.clone()).collect()
    }
}

#[test]
fn the_protocol_s_version_is_agreed_on_or_refused() {
    let viewers = viewers(ViewersMay::Look);
    let address = viewers.address().to_string();
    for (offered, chosen) in [
        ("foxglove.sdk.v1", "foxglove.sdk.v1"),
        ("foxglove.websocket.v1,foxglove.sdk.v1", "foxglove.sdk.v1"),
        ("foxglove.sdk.v1,foxglove.sdk.v1.1", "foxglove.sdk.v1.1"),
    ] {
        let mut viewer = Viewer::offering(&address, offered);
        assert_eq!(viewer.subprotocol, chosen);
        let info = viewer.text("serverInfo");
        assert_eq!(
            (&info["name"], &info["capabilities"]),
            (&json!("flexbeam"), &json!(["parameters", "parametersSubscribe"]))
        );
    }
    for offered in ["", "foxglove.websocket.v1", "foxglove.sdk.v10"] {
        let refused = handshake(&address, offered).map(drop).unwrap_err();
        assert!(refused.contains("400"), "{refused}");
    }
}

#[test]
fn topics_are_advertised_as_a_recording_declares_them() {
    let viewers = viewers(ViewersMay::Look);
    let mut viewer = Viewer::connect(&viewers.address().to_string());
    let advertised = viewer.subscribe(&[]);
    let channels = advertised["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 3);
    for topic in [RunTopic::SIGNALS, RunTopic::SETTINGS, RunTopic::EVENTS] {
        let found = channels.iter().find(|channel| channel["topic"] == topic.topic).unwrap();
        for (key, text) in [
            ("encoding", topic.message_encoding),
            ("schemaName", topic.schema_name),
            ("schemaEncoding", topic.schema_encoding),
            ("schema", topic.schema),
        ] {
            assert_eq!(found[key], text, "{}", topic.topic);
        }
    }
}

/// What came on `/signals`, `/settings` and `/events`, each with its time.
#[derive(Default)]
struct Seen {
    signals: Vec<(u64, Vec<u8>)>,
    settings: Vec<(u64, LiveSettings)>,
    events: Vec<(u64, RunEvent)>,
}

impl Seen {
    fn take(&mut self, said: Said) {
        let Said::Data { subscription, log_time_ns, payload } = said else { return };
        match subscription {
            1 => self.signals.push((log_time_ns, payload)),
            2 => self.settings.push((log_time_ns, serde_json::from_slice(&payload).unwrap())),
            _ => self.events.push((log_time_ns, serde_json::from_slice(&payload).unwrap())),
        }
    }

    fn is_over(&self) -> bool {
        self.events.last().is_some_and(|(_, event)| event.kind == "stopped")
    }
}

#[test]
fn what_viewers_see_is_what_the_recording_holds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let run = Run::recorded(ViewersMay::Look, Some(&path));
    let mut viewer = run.viewer();
    viewer.subscribe(&["/signals", "/settings", "/events"]);
    let (controls, live) = (run.session.controls.clone(), run.session.live.clone());
    let Run { session, viewers, .. } = run;
    let finished = std::thread::spawn(move || session.finish());
    let mut seen = Seen::default();
    while !seen.is_over() {
        seen.take(viewer.next());
        match seen.signals.len() {
            20 => controls.start(),
            200 => drop(live.change(|live| live.reference.amplitude_rad = 0.25).unwrap()),
            400 => controls.stop(),
            _ => {}
        }
    }
    finished.join().unwrap();
    drop(viewers);
    let Seen { signals, mut settings, mut events } = seen;

    let recorded = RunRecording::read(&path).unwrap();
    let first = RunSample::from_cdr(&signals[0].1).unwrap().tick;
    let rows = (0..recorded.samples.samples()).map(|k| recorded.samples.get(k).unwrap());
    let wanted: Vec<_> = rows
        .filter(|sample| sample.tick >= first)
        .map(|sample| (recorded.header.log_time_ns(sample.tick), sample.to_cdr().to_vec()))
        .collect();
    assert!(signals == wanted, "{} of {} samples, to the last bit", signals.len(), wanted.len());
    assert!(signals.len() > 400);
    settings.dedup();
    events.dedup();
    let timed = |tick: u64| recorded.header.log_time_ns(tick);
    assert_eq!(settings, recorded.settings.iter().map(|s| (timed(s.tick), s.clone())).collect::<Vec<_>>());
    assert_eq!(settings.last().unwrap().1.reference.amplitude_rad, 0.25);
    assert_eq!(events, recorded.events.iter().map(|e| (timed(e.tick), e.clone())).collect::<Vec<_>>());
    let kinds: Vec<&str> =
        events.iter().map(|(_, event)| event.kind.as_str()).filter(|kind| *kind != "warning").collect();
    assert_eq!(kinds, ["armed", "started", "stopped"]);
}

fn as_parameters(live: &LiveSettings) -> BTreeMap<String, Value> {
    let value = |value| match value {
        SettingValue::Number(number) => json!(number),
        SettingValue::Word(word) => json!(word),
    };
    live.by_key().into_iter().map(|(key, found)| (key, value(found))).collect()
}

/// By name.
fn pairs(parameters: &Value) -> BTreeMap<String, Value> {
    let list = parameters.as_array().unwrap();
    list.iter().map(|p| (p["name"].as_str().unwrap().to_string(), p["value"].clone())).collect()
}

#[test]
fn every_live_setting_is_a_parameter() {
    let run = Run::armed(ViewersMay::Look);
    let mut viewer = run.viewer();
    viewer.subscribe(&["/settings"]);
    let told: LiveSettings = viewer.wait_for("settings", |said| match said {
        Said::Data { payload, .. } => Some(serde_json::from_slice(payload).unwrap()),
        _ => None,
    });
    let all = viewer.ask(json!({ "op": "getParameters", "parameterNames": [] }));
    assert_eq!(pairs(&all), as_parameters(&told));
    assert_eq!((pairs(&all)["reference.shape"].as_str(), pairs(&all).len()), (Some("step"), 22));
    let whole = all.as_array().unwrap().iter().find(|p| p["name"] == "theta.scale").unwrap();
    assert_eq!(*whole, json!({ "name": "theta.scale", "type": "float64", "value": 1.0 }));
    let some = viewer.ask(json!({ "op": "getParameters", "parameterNames": ["eps_u_v", "unknown"] }));
    assert_eq!(pairs(&some), BTreeMap::from([("eps_u_v".into(), json!(run.live().settings.eps_u_v))]));
    run.end();
}

#[test]
fn a_viewer_that_may_changes_settings_and_the_others_hear_of_it() {
    let run = Run::armed(ViewersMay::Set);
    let (mut one, mut other) = (run.viewer(), run.viewer());
    other.send(&json!({ "op": "subscribeParameterUpdates", "parameterNames": ["eps_u_v", "reference.shape"] }));
    other.ask(json!({ "op": "getParameters", "parameterNames": ["eps_u_v"] }));
    let awkward: f64 = 0.1 + 0.2;
    assert_eq!(one.set("eps_u_v", json!(awkward)).as_f64().map(f64::to_bits), Some(awkward.to_bits()));
    assert_eq!(run.live().settings.eps_u_v.to_bits(), awkward.to_bits());
    let heard = |viewer: &mut Viewer, name: &str, value: &Value| {
        viewer.wait_for("an update", |said| match said {
            Said::Text(text) if text["op"] == "parameterValues" => {
                let pairs = pairs(&text["parameters"]);
                assert!(pairs.keys().all(|name| name == "eps_u_v" || name == "reference.shape"));
                (pairs.get(name) == Some(value)).then_some(())
            }
            _ => None,
        });
    };
    heard(&mut other, "eps_u_v", &json!(awkward));
    // Together they make sense, one by one they would not: a sine needs a period.
    run.session.live.change(|live| live.reference.period_s = 0.0).unwrap();
    assert_eq!(one.set("reference.shape", json!("sine")), json!("step"));
    let both = json!({ "op": "setParameters", "parameters": [
        { "name": "reference.shape", "value": "sine" }, { "name": "reference.period_s", "value": 2 }] });
    let now = [("reference.shape".into(), json!("sine")), ("reference.period_s".into(), json!(2.0))];
    assert_eq!(pairs(&one.ask(both)), BTreeMap::from(now));
    heard(&mut other, "reference.shape", &json!("sine"));
    // From elsewhere, as over the control socket.
    run.session.live.change(|live| live.settings.eps_u_v = 0.007).unwrap();
    heard(&mut other, "eps_u_v", &json!(0.007));
    assert_eq!(run.live().revision, 4);
    assert_eq!(run.end().iter().filter(|text| text.contains("viewer")).count(), 1);
}

#[test]
fn a_refused_change_leaves_the_old_value_and_a_trace() {
    let run = Run::armed(ViewersMay::Set);
    let mut viewer = run.viewer();
    let before = run.live();
    let refusals = [
        ("eps_u_v", json!(-1.0), json!(before.settings.eps_u_v), "senseless eps_u_v"),
        ("theta.offset_rad", json!(0.1), json!(0.0), "found at homing"),
        ("law", json!("cosine"), json!("inverse"), "cosine"),
        ("law", json!(3), json!("inverse"), "law"),
        ("eps_u_v", json!("many"), json!(before.settings.eps_u_v), "many"),
        ("eps_u_v", json!([0.1]), json!(before.settings.eps_u_v), "eps_u_v"),
        ("eps_u_v", json!({ "deeper": 1 }), json!(before.settings.eps_u_v), "eps_u_v"),
        ("eps_u_v.deeper", json!(1), Value::Null, "eps_u_v"),
        ("reference", json!("sine"), Value::Null, "sine"),
        ("reference.delay_s", json!(1), Value::Null, "delay_s"),
        ("epsilon", json!(1), Value::Null, "epsilon"),
        ("eps_u_v=0.1,law", json!("none"), Value::Null, "eps_u_v=0.1"),
    ];
    for (name, value, old, named) in &refusals {
        assert_eq!(viewer.set(name, value.clone()), *old, "{name}");
        let status = viewer.text("status");
        assert_eq!(status["level"], 1, "a warning");
        let words = status["message"].as_str().unwrap();
        assert!(words.contains(named) && words.contains("\nhint: "), "{words}");
    }
    assert_eq!(run.live(), before);
    // All or nothing.
    let half = json!({ "op": "setParameters", "parameters": [
        { "name": "u_p_plus_v", "value": 0.125 }, { "name": "eps_u_v", "value": -1.0 }] });
    assert_eq!(pairs(&viewer.ask(half))["u_p_plus_v"], json!(before.settings.u_p_plus_v));
    assert_eq!(run.live(), before);
    let warnings = run.end();
    let traces = warnings.iter().filter(|text| text.starts_with("a viewer's change was refused: ")).count();
    assert_eq!(traces, refusals.len() + 1, "{warnings:?}");
}

#[test]
fn viewers_may_not_change_anything_unless_somebody_says_so() {
    assert_eq!(ViewerOptions::default().may, ViewersMay::Look);
    let run = Run::armed(ViewersMay::Look);
    let mut viewer = run.viewer();
    let before = run.live();
    assert_eq!(viewer.set("eps_u_v", json!(0.5)), json!(before.settings.eps_u_v));
    let words = viewer.text("status")["message"].as_str().unwrap().to_string();
    assert!(words.contains("eps_u_v") && words.contains("--foxglove-set"), "{words}");
    // Without an id there is no answer; the status says it all the same.
    viewer.send(&json!({ "op": "setParameters", "parameters": [{ "name": "law", "value": "inverse" }] }));
    assert!(viewer.text("status")["message"].as_str().unwrap().contains("law"));
    assert_eq!(run.live(), before);
    assert_eq!(run.end().iter().filter(|text| text.contains("needed a run that viewers may change")).count(), 2);
}

#[test]
fn refusals_do_not_fill_the_recording() {
    let run = Run::armed(ViewersMay::Look);
    let mut viewer = run.viewer();
    let set = json!({ "op": "setParameters", "parameters": [{ "name": "eps_u_v", "value": 0.5 }] });
    (0..150).for_each(|_| viewer.send(&set));
    (0..150).for_each(|_| drop(viewer.text("status")));
    let warnings = run.end();
    let noted: Vec<&String> = warnings.iter().filter(|text| text.contains("viewer")).collect();
    assert_eq!(noted.len(), 100);
    assert!(noted[99].ends_with("further ones are not noted"));
}

#[test]
fn before_a_run_is_armed_there_are_no_parameters() {
    let viewers = viewers(ViewersMay::Set);
    let mut viewer = Viewer::connect(&viewers.address().to_string());
    assert_eq!(viewer.ask(json!({ "op": "getParameters", "parameterNames": [] })), json!([]));
    assert_eq!(viewer.set("eps_u_v", json!(0.5)), Value::Null);
    assert!(viewer.text("status")["message"].as_str().unwrap().contains("before the run was armed"));
}

#[test]
fn who_comes_late_hears_what_has_happened() {
    let viewers = viewers(ViewersMay::Look);
    let mut sink = viewers.sink(&header());
    let event = |k: u64| flexbeam_runtime::RunEvent {
        instant: k,
        kind: flexbeam_runtime::EventKind::Warning,
        text: format!("number {k}"),
    };
    (0..300).for_each(|k| sink.event(&event(k)).unwrap());
    sink.settings(7, &scripted::constant(1.0)).unwrap();
    sink.settings(9, &Live { revision: 1, ..scripted::constant(2.0) }).unwrap();
    let mut viewer = Viewer::connect(&viewers.address().to_string());
    viewer.subscribe(&["/settings", "/events"]);
    let mut next = || {
        viewer.wait_for("a message", |said| match said {
            Said::Data { subscription, log_time_ns, payload } => {
                Some((*subscription, *log_time_ns, serde_json::from_slice::<Value>(payload).unwrap()))
            }
            _ => None,
        })
    };
    let (subscription, log_time_ns, settings) = next();
    assert_eq!((subscription, log_time_ns, &settings["revision"]), (1, header().log_time_ns(9), &json!(1)));
    for k in 44..300 {
        let (subscription, log_time_ns, event) = next();
        assert_eq!(
            (subscription, log_time_ns, &event["text"]),
            (2, header().log_time_ns(k), &json!(format!("number {k}")))
        );
    }
}

/// A client's frame of this first byte, masked with zeroes.
fn frame(first: u8, payload: &[u8]) -> Vec<u8> {
    [&[first, 0x80 | payload.len() as u8, 0, 0, 0, 0], payload].concat()
}

#[test]
fn malformed_frames_harm_nobody_else() {
    let run = Run::armed(ViewersMay::Set);
    let address = run.viewers.address().to_string();
    let mut witness = run.viewer();
    witness.subscribe(&["/signals"]);
    let before = run.live();
    // Understood as frames, not as messages: the viewer is told and stays.
    let mut viewer = run.viewer();
    for text in
        ["", "{", "[]", "{\"op\":\"jump\"}", "{\"op\":\"setParameters\"}", "{\"op\":\"subscribe\",\"subscriptions\":7}"]
    {
        viewer.send_message(Message::text(text));
        assert_eq!(viewer.text("status")["level"], 2, "an error for {text:?}");
    }
    viewer.send_message(Message::binary(vec![0xee, 1, 2, 3]));
    assert_eq!(viewer.text("status")["level"], 2);
    viewer.send_message(Message::binary(vec![]));
    viewer.send(&json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": 4_000_000 }] }));
    assert_eq!(viewer.text("status")["level"], 2);
    viewer.send(
        &json!({ "op": "advertise", "channels": [{ "id": 1, "topic": "/x", "encoding": "json", "schemaName": "" }] }),
    );
    assert_eq!(viewer.text("status")["level"], 2, "viewers do not publish");
    assert!(!viewer.ask(json!({ "op": "getParameters", "parameterNames": [] })).as_array().unwrap().is_empty());
    // No frames at all: the connection ends.
    let broken = [
        frame(0x81, &[0xff, 0xfe]),
        frame(0x83, b"reserved opcode"),
        frame(0xf1, b"reserved bits"),
        frame(0x09, b"a ping in parts"),
        vec![0x81, 0x02, b'h', b'i'],
        [&[0x82, 0xff][..], &u64::MAX.to_be_bytes(), &[0; 4]].concat(),
        [&[0x82, 0xff][..], &(1u64 << 40).to_be_bytes(), &[0; 4]].concat(),
    ];
    for bytes in broken {
        let mut viewer = run.viewer();
        viewer.stream().write_all(&bytes).unwrap();
        viewer.wait_for("the end", |said| (*said == Said::Closed).then_some(()));
    }
    // No WebSocket at all; half a frame, and gone.
    let mut stranger = TcpStream::connect(&address).unwrap();
    stranger.write_all(b"\x16\x03\x01 not HTTP\r\n\r\n").unwrap();
    let _ = stranger.read_to_end(&mut Vec::new());
    run.viewer().stream().write_all(&[0x81, 0xfe, 0xff]).unwrap();
    drop(TcpStream::connect(&address).unwrap());

    let reached = run.session.live.current();
    assert_eq!(reached, before, "nothing was changed");
    let said = |viewer: &mut Viewer| match viewer.next() {
        Said::Data { payload, .. } => RunSample::from_cdr(&payload),
        _ => None,
    };
    let first = std::iter::repeat_with(|| said(&mut witness)).flatten().next().unwrap().tick;
    witness.wait_for("samples that go on", |said| match said {
        Said::Data { payload, .. } => RunSample::from_cdr(payload).filter(|sample| sample.tick > first + 100).map(drop),
        _ => None,
    });
    run.end();
}

#[test]
fn a_port_is_taken_once_and_given_back() {
    let first = viewers(ViewersMay::Look);
    assert_ne!(first.address().port(), 0);
    let refused = Viewers::open(first.address(), ViewerOptions::default()).map(drop).unwrap_err();
    assert!(matches!(&refused, NoViewers::Refused { address, .. } if *address == first.address().to_string()));
    assert!(refused.to_string().contains("in use"), "{refused}");
    let address = first.address().clone();
    let mut viewer = Viewer::connect(&address.to_string());
    let mut sink = first.sink(&header());
    viewer.subscribe(&["/signals"]);
    viewer.ask(json!({ "op": "getParameters", "parameterNames": [] }));
    sink.sample(&Sample { instant: 5, ..Sample::default() }).unwrap();
    drop(first);
    let mut last = None;
    viewer.wait_for("the end", |said| {
        if let Said::Data { payload, .. } = said {
            last = RunSample::from_cdr(payload);
        }
        (*said == Said::Closed).then_some(())
    });
    assert_eq!(last.unwrap().tick, 5, "the last message came before the end");
    drop(Viewers::open(&address, ViewerOptions::default()).unwrap());
    let senseless = ViewerOptions { most_per_s: 0.0, ..ViewerOptions::default() };
    assert_eq!(Viewers::open(&address, senseless).map(drop), Err(NoViewers::Rate(0.0)));
}
