//! Messages in the vehicle's name with sound checksums, and bytes of any kind, between those of a vehicle that is inspected, taken,
//! driven and handed back.
#![no_main]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial_core::{Plan, Trial, Vehicle};
use seatrial_links::autopilot::{Autopilot, Profile, Settings, Speaker, SteeringOutputs};
use seatrial_links::link::{Encoder, Message, Sender, Wire};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

const INTERVAL_S: f64 = 0.05;
const FULL_RUDDER_RAD: f64 = 0.26;
const PROFILES: [Profile; 3] = [Profile::Rover, Profile::Sub, Profile::Px4];
const VEHICLE: Sender = Sender {
    system: 1,
    component: 1,
};
/// Samples after the vehicle was taken.
const SAMPLES: usize = 100;
/// A trial is aborted after this, s.
const LONGEST_S: f64 = 60.0;

/// A vehicle, and what else comes from its address.
struct Between {
    boat: Speaker<FirstOrderVehicle>,
    now_s: f64,
    step_s: f64,
    /// Nothing else comes before, s.
    from_s: f64,
    input: Vec<u8>,
    read: usize,
    abort: Arc<AtomicBool>,
}

impl Between {
    fn byte(&mut self) -> Option<u8> {
        let byte = self.input.get(self.read).copied();
        self.read += 1;
        byte
    }

    /// A number, a length and a payload make a message; a length above 127 makes bytes of any kind.
    fn forged(&mut self) -> Vec<u8> {
        let (Some(low), Some(length)) = (self.byte(), self.byte()) else {
            self.abort.store(true, Ordering::Relaxed);
            return Vec::new();
        };
        let bytes: Vec<u8> = (0..length & 0x7f).map_while(|_| self.byte()).collect();
        if length > 127 {
            return bytes;
        }
        let mut payload = [0; 255];
        payload[..bytes.len()].copy_from_slice(&bytes);
        let message = Message::read(u32::from(low), &payload);
        message.map_or(Vec::new(), |message| {
            Encoder::new(VEHICLE).encode(&message, None, 0.0)
        })
    }
}

impl Wire for Between {
    fn now_s(&self) -> f64 {
        self.now_s
    }

    fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
        if self.step_s > until_s {
            self.now_s = self.now_s.max(until_s);
            return;
        }
        self.now_s = self.now_s.max(self.step_s);
        self.step_s += INTERVAL_S;
        if self.now_s > LONGEST_S {
            self.abort.store(true, Ordering::Relaxed);
        }
        let Ok(sent) = self.boat.step();
        bytes.extend(sent.unwrap_or_default());
        if self.now_s >= self.from_s {
            bytes.extend(self.forged());
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.boat.receive(bytes);
    }
}

fn play(first: u8, input: &[u8]) {
    let profile = PROFILES[usize::from(first) % PROFILES.len()];
    let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).expect("a vehicle");
    let abort = Arc::new(AtomicBool::new(false));
    let wire = Between {
        boat: Speaker::new(vehicle, profile, INTERVAL_S, FULL_RUDDER_RAD, None),
        now_s: 0.0,
        step_s: 0.0,
        from_s: f64::from(first >> 2) / 2.0,
        input: input.to_vec(),
        read: 0,
        abort: abort.clone(),
    };
    let settings = Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        trying_thrust: 0.6,
        envelope: Some("the plan's".into()),
        abort,
        outputs: (profile == Profile::Px4).then(|| SteeringOutputs {
            outputs: vec![1],
            pulses_us: [1100.0, 1500.0, 1900.0],
        }),
        ..Settings::default()
    };
    let mut autopilot = Autopilot::new(wire, settings, None);
    let preflight = autopilot.inspect();
    if preflight.checks.iter().all(|check| check.passed) {
        let taken = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
        if taken.iter().all(|check| check.passed) {
            let mut trial = Trial::new(Plan::paper()).expect("the paper's plan");
            for _ in 0..SAMPLES {
                let Ok(Some(sample)) = autopilot.next_sample() else {
                    break;
                };
                let _ = autopilot.act(&trial.step(&sample));
                while trial.take_event().is_some() {}
            }
        }
        autopilot.hand_back();
    }
}

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant_seed("mavlink", 0, vec![0, 30, 28, 1, 2, 3, 4, 0, 9, 1, 2, 3]),
    |data: &[u8]| {
        if let Some((first, input)) = data.split_first() {
            play(*first, input);
        }
    }
);
