//! An operator's abort goes before everything else; wrong tokens and uploads of viewers do not get far.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};

use seatrial::FullRudder;
use seatrial::preview::{Budget, Prior};
use seatrial_app::trials::order::{Preflight, Terms, TrialVehicle, VehicleError, VehicleLease};
use seatrial_core::Plan;
use seatrial_dash::{Server, Settings};
use tungstenite::Message;

/// What an abort may take on a busy machine; it takes some milliseconds.
const SOON: Duration = Duration::from_secs(1);
/// What each preview of [`Slow`] takes.
const SLOW: Duration = Duration::from_secs(3);
/// Connections that one address may have.
const MOST_CONNECTIONS: usize = 128;

/// A vehicle of which nobody knows anything for a long time.
struct Slow;

impl TrialVehicle for Slow {
    fn name(&self) -> &str {
        "slow"
    }

    fn description(&self) -> &str {
        "takes its time"
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn full_rudder(&self) -> Option<FullRudder> {
        None
    }

    fn prior(&self, _: &Plan<f64>, _: &Budget) -> Result<Prior, VehicleError> {
        sleep(SLOW);
        Err(VehicleError::refused("not known"))
    }

    fn inspect(&self, _: &Plan<f64>) -> Result<Preflight, VehicleError> {
        Err(VehicleError::refused("not known"))
    }

    fn take(&self, _: &Terms) -> Result<Box<dyn VehicleLease>, VehicleError> {
        Err(VehicleError::refused("not known"))
    }
}

struct Served {
    server: Server,
    operator: String,
    viewer: String,
}

impl Served {
    fn start(folder: &Path, requests_per_s: f64) -> Self {
        let settings = Settings {
            token_needed: true,
            requests_per_s,
            ..Settings::new(SocketAddr::from(([127, 0, 0, 1], 0)), folder.join("s.db"))
        };
        let server = Server::start(&settings, vec![Box::new(Slow)], Vec::new()).unwrap();
        let tokens = server.new_tokens().unwrap().clone();
        Self { server, operator: tokens.operator, viewer: tokens.viewer }
    }

    fn address(&self) -> String {
        let url = self.server.url();
        url.trim_start_matches("http://").trim_end_matches('/').into()
    }

    /// Status and body.
    fn ask(&self, token: &str, method: &str, path: &str, body: &str) -> (u16, String) {
        let address = self.address();
        let mut stream = TcpStream::connect(&address).unwrap();
        let request = format!(
            "{method} /api/v1{path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\n\
             Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        let _ = stream.read_to_string(&mut answer);
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
        let status = head.split_whitespace().nth(1).unwrap_or("0");
        (status.parse().unwrap(), body.into())
    }

    /// No trial runs, and the server says so at once.
    fn assert_abort_is_answered(&self) {
        let begun = Instant::now();
        let (status, body) = self.ask(&self.operator, "POST", "/trial/abort", "");
        assert_eq!(status, 409, "{body}");
        assert!(body.contains("no_trial"), "{body}");
        assert!(begun.elapsed() < SOON, "{:?}", begun.elapsed());
    }
}

#[test]
fn io_an_abort_does_not_wait_for_slow_requests() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), 100.0);
    scope(|scope| {
        for _ in 0..8 {
            let preview =
                || served.ask(&served.viewer, "POST", "/plans/preview", r#"{"vehicle": "slow"}"#);
            scope.spawn(preview);
        }
        sleep(SLOW / 6);
        served.assert_abort_is_answered();
    });
    let (_, audit) = served.ask(&served.operator, "GET", "/audit", "");
    assert!(audit.contains("abort_trial"), "{audit}");
}

#[test]
fn io_an_abort_does_not_wait_until_a_flood_is_over() {
    let folder = tempfile::tempdir().unwrap();
    // So few that a busy machine does not earn one meanwhile.
    let served = Served::start(folder.path(), 0.5);
    let statuses: Vec<u16> =
        (0..30).map(|_| served.ask(&served.viewer, "GET", "/vehicles", "").0).collect();
    assert_eq!((statuses[0], statuses[29]), (200, 429), "{statuses:?}");
    served.assert_abort_is_answered();
    let (status, _) = served.ask(&served.viewer, "POST", "/trial/abort", "");
    assert_eq!(status, 429, "a viewer's is a request like others");
}

#[test]
fn io_an_abort_gets_through_where_no_connection_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), 100.0);
    let idle: Vec<TcpStream> =
        (0..MOST_CONNECTIONS).map(|_| TcpStream::connect(served.address()).unwrap()).collect();
    sleep(SOON / 4);
    served.assert_abort_is_answered();
    let (status, body) = served.ask(&served.operator, "GET", "/vehicles", "");
    assert_eq!(status, 503, "{body}");
    drop(idle);
}

/// 400 requests at once and 100 a second are eight wrong tokens at once and two a second; one more is examined for what is left
/// of a request, and paid for later.
#[test]
fn io_a_wrong_token_costs_fifty_requests() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), 100.0);
    let begun = Instant::now();
    let statuses: Vec<u16> = scope(|scope| {
        let asked: Vec<_> = (0..60)
            .map(|_| scope.spawn(|| served.ask("wrong", "GET", "/vehicles", "").0))
            .collect();
        asked.into_iter().map(|a| a.join().unwrap()).collect()
    });
    let most = 9.0 + 2.0 * begun.elapsed().as_secs_f64();
    let examined = statuses.iter().filter(|status| **status == 401).count();
    let refused = statuses.iter().filter(|status| **status == 429).count();
    assert!(examined > 0 && examined as f64 <= most, "{statuses:?}");
    assert_eq!(examined + refused, 60, "{statuses:?}");
    served.assert_abort_is_answered();
}

#[test]
fn io_wrong_tokens_of_live_streams_cost_as_much() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), 100.0);
    let address = served.address();
    let begun = Instant::now();
    let mut sockets: Vec<_> = (0..20)
        .map(|_| {
            let stream = TcpStream::connect(&address).unwrap();
            tungstenite::client(format!("ws://{address}/api/v1/live"), stream).unwrap().0
        })
        .collect();
    for socket in &mut sockets {
        let hello = Message::text(r#"{"token": "wrong"}"#);
        socket.send(hello).unwrap();
    }
    let goodbyes: Vec<String> = sockets
        .iter_mut()
        .map(|socket| socket.read().unwrap().to_text().unwrap().to_owned())
        .collect();
    let count = |code: &str| goodbyes.iter().filter(|said| said.contains(code)).count();
    let most = 9.0 + 2.0 * begun.elapsed().as_secs_f64();
    assert!(count("token_needed") as f64 <= most, "{goodbyes:?}");
    assert_eq!(count("token_needed") + count("too_many_requests"), 20);
}

#[test]
fn io_a_viewer_may_not_upload() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), 100.0);
    for path in ["/logs/identify", "/logs/inspect"] {
        let (status, body) = served.ask(&served.viewer, "POST", path, "t,heading,rudder\n");
        assert_eq!(status, 403, "{body}");
        assert!(body.contains("operators_only"), "{body}");
        let (status, body) = served.ask(&served.operator, "POST", path, "t,heading,rudder\n");
        assert_eq!(status, 422, "{body}");
    }
}
