//! A vehicle that speaks MAVLink behind a bad link, in made-up time.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial_links::autopilot::{Profile, Speaker};
use seatrial_links::link::message::Heartbeat;
use seatrial_links::link::{Decoder, Encoder, Message, Sender, Wire};
use seatrial_sim::sensors::Chance;
use seatrial_sim::{ConfigError, FirstOrderVehicle, VehicleConfig};

use seatrial_app::Error;

/// Between two steps of the vehicle, s.
pub const INTERVAL_S: f64 = 0.05;
/// Its rudder at full steering, rad.
pub const FULL_RUDDER_RAD: f64 = 0.26;
/// Steering above this is a rudder that somebody holds, as a fraction of full.
const HELD: f64 = 0.05;
/// How long a passing loss of the link lasts, s.
const PASSES_AFTER_S: f64 = 3.0;

/// Bytes of a frame of MAVLink 2 before and after its payload.
const HEADER: usize = 10;
const CHECKSUM: usize = 2;

/// What the link does to datagrams.
#[derive(Clone, Copy, Debug, Default)]
pub struct Weather {
    /// Share that is lost.
    pub loss: f64,
    /// Share that comes twice.
    pub duplication: f64,
    /// Least time on the way, s.
    pub latency_s: f64,
    /// Further time, up to, s: they overtake each other.
    pub jitter_s: f64,
    /// Share that is garbage.
    pub garbage: f64,
    /// What becomes of the vehicle's messages of one kind, one by one.
    pub single: Option<Single>,
}

/// Messages of one kind that come more rarely and later than the others, or not at all.
#[derive(Clone, Copy, Debug)]
pub struct Single {
    /// The kind, MAVLink's number.
    pub id: u32,
    /// From when on, s.
    pub from_s: f64,
    /// Share that is lost.
    pub loss: f64,
    /// Least time between two that are sent, s.
    pub interval_s: f64,
    /// How much later than the others they come, s.
    pub late_s: f64,
}

/// HEARTBEAT, SYS_STATUS, PARAM_VALUE, ATTITUDE, LOCAL_POSITION_NED, SERVO_OUTPUT_RAW, RC_CHANNELS, COMMAND_ACK and TIMESYNC.
const KINDS: [u32; 9] = [0, 1, 22, 30, 32, SERVO_OUTPUT_RAW, 65, 77, 111];
/// MAVLink's number of the message with the rudder.
pub const SERVO_OUTPUT_RAW: u32 = 36;

impl Single {
    /// Of every other link one kind of messages.
    pub fn drawn(chance: &mut Chance) -> Option<Self> {
        let mut drawn = |most: f64| most * chance.uniform();
        let id = KINDS[drawn(KINDS.len() as f64) as usize];
        let single = Self {
            id,
            from_s: drawn(60.0),
            loss: drawn(0.5),
            interval_s: drawn(0.5),
            late_s: drawn(0.3),
        };
        (drawn(1.0) < 0.5).then_some(single)
    }
}

/// What happens to the vehicle or the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mishap {
    /// The pilot chooses another mode.
    PilotMode,
    /// The pilot moves a stick.
    PilotStick,
    /// The battery is low.
    Battery,
    /// The vehicle is disarmed.
    Disarmed,
    /// A stranger says in the vehicle's name that it is disarmed.
    ForgedDisarm,
    /// The autopilot starts again and has forgotten everything.
    Reboot,
    /// A ground station with our system id is heard.
    SecondStation,
    /// Nothing arrives any more, on either side; as where our process is gone.
    LinkLost,
    /// Nothing arrives for a while.
    LinkLostForAWhile,
    /// The vehicle is heard but does not hear.
    Deaf,
    /// The vehicle hears but is not heard.
    Mute,
    /// The operator wants the vehicle back.
    Abort,
}

impl Mishap {
    /// Every mishap.
    pub const ALL: [Self; 12] = [
        Self::PilotMode,
        Self::PilotStick,
        Self::Battery,
        Self::Disarmed,
        Self::ForgedDisarm,
        Self::Reboot,
        Self::SecondStation,
        Self::LinkLost,
        Self::LinkLostForAWhile,
        Self::Deaf,
        Self::Mute,
        Self::Abort,
    ];

    /// Does it cut the link for good?
    pub fn cuts(self) -> bool {
        matches!(self, Self::LinkLost | Self::Deaf | Self::Mute)
    }
}

const PILOTS_MODE: u32 = 4;
const VEHICLE: Sender = Sender { system: 1, component: 1 };

type Boat = Speaker<FirstOrderVehicle>;

/// A vehicle and the link to it.
pub struct Sea {
    /// The vehicle.
    pub boat: Boat,
    config: VehicleConfig,
    profile: Profile,
    /// The time on both sides, s.
    pub now_s: f64,
    step_s: f64,
    to_us: VecDeque<(f64, Vec<u8>)>,
    to_boat: VecDeque<(f64, Vec<u8>)>,
    /// What the link does.
    pub weather: Weather,
    chance: Chance,
    /// What happens, and when, s.
    pub mishap: Option<(f64, Mishap)>,
    has_happened: bool,
    /// When a message of the kind that is thinned was last sent, s.
    single_s: f64,
    /// When what has come could tell it on this side, s.
    pub seen_s: Option<f64>,
    /// When the rudder was first asked for, s.
    pub asked_s: Option<f64>,
    /// When the vehicle last held a rudder that was asked for, s.
    pub held_s: f64,
    decoder: Decoder,
    asked: Decoder,
    /// Set when the operator wants the vehicle back.
    pub abort: Arc<AtomicBool>,
    /// Datagrams that the vehicle has sent.
    pub sent: u64,
}

/// A vehicle as its owner left it.
pub fn boat(config: &VehicleConfig, profile: Profile, seed: u64) -> Result<Boat, Error> {
    let cannot = |error: ConfigError| Error::Setting(error.to_string());
    let vehicle = FirstOrderVehicle::new(config.clone(), seed).map_err(cannot)?;
    Ok(Speaker::new(vehicle, profile, INTERVAL_S, FULL_RUDDER_RAD, None))
}

/// The frames of MAVLink 2, without signatures, that a vehicle has sent together.
fn frames(mut bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let payload = usize::from(*bytes.get(1)?);
        let (frame, rest) = bytes.split_at_checked(HEADER + payload + CHECKSUM)?;
        bytes = rest;
        Some(frame)
    })
}

/// MAVLink's number of the message in a frame.
fn id_of(frame: &[u8]) -> u32 {
    u32::from_le_bytes([frame[7], frame[8], frame[9], 0])
}

impl Sea {
    /// A vehicle in this weather.
    pub fn new(
        config: &VehicleConfig,
        profile: Profile,
        weather: Weather,
        mishap: Option<(f64, Mishap)>,
        chance: Chance,
    ) -> Result<Self, Error> {
        Ok(Self {
            boat: boat(config, profile, 1)?,
            config: config.clone(),
            profile,
            now_s: 0.0,
            step_s: 0.0,
            to_us: VecDeque::new(),
            to_boat: VecDeque::new(),
            weather,
            chance,
            mishap,
            has_happened: false,
            single_s: f64::NEG_INFINITY,
            seen_s: None,
            asked_s: None,
            held_s: 0.0,
            decoder: Decoder::default(),
            asked: Decoder::default(),
            abort: Arc::default(),
            sent: 0,
        })
    }

    /// Datagrams on their way.
    pub fn under_way(&self) -> usize {
        self.to_us.len() + self.to_boat.len()
    }

    fn is_cut(&self, to_us: bool) -> bool {
        match self.mishap.filter(|(at_s, _)| self.now_s >= *at_s) {
            Some((_, Mishap::LinkLost)) => true,
            Some((at_s, Mishap::LinkLostForAWhile)) => self.now_s < at_s + PASSES_AFTER_S,
            Some((_, Mishap::Deaf)) => !to_us,
            Some((_, Mishap::Mute)) => to_us,
            _ => false,
        }
    }

    /// Sends what the vehicle says in one datagram, but for messages of the kind that is thinned.
    fn report(&mut self, bytes: &[u8]) {
        let Some(single) = self.weather.single.filter(|s| self.now_s >= s.from_s) else {
            return self.throw(bytes, true);
        };
        let mut others = Vec::new();
        for frame in frames(bytes) {
            if id_of(frame) != single.id {
                others.extend(frame);
                continue;
            }
            // A message on the very instant is due.
            let is_due = self.now_s - self.single_s >= single.interval_s - 1e-6;
            if is_due {
                self.single_s = self.now_s;
            }
            if is_due && self.chance.uniform() >= single.loss {
                self.throw_late(frame, true, single.late_s);
            }
        }
        self.throw(&others, true);
    }

    fn throw(&mut self, bytes: &[u8], to_us: bool) {
        self.throw_late(bytes, to_us, 0.0);
    }

    fn throw_late(&mut self, bytes: &[u8], to_us: bool, late_s: f64) {
        if bytes.is_empty() || self.is_cut(to_us) {
            return;
        }
        let weather = self.weather;
        let copies = 1 + u32::from(self.chance.uniform() < weather.duplication);
        for _ in 0..copies {
            if self.chance.uniform() < weather.loss {
                continue;
            }
            let arrival_s =
                self.now_s + late_s + weather.latency_s + weather.jitter_s * self.chance.uniform();
            let mut datagram = bytes.to_vec();
            if self.chance.uniform() < weather.garbage {
                datagram.iter_mut().for_each(|byte| *byte = (256.0 * self.chance.uniform()) as u8);
            }
            let queue = if to_us { &mut self.to_us } else { &mut self.to_boat };
            let place = queue.iter().rposition(|(other_s, _)| *other_s <= arrival_s);
            queue.insert(place.map_or(0, |place| place + 1), (arrival_s, datagram));
        }
    }

    fn happen(&mut self) {
        let Some((at_s, mishap)) = self.mishap.filter(|_| !self.has_happened) else {
            return;
        };
        if self.now_s < at_s {
            return;
        }
        self.has_happened = true;
        match mishap {
            Mishap::PilotMode => self.boat.mode = PILOTS_MODE,
            Mishap::PilotStick => {
                let stick = self.seen_stick();
                self.boat.sticks_us[stick] = 1900;
            }
            Mishap::Battery => self.boat.battery_percent = 5,
            Mishap::Disarmed => self.boat.is_armed = false,
            Mishap::Reboot => {
                if let Ok(boat) = boat(&self.config, self.profile, 1) {
                    self.boat = boat;
                }
            }
            Mishap::ForgedDisarm => {
                let forged = Heartbeat {
                    custom_mode: self.boat.mode,
                    kind: 11,
                    autopilot: 3,
                    base_mode: 0x01,
                    system_status: 4,
                    mavlink_version: 3,
                };
                self.say(VEHICLE, forged);
            }
            Mishap::SecondStation => {
                let station = Sender { system: 255, component: 1 };
                self.say(station, Heartbeat::GROUND_STATION);
            }
            Mishap::Abort => {
                self.abort.store(true, Ordering::Relaxed);
                self.seen_s = Some(self.now_s);
            }
            Mishap::LinkLost | Mishap::LinkLostForAWhile | Mishap::Deaf | Mishap::Mute => {
                self.seen_s = Some(self.now_s);
            }
        }
    }

    /// Is it before the vehicle was first asked for anything? What came at the very instant came before: the trial asks once it has
    /// looked where mode and sticks are, and in made-up time that takes none.
    pub fn is_before_demand(&self, time_s: f64) -> bool {
        self.asked_s.is_none_or(|asked_s| time_s <= asked_s)
    }

    /// A stick, from 0, whose movement the vehicle reports while we hold it: ArduSub takes the first eight from us.
    fn seen_stick(&self) -> usize {
        if self.profile == Profile::Sub { 8 } else { 6 }
    }

    fn say(&mut self, sender: Sender, heartbeat: Heartbeat) {
        let bytes = Encoder::new(sender).encode(&Message::from(heartbeat), None, 0.0);
        self.throw(&bytes, true);
    }

    /// Does what has come tell of the mishap?
    fn look(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        while let Some(frame) = self.decoder.next(None, 0.0) {
            let (Some(message), Some((_, mishap))) = (frame.message(), self.mishap) else {
                continue;
            };
            let stick = self.seen_stick();
            let tells = match (mishap, message) {
                (Mishap::PilotMode, Message::Heartbeat(h)) => {
                    frame.sender == VEHICLE && h.custom_mode == PILOTS_MODE
                }
                (Mishap::PilotStick, Message::RcChannels(rc)) => rc.pulses[stick] == 1900,
                (Mishap::Battery, Message::SysStatus(status)) => status.battery_percent == 5,
                (Mishap::Disarmed | Mishap::ForgedDisarm, Message::Heartbeat(h)) => {
                    frame.sender == VEHICLE && h.base_mode & 0x80 == 0
                }
                (Mishap::Reboot, Message::Attitude(_)) => true,
                (Mishap::SecondStation, Message::Heartbeat(_)) => frame.sender.system == 255,
                _ => false,
            };
            if self.has_happened && tells {
                self.seen_s.get_or_insert(self.now_s);
            }
        }
    }

    fn note_demand(&mut self, bytes: &[u8]) {
        self.asked.push(bytes);
        while let Some(frame) = self.asked.next(None, 0.0) {
            let asks = matches!(
                frame.message(),
                Some(Message::ManualControl(_) | Message::RcChannelsOverride(_))
            );
            if asks {
                self.asked_s.get_or_insert(self.now_s);
            }
        }
    }

    /// Lets the time pass until something has come for us, or that long.
    pub fn pass(&mut self, until_s: f64) -> Option<Vec<u8>> {
        let arrival_s =
            |queue: &VecDeque<(f64, Vec<u8>)>| queue.front().map_or(f64::INFINITY, |(s, _)| *s);
        loop {
            let (us_s, boat_s) = (arrival_s(&self.to_us), arrival_s(&self.to_boat));
            let due_s = us_s.min(boat_s).min(self.step_s);
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
            } else if us_s <= due_s {
                let (_, bytes) = self.to_us.pop_front()?;
                if !self.is_cut(true) {
                    self.look(&bytes);
                    return Some(bytes);
                }
            } else {
                self.step_s += INTERVAL_S;
                if self.boat.is_steered() && self.boat.steering().abs() > HELD {
                    self.held_s = self.now_s;
                }
                let Ok(bytes) = self.boat.step();
                self.sent += 1;
                self.report(&bytes.unwrap_or_default());
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
        self.note_demand(bytes);
        self.throw(bytes, false);
    }
}
