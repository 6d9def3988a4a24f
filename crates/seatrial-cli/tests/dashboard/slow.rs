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
            let said: &[u8] = if k % 2 == 0 {
                b"GET / HTTP/1.1\r\nHost: "
            } else {
                b""
            };
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

/// Processor time of the server so far, in ticks of 10 ms.
#[cfg(target_os = "linux")]
fn ticks(server: &Server) -> u64 {
    let about = std::fs::read_to_string(format!("/proc/{}/stat", server.child.id())).unwrap();
    let fields: Vec<&str> = about.split_whitespace().collect();
    fields[13].parse::<u64>().unwrap() + fields[14].parse::<u64>().unwrap()
}

/// A plan of days at a millisecond, and one that takes long to be played: neither costs memory or time, also where its client leaves.
#[cfg(target_os = "linux")]
#[test]
fn cli_a_preview_has_a_budget_and_ends_with_its_client() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--require-token"]);
    let thrusts: Vec<f64> = (0..16).map(|k| 0.5 + 0.03 * f64::from(k)).collect();
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = serde_json::json!(thrusts);
    let mut endless = plan.clone();
    endless["sample_interval_s"] = serde_json::json!(0.001);
    endless["settle"]["at_most_s"] = serde_json::json!(900_000.0);
    endless["settle"]["at_least_s"] = serde_json::json!(4000.0);
    plan["sample_interval_s"] = serde_json::json!(0.005);
    let slow = serde_json::json!({"vehicle": "sim:remus100", "plan": plan});
    let operator = server.token.replace(server.tokens[1].clone());
    for order in [
        serde_json::json!({"vehicle": "sim:starfish", "plan": endless}),
        slow.clone(),
    ] {
        let begun = Instant::now();
        let (status, told) = server.ask("POST", "/plans/preview").json(&order).send();
        assert_eq!(status, 422, "{told}");
        // Two seconds are a viewer's; this machine may be busy.
        assert!(begun.elapsed() < AT_MOST, "{:?}", begun.elapsed());
    }
    server.token = operator;
    let mut stream = TcpStream::connect(&server.address).unwrap();
    let head = format!(
        "POST /api/v1/plans/preview HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{slow}",
        server.address,
        server.tokens[0],
        slow.to_string().len()
    );
    stream.write_all(head.as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(500));
    drop(stream);
    std::thread::sleep(Duration::from_secs(1));
    let before = ticks(&server);
    std::thread::sleep(Duration::from_secs(1));
    assert!(ticks(&server) - before < 20, "it is still computed");
}
