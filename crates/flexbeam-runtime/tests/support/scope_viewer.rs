//! A viewer of the scope, written from the wire's description.

use serde_json::{Value, json};
use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::{ClientRequestBuilder, Error, Message, WebSocket};

/// Longest wait for something that must come; no stall of a shared machine is longer.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a server says.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    Text(Value),
    Frame(Frame),
    /// With its code; 0 for an end without one.
    Closed(u16),
}

/// Samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub lost: u32,
    pub ticks: Vec<u64>,
    /// By channel.
    pub values: Vec<Vec<f32>>,
}

impl Frame {
    fn of(bytes: &[u8]) -> Frame {
        let word = |k: usize| u32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
        let (n, m) = (word(1) as usize, word(4) as usize);
        assert_eq!((word(0), bytes.len()), (0x3153_4246, 24 + 4 * n * (1 + m)));
        let first = f64::from_le_bytes(bytes[8..16].try_into().unwrap()) as u64;
        let channel = |c: usize| (0..n).map(|k| f32::from_bits(word(6 + n * (1 + c) + k))).collect();
        Frame {
            lost: word(5),
            ticks: (0..n).map(|k| first + u64::from(word(6 + k))).collect(),
            values: (0..m).map(channel).collect(),
        }
    }
}

/// A viewer that is connected.
pub struct Viewer {
    socket: WebSocket<TcpStream>,
    /// The answer to its entering.
    pub hello: Value,
    next: u64,
}

/// The handshake alone, with headers of our own.
pub fn handshake(address: &str, headers: &[(&str, &str)]) -> Result<WebSocket<TcpStream>, String> {
    let stream = TcpStream::connect(address).map_err(|error| error.to_string())?;
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let request = ClientRequestBuilder::new(format!("ws://{address}/live").parse().unwrap());
    let request = headers.iter().fold(request, |request, (name, value)| request.with_header(*name, *value));
    tungstenite::client(request, stream).map(|(socket, _)| socket).map_err(|error| error.to_string())
}

pub fn read(socket: &mut WebSocket<TcpStream>) -> Said {
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => return Said::Text(serde_json::from_str(&text).unwrap()),
            Ok(Message::Binary(bytes)) => return Said::Frame(Frame::of(&bytes)),
            Ok(Message::Close(frame)) => return Said::Closed(frame.map_or(0, |frame| frame.code.into())),
            Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => panic!("nothing more is said"),
            Err(_) => return Said::Closed(0),
            Ok(_) => {}
        }
    }
}

impl Viewer {
    /// Enters with these keys, and what is usual for the rest.
    pub fn enter(address: &str, keys: Value) -> Viewer {
        let mut socket = handshake(address, &[]).unwrap();
        let mut enter =
            json!({ "type": "enter", "protocol": 1, "token": null, "name": "viewer", "key": "", "after": null });
        enter.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
        socket.send(Message::text(enter.to_string())).unwrap();
        let mut viewer = Viewer { socket, hello: Value::Null, next: 0 };
        viewer.hello = viewer.text("hello");
        viewer
    }

    pub fn id(&self) -> u64 {
        self.hello["viewer"].as_u64().unwrap()
    }

    pub fn socket(&mut self) -> &mut WebSocket<TcpStream> {
        &mut self.socket
    }

    pub fn next(&mut self) -> Said {
        read(&mut self.socket)
    }

    /// The first thing that `found` takes; whatever else is said passes by.
    pub fn wait_for<T>(&mut self, what: &str, mut found: impl FnMut(&Said) -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        loop {
            let said = self.next();
            if let Some(found) = found(&said) {
                return found;
            }
            assert!(!matches!(said, Said::Closed(_)), "{said:?} before {what}");
            assert!(Instant::now() < end, "no {what}");
        }
    }

    pub fn text(&mut self, kind: &str) -> Value {
        self.text_with(kind, |_| true)
    }

    pub fn text_with(&mut self, kind: &str, is: impl Fn(&Value) -> bool) -> Value {
        self.wait_for(kind, |said| match said {
            Said::Text(text) if text["type"] == kind && is(text) => Some(text.clone()),
            _ => None,
        })
    }

    pub fn frame(&mut self) -> Frame {
        self.wait_for("a frame", |said| if let Said::Frame(frame) = said { Some(frame.clone()) } else { None })
    }

    /// The reply's error; nothing when it was done.
    pub fn ask(&mut self, mut request: Value) -> Option<String> {
        self.next += 1;
        let id = self.next;
        request["id"] = json!(id);
        self.socket.send(Message::text(request.to_string())).unwrap();
        let reply = self.text_with("reply", |reply| reply["id"] == id);
        assert_eq!(reply["ok"].as_bool().unwrap(), reply.get("error").is_none());
        reply["error"].as_str().map(String::from)
    }

    pub fn set(&mut self, values: Value) -> Option<String> {
        self.ask(json!({ "type": "set", "values": values }))
    }

    pub fn act(&mut self, what: &str) -> Option<String> {
        self.ask(json!({ "type": "do", "request": { "do": what } }))
    }

    pub fn take(&mut self) -> Option<String> {
        self.ask(json!({ "type": "take" }))
    }

    /// The code with which the server closes.
    pub fn closed(&mut self) -> u16 {
        self.wait_for("the end", |said| if let Said::Closed(code) = said { Some(*code) } else { None })
    }
}
