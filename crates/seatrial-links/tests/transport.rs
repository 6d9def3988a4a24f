//! Links that break and mend themselves, and where they listen.
#![cfg(unix)]

use std::io::{Read, Write};
use std::net::{TcpListener, UdpSocket};
use std::time::Duration;

use seatrial_links::link::{Address, Transport, Wire};
use serialport::{SerialPort, TTYPort};

/// Longest wait for bytes that must come, s.
const LONGEST_S: f64 = 5.0;

fn receive(transport: &mut Transport, length: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let end_s = transport.now_s() + LONGEST_S;
    while bytes.len() < length && transport.now_s() < end_s {
        let until_s = transport.now_s() + 0.05;
        transport.receive(&mut bytes, until_s);
    }
    bytes
}

#[test]
fn io_a_tcp_link_comes_back() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap().to_string();
    let mut transport = Transport::open(&Address::Tcp(place)).unwrap();
    for round in 0..3_u8 {
        // The second and third are made anew by whoever reads: what is sent before is lost.
        let accepting = std::thread::spawn({
            let listener = listener.try_clone().unwrap();
            move || {
                let (mut stream, _) = listener.accept().unwrap();
                stream.write_all(&[round; 3]).unwrap();
                let mut heard = [0; 2];
                stream.read_exact(&mut heard).unwrap();
                heard
            }
        });
        assert_eq!(receive(&mut transport, 3), [round; 3]);
        transport.send(&[round, 7]);
        assert_eq!(accepting.join().unwrap(), [round, 7]);
    }
}

#[test]
fn io_a_serial_line_carries_both_ways() {
    let (mut vehicle, line) = TTYPort::pair().unwrap();
    vehicle.set_timeout(Duration::from_secs(5)).unwrap();
    let address = Address::Serial(line.name().unwrap(), 57_600);
    let mut transport = Transport::open(&address).unwrap();
    // Every byte: none is taken for a command of the terminal.
    let all: Vec<u8> = (0..=255).collect();
    vehicle.write_all(&all).unwrap();
    assert_eq!(receive(&mut transport, all.len()), all);
    transport.send(&all);
    let mut heard = vec![0; all.len()];
    vehicle.read_exact(&mut heard).unwrap();
    assert_eq!(heard, all);
    // Pulled out: nothing comes, nothing panics, sending is lost.
    drop((vehicle, line));
    let mut bytes = Vec::new();
    for _ in 0..3 {
        let until_s = transport.now_s() + 0.02;
        transport.receive(&mut bytes, until_s);
        transport.send(&all);
    }
    assert!(bytes.is_empty());
}

/// Where it is told to and nowhere else; where it only sends to this machine, it can be reached from this machine only.
#[test]
fn io_a_link_listens_at_its_address() {
    let place = "127.0.0.1:0".to_string();
    let inward = Transport::open(&Address::UdpIn(place)).unwrap();
    assert!(inward.local_address().unwrap().ip().is_loopback());
    let peer = UdpSocket::bind("127.0.0.1:0").unwrap();
    let place = peer.local_addr().unwrap().to_string();
    let mut outward = Transport::open(&Address::UdpOut(place)).unwrap();
    let local = outward.local_address().unwrap();
    assert!(local.ip().is_loopback());
    // A stranger is not heard, the peer is.
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    stranger.send_to(b"stranger", local).unwrap();
    peer.send_to(b"peer", local).unwrap();
    assert_eq!(receive(&mut outward, 4), b"peer");
}
