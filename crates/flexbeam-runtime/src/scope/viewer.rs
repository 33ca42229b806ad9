//! One viewer: it is heard at once, and told as fast as it listens.
//!
//! Nothing waits for a viewer but its own task: of samples and events it has a cursor each, of the rest the newest counts, and one
//! message at a time is on its way. Replies are the only queue, and a short one: when it is full, the viewer is not heard.

use super::door::Connection;
use super::hall::Hall;
use super::requests::NotDone;
use super::told::Told;
use crate::printable::fit_to_print;
use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message, WebSocket};
use flexbeam_files::{Enter, PageMessage, SCOPE_PROTOCOL, ServerMessage, TokenFound, ViewerMay, json_text};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, Stream, StreamExt};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::time::{MissedTickBehavior, interval, timeout};

/// For the first message.
const ENTER_TIME: Duration = Duration::from_secs(5);
/// For a message to be taken.
const TAKE_TIME: Duration = Duration::from_secs(10);
/// A viewer that says nothing, not even that it lives, is gone.
const SILENCE: Duration = Duration::from_secs(15);
/// How often it is asked whether it lives.
const PING: Duration = Duration::from_secs(5);
/// From one look to the next: thirty frames a second.
const BEAT: Duration = Duration::from_millis(33);
/// For the last words to arrive before the connection goes.
const FAREWELL: Duration = Duration::from_millis(500);
/// Replies that wait.
const MOST_REPLIES: usize = 16;
/// Between two messages that are heard: nobody moves a slider faster, and a flood costs little.
const PACE: Duration = Duration::from_millis(2);
/// Wrong tokens on a connection.
const MOST_WRONG: u32 = 3;
/// Longest name [characters], and longest key [bytes].
const LONGEST_NAME: usize = 40;
const LONGEST_KEY: usize = 128;

/// Why a connection ends: close code and words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct End(u16, &'static str);

impl End {
    pub(super) const FULL: End = End(4004, "too many viewers");
    pub(super) const NOT_BEGUN: End = End(1001, "the run did not begin");
    pub(super) const OVER: End = End(1000, "the run is over");
    const GONE: End = End(1000, "goodbye");
    const NOT_ENTERED: End = End(4001, "the first message must be enter, with a good token or none");
    const PROTOCOL: End = End(4002, "another version of the protocol");
    const MALFORMED: End = End(4003, "a message that is none");
    const SLOW: End = End(4005, "too slow");
    const TOO_BIG: End = End(1009, "a message of more than 64 KiB");
}

type Tell = SplitSink<WebSocket, Message>;
type Hear = SplitStream<WebSocket>;

/// From the handshake to the end.
pub(super) async fn serve(socket: WebSocket, hall: Arc<Hall>, connection: Arc<Connection>) {
    let (mut tell, mut hear) = socket.split();
    let end = tokio::select! {
        end = visit(&mut tell, &mut hear, &hall, &connection) => end,
        () = connection.evicted() => End::FULL,
    };
    let goodbye = Message::Close(Some(CloseFrame { code: end.0, reason: end.1.into() }));
    let said = async {
        if tell.send(goodbye).await.is_err() {
            return;
        }
        // Until the other side has closed, too: what it still sends must not cut our last words off.
        while let Some(Ok(heard)) = hear.next().await {
            if matches!(heard, Message::Close(_)) {
                return;
            }
        }
        // It was cut short in the middle of a message, and may still be sending it.
        if end != End::GONE {
            std::future::pending::<()>().await;
        }
    };
    let _ = timeout(FAREWELL, said).await;
}

async fn visit(tell: &mut Tell, hear: &mut Hear, hall: &Arc<Hall>, connection: &Connection) -> End {
    let enter =
        match timeout(ENTER_TIME, heard(&mut *hear)).await.map(|text| text.map(|text| PageMessage::parse(&text))) {
            Ok(Ok(Ok(PageMessage::Enter(enter)))) if enter.key.len() <= LONGEST_KEY => enter,
            Ok(Err(end)) if end != End::MALFORMED => return end,
            _ => return End::NOT_ENTERED,
        };
    if enter.protocol != SCOPE_PROTOCOL {
        return End::PROTOCOL;
    }
    let Some(guest) = Guest::enter(hall, &enter) else { return End::FULL };
    connection.settle();
    let (replies, waiting) = channel(MOST_REPLIES);
    tokio::select! {
        end = listen(hear, &guest, replies) => end,
        end = talk(tell, &guest, Told::new(hall, &enter), waiting) => end,
    }
}

/// A viewer that has entered; it leaves when it is dropped.
pub(super) struct Guest {
    hall: Arc<Hall>,
    id: u64,
    steers: AtomicBool,
    token: TokenFound,
    /// When it was last heard [ms since the server began].
    heard_ms: AtomicU64,
}

impl Guest {
    /// Nothing when the house is full.
    fn enter(hall: &Arc<Hall>, enter: &Enter) -> Option<Guest> {
        let token = offered(hall, enter);
        let may = if token == TokenFound::Good { ViewerMay::Steer } else { ViewerMay::Look };
        let name: String = fit_to_print(&enter.name).chars().take(LONGEST_NAME).collect();
        let id = hall.seats(|seats, now| seats.enter(now, &name, &enter.key, may)).ok()?;
        let (steers, heard_ms) = (AtomicBool::new(may == ViewerMay::Steer), AtomicU64::new(hall.now_ms()));
        Some(Guest { hall: hall.clone(), id, steers, token, heard_ms })
    }

    /// The token that it had forgotten.
    fn admit(&self) {
        self.hall.seats(|seats, now| seats.admit(now, self.id));
        self.steers.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_there(&self) -> bool {
        self.hall.seats(|seats, _| seats.has(self.id))
    }

    /// What it is told when it has entered.
    pub(super) fn hello(&self, wrong: bool) -> ServerMessage {
        let (may, token) = match (self.steers.load(Ordering::Relaxed), wrong) {
            (true, _) => (ViewerMay::Steer, TokenFound::Good),
            (false, true) => (ViewerMay::Look, TokenFound::Wrong),
            (false, false) => (ViewerMay::Look, self.token),
        };
        ServerMessage::Hello(Box::new(self.hall.hello(self.id, may, token)))
    }

    fn is_silent(&self) -> bool {
        let since = self.hall.now_ms().saturating_sub(self.heard_ms.load(Ordering::Relaxed));
        Duration::from_millis(since) > SILENCE
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        self.hall.seats(|seats, now| seats.leave(now, self.id));
    }
}

fn offered(hall: &Hall, enter: &Enter) -> TokenFound {
    match &enter.token {
        None => TokenFound::None,
        Some(token) if hall.token.is(token) => TokenFound::Good,
        Some(_) => TokenFound::Wrong,
    }
}

/// The next text.
async fn heard(mut hear: impl Stream<Item = Result<Message, axum::Error>> + Unpin) -> Result<String, End> {
    loop {
        match hear.next().await {
            Some(Ok(Message::Text(text))) => return Ok(text.to_string()),
            Some(Ok(Message::Ping(_) | Message::Pong(_))) => {}
            Some(Ok(Message::Binary(_))) => return Err(End::MALFORMED),
            Some(Ok(Message::Close(_))) | None => return Err(End::GONE),
            // The library has no other sign of it; a test sends such a message.
            Some(Err(error)) if error.to_string().contains("too long") => return Err(End::TOO_BIG),
            Some(Err(_)) => return Err(End::MALFORMED),
        }
    }
}

/// Hears the viewer until there is a reason to end.
async fn listen(hear: &mut Hear, guest: &Guest, replies: Sender<ServerMessage>) -> End {
    let mut wrong = u32::from(guest.token == TokenFound::Wrong);
    loop {
        let text = match heard_alive(hear, guest).await {
            Ok(text) => text,
            Err(end) => return end,
        };
        let answer = match PageMessage::parse(&text) {
            Ok(PageMessage::Enter(_)) if guest.steers.load(Ordering::Relaxed) => return End::MALFORMED,
            Ok(PageMessage::Enter(enter)) => {
                let found = offered(&guest.hall, &enter);
                match found {
                    TokenFound::Good => guest.admit(),
                    TokenFound::Wrong => wrong += 1,
                    TokenFound::None => {}
                }
                if wrong >= MOST_WRONG {
                    return End::NOT_ENTERED;
                }
                guest.hello(found == TokenFound::Wrong)
            }
            Ok(message) => {
                reply(message.id(), guest.hall.obey(guest.id, &message).map_err(|refused| refused.to_string()))
            }
            // Whoever asked has an answer; what has no number is no message at all.
            Err(error) => match PageMessage::id_of(&text) {
                Some(id) => reply(Some(id), Err(NotDone::NoMessage(error).to_string())),
                None => return End::MALFORMED,
            },
        };
        if replies.send(answer).await.is_err() {
            return End::GONE;
        }
        tokio::time::sleep(PACE).await;
    }
}

async fn heard_alive(hear: &mut Hear, guest: &Guest) -> Result<String, End> {
    let alive = hear.inspect(|_| guest.heard_ms.store(guest.hall.now_ms(), Ordering::Relaxed));
    heard(alive).await
}

fn reply(id: Option<u64>, done: Result<(), String>) -> ServerMessage {
    ServerMessage::Reply {
        id: id.unwrap_or_default(),
        ok: done.is_ok(),
        error: done.err().map(|text| fit_to_print(&text)),
    }
}

/// Tells the viewer what it does not know yet, one message at a time.
async fn talk(tell: &mut Tell, guest: &Guest, mut told: Told, mut replies: Receiver<ServerMessage>) -> End {
    match talked(tell, guest, &mut told, &mut replies).await {
        Ok(end) | Err(end) => end,
    }
}

async fn talked(
    tell: &mut Tell,
    guest: &Guest,
    told: &mut Told,
    replies: &mut Receiver<ServerMessage>,
) -> Result<End, End> {
    let (mut beat, mut ping) = (interval(BEAT), interval(PING));
    beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
    ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            biased;
            reply = replies.recv() => match reply {
                Some(reply) => send(tell, text(&reply)).await?,
                None => return Ok(End::GONE),
            },
            _ = ping.tick() => send(tell, Message::Ping(Bytes::new())).await?,
            _ = beat.tick() => {
                if guest.is_silent() {
                    return Ok(End::SLOW);
                }
                guest.hall.gather();
                told.beat();
                while let Some(message) = told.next(&guest.hall, guest) {
                    let (began, samples) = (Instant::now(), matches!(message, Message::Binary(_)));
                    send(tell, message).await?;
                    if samples {
                        told.took(&guest.hall, began.elapsed());
                    }
                    while let Ok(reply) = replies.try_recv() {
                        send(tell, text(&reply)).await?;
                    }
                }
                if let Some(end) = told.end(&guest.hall, guest) {
                    return Ok(end);
                }
            }
        }
    }
}

pub(super) fn text(message: &ServerMessage) -> Message {
    Message::Text(json_text(message).into())
}

async fn send(tell: &mut Tell, message: Message) -> Result<(), End> {
    match timeout(TAKE_TIME, tell.send(message)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) => Err(End::GONE),
        Err(_) => Err(End::SLOW),
    }
}
