//! What a link must not do: listen to the world unasked, tell its key.
#![cfg(target_os = "linux")]

use std::net::UdpSocket;
use std::time::{Duration, Instant};

use seatrial_dev::start_in;

const KEY: [u8; 32] = *b"\x01seatrial keeps this to itself!\xfe";

/// The local addresses of a process's sockets, as the kernel writes them: hexadecimal, the first byte last.
fn sockets(process: u32) -> Vec<String> {
    let links = std::fs::read_dir(format!("/proc/{process}/fd")).unwrap();
    let inodes: Vec<String> = links
        .filter_map(|link| std::fs::read_link(link.ok()?.path()).ok())
        .filter_map(|link| {
            let inode = link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?;
            Some(inode.to_string())
        })
        .collect();
    let mut sockets = Vec::new();
    for kind in ["udp", "udp6", "tcp", "tcp6"] {
        let table = std::fs::read_to_string(format!("/proc/{process}/net/{kind}")).unwrap();
        for line in table.lines().skip(1) {
            let fields: Vec<&str> = line.split_whitespace().collect();
            if inodes.iter().any(|inode| inode == fields[9]) {
                sockets.push(format!("{kind} {}", fields[1]));
            }
        }
    }
    sockets
}

fn free_port() -> u16 {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.local_addr().unwrap().port()
}

fn finds(bytes: &[u8], wanted: &[u8]) -> bool {
    bytes.windows(wanted.len()).any(|window| window == wanted)
}

/// A signed link, vehicle and trial: neither can be reached from elsewhere, and the key is in nothing that they say or leave.
#[test]
fn cli_a_link_keeps_to_this_machine_and_its_key_to_itself() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    std::fs::write(place.join("key"), KEY).unwrap();
    std::fs::write(place.join("plan.toml"), "thrusts = [0.6]\n").unwrap();
    let udp = format!("127.0.0.1:{}", free_port());
    let address = format!("mavlink:udp:{udp}");
    let signed = ["--signing-key", "key"];
    let sim = ["sim", "serve", "--udp", &udp, "--seconds", "600", "--speed", "8"];
    let mut boat = start_in(place, &[&sim[..], &signed].concat());
    let trial = [
        "trial",
        "--yes",
        "--json",
        "--plan",
        "plan.toml",
        "--full-rudder-deg",
        "14.9",
        "--vehicle",
        &address,
    ];
    let trial = start_in(place, &[&trial[..], &signed].concat());
    let mut seen = Vec::new();
    let begin = Instant::now();
    while seen.len() < 2 && begin.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(20));
        seen = [sockets(trial.id()), sockets(boat.id())].concat();
    }
    assert_eq!(seen.len(), 2, "{seen:?}");
    // 127.0.0.1
    assert!(seen.iter().all(|socket| socket.starts_with("udp 0100007F:")), "{seen:?}");
    let output = trial.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    // Its model may be refused on a busy machine: the vehicle is in a hurry.
    assert!(matches!(output.status.code(), Some(0 | 4)), "{errors}");
    boat.kill().unwrap();
    let boat = boat.wait_with_output().unwrap();
    let mut said = vec![output.stdout, output.stderr, boat.stdout, boat.stderr];
    for entry in std::fs::read_dir(place).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().unwrap() != "key" {
            said.push(std::fs::read(path).unwrap());
        }
    }
    let hexadecimal: String = KEY.iter().map(|byte| format!("{byte:02x}")).collect();
    let listed = format!("{:?}", &KEY[..4]);
    let listed = listed.trim_end_matches(']');
    for bytes in &said {
        // Its beginning is enough to tell.
        let lower = bytes.to_ascii_lowercase();
        assert!(!finds(bytes, &KEY[..8]));
        assert!(!finds(&lower, &hexadecimal.as_bytes()[..16]));
        assert!(!finds(bytes, listed.as_bytes()));
    }
}
