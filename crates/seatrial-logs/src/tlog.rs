//! MAVLink telemetry logs (`.tlog`): frames, each behind the time of its arrival.
//!
//! The times of the samples are those that the autopilot wrote into its messages, s since its boot; the
//! ground station's time of arrival is the column `arrival_us` of every kind.
use std::collections::BTreeMap;

use crate::Quantity::*;
use crate::Unit::*;
use crate::bytes::{Bytes, Found, text_of};
use crate::error::Fault;
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages, names};
use crate::number::median;
use crate::table::{Known, KnownChannel, KnownField};
use seatrial_mavlink::ardupilot::{Parameters, Pulse, Steering};
use seatrial_mavlink::logged::{Frame, LONGEST_FRAME, Next, PAYLOAD, STAMP};
use seatrial_mavlink::message::{
    Attitude, Heartbeat, LOGGED, ParamValue, RcChannels, RcChannelsScaled, ServoOutputRaw,
};
use seatrial_mavlink::{Definition, MessageClock, Sender, aircraft};

/// Outputs in SERVO_OUTPUT_RAW.
const OUTPUTS: usize = 16;
/// Pairs of normalised and real steering that are compared.
const MOST_PAIRS: usize = 4096;
/// Steering under this share of full is too little to compare, 1/10000.
const LEAST_SCALED: f64 = 1000.0;

/// `MAV_AUTOPILOT` and `MAV_TYPE` of a heartbeat.
const ARDUPILOT: u8 = 3;
const GROUND_ROVER: u8 = 10;
const SURFACE_BOAT: u8 = 11;
const SUBMARINE: u8 = 12;

/// The output or input that steers, and the message that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SteeringField {
    message: u32,
    steering: Steering,
}

/// The field that [`Telemetry`] adds to the message that steers.
const STEERING: &str = "steering_fraction";

/// Fields that feed a quantity, the preferred one first.
const CHANNELS: [KnownField; 9] = [
    (Heading, "ATTITUDE", "yaw", Some(Radian)),
    (Roll, "ATTITUDE", "roll", Some(Radian)),
    (Pitch, "ATTITUDE", "pitch", Some(Radian)),
    (YawRate, "ATTITUDE", "yawspeed", Some(RadianPerSecond)),
    (Speed, "VFR_HUD", "groundspeed", Some(MetrePerSecond)),
    (Thrust, "VFR_HUD", "throttle", Some(Percent)),
    (Depth, "LOCAL_POSITION_NED", "z", Some(Metre)),
    (North, "LOCAL_POSITION_NED", "x", Some(Metre)),
    (East, "LOCAL_POSITION_NED", "y", Some(Metre)),
];

/// A telemetry log.
pub(crate) struct Telemetry {
    bytes: Bytes,
    kinds: Vec<Kind>,
    /// Kind of every message in [`LOGGED`].
    kind_of: Vec<Option<usize>>,
    vehicle: Sender,
    steering: Option<SteeringField>,
    /// Where the pulses of output 1 and those that follow stand among the numbers of the message that steers.
    pulses: Vec<usize>,
    is_submarine: bool,
    aircraft: Option<&'static str>,
    because: String,
    doubt: Option<String>,
    boot_s: f64,
}

/// Messages whose fields the first pass looks at.
const LEARNT: [u32; 4] = [Heartbeat::ID, ParamValue::ID, ServoOutputRaw::ID, RcChannelsScaled::ID];

/// What the first pass collects of one sender.
#[derive(Default)]
struct Learnt {
    messages: Vec<u64>,
    parameters: Parameters,
    /// Kind of vehicle and autopilot.
    heartbeat: Option<(u8, u8)>,
    /// Pulse of output 1 and the steering it stands for, 1/10000.
    pairs: Vec<(f64, f64)>,
    pulse_us: Option<f64>,
}

impl Telemetry {
    /// Reads the file once for who sends what and for the parameters.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            kinds: Vec::new(),
            kind_of: vec![None; LOGGED.len()],
            vehicle: Sender { system: 0, component: 0 },
            steering: None,
            pulses: Vec::new(),
            is_submarine: false,
            aircraft: None,
            because: String::new(),
            doubt: None,
            boot_s: 0.0,
        };
        let mut senders: BTreeMap<Sender, Learnt> = BTreeMap::new();
        while let Some(frame) = log.next_frame()? {
            if let Some(message) = frame.message {
                let learnt = senders.entry(frame.sender).or_default();
                learnt.take(message, || frame.payload(log.bytes.seen()));
            }
            log.bytes.skip(frame.length);
        }
        let attitude = LOGGED.iter().position(|m| m.id == Attitude::ID);
        let attitudes = |learnt: &Learnt| attitude.and_then(|i| learnt.messages.get(i).copied());
        let Some((vehicle, learnt)) =
            senders.into_iter().max_by_key(|(_, learnt)| attitudes(learnt))
        else {
            return Err(Fault::NothingToRead {
                format: "MAVLink telemetry",
                what: "no message is of a kind that is read".into(),
            });
        };
        log.vehicle = vehicle;
        log.is_submarine = learnt.heartbeat.is_some_and(|(vehicle, _)| vehicle == SUBMARINE);
        log.aircraft = learnt.heartbeat.and_then(|(vehicle, _)| aircraft(vehicle));
        log.choose_steering(&learnt);
        log.name_kinds(&learnt);
        log.bytes.begin_again()?;
        Ok(log)
    }

    /// The kinds of messages that the vehicle sent, with their fields and the steering.
    fn name_kinds(&mut self, learnt: &Learnt) {
        self.pulses = self.steering.map_or(Vec::new(), |field| {
            let steers = LOGGED.iter().find(|m| m.id == field.message);
            let names = steers.into_iter().flat_map(Definition::number_names);
            let is_pulse = |name: &str| name.ends_with("_raw");
            (0..).zip(names).filter(|(_, name)| is_pulse(name)).map(|(index, _)| index).collect()
        });
        for (message, definition) in LOGGED.iter().enumerate() {
            if learnt.count(definition.id) == 0 {
                continue;
            }
            self.kind_of[message] = Some(self.kinds.len());
            let mut fields: Vec<String> = definition.number_names().map(String::from).collect();
            fields.push("arrival_us".into());
            if self.steering.is_some_and(|s| s.message == definition.id) {
                fields.push(STEERING.into());
            }
            self.kinds.push(Kind { name: definition.name.into(), fields });
        }
    }

    fn choose_steering(&mut self, learnt: &Learnt) {
        let from_parameters = Steering::find(&learnt.parameters, OUTPUTS);
        let has_outputs = learnt.count(ServoOutputRaw::ID) > 0;
        if let Some(steering) = from_parameters.filter(|_| has_outputs) {
            self.because = steering.text();
            self.steering = Some(SteeringField { message: ServoOutputRaw::ID, steering });
            return;
        }
        let (vehicle, autopilot) = learnt.heartbeat.unwrap_or_default();
        let knows_functions = learnt.parameters.get("SERVO1_FUNCTION").is_some();
        match vehicle {
            GROUND_ROVER | SURFACE_BOAT
                if autopilot == ARDUPILOT && has_outputs && !knows_functions =>
            {
                let (pulse, why) = match learnt.observed_pulse() {
                    Some(pulse) => (pulse, "from RC_CHANNELS_SCALED"),
                    None => (Pulse::of(&learnt.parameters, "SERVO1"), "the default"),
                };
                let steering = Steering::Output { number: 1, pulse };
                self.because = steering.text();
                self.doubt = Some(format!(
                    "no SERVOn_FUNCTION in the log: output 1 is taken to steer, as ArduPilot's boats and rovers have it, with {} ({why}); choose another with --rudder NAME",
                    pulse.text()
                ));
                self.steering = Some(SteeringField { message: ServoOutputRaw::ID, steering });
            }
            SUBMARINE if learnt.count(RcChannels::ID) > 0 => {
                let number = match learnt.parameters.get("RCMAP_YAW") {
                    Some(channel) if (1.0..=18.0).contains(&channel) => channel as usize,
                    _ => 4,
                };
                let pulse = Pulse::of(&learnt.parameters, &format!("RC{number}"));
                self.because = format!("the yaw command, channel {number}, {}", pulse.text());
                self.doubt = Some(format!(
                    "no output is a rudder: the yaw command of the pilot, channel {number}, is taken to steer; it does so only in manual modes"
                ));
                self.steering = Some(SteeringField {
                    message: RcChannels::ID,
                    steering: Steering::Output { number, pulse },
                });
            }
            _ => self.because = learnt.parameters.functions(),
        }
    }

    /// Goes to the next frame; bytes that are none are passed over.
    fn next_frame(&mut self) -> Result<Option<Frame>, Fault> {
        // One frame and the first bytes of the next.
        self.bytes.find_packet(2 * STAMP + LONGEST_FRAME + 1, |seen| match Frame::at(seen) {
            Next::Frame(frame) => Found::Packet(frame),
            Next::NoFrame => Found::Nothing(1),
            Next::Cut => Found::Cut,
        })
    }

    /// Seconds since boot, from the message's own clock, else that of the message before.
    fn time_s(&mut self, definition: &Definition, payload: &[u8]) -> f64 {
        let first = definition.field(payload, "time_boot_ms");
        match definition.clock {
            MessageClock::BootMilliseconds => {
                self.boot_s = first.unwrap_or(0.0) / 1e3;
                self.boot_s
            }
            MessageClock::BootMicroseconds => {
                let turn_us = 2_f64.powi(32);
                let us = definition.field(payload, "time_usec").unwrap_or(0.0);
                let turns = ((self.boot_s * 1e6 - us) / turn_us).round().max(0.0);
                (us + turns * turn_us) / 1e6
            }
            MessageClock::None => self.boot_s,
        }
    }
}

impl Learnt {
    fn take(&mut self, message: usize, payload: impl FnOnce() -> [u8; PAYLOAD]) {
        self.messages.resize(LOGGED.len(), 0);
        self.messages[message] += 1;
        let definition = &LOGGED[message];
        if !LEARNT.contains(&definition.id) {
            return;
        }
        let payload = &payload();
        let field = |name: &str| definition.field(payload, name).unwrap_or(f64::NAN);
        match definition.id {
            Heartbeat::ID => self.heartbeat = Some((field("type") as u8, field("autopilot") as u8)),
            ParamValue::ID => {
                let name = text_of(&payload[8..24]);
                self.parameters.insert(name, field("param_value"));
            }
            ServoOutputRaw::ID if field("port") == 0.0 => self.pulse_us = Some(field("servo1_raw")),
            RcChannelsScaled::ID if self.pairs.len() < MOST_PAIRS => {
                if let Some(pulse_us) = self.pulse_us {
                    self.pairs.push((pulse_us, field("chan1_scaled")));
                }
            }
            _ => {}
        }
    }

    fn count(&self, id: u32) -> u64 {
        LOGGED
            .iter()
            .zip(&self.messages)
            .find(|(message, _)| message.id == id)
            .map_or(0, |(_, count)| *count)
    }

    /// The pulses of output 1, from the normalised steering that ArduPilot's rovers send beside it.
    fn observed_pulse(&self) -> Option<Pulse> {
        let trim_us = median(
            self.pairs.iter().filter(|(_, scaled)| *scaled == 0.0).map(|(pulse_us, _)| *pulse_us),
        )?;
        let full_us = median(
            self.pairs
                .iter()
                .filter(|(_, scaled)| scaled.abs() >= LEAST_SCALED)
                .map(|(pulse_us, scaled)| (pulse_us - trim_us) / scaled * 1e4),
        )?;
        (full_us != 0.0).then_some(Pulse {
            lowest_us: trim_us - full_us.abs(),
            trim_us,
            highest_us: trim_us + full_us.abs(),
            is_reversed: full_us < 0.0,
        })
    }
}

impl Messages for Telemetry {
    fn aircraft(&self) -> Option<&'static str> {
        self.aircraft
    }

    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        let name_of = |id: u32| LOGGED.iter().find(|m| m.id == id).map_or("", |m| m.name);
        match self.steering {
            Some(steering) => {
                known.channels.push(KnownChannel {
                    quantity: Rudder,
                    column: format!("{}.{STEERING}", name_of(steering.message)),
                    unit: Some(Fraction),
                    because: Some(self.because.clone()),
                    doubt: self.doubt.clone(),
                });
            }
            None => known.expects(
                Rudder,
                "SERVO_OUTPUT_RAW messages and one of the outputs 1 to 16 with SERVOn_FUNCTION 21 (rudder), 26 (ground steering) or 73 and 74 (throttle left and right)",
                &self.because,
            ),
        }
        let is_afloat = |of: &KnownField| of.0 == Depth && !self.is_submarine;
        let fields = CHANNELS.into_iter().filter(|of| !is_afloat(of));
        known.add_fields(&self.kinds, fields);
        known.expects(Heading, "ATTITUDE messages", &names(&self.kinds));
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some(frame) = self.next_frame()? {
            let of_vehicle = frame.message.filter(|_| frame.sender == self.vehicle);
            let payload = of_vehicle.map(|_| frame.payload(self.bytes.seen()));
            self.bytes.skip(frame.length);
            let Some((index, payload)) = of_vehicle.zip(payload.as_ref()) else {
                continue;
            };
            let definition = &LOGGED[index];
            let time_s = self.time_s(definition, payload);
            let Some(kind) = self.kind_of[index].filter(|kind| wanted[*kind]) else {
                continue;
            };
            let has_ports = [ServoOutputRaw::ID, RcChannelsScaled::ID].contains(&definition.id);
            if has_ports && definition.field(payload, "port") != Some(0.0) {
                continue;
            }
            let arrival_us = std::iter::once(frame.arrival_us);
            message.set(kind, time_s, definition.numbers(payload).chain(arrival_us));
            if let Some(field) = self.steering.filter(|s| s.message == definition.id) {
                let pulse_us = |number: usize| match self.pulses.get(number - 1) {
                    Some(index) => message.values[*index],
                    None => f64::NAN,
                };
                let fraction = field.steering.fraction(pulse_us);
                message.values.push(fraction);
            }
            return Ok(true);
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn is_damaged(&self) -> bool {
        self.bytes.damage.bytes > 0
    }
}
