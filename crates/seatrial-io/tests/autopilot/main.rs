//! Trials on a vehicle that speaks MAVLink, in made-up time: bad links, pilots, failsafes, a process that is gone.

use std::collections::{BTreeMap, VecDeque};

use seatrial::campaign::Campaign;
use seatrial::conduct::{Conducted, Watch, conduct};
use seatrial::logbook::Step;
use seatrial_core::{AbortReason, List, Outcome, Plan, Trial};
use seatrial_io::autopilot::{Autopilot, Backup, Check, Settings, Speaker, Stop};
use seatrial_io::link::message::Heartbeat;
use seatrial_io::link::{Decoder, Encoder, Message, Sender, Wire};
use seatrial_sim::plant::Servo;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

const INTERVAL_S: f64 = 0.05;
const FULL_RUDDER_RAD: f64 = 0.26;

/// Numbers that look random, the same for a seed.
#[derive(Clone)]
struct Draw(u64);

impl Draw {
    /// From 0 up to 1.
    fn next(&mut self) -> f64 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2_f64.powi(64)
    }
}

/// What the link does to datagrams.
#[derive(Clone, Copy, Default)]
struct Weather {
    loss: f64,
    duplication: f64,
    latency_s: f64,
    /// Further latency of a datagram, up to: they overtake each other.
    jitter_s: f64,
    garbage: f64,
}

/// What happens to the vehicle or the link.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mishap {
    PilotMode,
    PilotStick,
    Battery,
    Disarmed,
    Reboot,
    SecondStation,
    /// Nothing comes any more, and nothing arrives.
    LinkLost,
    /// Likewise, for 3 s.
    LinkLostForAWhile,
    /// The vehicle is heard but does not hear.
    Deaf,
    /// The vehicle hears but is not heard.
    Mute,
    /// The operator stops the trial.
    Abort,
    /// Our process is gone.
    Killed,
}

const MISHAPS: [Mishap; 12] = [
    Mishap::PilotMode,
    Mishap::PilotStick,
    Mishap::Battery,
    Mishap::Disarmed,
    Mishap::Reboot,
    Mishap::SecondStation,
    Mishap::LinkLost,
    Mishap::LinkLostForAWhile,
    Mishap::Deaf,
    Mishap::Mute,
    Mishap::Abort,
    Mishap::Killed,
];

type Boat = Speaker<FirstOrderVehicle>;

/// A vehicle and the link to it, in made-up time.
struct Sea {
    boat: Boat,
    config: VehicleConfig,
    now_s: f64,
    step_s: f64,
    to_us: VecDeque<(f64, Vec<u8>)>,
    to_boat: VecDeque<(f64, Vec<u8>)>,
    weather: Weather,
    draw: Draw,
    mishap: Option<(f64, Mishap)>,
    has_happened: bool,
    /// When the mishap could be known on this side.
    seen_s: Option<f64>,
    decoder: Decoder,
    /// When the vehicle last held a rudder that was asked for.
    held_s: f64,
}

fn boat(config: &VehicleConfig) -> Boat {
    let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
    Speaker::new(vehicle, INTERVAL_S, FULL_RUDDER_RAD, None)
}

impl Sea {
    fn new(config: VehicleConfig, weather: Weather, seed: u64) -> Self {
        Self {
            boat: boat(&config),
            config,
            now_s: 0.0,
            step_s: 0.0,
            to_us: VecDeque::new(),
            to_boat: VecDeque::new(),
            weather,
            draw: Draw(seed),
            mishap: None,
            has_happened: false,
            seen_s: None,
            decoder: Decoder::default(),
            held_s: 0.0,
        }
    }

    fn is_cut(&self, to_us: bool) -> bool {
        let Some((at_s, mishap)) = self.mishap.filter(|(at_s, _)| self.now_s >= *at_s) else {
            return false;
        };
        match mishap {
            Mishap::LinkLost => true,
            Mishap::LinkLostForAWhile => self.now_s < at_s + 3.0,
            Mishap::Deaf => !to_us,
            Mishap::Mute => to_us,
            _ => false,
        }
    }

    fn throw(&mut self, bytes: Vec<u8>, to_us: bool) {
        if bytes.is_empty() || self.is_cut(to_us) {
            return;
        }
        let weather = self.weather;
        let copies = 1 + u32::from(self.draw.next() < weather.duplication);
        for _ in 0..copies {
            if self.draw.next() < weather.loss {
                continue;
            }
            let arrival_s = self.now_s + weather.latency_s + weather.jitter_s * self.draw.next();
            let mut datagram = bytes.clone();
            if self.draw.next() < weather.garbage {
                datagram = (0..60)
                    .map(|_| (256.0 * self.draw.next()) as u8 | 0xf0)
                    .collect();
            }
            let queue = if to_us {
                &mut self.to_us
            } else {
                &mut self.to_boat
            };
            let place = queue.iter().rposition(|(other_s, _)| *other_s <= arrival_s);
            queue.insert(place.map_or(0, |place| place + 1), (arrival_s, datagram));
        }
    }

    fn happen(&mut self) {
        let Some((at_s, mishap)) = self.mishap else {
            return;
        };
        if self.has_happened || self.now_s < at_s {
            return;
        }
        self.has_happened = true;
        match mishap {
            Mishap::PilotMode => self.boat.mode = 4,
            Mishap::PilotStick => self.boat.sticks_us[6] = 1900,
            Mishap::Battery => self.boat.battery_percent = 5,
            Mishap::Disarmed => self.boat.is_armed = false,
            Mishap::Reboot => self.boat = boat(&self.config),
            Mishap::SecondStation => {
                let station = Sender {
                    system: 255,
                    component: 1,
                };
                let heartbeat = Message::from(Heartbeat {
                    custom_mode: 0,
                    kind: 6,
                    autopilot: 8,
                    base_mode: 0,
                    system_status: 4,
                    mavlink_version: 3,
                });
                let frame = Encoder::new(station).encode(&heartbeat, None, 0.0);
                self.throw(frame, true);
            }
            _ => self.seen_s = Some(self.now_s),
        }
    }

    /// Does what has come tell of the mishap?
    fn look(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        while let Some(frame) = self.decoder.next(None, 0.0) {
            let (Some(message), Some((_, mishap))) = (frame.message(), self.mishap) else {
                continue;
            };
            let tells = match (mishap, message) {
                (Mishap::PilotMode, Message::Heartbeat(h)) => h.custom_mode != 0,
                (Mishap::PilotStick, Message::RcChannels(rc)) => rc.pulses[6] == 1900,
                (Mishap::Battery, Message::SysStatus(status)) => status.battery_percent == 5,
                (Mishap::Disarmed, Message::Heartbeat(h)) => h.base_mode & 0x80 == 0,
                (Mishap::Reboot, Message::Attitude(_)) => true,
                (Mishap::SecondStation, Message::Heartbeat(_)) => frame.sender.system == 255,
                _ => false,
            };
            if self.has_happened && tells && self.seen_s.is_none() {
                self.seen_s = Some(self.now_s);
            }
        }
    }

    /// Lets the time pass until something has come for us, or that long.
    fn pass(&mut self, until_s: f64) -> Option<Vec<u8>> {
        loop {
            let next_s = self.to_us.front().map_or(f64::INFINITY, |(at_s, _)| *at_s);
            let boat_s = self
                .to_boat
                .front()
                .map_or(f64::INFINITY, |(at_s, _)| *at_s);
            let due_s = next_s.min(boat_s).min(self.step_s);
            if due_s > until_s {
                self.now_s = self.now_s.max(until_s);
                return None;
            }
            self.now_s = self.now_s.max(due_s);
            self.happen();
            if boat_s <= due_s {
                if let Some((_, bytes)) = self.to_boat.pop_front() {
                    self.boat.receive(&bytes);
                }
            } else if next_s <= due_s {
                let (_, bytes) = self.to_us.pop_front()?;
                if !self.is_cut(true) {
                    self.look(&bytes);
                    return Some(bytes);
                }
            } else {
                self.step_s += INTERVAL_S;
                if self.boat.mode == 0 && self.boat.is_armed && self.boat.steering().abs() > 0.05 {
                    self.held_s = self.now_s;
                }
                let bytes = self.boat.step().unwrap().unwrap();
                self.throw(bytes, true);
            }
        }
    }
}

impl Wire for Sea {
    fn now_s(&self) -> f64 {
        self.now_s
    }

    fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
        if let Some(received) = self.pass(until_s) {
            bytes.extend(received);
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.throw(bytes.to_vec(), false);
    }
}

fn starfish() -> VehicleConfig {
    VehicleConfig::starfish()
}

fn plan() -> Plan<f64> {
    Plan {
        thrusts: List::from_slice(&[0.6]).unwrap(),
        ..Plan::paper()
    }
}

fn settings() -> Settings {
    Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        trying_thrust: 0.6,
        envelope: Some("the paper's".into()),
        ..Settings::default()
    }
}

fn about() -> Campaign {
    Campaign {
        software_version: "test".into(),
        vehicle: "mavlink".into(),
        configuration: "default".into(),
        seed: None,
        rudder_limit_rad: FULL_RUDDER_RAD,
        runs: Vec::new(),
        outcome: None,
    }
}

/// Keeps every step, and aborts when it is told.
#[derive(Default)]
struct Witness {
    steps: Vec<Step>,
    abort_from_s: Option<f64>,
    stop_from_s: Option<f64>,
}

impl Watch for Witness {
    fn step(&mut self, step: &Step, _trial: &Trial<f64>) {
        self.steps.push(*step);
        let is_gone = self
            .stop_from_s
            .is_some_and(|from_s| step.sample.time_s >= from_s);
        assert!(!is_gone, "the process is gone");
    }

    fn wants_abort(&mut self) -> bool {
        let last_s = self.steps.last().map_or(0.0, |step| step.sample.time_s);
        self.abort_from_s.is_some_and(|from_s| last_s >= from_s)
    }
}

fn failures(checks: &[Check]) -> Vec<String> {
    let failed = checks.iter().filter(|check| !check.passed);
    failed
        .map(|check| format!("{}: {}", check.name, check.text))
        .collect()
}

/// A vehicle that is ours, and what would put it back.
fn taken(sea: Sea) -> (Autopilot<Sea>, Backup) {
    let mut autopilot = Autopilot::new(sea, settings(), None);
    let preflight = autopilot.inspect();
    assert_eq!(failures(&preflight.checks), [""; 0]);
    let mut kept = None;
    let checks = autopilot.take_control(&preflight.changes, &mut |backup| {
        kept = Some(backup.clone());
        Ok(())
    });
    assert_eq!(failures(&checks), [""; 0]);
    (autopilot, kept.unwrap())
}

fn run(autopilot: &mut Autopilot<Sea>, witness: &mut Witness) -> Conducted<Stop> {
    conduct(autopilot, plan(), about(), witness).unwrap()
}

fn assert_as_before(sea: &Sea) {
    assert_eq!(sea.boat.parameter("RC_OVERRIDE_TIME"), Some(3.0));
    assert_eq!(sea.boat.parameter("FS_GCS_ENABLE"), Some(0.0));
}

/// The estimates of the steps again, bit for bit.
fn assert_replays(steps: &[Step]) {
    let mut trial = Trial::new(plan()).unwrap();
    // The two steps of an operator's abort are nothing that samples tell.
    let is_over = steps
        .last()
        .is_some_and(|step| step.action.outcome.is_some());
    for step in &steps[..steps.len() - if is_over { 2 } else { 0 }] {
        let again = Step::take(&mut trial, step.sample);
        let bits = |step: &Step| step.estimate.map(|model| model.theta().map(f64::to_bits));
        assert_eq!(bits(&again), bits(step));
        while trial.take_event().is_some() {}
    }
}

fn assert_near(campaign: &Campaign, truth: [f64; 2], share: f64) {
    let run = campaign.runs.last().unwrap();
    let identification = run.identification.as_ref().expect("a model");
    let model = identification.model();
    for (found, truth) in [model.a22_per_s, model.b2_per_s2].into_iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < share, "{found} for {truth}");
    }
}

fn truth(config: &VehicleConfig) -> [f64; 2] {
    let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
    let model = vehicle.truth(0.6).model;
    [model.a22_per_s, model.b2_per_s2]
}

/// Quiet water: the tolerance of the issue is for the link, not for the sea.
fn calm() -> VehicleConfig {
    let mut config = starfish().noise_free();
    config.sensors.compass.noise_rad = 0.003;
    config
}

#[test]
fn recover_a_whole_trial_replays_bit_for_bit() {
    let (mut autopilot, backup) = taken(Sea::new(calm(), Weather::default(), 1));
    assert_eq!(backup.mode, Some(4));
    assert_eq!(autopilot.wire().boat.mode, 0);
    let mut witness = Witness::default();
    let conducted = run(&mut autopilot, &mut witness);
    assert_eq!(conducted.fault, None);
    assert_eq!(conducted.campaign.outcome, Some(Outcome::Finished));
    let done = autopilot.hand_back();
    assert!(done.is_complete(), "{done:?}");
    assert_eq!(done.mode_restored, Some(true));
    assert_eq!(done.throttle_neutral, Some(true));
    assert_as_before(autopilot.wire());
    assert_eq!(autopilot.wire().boat.mode, 4);
    assert_replays(&witness.steps);
    // The 5 %.
    assert_near(&conducted.campaign, truth(&calm()), 0.05);
}

/// ArduPilot's Rover on the plant: a servo's lag of 0.15 s, which the outputs do not show.
#[test]
fn recover_a_lagging_rudder() {
    let mut config = calm();
    config.servo = Servo {
        time_constant_s: 0.15,
        ..config.servo
    };
    for speed in &mut config.speeds {
        (speed.a22_per_s, speed.b2_per_s2, speed.c0_rad_per_s2) = (-0.91, 1.75, 0.02);
    }
    let (mut autopilot, _) = taken(Sea::new(config.clone(), Weather::default(), 1));
    let mut witness = Witness::default();
    let conducted = run(&mut autopilot, &mut witness);
    // The 5 %, lag included.
    assert_near(&conducted.campaign, truth(&config), 0.05);
}

#[test]
fn recover_through_bad_links() {
    let loss = Weather {
        loss: 0.3,
        ..Weather::default()
    };
    let disorder = Weather {
        duplication: 0.3,
        jitter_s: 0.12,
        garbage: 0.05,
        ..Weather::default()
    };
    let late = Weather {
        latency_s: 0.5,
        ..Weather::default()
    };
    for (name, weather, share) in [
        ("loss", loss, 0.1),
        ("disorder", disorder, 0.1),
        ("late", late, 0.05),
    ] {
        let (mut autopilot, _) = taken(Sea::new(calm(), weather, 3));
        let mut witness = Witness::default();
        let conducted = run(&mut autopilot, &mut witness);
        let outcome = conducted.campaign.outcome;
        assert_eq!(
            outcome,
            Some(Outcome::Finished),
            "{name}: {:?}",
            conducted.fault
        );
        let done = autopilot.hand_back();
        assert!(done.is_complete(), "{name}: {done:?}");
        assert_as_before(autopilot.wire());
        assert_replays(&witness.steps);
        // A third of the samples are missing, and with them the instants of some edges.
        assert_near(&conducted.campaign, truth(&calm()), share);
    }
}

/// One mishap at one time; what the vehicle did about it.
fn suffer(mishap: Mishap, after_s: f64, seed: u64) {
    let (mut autopilot, backup) = taken(Sea::new(starfish(), Weather::default(), seed));
    let start_s = autopilot.wire().now_s;
    let at_s = start_s + after_s;
    let told = format!("{mishap:?} after {after_s:.2} s, seed {seed}");
    let mut witness = Witness::default();
    autopilot.wire().mishap = Some((at_s, mishap));
    match mishap {
        Mishap::Abort => witness.abort_from_s = Some(at_s),
        Mishap::Killed => witness.stop_from_s = Some(at_s),
        _ => {}
    }
    if mishap == Mishap::Killed {
        // Nothing of ours runs any more, not even what runs when something is dropped.
        let mut autopilot = std::mem::ManuallyDrop::new(autopilot);
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let gone = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            run(&mut autopilot, &mut witness)
        }));
        std::panic::set_hook(hook);
        assert!(gone.is_err(), "{told}");
        let end_s = autopilot.wire().now_s + 5.0;
        while autopilot.wire().pass(end_s).is_some() {}
        assert_held(autopilot.wire(), &told);
        let sea = std::mem::ManuallyDrop::into_inner(autopilot);
        restore_later(sea, &backup, &told);
        return;
    }
    let conducted = run(&mut autopilot, &mut witness);
    let outcome = conducted.campaign.outcome.unwrap();
    assert_ne!(outcome, Outcome::Finished, "{told}");
    let is_pilots = matches!(
        mishap,
        Mishap::PilotMode | Mishap::PilotStick | Mishap::Disarmed | Mishap::Abort
    );
    // A disarmed vehicle may be noticed first by its rudder, which does not follow.
    let is_noticed_first = mishap == Mishap::Disarmed && conducted.fault.is_some();
    let expected = if is_pilots && !is_noticed_first {
        AbortReason::Operator
    } else {
        AbortReason::LinkLost
    };
    assert_eq!(outcome, Outcome::Aborted(expected), "{told}");
    let last_s = witness.steps.last().unwrap().sample.time_s;
    // A sample is complete with the next, and one may be under way.
    let gap_s = autopilot
        .wire()
        .seen_s
        .map_or(0.0, |seen_s| seen_s - last_s);
    assert!(
        gap_s < 0.2 || mishap == Mishap::Reboot,
        "{told}: {gap_s} s are missing"
    );
    let kept = conducted
        .campaign
        .runs
        .iter()
        .map(|run| run.record.samples.len())
        .sum::<usize>();
    assert!(
        kept + 3 >= witness.steps.len(),
        "{told}: {kept} of {}",
        witness.steps.len()
    );
    assert_replays(&witness.steps);
    let done = autopilot.hand_back();
    assert_held(autopilot.wire(), &told);
    let is_cut = matches!(mishap, Mishap::LinkLost | Mishap::Deaf | Mishap::Mute);
    assert_eq!(done.not_restored.is_empty(), !is_cut, "{told}: {done:?}");
    if is_cut {
        autopilot.wire().mishap = None;
        restore_later(autopilot, &backup, &told);
    } else if mishap != Mishap::Reboot {
        assert_as_before(autopilot.wire());
    }
    // A reboot is a vehicle that has forgotten what was changed: it is as before already.
}

fn assert_held(sea: &Sea, told: &str) {
    // What is noticed by a rudder that does not follow is never told.
    let seen_s = sea.seen_s.unwrap_or(sea.now_s);
    // The second, and a step of the vehicle.
    let held_s = sea.held_s - seen_s;
    assert!(
        held_s <= 1.0 + INTERVAL_S,
        "{told}: the rudder was held for {held_s:.2} s"
    );
}

fn restore_later(mut autopilot: Autopilot<Sea>, backup: &Backup, told: &str) {
    autopilot.wire().mishap = None;
    let done = autopilot.restore(backup);
    assert!(done.is_complete(), "{told}: {done:?}");
    assert_as_before(autopilot.wire());
    std::mem::forget(autopilot);
}

/// Mishaps at random instants of the trial; SEATRIAL_MISHAPS says how many.
#[test]
fn prop_every_mishap_ends_with_the_rudder_released() {
    let count = std::env::var("SEATRIAL_MISHAPS").ok();
    let count = count.and_then(|count| count.parse().ok()).unwrap_or(36);
    let mut draw = Draw(20);
    let mut suffered = BTreeMap::new();
    for seed in 0..count {
        let mishap = MISHAPS[seed as usize % MISHAPS.len()];
        // Settling takes 10 to 40 s, then 33 s of manoeuvres.
        suffer(mishap, 0.5 + 40.0 * draw.next(), seed);
        *suffered.entry(format!("{mishap:?}")).or_insert(0) += 1;
    }
    println!("{suffered:?}");
}

#[test]
fn io_a_preflight_refuses_and_says_why() {
    let refused = |change: fn(&mut Sea), settings: Settings| {
        let mut sea = Sea::new(starfish(), Weather::default(), 1);
        change(&mut sea);
        failures(&Autopilot::new(sea, settings, None).inspect().checks).join("; ")
    };
    let with = |change: fn(&mut Settings)| {
        let mut settings = settings();
        change(&mut settings);
        settings
    };
    type Case = (fn(&mut Sea), Settings, &'static str);
    let cases: [Case; 6] = [
        (|sea| sea.boat.is_armed = false, settings(), "armed"),
        (|sea| sea.boat.battery_percent = 10, settings(), "battery"),
        (|sea| sea.weather.loss = 1.0, settings(), "heartbeat"),
        (|_| {}, with(|s| s.system_id = 254), "system id"),
        (|_| {}, with(|s| s.sample_interval_s = 0.02), "rates"),
        (|_| {}, with(|s| s.envelope = None), "envelope"),
    ];
    for (change, settings, expected) in cases {
        let refused = refused(change, settings);
        assert!(refused.contains(expected), "{expected}: {refused}");
    }
}

/// A rudder that turns the other way, and one whose output does not move, are found before the trial.
#[test]
fn io_the_wiggle_finds_a_rudder_that_does_not_answer() {
    let refused = |config: VehicleConfig, settings: Settings| {
        let mut autopilot = Autopilot::new(Sea::new(config, Weather::default(), 1), settings, None);
        let preflight = autopilot.inspect();
        let checks = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
        let failures = failures(&checks).join("; ");
        autopilot.hand_back();
        assert_as_before(autopilot.wire());
        failures
    };
    let mut reversed = starfish();
    reversed
        .speeds
        .iter_mut()
        .for_each(|speed| speed.b2_per_s2 *= -1.0);
    assert!(refused(reversed, settings()).contains("rudder sense"));
    let elsewhere = Settings {
        outputs: Some(seatrial_io::autopilot::SteeringOutputs {
            outputs: vec![2],
            pulses_us: [1100.0, 1500.0, 1900.0],
        }),
        ..settings()
    };
    assert!(refused(starfish(), elsewhere).contains("echo"));
}

/// Without a place for the backup nothing is changed.
#[test]
fn io_no_backup_no_change() {
    let sea = Sea::new(starfish(), Weather::default(), 1);
    let mut autopilot = Autopilot::new(sea, settings(), None);
    let preflight = autopilot.inspect();
    let checks = autopilot.take_control(&preflight.changes, &mut |_| {
        Err(std::io::Error::other("full"))
    });
    assert!(failures(&checks).join("").contains("full"));
    assert_as_before(autopilot.wire());
    assert_eq!(autopilot.wire().boat.mode, 4);
}

/// A panic on this side hands the vehicle back as it is dropped.
#[test]
fn io_a_panic_hands_the_vehicle_back() {
    struct Shared(std::rc::Rc<std::cell::RefCell<Sea>>);
    impl Wire for Shared {
        fn now_s(&self) -> f64 {
            self.0.borrow().now_s
        }
        fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
            self.0.borrow_mut().receive(bytes, until_s);
        }
        fn send(&mut self, bytes: &[u8]) {
            self.0.borrow_mut().send(bytes);
        }
    }
    let sea = std::rc::Rc::new(std::cell::RefCell::new(Sea::new(
        starfish(),
        Weather::default(),
        1,
    )));
    let mut autopilot = Autopilot::new(Shared(sea.clone()), settings(), None);
    let preflight = autopilot.inspect();
    let checks = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
    assert_eq!(failures(&checks), [""; 0]);
    let start_s = sea.borrow().now_s;
    let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(move || {
        let mut witness = Witness {
            stop_from_s: Some(start_s + 12.0),
            ..Witness::default()
        };
        conduct(&mut autopilot, plan(), about(), &mut witness)
    }));
    assert!(panicked.is_err());
    assert_as_before(&sea.borrow());
    assert_eq!(sea.borrow().boat.mode, 4);
    assert_eq!(sea.borrow().boat.steering(), 0.0);
}
