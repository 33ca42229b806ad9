//! The scope over its wire: what viewers see is what the run was, what they may is what token and control permit.

mod scripted;
#[path = "support/scope.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod support;

use flexbeam_files::RunSample;
use flexbeam_runtime::scope::{NoScope, ScopeServer, Token};
use flexbeam_runtime::{Phase, RunFault, Sample, Sink};
use serde_json::{Value, json};
use std::sync::atomic::Ordering;
use support::{Frame, Run, START_UNIX_NS, Said, Viewer, about, enter, handshake, read, server, token};
use tungstenite::Message;

fn channel(viewer: &Viewer, key: &str) -> usize {
    viewer.hello["signals"].as_array().unwrap().iter().position(|signal| signal["key"] == key).unwrap()
}

#[test]
fn hello_tells_all_that_a_page_needs() {
    let run = Run::armed();
    let viewer = run.viewer("laptop");
    let hello = &viewer.hello;
    assert_eq!((&hello["protocol"], &hello["may"], &hello["token"]), (&json!(1), &json!("steer"), &json!("good")));
    assert_eq!(
        hello["run"],
        json!({ "controller": "controller.toml", "project": "beam", "port": "simulated", "period_s": 0.001,
                "start_unix_ns": START_UNIX_NS.to_string(), "can_save": true })
    );
    let keys: Vec<&str> =
        hello["signals"].as_array().unwrap().iter().map(|signal| signal["key"].as_str().unwrap()).collect();
    assert!(keys.iter().all(|key| RunSample::NAMES.contains(key)) && keys.len() == 16);
    let psi = &hello["signals"][channel(&viewer, "psi_rad")];
    assert_eq!((&psi["unit"], psi["factor"].as_f64()), (&json!("°"), Some(1f64.to_degrees())));
    assert_eq!(hello["certificate"]["holds"], true);
    assert_eq!(hello["screen"], json!({ "scope": [], "panel": [] }));
    let eps = hello["knobs"].as_array().unwrap().iter().find(|knob| knob["key"] == "eps_u_v").unwrap();
    assert_eq!((&eps["low"], &eps["high"], &eps["why_fixed"]), (&json!(0.0), &Value::Null, &Value::Null));
    assert_eq!(run.onlooker().hello["token"], "none");
}

/// To the last bit of single precision, from the first tick to the last, whenever a viewer came.
#[test]
fn what_viewers_see_is_what_the_run_was() {
    let run = Run::armed();
    let (mut early, controls) = (run.onlooker(), run.session.controls.clone());
    let mut late = None;
    let mut frames = Vec::new();
    let Run { session, server, ear, .. } = run;
    let finished = std::thread::spawn(move || session.finish());
    let mut seen = 0;
    let over = early.wait_for("the end", |said| {
        if let Said::Frame(frame) = said {
            let before = seen;
            seen += frame.ticks.len();
            frames.push(frame.clone());
            if before < 100 && seen >= 100 {
                controls.start();
            }
            if before < 400 && seen >= 400 {
                late = Some(enter(&server, json!({})));
                controls.stop();
            }
        }
        match said {
            Said::Text(text) if text["type"] == "over" => Some(text["result"].clone()),
            _ => None,
        }
    });
    let report = finished.join().unwrap().report;
    assert_eq!(over["recording"], "run.mcap");
    assert_eq!((over["cause"].as_str(), over["ticks"].as_u64()), (Some("asked"), Some(report.meter.lateness.count())));
    assert_eq!(early.closed(), 1000);
    let mut late = late.unwrap();
    let mut of_late = Vec::new();
    late.wait_for("the end", |said| match said {
        Said::Frame(frame) => {
            of_late.push(frame.clone());
            None
        }
        Said::Text(text) => (text["type"] == "over").then_some(()),
        Said::Closed(_) => None,
    });

    let samples = ear.0.lock().unwrap().samples.clone();
    for frames in [frames, of_late] {
        same(&frames, &samples, &early);
    }
    assert!(samples.len() > 400 && samples.iter().any(|sample| sample.phase == Phase::Running));
}

fn same(frames: &[Frame], samples: &[Sample], viewer: &Viewer) {
    assert!(frames.iter().all(|frame| frame.lost == 0));
    let ticks: Vec<u64> = frames.iter().flat_map(|frame| frame.ticks.clone()).collect();
    assert!(ticks.iter().copied().eq(samples.iter().map(|sample| sample.instant)));
    let column = |key: &str| frames.iter().flat_map(|f| f.values[channel(viewer, key)].clone()).collect::<Vec<f32>>();
    type Of = fn(&Sample) -> f64;
    let expected: [(&str, Of); 12] = [
        ("reference_rad", |s| s.reference_rad),
        ("smoothed_rad", |s| s.commanded.reference_rad),
        ("y_model_rad", |s| s.commanded.y_model_rad),
        ("theta_rad", |s| s.measured.theta_rad),
        ("alpha_rad", |s| s.measured.alpha_rad),
        ("error_rad", |s| s.commanded.error_rad),
        ("voltage_v", |s| s.voltage_v),
        ("commanded_v", |s| s.commanded.voltage_v),
        ("u_v", |s| s.commanded.u_v),
        ("lateness_ns", |s| s.lateness_ns as f64),
        ("stale", |s| f64::from(u8::from(s.stale))),
        // The kernel's tip angle while it runs; before and after, where the sensors say it is.
        ("psi_rad", |s| match s.phase {
            Phase::Running => s.commanded.y_rad,
            _ => s.measured.theta_rad + s.measured.alpha_rad,
        }),
    ];
    for (key, of) in expected {
        let wanted = samples.iter().map(|sample| (of(sample) as f32).to_bits());
        assert!(column(key).iter().map(|x| x.to_bits()).eq(wanted), "{key}");
    }
}

#[test]
fn a_setting_is_changed_by_the_one_in_control_and_all_hear_of_it() {
    let run = Run::armed();
    let (mut one, mut other) = (run.viewer("laptop"), run.onlooker());
    assert!(one.set(json!({ "eps_u_v": 0.02 })).unwrap().contains("not in control"));
    assert_eq!(one.take(), None);
    let awkward: f64 = 0.1 + 0.2;
    assert_eq!(one.set(json!({ "eps_u_v": awkward, "law": "switched", "reference.period_s": 2 })), None);
    let live = run.session.live.current();
    assert_eq!((live.revision, live.settings.eps_u_v.to_bits()), (1, awkward.to_bits()));
    assert_eq!(live.reference.period_s, 2.0);
    let state = other.text_with("state", |state| state["revision"] == 1);
    assert_eq!((state["values"]["eps_u_v"].as_f64(), &state["values"]["law"]), (Some(awkward), &json!("switched")));
    assert_eq!(state["phase"], "armed");
    assert_eq!(one.set(json!({ "eps_u_v": 0.03 })), None);
    // From elsewhere, as over the control socket.
    run.session.live.change(|live| live.settings.u_p_plus_v = 0.25).unwrap();
    other.text_with("state", |state| state["values"]["u_p_plus_v"] == 0.25);
    let told =
        one.text_with("event", |event| event["kind"] == "control" && event["text"].as_str().unwrap().contains("set"));
    assert_eq!(told["text"], "viewer \"laptop\" set eps_u_v = 0.03, law = switched, reference.period_s = 2.0");
    let control = run.end("control");
    assert_eq!(control[0], format!("viewer {} \"laptop\" is in control", one.id()));
    assert_eq!(control.len(), 2, "{control:?}");
}

#[test]
fn a_refused_change_names_the_limits_and_leaves_everything_as_it_was() {
    let run = Run::armed();
    let mut viewer = run.viewer("laptop");
    viewer.take();
    let before = run.session.live.current();
    let refusals = [
        (json!({ "eps_u_v": -1 }), "found eps_u_v of -1, needed at least 0"),
        (json!({ "voltage_limit_v": 11 }), "needed at least 0 and at most 10"),
        (json!({ "deflection_limit_rad": 0 }), "needed more than 0 and at most 0.5"),
        (json!({ "theta.low_pass": 0 }), "needed more than 0 and at most 1"),
        (json!({ "theta.offset_rad": 0.1 }), "found at homing"),
        (json!({ "reference.shape": "file" }), "a reference file"),
        (json!({ "law": "cosine" }), "cosine"),
        (json!({ "law": 3 }), "law"),
        (json!({ "eps_u_v": "many" }), "many"),
        (json!({ "eps_u_v": null }), "a message that is none"),
        (json!({ "eps_u_v.deeper": 1 }), "eps_u_v"),
        (json!({ "epsilon": 1 }), "epsilon"),
        (json!({ "reference": "sine" }), "sine"),
        (json!({ "u_p_plus_v": 0.1, "eps_u_v": -1 }), "eps_u_v"),
    ];
    for (values, named) in &refusals {
        let words = viewer.set(values.clone()).unwrap();
        assert!(words.contains(named) && words.contains("\nhint: "), "{values}: {words}");
    }
    assert_eq!(run.session.live.current(), before);
    // A message that is none is no request; the others are in the recording.
    assert_eq!(run.end("warning").iter().filter(|text| text.contains("refused")).count(), refusals.len() - 1);
}

#[test]
fn without_the_token_nothing_changes() {
    let run = Run::armed();
    let before = run.session.live.current();
    let mut viewer = run.onlooker();
    assert_eq!(viewer.hello["may"], "look");
    let requests = [
        json!({ "type": "take" }),
        json!({ "type": "release" }),
        json!({ "type": "give", "to": 1, "yes": true }),
        json!({ "type": "set", "values": { "eps_u_v": 0.5 } }),
        json!({ "type": "do", "request": { "do": "start" } }),
        json!({ "type": "do", "request": { "do": "stop" } }),
        json!({ "type": "do", "request": { "do": "emergency" } }),
        json!({ "type": "save", "screen": { "scope": [], "panel": [] } }),
    ];
    for request in &requests {
        assert!(viewer.ask(request.clone()).unwrap().contains("token"), "{request}");
    }
    assert_eq!((run.session.live.current(), run.session.controls.phase()), (before, Phase::Armed));
    assert!(run.saved.lock().unwrap().is_empty());
    assert_eq!(run.end("warning").iter().filter(|text| text.contains("token")).count(), requests.len());
}

#[test]
fn three_wrong_tokens_close_the_connection_and_a_good_one_may_come_later() {
    let run = Run::armed();
    let entering = |token: &str| {
        Message::text(
            json!({ "type": "enter", "protocol": 1, "token": token, "name": "", "key": "", "after": null }).to_string(),
        )
    };
    let wrong = "a".repeat(26);
    let mut viewer = enter(&run.server, json!({ "token": wrong }));
    assert_eq!((&viewer.hello["token"], &viewer.hello["may"]), (&json!("wrong"), &json!("look")));
    assert!(viewer.take().unwrap().contains("token"));
    viewer.socket().send(entering(&wrong)).unwrap();
    assert_eq!(viewer.text("hello")["token"], "wrong");
    viewer.socket().send(entering(&token(&run.server))).unwrap();
    assert_eq!(viewer.text("hello")["may"], "steer");
    assert_eq!(viewer.take(), None);

    let mut guesser = enter(&run.server, json!({ "token": "" }));
    guesser.socket().send(entering(&wrong)).unwrap();
    guesser.socket().send(entering(&wrong)).unwrap();
    assert_eq!(guesser.closed(), 4001);
    run.end("warning");
}

#[test]
fn start_needs_control_and_stops_need_the_token_alone() {
    for (stop, kind, ends) in [("stop", "stopped", Phase::Stopped), ("emergency", "fault", Phase::Faulted)] {
        let run = Run::armed();
        let (mut one, mut other) = (run.viewer("laptop"), run.viewer("tablet"));
        one.take();
        assert!(other.act("start").unwrap().contains("not in control"));
        assert_eq!(one.act("start"), None);
        other.text_with("state", |state| state["phase"] == "running");
        assert_eq!(other.act(stop), None);
        let Run { session, server, .. } = run;
        let cause = session.finish().report.cause;
        assert_eq!(cause == flexbeam_runtime::Cause::Fault(RunFault::Emergency), stop == "emergency");
        let mut told = Vec::new();
        let over = one.wait_for("over", |said| {
            let Said::Text(text) = said else { return None };
            told.push(text.clone());
            (text["type"] == "over").then(|| text.clone())
        });
        assert!(
            told.iter().any(|text| text["phase"] == ends.name() && text["time_s"].as_f64() > Some(0.0)),
            "{told:?}"
        );
        assert!(told.iter().any(|text| text["type"] == "event" && text["kind"] == kind), "{told:?}");
        assert_eq!(over["result"]["cause"], if stop == "stop" { "asked" } else { "fault" });
        assert_eq!(one.closed(), 1000);
        drop(server);
    }
}

#[test]
fn control_is_handed_over_when_it_is_asked_for() {
    let run = Run::armed();
    let (mut one, mut other) = (run.viewer("laptop"), run.viewer("tablet"));
    assert_eq!((one.take(), other.take()), (None, None));
    let asking = one.text_with("viewers", |viewers| !viewers["asking"].is_null());
    assert_eq!((&asking["in_control"], &asking["asking"]["name"]), (&json!(one.id()), &json!("tablet")));
    let third = run.viewer("phone").take().unwrap();
    assert!(third.contains("found tablet asking"), "{third}");
    let to = other.id();
    assert_eq!(one.ask(json!({ "type": "give", "to": to, "yes": false })), None);
    other.text_with("viewers", |viewers| viewers["asking"].is_null() && viewers["in_control"] == one.id());
    assert_eq!(other.take(), None);
    assert_eq!(one.ask(json!({ "type": "give", "to": to, "yes": true })), None);
    other.text_with("viewers", |viewers| viewers["in_control"] == to);
    assert_eq!(other.set(json!({ "eps_u_v": 0.5 })), None);
    assert!(one.set(json!({ "eps_u_v": 0.6 })).unwrap().contains("not in control"));
    assert_eq!(other.ask(json!({ "type": "release" })), None);
    one.text_with("viewers", |viewers| viewers["in_control"].is_null());
    let hands = run.end("control");
    let who: Vec<&str> = hands.iter().map(|text| text.split('"').nth(1).unwrap_or("nobody")).collect();
    assert_eq!(who, ["laptop", "tablet", "tablet", "nobody"], "{hands:?}");
}

#[test]
fn a_connection_that_comes_back_has_its_seat_and_every_sample() {
    let run = Run::armed();
    let mut viewer = run.viewer("laptop");
    let mut ticks = Vec::new();
    while ticks.len() < 300 {
        ticks.extend(viewer.frame().ticks);
    }
    // Frames that come before the reply pass by; the page that comes back says that it does not have them.
    viewer.take();
    drop(viewer);
    std::thread::sleep(std::time::Duration::from_millis(300));
    let (good, last) = (token(&run.server), ticks.last().copied().unwrap());
    let keys = |after: u64, start: u64| json!({ "token": good, "name": "laptop", "key": "laptop", "after": after, "run": start.to_string() });
    let mut back = enter(&run.server, keys(last, START_UNIX_NS));
    let frame = back.frame();
    assert!(frame.ticks[0] > last && frame.lost == 0);
    ticks.extend(frame.ticks);
    while ticks.len() < 900 {
        ticks.extend(back.frame().ticks);
    }
    assert_eq!(back.set(json!({ "eps_u_v": 0.5 })), None, "the seat was kept");
    // What the page had was of another run: it gets this one whole.
    let mut other = enter(&run.server, keys(last, 1));
    let first = other.frame().ticks[0];
    let (_, ear) = run.finish();
    let samples = &ear.0.lock().unwrap().samples;
    assert!(ticks.iter().eq(samples.iter().take(ticks.len()).map(|sample| &sample.instant)), "no hole, no repetition");
    assert_eq!(first, samples[0].instant);
}

#[test]
fn scopes_and_panels_are_saved_with_the_settings_in_force() {
    let run = Run::armed();
    let mut viewer = run.viewer("laptop");
    viewer.take();
    viewer.set(json!({ "eps_u_v": 0.025 }));
    let screen = json!({
        "scope": [{ "title": "Tip", "kind": "time", "signals": ["psi_rad"], "span_s": 5.0,
                    "trigger": { "signal": "psi_rad", "edge": "rising", "level": 0.1, "mode": "auto", "before": 0.2 } }],
        "panel": [{ "title": "Law", "settings": ["eps_u_v"], "ranges": { "eps_u_v": [0.0, 0.1] } }] });
    let save = |screen: &Value| json!({ "type": "save", "screen": screen });
    assert_eq!(viewer.ask(save(&screen)), None);
    assert_eq!(run.onlooker().hello["screen"], screen, "who comes later gets it");
    for (key, value, named) in [
        ("span_s", json!(-1.0), "span_s"),
        ("title", json!("unwritable"), "no space"),
        ("colour", json!("red"), "colour"),
    ] {
        let mut wrong = screen.clone();
        wrong["scope"][0][key] = value;
        assert!(viewer.ask(save(&wrong)).unwrap().contains(named), "{named}");
    }
    let saved = run.saved.lock().unwrap().clone();
    assert_eq!((saved.len(), saved[0].0.scopes[0].span_s, saved[0].1.settings.eps_u_v), (1, 5.0, Some(0.025)));
    run.end("warning");
}

#[test]
fn before_the_run_is_armed_a_viewer_sees_that_and_may_end_the_homing() {
    let about = about(None);
    let asked = about.asked.clone();
    let server = server(about);
    let mut viewer = enter(&server, json!({ "token": token(&server) }));
    assert_eq!((&viewer.hello["knobs"], &viewer.hello["run"]["start_unix_ns"]), (&json!([]), &json!("0")));
    assert_eq!(viewer.text("state")["phase"], "configured");
    viewer.take();
    assert!(viewer.set(json!({ "eps_u_v": 0.5 })).unwrap().contains("before the run was armed"));
    assert!(viewer.act("start").unwrap().contains("before the run was armed"));
    assert!(!asked.load(Ordering::Acquire));
    assert_eq!(viewer.act("emergency"), None);
    assert!(asked.load(Ordering::Acquire));
    drop(server);
    assert_eq!(viewer.closed(), 1001);
}

/// Samples come before the settings may be changed: until then there is no run, and nothing of it is told.
#[test]
fn who_comes_in_the_instant_of_arming_misses_neither_settings_nor_samples() {
    let server = server(about(None));
    let mut sink = server.sink(&support::header(1e-3));
    for instant in 0..50 {
        sink.sample(&Sample { instant, ..Sample::default() }).unwrap();
    }
    let mut viewer = enter(&server, json!({}));
    assert_eq!((&viewer.hello["knobs"], &viewer.hello["run"]["start_unix_ns"]), (&json!([]), &json!("0")));
    viewer.text("state");
    viewer.text("state");
    let (live, _reader) = flexbeam_runtime::live(scripted::constant(0.0)).unwrap();
    let steering =
        flexbeam_runtime::Steering { controls: Default::default(), live, latest: Default::default(), period_s: 1e-3 };
    let run = Run::armed();
    server.steer(steering, run.session.notes());
    let mut is_armed = false;
    let ticks = viewer.wait_for("the first frame of the run", |said| match said {
        Said::Text(text) => {
            is_armed |= text["type"] == "hello" && text["run"]["start_unix_ns"] == json!(START_UNIX_NS.to_string());
            None
        }
        Said::Frame(frame) => Some(frame.ticks.clone()).filter(|_| is_armed),
        Said::Closed(_) => None,
    });
    assert_eq!(ticks, (0..50).collect::<Vec<u64>>());
    run.end("warning");
}

#[test]
fn hello_comes_again_when_the_run_is_armed() {
    let server = server(about(None));
    let mut viewer = enter(&server, json!({}));
    let (live, _reader) = flexbeam_runtime::live(scripted::constant(0.0)).unwrap();
    let steering =
        flexbeam_runtime::Steering { controls: Default::default(), live, latest: Default::default(), period_s: 1e-3 };
    let _sink = server.sink(&support::header(1e-3));
    let run = Run::armed();
    server.steer(steering, run.session.notes());
    let hello = viewer.text("hello");
    assert_eq!(hello["run"]["start_unix_ns"], START_UNIX_NS.to_string());
    assert!(hello["knobs"].as_array().unwrap().len() > 20);
    run.end("warning");
}

#[test]
fn the_table_is_told_again_when_it_changes() {
    use flexbeam_runtime::{Reference, Shape};
    let run = Run::armed();
    let mut viewer = run.onlooker();
    let file = Reference { samples: [0.1, 0.2].into(), ..run.session.live.current().reference };
    run.session.live.change(|live| live.reference = Reference { shape: Shape::File, ..file }).unwrap();
    let knobs = viewer.text("knobs");
    let amplitude = knobs["knobs"].as_array().unwrap().iter().find(|k| k["key"] == "reference.amplitude_rad").unwrap();
    assert_eq!((&amplitude["unit"], &amplitude["factor"]), (&json!(""), &json!(1.0)));
    run.end("warning");
}

#[test]
fn another_version_and_a_first_message_that_is_no_enter_are_refused() {
    let server = server(about(None));
    let address = server.address().to_string();
    for (first, code) in [
        (r#"{"type":"enter","protocol":2,"token":null,"name":"","key":"","after":null}"#.to_string(), 4002),
        (r#"{"type":"take","id":1}"#.into(), 4001),
        ("hello".into(), 4001),
        (
            format!(
                r#"{{"type":"enter","protocol":1,"token":null,"name":"","key":"{}","after":null}}"#,
                "k".repeat(129)
            ),
            4001,
        ),
    ] {
        let mut socket = handshake(&address, &[]).unwrap();
        socket.send(Message::text(&first)).unwrap();
        assert_eq!(read(&mut socket), Said::Closed(code), "{first}");
    }
    // Or nothing at all, within five seconds.
    let mut silent = handshake(&address, &[]).unwrap();
    assert_eq!(read(&mut silent), Said::Closed(4001));
}

#[test]
fn a_port_that_is_taken_is_refused() {
    let server = server(about(None));
    assert_eq!(server.url(), format!("http://{}/#{}", server.address(), token(&server)));
    let again = ScopeServer::open(server.address(), Token::new().unwrap(), about(None));
    let NoScope { address, reason } = again.unwrap_err();
    assert_eq!(address, server.address().to_string());
    assert!(reason.contains("in use"), "{reason}");
    let nowhere = ScopeServer::open(&"192.0.2.1:8787".parse().unwrap(), Token::new().unwrap(), about(None));
    assert!(nowhere.unwrap_err().to_string().contains("\nhint: "));
}
