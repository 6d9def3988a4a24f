//! The vehicle is handed back while everything else stands still: nobody reads the program's output, the logbook's disk hangs, and no
//! viewer reads. `cargo nextest run -p seatrial-cli --run-ignored all --no-capture -E 'test(val_everything_stands_still)'`, with
//! SEATRIAL_STALLS for how many trials.

use std::io::{BufRead, BufReader, PipeReader, PipeWriter, Read, Write, pipe};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::process::{Child, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};

use seatrial_dev::program;
use seatrial_links::autopilot::{Profile, Speaker};
use seatrial_logbook::Logbook;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use serde_json::json;
use tungstenite::{Message, WebSocket};

use super::server::{PATIENCE, Server};

const INTERVAL: Duration = Duration::from_millis(50);
/// Until the abort the vehicle's time goes so many times faster.
const HURRY: u32 = 10;
/// From the abort to neutral rudder, and to the last parameter: the issue's, and a step of the vehicle.
const NEUTRAL_WITHIN: Duration = Duration::from_millis(550);
const BACK_WITHIN: Duration = Duration::from_millis(3050);
/// The trial is aborted within this of its first sample: in the lead-in, the doublet or after it.
const ABORTED_WITHIN: Duration = Duration::from_millis(3000);
/// Between two viewers who come: an address has 100 requests a second, and each viewer takes two.
const VIEWERS_EVERY: Duration = Duration::from_millis(25);
/// Servers at a time.
const SERVERS: u32 = 1;

/// What the vehicle saw.
#[derive(Clone, Copy, Default)]
struct Seen {
    /// When its rudder was last deflected by a command.
    deflected: Option<Instant>,
    /// When a parameter was last not as before.
    changed: Option<Instant>,
}

/// A vehicle on a socket, in a hurry while nobody measures.
struct Boat {
    socket: UdpSocket,
    is_measured: AtomicBool,
    is_over: AtomicBool,
    seen: Mutex<Seen>,
}

impl Boat {
    fn new() -> Self {
        Self {
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            is_measured: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
            seen: Mutex::default(),
        }
    }

    fn address(&self) -> String {
        format!("mavlink:udpout:{}", self.socket.local_addr().unwrap())
    }

    fn sail(&self) {
        let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
        let interval_s = INTERVAL.as_secs_f64();
        let mut speaker = Speaker::new(vehicle, Profile::Rover, interval_s, 0.26, None);
        let before: Vec<(String, f32)> = speaker.parameters().collect();
        let mut station: Option<SocketAddr> = None;
        let mut buffer = [0; 1 << 16];
        while !self.is_over.load(Ordering::Relaxed) {
            let bytes = speaker.step().unwrap().unwrap();
            if let Some(station) = station {
                // Nobody may be there any more.
                let _ = self.socket.send_to(&bytes, station);
            }
            let end = Instant::now()
                + match self.is_measured.load(Ordering::Relaxed) {
                    true => INTERVAL,
                    false => INTERVAL / HURRY,
                };
            loop {
                let left = end.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    break;
                }
                self.socket.set_read_timeout(Some(left)).unwrap();
                if let Ok((length, sender)) = self.socket.recv_from(&mut buffer) {
                    station = Some(sender);
                    speaker.receive(&buffer[..length]);
                }
            }
            let mut seen = self.seen.lock().unwrap();
            if speaker.is_steered() && speaker.steering().abs() > 0.05 {
                seen.deflected = Some(Instant::now());
            }
            if !before.iter().all(|(name, value)| speaker.parameter(name) == Some(*value)) {
                seen.changed = Some(Instant::now());
            }
        }
    }
}

/// What the program writes to: read up to its address, then never again.
struct Terminal {
    _reader: BufReader<PipeReader>,
    writer: PipeWriter,
}

impl Terminal {
    /// Fills it, so that the next byte waits for ever; what fills it waits, too.
    fn stop(&self) {
        let mut writer = self.writer.try_clone().unwrap();
        std::thread::spawn(move || while writer.write_all(&[b' '; 4096]).is_ok() {});
    }
}

/// A server that nobody reads.
struct Stalled {
    server: Server,
    _terminals: [Terminal; 2],
    _viewers: Vec<WebSocket<TcpStream>>,
}

impl Stalled {
    fn start(folder: &std::path::Path, boat: &Boat, viewers: usize) -> Self {
        let address = boat.address();
        let (reader, writer) = pipe().unwrap();
        let (said, to_say) = pipe().unwrap();
        let child: Child = program()
            .current_dir(folder)
            .args([
                "serve",
                "--listen",
                "127.0.0.1:0",
                "--require-token",
                "--full-rudder-deg",
                "14.9",
            ])
            .args(["--logbook", "seatrial.db", "--vehicle", &address])
            .stdout(Stdio::from(writer.try_clone().unwrap()))
            .stderr(Stdio::from(to_say.try_clone().unwrap()))
            .spawn()
            .unwrap();
        let (mut reader, mut said) = (BufReader::new(reader), BufReader::new(said));
        let line = |reader: &mut BufReader<PipeReader>| {
            let mut text = String::new();
            reader.read_line(&mut text).unwrap();
            text.trim().to_owned()
        };
        line(&mut said);
        let tokens = [(); 2].map(|()| {
            let text = line(&mut said);
            text.split_whitespace().last().unwrap().to_owned()
        });
        let address = line(&mut reader);
        let address = address.trim_start_matches("http://").trim_end_matches('/').to_owned();
        let server =
            Server { child, address, token: tokens.first().cloned(), tokens: tokens.to_vec() };
        let terminals =
            [Terminal { _reader: reader, writer }, Terminal { _reader: said, writer: to_say }];
        let viewers = (0..viewers).map(|_| {
            sleep(VIEWERS_EVERY);
            let hello = json!({"token": server.tokens[1]});
            let stream = TcpStream::connect(&server.address).unwrap();
            let url = format!("ws://{}/api/v1/live", server.address);
            let (mut socket, _) = tungstenite::client(url, stream).unwrap();
            socket.send(Message::text(hello.to_string())).unwrap();
            socket
        });
        let viewers = viewers.collect();
        terminals.iter().for_each(Terminal::stop);
        Self { server, _terminals: terminals, _viewers: viewers }
    }
}

/// How long the rudder and the parameters took.
type Took = (Duration, Duration);

/// Asks for the vehicle, as a person does who presses the button again; the status, where it was answered.
fn abort(server: &Server) -> Option<[u8; 3]> {
    let (address, token) = (&server.address, &server.tokens[0]);
    let head = format!(
        "POST /api/v1/trial/abort HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\nContent-Length: 0\r\n\r\n"
    );
    let mut answer = [0; 12];
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    // A connection that is closed at once is not answered.
    stream.write_all(head.as_bytes()).ok()?;
    stream.read_exact(&mut answer).ok()?;
    answer.last_chunk().copied()
}

/// Aborts a trial at some instant while everything stands still; `None` where it was over by then.
fn hand_back(
    stalled: &Stalled,
    boat: &Boat,
    folder: &std::path::Path,
    after: Duration,
) -> Option<Took> {
    let server = &stalled.server;
    let lease = server.control("Anna");
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = json!([0.6]);
    let order = json!({"vehicle": boat.address(), "plan": plan, "agreed": true});
    server.start_trial(&lease, &order);
    sleep(after);
    let held = Logbook::hold(&folder.join("seatrial.db")).unwrap();
    boat.is_measured.store(true, Ordering::Relaxed);
    let asked = Instant::now();
    let status = loop {
        if let Some(status) = abort(server) {
            break status;
        }
        assert!(asked.elapsed() < PATIENCE);
    };
    let answered = asked.elapsed();
    sleep(BACK_WITHIN + 4 * INTERVAL);
    let seen = *boat.seen.lock().unwrap();
    boat.is_measured.store(false, Ordering::Relaxed);
    drop(held);
    server.wait_for_end();
    let (released, told) = server.ask("DELETE", "/control").lease(&lease).send();
    assert!(released < 300, "{told}");
    let since =
        |at: Option<Instant>| at.map_or(Duration::ZERO, |at| at.saturating_duration_since(asked));
    assert!(seen.changed.is_some(), "no trial changed anything");
    let took = (since(seen.deflected), since(seen.changed));
    println!("answered after {answered:.2?}: {took:.2?}");
    // A trial in a hurry on a busy machine may have ended by itself.
    (status == *b"202").then_some(took)
}

/// So many trials, shared by servers with so many viewers each; how long each hand-back took.
fn hand_backs(trials: u32, servers: u32, viewers: usize) -> Vec<Took> {
    let (next, took) = (AtomicU32::new(0), Mutex::new(Vec::new()));
    scope(|threads| {
        for _ in 0..servers {
            threads.spawn(|| {
                let folder = tempfile::tempdir().unwrap();
                let boat = Boat::new();
                scope(|inner| {
                    inner.spawn(|| boat.sail());
                    let over = Over(&boat.is_over);
                    let stalled = Stalled::start(folder.path(), &boat, viewers);
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= trials {
                            break;
                        }
                        // Spread evenly: the golden ratio's multiples.
                        let share = (f64::from(number) * 0.618_033_988_749_894_9).fract();
                        let one = hand_back(
                            &stalled,
                            &boat,
                            folder.path(),
                            ABORTED_WITHIN.mul_f64(share),
                        );
                        took.lock().unwrap().extend(one);
                    }
                    drop(over);
                });
            });
        }
    });
    took.into_inner().unwrap()
}

/// Ends the vehicle's thread also where an assertion fails.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn assert_in_time(took: &[Took]) {
    let longest = took.iter().fold(Took::default(), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let late =
        took.iter().filter(|(neutral, back)| *neutral > NEUTRAL_WITHIN || *back > BACK_WITHIN);
    let late = late.count();
    println!(
        "{} hand-backs, {late} late; longest to neutral {:.2?}, to the parameters {:.2?}",
        took.len(),
        longest.0,
        longest.1
    );
    assert_eq!(late, 0, "{took:?}");
    assert!(!took.is_empty());
}

#[test]
fn io_a_vehicle_is_handed_back_while_terminal_disk_and_viewers_stand_still() {
    assert_in_time(&hand_backs(2, 1, 20));
}

#[test]
#[ignore = "measures time: some 3 h of a quiet machine for 1000"]
fn val_everything_stands_still() {
    let trials = std::env::var("SEATRIAL_STALLS").ok();
    assert_in_time(&hand_backs(trials.map_or(1000, |n| n.parse().unwrap()), SERVERS, 500));
}
