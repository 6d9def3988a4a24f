//! The live server, with a WebSocket client that speaks the protocol of Foxglove.
#![cfg(feature = "foxglove")]

use std::net::TcpStream;
use std::time::{Duration, Instant};

use seatrial_core::{Sample, YawModel};
use seatrial_logs::{Estimate, FoxgloveServer, Row, RowWriter};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::{Message, WebSocket};

type Client = WebSocket<TcpStream>;

fn connect(server: &FoxgloveServer) -> Client {
    let url = server.url();
    let mut request = url.as_str().into_client_request().unwrap();
    request
        .headers_mut()
        .insert("Sec-WebSocket-Protocol", HeaderValue::from_static("foxglove.sdk.v1"));
    let stream = TcpStream::connect(url.strip_prefix("ws://").unwrap()).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    tungstenite::client(request, stream).unwrap().0
}

/// The channels that the server advertises.
fn advertised(client: &mut Client) -> Vec<Value> {
    loop {
        if let Message::Text(text) = client.read().unwrap() {
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["op"] == "advertise" {
                return message["channels"].as_array().unwrap().clone();
            }
        }
    }
}

/// Subscribes to channels, numbered as they are given.
fn subscribe(client: &mut Client, channels: &[Value]) {
    let subscriptions: Vec<Value> = channels
        .iter()
        .enumerate()
        .map(|(id, channel)| json!({"id": id, "channelId": channel["id"]}))
        .collect();
    let message = json!({"op": "subscribe", "subscriptions": subscriptions}).to_string();
    client.send(Message::text(message)).unwrap();
}

fn row(k: u32) -> Row {
    Row {
        sample: Sample {
            time_s: f64::from(k) * 0.05,
            heading_rad: 0.25,
            rudder_rad: -0.5,
            ..Sample::default()
        },
        stage: None,
        estimate: Some(Estimate {
            model: YawModel::from_theta([-1.25, 2.0, 0.0]),
            half_widths: None,
            step_norm: 0.0,
        }),
    }
}

#[test]
fn io_a_viewer_receives_what_it_subscribes_to() {
    let mut server = FoxgloveServer::start("127.0.0.1", 0).unwrap();
    let mut client = connect(&server);
    let channels: Vec<Value> = advertised(&mut client)
        .into_iter()
        .filter(|channel| {
            ["/rudder_rad", "/estimate_a22_per_s"].iter().any(|topic| channel["topic"] == *topic)
        })
        .collect();
    assert_eq!(channels.len(), 2);
    for channel in &channels {
        assert_eq!(channel["encoding"], "cdr");
        assert_eq!(channel["schemaName"], "std_msgs/msg/Float64");
        assert_eq!(channel["schemaEncoding"], "ros2msg");
        assert_eq!(channel["schema"], "float64 data");
    }
    subscribe(&mut client, &channels);
    // The subscription takes effect some time later.
    let writer = std::thread::spawn(move || {
        for k in 0..400 {
            server.write(&row(k)).unwrap();
            std::thread::sleep(Duration::from_millis(5));
        }
    });
    let mut seen = [false; 2];
    while seen != [true; 2] {
        let Message::Binary(message) = client.read().unwrap() else {
            continue;
        };
        // Message data: opcode 1, subscription, time, payload.
        assert_eq!((message[0], message.len()), (1, 1 + 4 + 8 + 12));
        let subscription = u32::from_le_bytes(message[1..5].try_into().unwrap()) as usize;
        let time_ns = u64::from_le_bytes(message[5..13].try_into().unwrap());
        assert_eq!(time_ns % 50_000_000, 0);
        assert_eq!(message[13..17], [0, 1, 0, 0]);
        let value = f64::from_le_bytes(message[17..].try_into().unwrap());
        let expected = match channels[subscription]["topic"].as_str() {
            Some("/rudder_rad") => -0.5,
            _ => -1.25,
        };
        assert_eq!(value, expected);
        seen[subscription] = true;
    }
    writer.join().unwrap();
}

#[test]
fn io_a_viewer_that_reads_nothing_stops_nothing() {
    let mut server = FoxgloveServer::start("127.0.0.1", 0).unwrap();
    let mut client = connect(&server);
    let channels = advertised(&mut client);
    subscribe(&mut client, &channels);
    let begun = Instant::now();
    // Some 20 MB, more than the buffers of a connection.
    for k in 0..100_000 {
        server.write(&row(k)).unwrap();
    }
    // Ten times what it takes on a busy machine; a full connection would block for good.
    assert!(begun.elapsed() < Duration::from_secs(60));
    // It did subscribe in time.
    while !matches!(client.read().unwrap(), Message::Binary(_)) {}
    Box::new(server).finish().unwrap();
}
