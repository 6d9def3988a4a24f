//! A vehicle and the link to it, in made-up time: bad weather, mishaps.

use std::collections::VecDeque;

use seatrial_links::autopilot::{Profile, Speaker};
use seatrial_links::link::{Decoder, Message, Wire};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use super::second_station;

pub const INTERVAL_S: f64 = 0.05;
pub const FULL_RUDDER_RAD: f64 = 0.26;
/// ArduSub's MANUAL.
const SUB_MANUAL: u32 = 19;

/// Numbers that look random, the same for a seed.
#[derive(Clone)]
pub struct Draw(pub u64);

impl Draw {
    /// From 0 up to 1.
    pub fn next(&mut self) -> f64 {
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
pub struct Weather {
    pub loss: f64,
    pub duplication: f64,
    pub latency_s: f64,
    /// Further latency of a datagram, up to: they overtake each other.
    pub jitter_s: f64,
    pub garbage: f64,
}

/// What happens to the vehicle or the link.
#[allow(dead_code, reason = "trials and commissions suffer some each")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mishap {
    PilotMode,
    /// The pilot takes MANUAL.
    PilotManual,
    PilotStick,
    SteeringStick,
    ThrottleStick,
    Battery,
    Disarmed,
    Reboot,
    SecondStation,
    /// Its joystick steers the vehicle; we hear nothing of it.
    SecondJoystick,
    /// Nothing comes any more, and nothing arrives.
    LinkLost,
    /// Nothing comes and nothing arrives for 3 s.
    LinkLostForAWhile,
    /// Nothing comes and nothing arrives for half a second.
    LinkGap,
    /// The vehicle is heard but does not hear.
    Deaf,
    /// It does not hear for 3 s.
    DeafForAWhile,
    /// The vehicle hears but is not heard.
    Mute,
    /// It is not heard for 3 s.
    MuteForAWhile,
    /// The vehicle takes no parameter any more.
    ParametersLost,
    /// The operator stops the trial.
    Abort,
    /// Our process is gone.
    Killed,
    /// Our process is gone, and the vehicle starts again.
    KilledAndRebooted,
}

pub const MISHAPS: [Mishap; 12] = [
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

pub type Boat = Speaker<FirstOrderVehicle>;

/// A vehicle and the link to it, in made-up time.
pub struct Sea {
    pub boat: Boat,
    config: VehicleConfig,
    pub profile: Profile,
    pub now_s: f64,
    step_s: f64,
    to_us: VecDeque<(f64, Vec<u8>)>,
    to_boat: VecDeque<(f64, Vec<u8>)>,
    pub weather: Weather,
    draw: Draw,
    pub mishap: Option<(f64, Mishap)>,
    has_happened: bool,
    /// When the mishap could be known on this side.
    pub seen_s: Option<f64>,
    decoder: Decoder,
    /// When the vehicle last held a rudder that was asked for.
    pub held_s: f64,
}

pub fn boat(config: &VehicleConfig, profile: Profile) -> Boat {
    let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
    Speaker::new(vehicle, profile, INTERVAL_S, FULL_RUDDER_RAD, None)
}

impl Sea {
    pub fn new(config: VehicleConfig, weather: Weather, seed: u64) -> Self {
        Self::of(Profile::Rover, config, weather, seed)
    }

    pub fn of(profile: Profile, config: VehicleConfig, weather: Weather, seed: u64) -> Self {
        Self {
            boat: boat(&config, profile),
            config,
            profile,
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
            Mishap::LinkGap => self.now_s < at_s + 0.5,
            Mishap::Deaf => !to_us,
            Mishap::DeafForAWhile => !to_us && self.now_s < at_s + 3.0,
            Mishap::Mute => to_us,
            Mishap::MuteForAWhile => to_us && self.now_s < at_s + 3.0,
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
                datagram = (0..60).map(|_| (256.0 * self.draw.next()) as u8 | 0xf0).collect();
            }
            let queue = if to_us { &mut self.to_us } else { &mut self.to_boat };
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
            Mishap::PilotManual => self.boat.mode = 0,
            Mishap::PilotStick => self.boat.sticks_us[self.free_stick()] = 1900,
            Mishap::SteeringStick => self.boat.sticks_us[0] = 1800,
            Mishap::ThrottleStick => self.boat.sticks_us[2] = 1200,
            Mishap::Battery => self.boat.battery_percent = 5,
            Mishap::Disarmed => self.boat.is_armed = false,
            Mishap::Reboot => self.restart(),
            Mishap::KilledAndRebooted => {
                self.restart();
                self.seen_s = Some(self.now_s);
            }
            Mishap::SecondStation => self.throw(second_station::heartbeat(), true),
            _ => self.seen_s = Some(self.now_s),
        }
    }

    /// The vehicle's autopilot starts again, disarmed, with its parameters.
    fn restart(&mut self) {
        let kept: Vec<_> = self.boat.parameters().collect();
        let mut restarted = boat(&self.config, self.profile);
        for (name, value) in kept {
            restarted.set_parameter(&name, value);
        }
        restarted.is_armed = false;
        self.boat = restarted;
    }

    /// Is a message to the vehicle lost?
    fn is_lost(&self, bytes: &[u8]) -> bool {
        let mishap = self.mishap.filter(|(at_s, _)| self.now_s >= *at_s);
        if mishap.map(|(_, mishap)| mishap) != Some(Mishap::ParametersLost) {
            return false;
        }
        let mut decoder = Decoder::default();
        decoder.push(bytes);
        let frame = decoder.next(None, 0.0);
        let message = frame.and_then(|frame| frame.message());
        matches!(message, Some(Message::ParamSet(_)))
    }

    /// Does what has come tell of the mishap?
    fn look(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        while let Some(frame) = self.decoder.next(None, 0.0) {
            let (Some(message), Some((_, mishap))) = (frame.message(), self.mishap) else {
                continue;
            };
            let tells = match (mishap, message) {
                (Mishap::PilotMode, Message::Heartbeat(h)) => h.custom_mode == 4,
                (Mishap::PilotManual, Message::Heartbeat(h)) => h.custom_mode == 0,
                (Mishap::PilotStick, Message::RcChannels(rc)) => {
                    rc.pulses[self.free_stick()] == 1900
                }
                (Mishap::SteeringStick, Message::RcChannels(rc)) => rc.pulses[0] == 1800,
                (Mishap::ThrottleStick, Message::RcChannels(rc)) => rc.pulses[2] == 1200,
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

    /// A stick that is never ours.
    fn free_stick(&self) -> usize {
        match self.profile {
            Profile::Sub => 8,
            _ => 6,
        }
    }

    /// Does it do what was asked for? A submarine that steers by itself always turns to some heading, but not ahead.
    fn is_driven(&self) -> bool {
        let is_steering = self.boat.is_steered() && self.boat.steering().abs() > 0.05;
        match self.profile == Profile::Sub && self.boat.mode != SUB_MANUAL {
            true => self.boat.thrust().abs() > 0.05,
            false => is_steering,
        }
    }

    /// Lets the time pass until something has come for us, or that long.
    pub fn pass(&mut self, until_s: f64) -> Option<Vec<u8>> {
        loop {
            let next_s = self.to_us.front().map_or(f64::INFINITY, |(at_s, _)| *at_s);
            let boat_s = self.to_boat.front().map_or(f64::INFINITY, |(at_s, _)| *at_s);
            let due_s = next_s.min(boat_s).min(self.step_s);
            if due_s > until_s {
                self.now_s = self.now_s.max(until_s);
                return None;
            }
            self.now_s = self.now_s.max(due_s);
            self.happen();
            if boat_s <= due_s {
                if let Some((_, bytes)) = self.to_boat.pop_front()
                    && !self.is_lost(&bytes)
                {
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
                if self.has_happened && self.mishap.is_some_and(|m| m.1 == Mishap::SecondJoystick) {
                    self.boat.receive(&second_station::joystick());
                }
                if self.is_driven() {
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
