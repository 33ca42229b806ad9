//! The door: TCP connections, a bounded number of them, and who gets in by which Host and Origin.

use super::hall::Hall;
use super::page;
use super::viewer;
use axum::Router;
use axum::body::Body;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Extension, FromRequestParts, Request, State};
use axum::http::{HeaderMap, Method, Response, StatusCode, header};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use nix::sys::socket::setsockopt;
use nix::sys::socket::sockopt::SndBuf;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;

/// TCP connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// Between two of them: a flood costs little.
const PACE: Duration = Duration::from_millis(1);
/// What the system queues for a connection [bytes]; it takes twice as much.
const SEND_BUFFER: usize = 16 * 1024;
/// For the head of a request.
const HEAD_TIME: Duration = Duration::from_secs(5);
/// For a connection that asks for files.
const FILES_TIME: Duration = Duration::from_secs(60);
/// Longest head of a request [bytes].
const LONGEST_HEAD: usize = 16 * 1024;
/// Longest message of a page [bytes].
const LONGEST_MESSAGE: usize = 64 * 1024;

/// One connection: it counts until the last holder drops it.
pub(super) struct Connection {
    /// It is a viewer's, who entered: it is not let go for another.
    settled: AtomicBool,
    gone: Notify,
}

impl Connection {
    /// From now on it stays.
    pub(super) fn settle(&self) {
        self.settled.store(true, Ordering::Relaxed);
    }

    /// When it has to make room.
    pub(super) async fn evicted(&self) {
        self.gone.notified().await;
    }
}

/// The connections that are there, oldest first. When there are too many, the newest gets the place of the oldest that is not a
/// viewer's.
#[derive(Default)]
struct Connections(Mutex<Vec<Weak<Connection>>>);

impl Connections {
    /// A place; nothing when all are viewers'.
    fn place(&self) -> Option<Arc<Connection>> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|connection| connection.strong_count() > 0);
        if all.len() >= MOST_CONNECTIONS {
            let waits = |connection: &Weak<Connection>| {
                connection.upgrade().is_some_and(|connection| !connection.settled.load(Ordering::Relaxed))
            };
            let oldest = all.iter().position(waits)?;
            if let Some(oldest) = all.remove(oldest).upgrade() {
                // One that waits later finds it, too.
                oldest.gone.notify_one();
            }
        }
        let connection = Arc::new(Connection { settled: AtomicBool::new(false), gone: Notify::new() });
        all.push(Arc::downgrade(&connection));
        Some(connection)
    }
}

/// Lets them in, for ever.
pub(super) async fn admit(listener: TcpListener, hall: Arc<Hall>) {
    let connections = Connections::default();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // Out of descriptors, say: a short rest, and the next one may have better luck.
            tokio::time::sleep(Duration::from_millis(20)).await;
            continue;
        };
        if let Some(connection) = connections.place() {
            tokio::spawn(serve(stream, connection, hall.clone()));
        }
        tokio::time::sleep(PACE).await;
    }
}

async fn serve(stream: TcpStream, connection: Arc<Connection>, hall: Arc<Hall>) {
    // Small messages both ways: a slider is not to wait for the answer before.
    let _ = stream.set_nodelay(true);
    // Without it the system queues megabytes for a slow line, and a state arrives behind a minute of samples.
    let _ = setsockopt(&stream, SndBuf, &SEND_BUFFER);
    let router = Router::new().fallback(answer).layer(Extension(connection.clone())).with_state(hall);
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD_TIME).max_buf_size(LONGEST_HEAD);
    let served = http.serve_connection(TokioIo::new(stream), TowerToHyperService::new(router)).with_upgrades();
    tokio::select! {
        _ = tokio::time::timeout(FILES_TIME, served) => {}
        () = connection.evicted() => {}
    }
}

async fn answer(
    State(hall): State<Arc<Hall>>,
    Extension(connection): Extension<Arc<Connection>>,
    request: Request,
) -> Response<Body> {
    let (mut parts, _) = request.into_parts();
    if !is_ours(&parts.headers, &hall.host) {
        return page::refusal(
            StatusCode::FORBIDDEN,
            "found another Host or Origin, needed the address that flexbeam run printed\n",
        );
    }
    if parts.method != Method::GET && parts.method != Method::HEAD {
        return page::refusal(StatusCode::METHOD_NOT_ALLOWED, "found another method, needed GET\n");
    }
    if parts.uri.path() != "/live" {
        return page::file(parts.uri.path());
    }
    match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade
            .max_message_size(LONGEST_MESSAGE)
            .max_frame_size(LONGEST_MESSAGE)
            .on_upgrade(move |socket| viewer::serve(socket, hall, connection)),
        Err(_) => page::refusal(StatusCode::UPGRADE_REQUIRED, "found a plain request, needed a WebSocket\n"),
    }
}

/// The Host is this server's, so that no name of another site leads here; the Origin, where a browser names one, is that Host's.
fn is_ours(headers: &HeaderMap, own: &str) -> bool {
    let only = |name| {
        let mut all = headers.get_all(name).iter();
        let first = all.next();
        (all.next().is_none(), first.map(|value| value.to_str().unwrap_or_default()))
    };
    let (true, Some(host)) = only(header::HOST) else { return false };
    let name = if host.ends_with(']') { host } else { host.rsplit_once(':').map_or(host, |(name, _)| name) };
    let number = name.trim_start_matches('[').trim_end_matches(']');
    let known = name.eq_ignore_ascii_case("localhost") || name.eq_ignore_ascii_case(own);
    if !known && number.parse::<IpAddr>().is_err() {
        return false;
    }
    match only(header::ORIGIN) {
        (true, None) => true,
        (true, Some(origin)) => origin.strip_prefix("http://").is_some_and(|origin| origin.eq_ignore_ascii_case(host)),
        (false, _) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ours(host: &[&str], origin: &[&str]) -> bool {
        let mut headers = HeaderMap::new();
        headers.extend(host.iter().map(|host| (header::HOST, host.parse().unwrap())));
        headers.extend(origin.iter().map(|origin| (header::ORIGIN, origin.parse().unwrap())));
        is_ours(&headers, "rig.example")
    }

    #[test]
    fn a_host_is_a_number_localhost_or_the_server_s_own_name() {
        for host in
            ["127.0.0.1:8787", "127.0.0.1", "LOCALHOST:1", "[::1]:8787", "[::1]", "192.168.1.7:1", "rig.example:1"]
        {
            assert!(ours(&[host], &[]), "{host}");
            assert!(ours(&[host], &[&format!("http://{host}")]), "{host}");
            assert!(!ours(&[host], &["null"]) && !ours(&[host], &[&format!("https://{host}")]), "{host}");
        }
        for host in ["evil.example", "evil.example:8787", "127.0.0.1.evil.example", "", "rig.example.evil.example:1"] {
            assert!(!ours(&[host], &[]), "{host}");
        }
        assert!(!ours(&[], &[]) && !ours(&["localhost", "localhost"], &[]));
    }

    #[test]
    fn an_origin_is_that_of_the_host_to_the_port() {
        let host = "127.0.0.1:8787";
        for origin in ["http://127.0.0.1:8788", "http://127.0.0.1", "http://evil.example", "127.0.0.1:8787", ""] {
            assert!(!ours(&[host], &[origin]), "{origin}");
        }
        assert!(!ours(&[host], &["http://127.0.0.1:8787", "http://127.0.0.1:8787"]));
    }

    #[test]
    fn the_oldest_connection_that_is_no_viewer_s_makes_room() {
        let connections = Connections::default();
        let mut held: Vec<_> = (0..MOST_CONNECTIONS).map(|_| connections.place().unwrap()).collect();
        held[0].settle();
        let newest = connections.place().unwrap();
        assert_eq!(connections.0.lock().unwrap().len(), MOST_CONNECTIONS);
        held.iter().for_each(|connection| connection.settle());
        newest.settle();
        assert!(connections.place().is_none(), "all are viewers'");
        held.pop();
        assert!(connections.place().is_some());
    }
}
