//! A viewer of the Foxglove WebSocket protocol, written from the protocol's description.

use serde_json::{Value, json};
use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::handshake::client::Response;
use tungstenite::{ClientRequestBuilder, Error, Message, WebSocket};

/// Longest wait for something that must come; no stall of a shared machine is longer.
const PATIENCE: Duration = Duration::from_secs(60);

/// First byte of a message on a topic.
const MESSAGE_DATA: u8 = 1;

/// What a server says.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// A JSON message.
    Text(Value),
    /// A message on a topic.
    Data { subscription: u32, log_time_ns: u64, payload: Vec<u8> },
    /// The end of the connection, however it came.
    Closed,
}

/// A viewer that is connected.
pub struct Viewer {
    socket: WebSocket<TcpStream>,
    /// What the server chose.
    pub subprotocol: String,
}

/// A handshake that offers these protocols, separated by commas.
pub fn handshake(address: &str, offered: &str) -> Result<(WebSocket<TcpStream>, Response), String> {
    let stream = TcpStream::connect(address).map_err(|error| error.to_string())?;
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let request = ClientRequestBuilder::new(format!("ws://{address}/").parse().unwrap());
    let request = offered.split(',').filter(|word| !word.is_empty()).fold(request, |r, word| r.with_sub_protocol(word));
    tungstenite::client(request, stream).map_err(|error| error.to_string())
}

impl Viewer {
    pub fn connect(address: &str) -> Viewer {
        Viewer::offering(address, "foxglove.sdk.v1")
    }

    pub fn offering(address: &str, offered: &str) -> Viewer {
        let (socket, response) = handshake(address, offered).unwrap();
        let chosen = response.headers().get("sec-websocket-protocol").unwrap();
        Viewer { socket, subprotocol: chosen.to_str().unwrap().into() }
    }

    /// Below the WebSocket: for bytes that no library would send.
    pub fn stream(&mut self) -> &mut TcpStream {
        self.socket.get_mut()
    }

    pub fn send(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    pub fn send_message(&mut self, message: Message) {
        self.socket.send(message).unwrap();
    }

    /// The next thing said, pings left out.
    pub fn next(&mut self) -> Said {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => return Said::Text(serde_json::from_str(&text).unwrap()),
                Ok(Message::Binary(bytes)) => return data(&bytes),
                Ok(Message::Close(_)) | Err(Error::ConnectionClosed | Error::AlreadyClosed | Error::Protocol(_)) => {
                    return Said::Closed;
                }
                Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => panic!("nothing more is said"),
                Err(Error::Io(_)) => return Said::Closed,
                Ok(_) => {}
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// The first thing said that is wanted; what comes before is dropped.
    pub fn wait_for<T>(&mut self, what: &str, mut wanted: impl FnMut(&Said) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            let said = self.next();
            if let Some(found) = wanted(&said) {
                return found;
            }
            assert!(said != Said::Closed && start.elapsed() < PATIENCE, "never: {what}");
        }
    }

    /// The next JSON message of this operation.
    pub fn text(&mut self, op: &str) -> Value {
        self.wait_for(op, |said| match said {
            Said::Text(text) if text["op"] == op => Some(text.clone()),
            _ => None,
        })
    }

    /// Subscribes to these topics, as 1, 2, 3..; before anything else was read.
    pub fn subscribe(&mut self, topics: &[&str]) -> Value {
        let advertised = self.text("advertise");
        let channels = advertised["channels"].as_array().unwrap();
        let id = |topic: &str| channels.iter().find(|c| c["topic"] == topic).unwrap()["id"].clone();
        let wanted: Vec<Value> =
            topics.iter().enumerate().map(|(k, topic)| json!({ "id": k + 1, "channelId": id(topic) })).collect();
        self.send(&json!({ "op": "subscribe", "subscriptions": wanted }));
        advertised
    }

    /// Answer to a question that carries an id.
    pub fn ask(&mut self, mut question: Value) -> Value {
        question["id"] = "asked".into();
        self.send(&question);
        self.wait_for("an answer", |said| match said {
            Said::Text(text) if text["op"] == "parameterValues" && text["id"] == "asked" => {
                Some(text["parameters"].clone())
            }
            _ => None,
        })
    }

    /// Sets one parameter; what the server answers that it is, which is nothing for a name that nobody knows.
    pub fn set(&mut self, name: &str, value: Value) -> Value {
        let set = json!({ "op": "setParameters", "parameters": [{ "name": name, "value": value }] });
        self.ask(set)[0]["value"].clone()
    }
}

fn data(bytes: &[u8]) -> Said {
    assert_eq!(bytes[0], MESSAGE_DATA);
    Said::Data {
        subscription: u32::from_le_bytes(bytes[1..5].try_into().unwrap()),
        log_time_ns: u64::from_le_bytes(bytes[5..13].try_into().unwrap()),
        payload: bytes[13..].to_vec(),
    }
}
