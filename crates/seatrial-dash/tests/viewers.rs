//! What a hundred viewers cost the trial. `cargo nextest run -p seatrial-dash --test viewers --run-ignored all --no-capture`

use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use seatrial::conduct::{Conducted, Pace, Watch, conduct};
use seatrial::identification::Refined;
use seatrial::logbook::{Keeper, Logbook, NewCampaign, Recorder, Step};
use seatrial::preview::Preview;
use seatrial::{Campaign, Run};
use seatrial_core::{Action, Plan, Sample, Trial, Vehicle};
use seatrial_dash::api::{Preflight, VehicleForm};
use seatrial_dash::{Craft, ReadLog, Server, Settings, Take, Tap, Workshop};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use tungstenite::{Message, WebSocket};

const VIEWERS: usize = 100;
/// The vehicle samples at 20 Hz; ten times as fast there are enough steps for a 99.9th percentile in some 20 s.
const FASTER: f64 = 10.0;

/// The trial is conducted here.
struct NoWorkshop;

impl Workshop for NoWorkshop {
    fn vehicles(&self) -> Vec<VehicleForm> {
        Vec::new()
    }

    fn preview(&self, _: &str, _: &Plan<f64>) -> Result<Preview, String> {
        Err("none".into())
    }

    fn preflight(&self, _: &str, _: &Plan<f64>) -> Result<Preflight, String> {
        Err("none".into())
    }

    fn take(&self, _: &Take) -> Result<Box<dyn Craft>, String> {
        Err("none".into())
    }

    fn identify(&self, _: &Path, _: &str) -> Result<ReadLog, String> {
        Err("none".into())
    }

    fn inspect(&self, _: &Path, _: &str) -> Result<ReadLog, String> {
        Err("none".into())
    }
}

/// Measures from a sample to the command that answers it.
struct Timed {
    vehicle: FirstOrderVehicle,
    sampled: Instant,
    steps: Vec<Duration>,
}

impl Vehicle<f64> for Timed {
    type Error = std::convert::Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Self::Error> {
        let sample = self.vehicle.next_sample();
        self.sampled = Instant::now();
        sample
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Self::Error> {
        self.steps.push(self.sampled.elapsed());
        self.vehicle.act(action)
    }
}

struct Watched {
    keeper: Keeper,
    tap: Tap,
    pace: Pace,
    /// From the command to the end of telling.
    told: Vec<Duration>,
}

impl Watch for Watched {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.keeper.run_started(number, thrust, attempt);
        self.tap.run_started(number, thrust, attempt);
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.keeper.step(step, trial);
        let begun = Instant::now();
        self.tap.step(step, trial);
        self.told.push(begun.elapsed());
        self.pace.wait(step.sample.time_s);
    }

    fn interval(&mut self, refined: &Refined) {
        self.tap.interval(refined);
    }

    fn run_ended(&mut self, run: &mut Run) {
        // Last, because it takes the record out.
        self.tap.run_ended(run);
        self.keeper.run_ended(run);
    }
}

fn viewer(address: &str) -> WebSocket<TcpStream> {
    let stream = TcpStream::connect(address).unwrap();
    let (mut socket, _) =
        tungstenite::client(format!("ws://{address}/api/v1/live"), stream).unwrap();
    socket.send(Message::text("{}")).unwrap();
    socket
}

/// Reads until the trial is over; how many messages.
fn read(mut socket: WebSocket<TcpStream>) -> usize {
    let mut messages = 0;
    while let Ok(message) = socket.read() {
        messages += 1;
        if message
            .to_text()
            .is_ok_and(|text| text.contains("\"trial_ended\""))
        {
            break;
        }
    }
    messages
}

/// The 99.9th percentiles of the step and of telling.
fn trial(viewers: usize) -> [Duration; 2] {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let settings = Settings {
        requests_per_s: 1e4,
        ..Settings::new(listen, &logbook)
    };
    let server = Server::start(&settings, NoWorkshop).unwrap();
    let plan = Plan::paper();
    let about = Campaign {
        software_version: "test".into(),
        vehicle: "sim:starfish".into(),
        configuration: "default".into(),
        seed: Some(1),
        rudder_limit_rad: plan.rudder_limit_rad,
        runs: Vec::new(),
        outcome: None,
    };
    let new = NewCampaign {
        configuration: "default",
        notes: None,
        software_version: "test",
        vehicle: "sim:starfish",
        seed: Some(1),
        rudder_limit_rad: plan.rudder_limit_rad,
        plan: "",
    };
    let recorder = Recorder::begin(Logbook::open(&logbook).unwrap(), &new).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let tap = server
        .attach(recorder.campaign(), &about, &plan, Arc::clone(&stop))
        .unwrap();
    let url = server.url();
    let address = url.trim_start_matches("http://").trim_end_matches('/');
    let idle: Vec<_> = (0..viewers / 10).map(|_| viewer(address)).collect();
    let reading: Vec<_> = (idle.len()..viewers)
        .map(|_| viewer(address))
        .map(|socket| std::thread::spawn(move || read(socket)))
        .collect();
    let mut vehicle = Timed {
        vehicle: FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap(),
        sampled: Instant::now(),
        steps: Vec::new(),
    };
    let mut watched = Watched {
        keeper: Keeper::new(recorder),
        tap: tap.clone(),
        pace: Pace::new(FASTER),
        told: Vec::new(),
    };
    let Conducted { campaign, .. } = conduct(&mut vehicle, plan, about, &mut watched).unwrap();
    assert!(campaign.runs.len() >= 5 && !stop.load(Ordering::Relaxed));
    server.detach(&tap, campaign.outcome, Vec::new());
    for reader in reading {
        let messages = reader.join().unwrap();
        assert!(messages > 100, "{messages} messages");
    }
    drop(idle);
    server.stop();
    [percentile(vehicle.steps), percentile(watched.told)]
}

fn percentile(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() * 999 / 1000]
}

#[test]
#[ignore = "measures time: some 2 min of a quiet machine"]
fn val_a_hundred_viewers_cost_the_trial_nothing() {
    let ([alone, told_alone], [watched, told_watched]) = (trial(0), trial(VIEWERS));
    println!(
        "99.9th percentile of the step: {alone:?} alone, {watched:?} with {VIEWERS} viewers, a tenth of which never reads; \
         of telling: {told_alone:?}, {told_watched:?}"
    );
    // A tenth, and what a timer of this machine can tell.
    assert!(watched <= alone.mul_f64(1.1) + Duration::from_micros(100));
}
