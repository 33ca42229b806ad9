//! What may reach a port on a bad day: none of it touches the run, and an honest viewer is served all the while.

mod scripted;
#[path = "support/scope.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod support;

use flexbeam_runtime::{Phase, Sample, Sink};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use support::{Run, Said, Viewer, about, enter, handshake, header, read, server, token};
use tungstenite::Message;
use tungstenite::protocol::frame::coding::{Control, Data, OpCode};
use tungstenite::protocol::frame::{Frame, FrameHeader};

/// An answer to raw bytes, all of it; empty where the connection was closed without one.
fn answer(run: &Run, request: &str) -> String {
    let mut stream = TcpStream::connect(run.server.address().to_string()).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut text = Vec::new();
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

fn get(path: &str, headers: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n")
}

/// The run goes on, and who comes in honesty is served and may steer.
fn still_works(run: &Run) {
    assert_eq!(run.session.controls.phase(), Phase::Armed);
    let mut honest = run.viewer("honest");
    let first = honest.frame();
    assert!(honest.frame().ticks[0] > first.ticks[0]);
    assert_eq!(honest.take(), None);
    let before = run.session.live.current().revision;
    assert_eq!(honest.set(json!({ "eps_u_v": 0.01 * f64::from(before + 1) })), None);
    assert_eq!(run.session.live.current().revision, before + 1);
    assert_eq!(honest.ask(json!({ "type": "release" })), None);
}

#[test]
fn the_page_comes_with_headers_that_keep_others_out() {
    let run = Run::armed();
    let page = answer(&run, &get("/", "Host: localhost\r\n"));
    let (head, body) = page.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200") && body.contains("<html"), "{page}");
    let policy = "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                  connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    for header in [
        policy,
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
        "cross-origin-opener-policy: same-origin",
        "cross-origin-resource-policy: same-origin",
        "content-type: text/html; charset=utf-8",
    ] {
        assert!(head.contains(header), "{header}\n{head}");
    }
    assert!(!page.contains(&token(&run.server)), "the token is nowhere in it");
    let status = |request: &str| answer(&run, request).split(' ').nth(1).unwrap_or_default().to_string();
    let host = "Host: 127.0.0.1:1\r\n";
    for path in ["/none", "/../Cargo.toml", "/%2e%2e/Cargo.toml", "//etc/passwd", "/index.html/"] {
        assert_eq!(status(&get(path, host)), "404", "{path}");
    }
    assert_eq!(status(&get("/live", host)), "426");
    assert_eq!(status(&get("/live?token=x", host)), "426");
    assert_eq!(status(&get("/", host).replace("GET", "POST")), "405");
    run.end("warning");
}

#[test]
fn another_origin_and_a_foreign_host_are_refused() {
    let run = Run::armed();
    let address = run.server.address().to_string();
    let own = format!("http://{address}");
    handshake(&address, &[("Origin", &own)]).map(drop).unwrap();
    for headers in [
        &[("Origin", "http://evil.example")][..],
        &[("Origin", "null")],
        &[("Origin", "http://127.0.0.1:1")],
        &[("Origin", "http://localhost")],
    ] {
        let refused = handshake(&address, headers).map(drop).unwrap_err();
        assert!(refused.contains("403"), "{headers:?}: {refused}");
    }
    for headers in
        ["Host: evil.example\r\n", "", "Host: localhost\r\nHost: localhost\r\n", "Host: rig\r\nOrigin: http://rig\r\n"]
    {
        let refused = answer(&run, &get("/", headers));
        assert!(refused.contains(" 403 ") || refused.contains(" 400 "), "{headers:?}: {refused}");
    }
    still_works(&run);
    run.end("warning");
}

#[test]
fn messages_that_are_none_end_their_own_connection_alone() {
    let run = Run::armed();
    for (message, code) in [
        (Message::text("hello"), 4003),
        (Message::text("{}"), 4003),
        (Message::text(r#"{"type":"jump"}"#), 4003),
        (Message::text("[".repeat(60_000)), 4003),
        (Message::binary(vec![0; 100]), 4003),
    ] {
        let mut viewer = run.onlooker();
        viewer.socket().send(message.clone()).unwrap();
        assert_eq!(viewer.closed(), code, "{message:?}");
    }
    let mut viewer = run.onlooker();
    let deep = format!("{}1{}", r#"{"a":"#.repeat(200), "}".repeat(200));
    let deep = format!(r#"{{"type":"set","id":5,"values":{{"a":{deep}}}}}"#);
    viewer.socket().send(Message::text(deep)).unwrap();
    assert_eq!(viewer.text_with("reply", |reply| reply["id"] == 5)["ok"], false, "deeper than any message");
    // A key of sixty thousand parts would be a tree that overflows a stack.
    let mut viewer = run.viewer("tablet");
    viewer.take();
    let parts = format!("a{}", ".a".repeat(30_000));
    assert!(viewer.set(json!({ parts: 1 })).unwrap().contains("parts"));
    assert_eq!(viewer.ask(json!({ "type": "release" })), None);
    still_works(&run);
    run.end("warning");
}

#[test]
fn bytes_that_are_no_frames_end_their_own_connection_alone() {
    let run = Run::armed();
    let masked = |opcode, payload: Vec<u8>| {
        let header = FrameHeader { opcode, mask: Some([1, 2, 3, 4]), ..FrameHeader::default() };
        Message::Frame(Frame::from_payload(header, payload.into()))
    };
    let broken = [
        masked(OpCode::Data(Data::Reserved(5)), vec![1]),
        masked(OpCode::Control(Control::Ping), vec![0; 300]),
        masked(OpCode::Data(Data::Continue), vec![1]),
        masked(OpCode::Data(Data::Text), vec![0xff, 0xfe]),
    ];
    for message in broken {
        let mut viewer = run.onlooker();
        viewer.socket().send(message).unwrap();
        let code = viewer.closed();
        assert!([0, 1002, 1007, 4003].contains(&code), "{code}");
    }
    let mut viewer = run.onlooker();
    viewer.socket().get_mut().write_all(&[0x5a; 4096]).unwrap();
    viewer.closed();
    still_works(&run);
    run.end("warning");
}

#[test]
fn a_message_that_is_too_big_is_refused_as_such() {
    let run = Run::armed();
    let mut stranger = handshake(&run.server.address().to_string(), &[]).unwrap();
    stranger.send(Message::text("x".repeat(70_000))).unwrap();
    assert_eq!(read(&mut stranger), Said::Closed(1009), "before it entered");
    for bytes in [64 * 1024 + 1, 1 << 20] {
        let mut viewer = run.onlooker();
        // The server may have closed before all of it is sent.
        let _ = viewer.socket().send(Message::text("x".repeat(bytes)));
        let code = viewer.closed();
        assert!(code == 1009 || (code == 0 && bytes == 1 << 20), "{bytes}: {code}");
    }
    // In many pieces it is no smaller.
    let mut viewer = run.onlooker();
    for k in 0..80 {
        let opcode = OpCode::Data(if k == 0 { Data::Text } else { Data::Continue });
        let header = FrameHeader { is_final: false, opcode, mask: Some([0; 4]), ..FrameHeader::default() };
        let piece = Message::Frame(Frame::from_payload(header, vec![b'x'; 1024].into()));
        let _ = viewer.socket().send(piece);
    }
    assert_eq!(viewer.closed(), 1009);
    still_works(&run);
    run.end("warning");
}

/// Half a head, a head that comes letter by letter, a handshake and then silence.
#[test]
fn slow_connections_are_let_go() {
    let run = Run::armed();
    let address = run.server.address().to_string();
    let began = Instant::now();
    let mut half = TcpStream::connect(&address).unwrap();
    half.write_all(b"GET / HTTP/1.1\r\nHost: local").unwrap();
    let mut silent = handshake(&address, &[]).unwrap();
    let mut letters = TcpStream::connect(&address).unwrap();
    letters.set_nodelay(true).unwrap();
    let trickle = std::thread::spawn(move || {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(30) && letters.write_all(b"G").is_ok() {
            std::thread::sleep(Duration::from_millis(100));
        }
        began.elapsed()
    });
    still_works(&run);
    half.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let mut rest = Vec::new();
    half.read_to_end(&mut rest).unwrap();
    assert!(began.elapsed() >= Duration::from_secs(4), "an honest slow one has its time");
    assert_eq!(read(&mut silent), Said::Closed(4001));
    assert!(trickle.join().unwrap() < Duration::from_secs(30));
    run.end("warning");
}

/// Bounded: a thousand at once, in four hundred milliseconds or so, on the loopback.
#[test]
fn a_thousand_connections_leave_a_place_for_an_honest_viewer() {
    let run = Run::armed();
    let address = run.server.address().to_string();
    let mut before = run.viewer("before");
    let mut flood: Vec<TcpStream> = Vec::new();
    let deadline = Instant::now() + Duration::from_secs(60);
    while flood.len() < 1000 && Instant::now() < deadline {
        flood.extend(TcpStream::connect(&address));
    }
    assert_eq!(flood.len(), 1000);
    // All of them at the door, none says anything.
    still_works(&run);
    let first = before.frame();
    assert!(before.frame().ticks[0] > first.ticks[0], "who was there stays");
    drop(flood);
    still_works(&run);
    run.end("warning");
}

#[test]
fn a_full_house_is_refused_and_the_token_opens_it() {
    let run = Run::armed();
    let mut onlookers: Vec<Viewer> = (0..32).map(|_| run.onlooker()).collect();
    let mut socket = handshake(&run.server.address().to_string(), &[]).unwrap();
    let enter = json!({ "type": "enter", "protocol": 1, "token": null, "name": "", "key": "", "after": null });
    socket.send(Message::text(enter.to_string())).unwrap();
    assert_eq!(read(&mut socket), Said::Closed(4004));
    still_works(&run);
    assert_eq!(onlookers[0].closed(), 4004, "the first onlooker made room");
    run.end("warning");
}

#[test]
fn what_a_viewer_is_called_cannot_write_on_a_terminal() {
    let run = Run::armed();
    let name = format!("a\u{1b}[2Jb\n{}", "x".repeat(10_000));
    let mut viewer = enter(&run.server, json!({ "token": token(&run.server), "name": name }));
    viewer.take();
    let told = run.end("control");
    assert!(told[0].contains("a[2Jb") && told[0].chars().count() < 100 && !told[0].contains('\u{1b}'), "{told:?}");
}

#[test]
fn refusals_and_changes_of_hands_do_not_fill_the_recording() {
    let run = Run::armed();
    let mut viewer = run.viewer("tablet");
    for _ in 0..150 {
        viewer.act("start");
    }
    let warnings = run.end("warning");
    let noted: Vec<&String> = warnings.iter().filter(|text| text.contains("refused")).collect();
    assert_eq!(noted.len(), 100);
    assert!(noted[99].ends_with("further ones are not noted"));
}

/// The farewell does not wait for it either.
#[test]
fn a_server_ends_although_a_viewer_never_reads() {
    let server = server(about(None));
    let mut sink = server.sink(&header(1e-3));
    let stalled = enter(&server, json!({}));
    (0..200_000).for_each(|instant| sink.sample(&Sample { instant, ..Sample::default() }).unwrap());
    std::thread::sleep(Duration::from_millis(500));
    let began = Instant::now();
    drop(server);
    assert!(began.elapsed() < Duration::from_secs(20), "{:?}", began.elapsed());
    drop(stalled);
}

/// A viewer that is not there any more, and did not say so.
#[test]
fn a_viewer_that_takes_nothing_for_ten_seconds_is_let_go() {
    let server = server(about(None));
    let mut sink = server.sink(&header(1e-3));
    let mut stalled = enter(&server, json!({}));
    let mut other = enter(&server, json!({}));
    let end = Instant::now() + Duration::from_secs(60);
    let enough = Arc::new(AtomicBool::new(false));
    let done = enough.clone();
    let feed = std::thread::spawn(move || {
        let mut instant = 0;
        while !done.load(Ordering::Relaxed) && Instant::now() < end {
            (0..1000).for_each(|_| {
                sink.sample(&Sample { instant, ..Sample::default() }).unwrap();
                instant += 1;
            });
            std::thread::sleep(Duration::from_millis(10));
        }
    });
    let alone = |text: &Value| text["viewers"].as_array().unwrap().len() == 1;
    other.text_with("viewers", |text| text["viewers"].as_array().unwrap().len() == 2);
    other.text_with("viewers", alone);
    assert!(Instant::now() < end, "it was let go while it was fed");
    enough.store(true, Ordering::Relaxed);
    let code = stalled.closed();
    assert!([0, 4005].contains(&code), "{code}");
    feed.join().unwrap();
}
