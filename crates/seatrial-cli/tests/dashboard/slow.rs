//! Clients that take their time on purpose.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::server::Server;

/// Connections that one address may have, and how long a head or a body may stand still.
const MOST: usize = 128;
const AT_MOST: Duration = Duration::from_secs(5);

fn is_closed_within(mut stream: &TcpStream, limit: Duration) -> bool {
    stream.set_read_timeout(Some(limit)).unwrap();
    let mut said = Vec::new();
    // A reset is an end, too.
    match stream.read_to_end(&mut said) {
        Ok(_) => true,
        Err(error) => error.kind() == std::io::ErrorKind::ConnectionReset,
    }
}

/// They are turned away when there are too many of them, and cut off; who watches goes on watching.
#[test]
fn cli_slow_requests_do_not_hold_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let mut viewer = server.viewer(&serde_json::json!({}));
    viewer.next();
    let begun = Instant::now();
    let connect = || TcpStream::connect(&server.address).unwrap();
    let mut slow: Vec<TcpStream> = (0..MOST)
        .map(|k| {
            let mut stream = connect();
            let said: &[u8] = if k % 2 == 0 { b"GET / HTTP/1.1\r\nHost: " } else { b"" };
            stream.write_all(said).unwrap();
            stream
        })
        .collect();
    let one_more = connect();
    assert!(is_closed_within(&one_more, AT_MOST / 2), "too many");
    assert!(begun.elapsed() < AT_MOST, "before the first are cut off");

    // A byte now and then does not help.
    std::thread::sleep(AT_MOST / 2);
    for stream in slow.iter_mut().step_by(2) {
        let _ = stream.write_all(b"a");
    }
    for stream in &slow {
        assert!(is_closed_within(stream, 2 * AT_MOST));
    }
    assert!(begun.elapsed() < 3 * AT_MOST, "{:?}", begun.elapsed());
    assert_eq!(server.get("/status")["viewers"], 1);

    // A log that stops coming.
    let mut stalled = connect();
    let head = format!(
        "POST /api/v1/logs/identify HTTP/1.1\r\nHost: {}\r\nContent-Length: 1000\r\n\r\nt,",
        server.address
    );
    stalled.write_all(head.as_bytes()).unwrap();
    assert!(is_closed_within(&stalled, 2 * AT_MOST));
}

/// Of a plan of days at a millisecond, and of one that is long for a viewer, nothing is computed; an operator may ask for more.
#[test]
fn cli_a_preview_has_a_budget_of_samples() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--require-token"]);
    let thrusts: Vec<f64> = (0..16).map(|k| 0.5 + 0.03 * f64::from(k)).collect();
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = serde_json::json!(thrusts);
    plan["settle"]["at_most_s"] = serde_json::json!(700.0);
    plan["settle"]["at_least_s"] = serde_json::json!(600.0);
    let long = serde_json::json!({"vehicle": "sim:starfish", "plan": plan});
    plan["sample_interval_s"] = serde_json::json!(0.001);
    plan["settle"]["at_most_s"] = serde_json::json!(900_000.0);
    plan["settle"]["at_least_s"] = serde_json::json!(800_000.0);
    let endless = serde_json::json!({"vehicle": "sim:starfish", "plan": plan});
    let ask = |server: &Server, order| server.ask("POST", "/plans/preview").json(order).send();
    assert_eq!([ask(&server, &endless).0, ask(&server, &long).0], [422, 200]);
    server.token = Some(server.tokens[1].clone());
    let begun = Instant::now();
    for order in [&endless, &long] {
        let (status, told) = ask(&server, order);
        assert_eq!(status, 422, "{told}");
    }
    assert!(begun.elapsed() < AT_MOST, "{:?}", begun.elapsed());
}
