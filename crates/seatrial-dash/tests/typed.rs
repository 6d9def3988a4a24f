//! What people and programs type: requests, queries, headers, bodies and live messages, damaged in many ways, through the whole
//! server. `SEATRIAL_DAMAGED=N` tries so many damaged copies of each request instead of forty.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use seatrial::FullRudder;
use seatrial::preview::{Budget, Prior};
use seatrial_app::trials::order::{Preflight, Terms, TrialVehicle, VehicleError, VehicleLease};
use seatrial_core::Plan;
use seatrial_dash::{Server, Settings};
use seatrial_dev::{Damage, damaged_copies};
use tungstenite::Message;

/// Damaged copies of each request.
const OF_EACH: u64 = 40;
/// An answer takes milliseconds; a request that is not whole is waited for longer by the server.
const ANSWERED_WITHIN: Duration = Duration::from_millis(700);

const REQUESTS: [(&str, &str, &str); 14] = [
    ("GET", "/status", ""),
    ("GET", "/campaigns/1/runs/1/series?points=200&from_s=0.5", ""),
    ("GET", "/compare?a=1&b=2", ""),
    ("GET", "/campaigns/1/gains.param?rehearsal=true", ""),
    ("GET", "/audit?limit=10", ""),
    ("POST", "/control", r#"{"name": "Anna"}"#),
    (
        "POST",
        "/plans/preview",
        r#"{"vehicle": "none", "plan": {"thrusts": [0.6, 0.8], "sample_interval_s": 0.05}}"#,
    ),
    ("POST", "/preflight", r#"{"vehicle": "none"}"#),
    (
        "POST",
        "/trial",
        r#"{"vehicle": "none", "seed": 3, "configuration": "bare", "notes": "x", "agreed": true}"#,
    ),
    ("POST", "/trial/abort", ""),
    ("POST", "/trial/repeat", r#"{"campaign": 1, "thrust": 0.6}"#),
    ("POST", "/trial/go-on", r#"{"campaign": 1}"#),
    ("POST", "/campaigns/1/runs/1/review", r#"{"accepted": true, "note": "good"}"#),
    (
        "POST",
        "/logs/identify?name=run.csv&rudder=rudder_rad&units=heading=rad",
        "time_s,heading_rad,rudder_rad\n0,0,0\n0.05,0.1,0.2\n",
    ),
];

/// A vehicle that nobody gets.
struct Refusing;

impl TrialVehicle for Refusing {
    fn name(&self) -> &str {
        "none"
    }

    fn description(&self) -> &str {
        "refuses everything"
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn full_rudder(&self) -> Option<FullRudder> {
        None
    }

    fn prior(&self, _: &Plan<f64>, _: &Budget) -> Result<Prior, VehicleError> {
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
    _folder: tempfile::TempDir,
    server: Server,
}

impl Served {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let logbook = folder.path().join("s.db");
        let settings = Settings {
            requests_per_s: 1e9,
            ..Settings::new(SocketAddr::from(([127, 0, 0, 1], 0)), logbook)
        };
        let server = Server::start(&settings, vec![Box::new(Refusing)], Vec::new()).unwrap();
        Self { _folder: folder, server }
    }

    fn address(&self) -> String {
        let url = self.server.url();
        url.trim_start_matches("http://").trim_end_matches('/').into()
    }

    /// The status of the answer; 0 where the connection was closed, or nothing came of a request that is not whole.
    fn ask(&self, request: &[u8]) -> u16 {
        let mut stream = TcpStream::connect(self.address()).unwrap();
        stream.set_read_timeout(Some(ANSWERED_WITHIN)).unwrap();
        let _ = stream.write_all(request);
        let mut answer = [0; 64];
        let read = stream.read(&mut answer).unwrap_or(0);
        let head = String::from_utf8_lossy(&answer[..read]).into_owned();
        head.split_whitespace().nth(1).and_then(|status| status.parse().ok()).unwrap_or(0)
    }

    fn request(&self, method: &[u8], path: &[u8], body: &[u8], header: &[u8]) -> Vec<u8> {
        let head = format!(
            "Host: {}\r\nConnection: close\r\nContent-Type: application/json\r\n",
            self.address()
        );
        let length = format!("\r\nContent-Length: {}\r\n\r\n", body.len());
        [
            method,
            b" /api/v1",
            path,
            b" HTTP/1.1\r\n",
            head.as_bytes(),
            header,
            length.as_bytes(),
            body,
        ]
        .concat()
    }
}

#[test]
fn prop_no_request_or_message_makes_a_server_error() {
    let served = Served::start();
    let copies = damaged_copies(OF_EACH);
    let mut answered = 0;
    for (number, (method, path, body)) in REQUESTS.iter().enumerate() {
        for copy in 0..copies {
            let mut draw = Damage::new((number as u64) << 40 | copy);
            let [mut a, mut b, mut c] = [method, path, body].map(|text| text.as_bytes().to_vec());
            let mut header = b"seatrial-lease: 1".to_vec();
            match draw.below(8) {
                0 => a = draw.of(&a),
                1..4 => b = draw.of(&b),
                4 => header = draw.of(&header),
                _ => c = draw.of(&c),
            }
            let request = served.request(&a, &b, &c, &header);
            let status = served.ask(&request);
            answered += u64::from(status > 0);
            assert!(status < 500, "{status}: {}", String::from_utf8_lossy(&request));
        }
        assert_eq!(served.ask(&served.request(b"GET", b"/status", b"", b"x: 1")), 200);
    }
    assert!(answered > 10 * copies, "{answered}");
    let hello: &[u8] = br#"{"token": null, "stream": "x", "after": 3, "lease": null}"#;
    for seed in 0..copies {
        let (mut socket, _) =
            tungstenite::connect(format!("ws://{}/api/v1/live", served.address())).unwrap();
        let said = String::from_utf8_lossy(&Damage::new(seed).of(hello)).into_owned();
        socket.send(Message::from(said.clone())).unwrap();
        let answer = socket.read().unwrap();
        assert!(answer.is_text(), "{said}: {answer:?}");
    }
    assert_eq!(served.ask(&served.request(b"GET", b"/status", b"", b"x: 1")), 200);
}
