//! How soon an operator's abort is answered while 500 viewers watch, the operator's own address floods the server and logs are
//! uploaded. `cargo nextest run --workspace --run-ignored all --no-capture -E 'test(val_aborts_under_load)'`
#![cfg(target_os = "linux")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{scope, sleep};
use std::time::{Duration, Instant, SystemTime};

use rustix::process::{Resource, getrlimit, setpriority_process, setrlimit};
use rustix::thread::gettid;
use seatrial::{Campaign, Run, Step};
use seatrial_app::TrialPlan;
use seatrial_app::conduct::{Pace, Watch, conduct};
use seatrial_app::trials::order::{CampaignStart, View};
use seatrial_core::{Plan, Trial};
use seatrial_dash::{Server, Settings, TrialPlace};
use seatrial_logbook::{Keeper, Logbook, NewCampaign, Recorder};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use tungstenite::{Message, WebSocket};

/// An answer later than this is too late, in more than one of a thousand aborts.
const WITHIN: Duration = Duration::from_millis(100);
/// Between two aborts.
const EVERY: Duration = Duration::from_millis(50);
/// Between two viewers who come: an address has 100 requests a second, and each viewer takes two.
const VIEWERS_EVERY: Duration = Duration::from_millis(25);
/// Between two looks of the viewers at their sockets.
const LOOKS_EVERY: Duration = Duration::from_millis(20);
/// Rows of an uploaded log.
const ROWS: usize = 20_000;

/// What the server has to do besides.
#[derive(Clone, Copy, Debug)]
struct Load {
    viewers: usize,
    /// Clients of the operator's own address that ask as often as they can, every other with a wrong token.
    flood: usize,
    uploads: usize,
}

#[derive(Default)]
struct Counts {
    messages: AtomicU64,
    requests: AtomicU64,
    refused: AtomicU64,
    uploads: AtomicU64,
}

struct Served {
    server: Server,
    operator: String,
    viewer: String,
}

impl Served {
    fn start(folder: &Path) -> Self {
        let settings = Settings {
            token_needed: true,
            ..Settings::new(SocketAddr::from(([127, 0, 0, 1], 0)), folder.join("s.db"))
        };
        let server = Server::start(&settings, Vec::new(), Vec::new()).unwrap();
        let tokens = server.new_tokens().unwrap().clone();
        Self { server, operator: tokens.operator, viewer: tokens.viewer }
    }

    fn address(&self) -> String {
        let url = self.server.url();
        url.trim_start_matches("http://").trim_end_matches('/').into()
    }

    /// The status; 0 where the connection was closed without an answer.
    fn ask(&self, token: &str, method: &str, path: &str, body: &str) -> u16 {
        let address = self.address();
        let request = format!(
            "{method} /api/v1{path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\n\
             Content-Length: {}\r\n\r\n{body}",
            body.len()
        );
        let mut answer = String::new();
        if let Ok(mut stream) = TcpStream::connect(&address) {
            let _ = stream.write_all(request.as_bytes());
            let _ = stream.read_to_string(&mut answer);
        }
        let status = answer.split_whitespace().nth(1);
        status.and_then(|status| status.parse().ok()).unwrap_or(0)
    }

    fn watching(&self) -> WebSocket<TcpStream> {
        let address = self.address();
        let stream = TcpStream::connect(&address).unwrap();
        let (mut socket, _) =
            tungstenite::client(format!("ws://{address}/api/v1/live"), stream).unwrap();
        let hello = format!(r#"{{"token": "{}"}}"#, self.viewer);
        socket.send(Message::text(hello)).unwrap();
        socket.get_ref().set_nonblocking(true).unwrap();
        socket
    }
}

/// Clients have machines of their own: here they let others go first.
fn go_last() {
    setpriority_process(Some(gettid()), 19).unwrap();
}

/// Ends what is beside the measurement, also where that fails.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Keeps and shows a trial that goes on until the measurement is over, whatever is asked for.
struct Going<'a> {
    keeper: Keeper,
    shown: TrialPlace,
    pace: Pace,
    is_over: &'a AtomicBool,
}

impl Watch for Going<'_> {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.keeper.run_started(number, thrust, attempt);
        self.shown.run_started(number, thrust, attempt);
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.keeper.step(step, trial);
        self.shown.step(step, trial);
        self.pace.wait(step.sample.time_s);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.keeper.run_ended(run);
        self.shown.run_ended(run);
    }

    fn wants_abort(&mut self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }
}

/// A trial in real time until the measurement is over.
fn sail(served: &Served, folder: &Path, is_over: &AtomicBool, begun: &AtomicBool) {
    // No run is good enough, so that each is made again and again.
    let plan = Plan { accept_from_r2: 1.0, max_repeats: 20, ..Plan::paper() };
    let about = Campaign { seed: Some(1), ..Campaign::of("sim:starfish", &plan) };
    let new = NewCampaign {
        configuration: "default",
        notes: None,
        software_version: "test",
        vehicle: "sim:starfish",
        seed: Some(1),
        rudder_limit_rad: plan.rudder_limit_rad,
        full_rudder: None,
        scenario: None,
        plan: "",
    };
    let logbook = Logbook::open(folder.join("s.db")).unwrap();
    let recorder = Recorder::begin(logbook, &new).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let mut shown = served.server.attach(&stop).unwrap();
    shown.begun(&CampaignStart {
        campaign: recorder.campaign(),
        about: about.clone(),
        plan: TrialPlan::from(plan).checked().unwrap(),
        realtime_factor: None,
        time: SystemTime::now(),
    });
    begun.store(true, Ordering::Relaxed);
    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
    let mut going =
        Going { keeper: Keeper::new(recorder, false), shown, pace: Pace::new(1.0), is_over };
    let conducted = conduct(&mut vehicle, plan, about, &mut going).unwrap();
    assert!(is_over.load(Ordering::Relaxed), "the trial was over before the measurement");
    going.shown.ended(&conducted.campaign, &[]);
}

fn watch(mut sockets: Vec<WebSocket<TcpStream>>, is_over: &AtomicBool, counts: &Counts) {
    go_last();
    while !is_over.load(Ordering::Relaxed) {
        sleep(LOOKS_EVERY);
        for socket in &mut sockets {
            while socket.read().is_ok() {
                counts.messages.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

fn flood(served: &Served, number: usize, is_over: &AtomicBool, counts: &Counts) {
    go_last();
    let token = match number % 2 {
        0 => &served.viewer,
        _ => "wrong",
    };
    while !is_over.load(Ordering::Relaxed) {
        let status = served.ask(token, "GET", "/campaigns", "");
        counts.requests.fetch_add(1, Ordering::Relaxed);
        let is_refused = u64::from(status != 200);
        counts.refused.fetch_add(is_refused, Ordering::Relaxed);
    }
}

fn upload(served: &Served, log: &str, is_over: &AtomicBool, counts: &Counts) {
    go_last();
    while !is_over.load(Ordering::Relaxed) {
        let path = "/logs/inspect?name=run.csv";
        if served.ask(&served.operator, "POST", path, log) == 200 {
            counts.uploads.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// A log of 20 Hz.
fn log() -> String {
    let row = |k: usize| {
        let (time_s, rudder) = (0.05 * k as f64, 0.2 * f64::from(u8::from(k % 80 < 40)));
        format!("{time_s:.2},{:.6},{rudder}\n", (0.3 * time_s).sin())
    };
    let rows: String = (0..ROWS).map(row).collect();
    format!("time_s,heading_rad,rudder_rad\n{rows}")
}

/// How long so many aborts took, shortest first; each must be answered with 202.
fn aborts(load: Load, count: usize) -> Vec<Duration> {
    // As many files as the system grants.
    let mut limit = getrlimit(Resource::Nofile);
    limit.current = limit.maximum;
    setrlimit(Resource::Nofile, limit).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path());
    let (is_over, begun) = (AtomicBool::new(false), AtomicBool::new(false));
    let (counts, log) = (Counts::default(), log());
    let took = scope(|scope| {
        let over = Over(&is_over);
        scope.spawn(|| sail(&served, folder.path(), &is_over, &begun));
        let sockets = (0..load.viewers).map(|_| {
            sleep(VIEWERS_EVERY);
            served.watching()
        });
        let sockets: Vec<_> = sockets.collect();
        scope.spawn(|| watch(sockets, &is_over, &counts));
        for number in 0..load.flood {
            let (served, is_over, counts) = (&served, &is_over, &counts);
            scope.spawn(move || flood(served, number, is_over, counts));
        }
        for _ in 0..load.uploads {
            scope.spawn(|| upload(&served, &log, &is_over, &counts));
        }
        while !begun.load(Ordering::Relaxed) {
            sleep(EVERY);
        }
        let took = (0..count).map(|_| {
            sleep(EVERY);
            let asked = Instant::now();
            let status = served.ask(&served.operator, "POST", "/trial/abort", "");
            (status, asked.elapsed())
        });
        let took: Vec<_> = took.collect();
        drop(over);
        took
    });
    served.server.stop();
    println!(
        "{load:?}: {} messages read, {} requests, {} of them refused, {} uploads",
        counts.messages.into_inner(),
        counts.requests.into_inner(),
        counts.refused.into_inner(),
        counts.uploads.into_inner()
    );
    let refused = took.iter().filter(|(status, _)| *status != 202);
    assert_eq!(refused.count(), 0, "{took:?}");
    let mut took: Vec<Duration> = took.into_iter().map(|(_, took)| took).collect();
    took.sort_unstable();
    took
}

fn row(took: &[Duration]) -> String {
    let at = |permille: usize| took[(took.len() * permille / 1000).min(took.len() - 1)];
    let late = took.iter().filter(|took| **took > WITHIN).count();
    format!(
        "{} aborts: median {:.1?}, 99 % {:.1?}, 99.9 % {:.1?}, longest {:.1?}; {late} later than {WITHIN:?}",
        took.len(),
        at(500),
        at(990),
        at(999),
        at(1000)
    )
}

/// A small load, in every run of the tests: every abort is answered, most of them soon, on however busy a machine.
#[test]
fn io_every_abort_under_load_is_answered() {
    let load = Load { viewers: 30, flood: 4, uploads: 1 };
    let took = aborts(load, 40);
    println!("{}", row(&took));
    assert!(took[took.len() / 2] < 5 * WITHIN, "{}", row(&took));
}

#[test]
#[ignore = "measures time: some 4 min of a quiet machine"]
fn val_aborts_under_load() {
    let alone = Load { viewers: 0, flood: 0, uploads: 0 };
    println!("{}", row(&aborts(alone, 500)));
    let load = Load { viewers: 500, flood: 8, uploads: 5 };
    let took = aborts(load, 2000);
    println!("{}", row(&took));
    let late = took.iter().filter(|took| **took > WITHIN).count();
    assert!(late <= took.len() / 1000, "{}", row(&took));
}
