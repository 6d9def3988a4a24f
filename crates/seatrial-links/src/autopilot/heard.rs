//! What a vehicle has reported.

use std::collections::{BTreeSet, VecDeque};

use super::overrides::Overrides;
use super::stop::Stop;
use super::{Profile, Settings};
use crate::link::message::{
    EkfStatusReport, EstimatorStatus, GpsRawInt, Heartbeat, RcChannels, SysStatus,
};
use crate::link::{Message, Sender};

/// MAV_AUTOPILOT_INVALID: no autopilot.
const NO_AUTOPILOT: u8 = 8;
/// The bit of `base_mode` of an armed vehicle.
const ARMED: u8 = 0x80;
/// MAV_STATE_CRITICAL and what is worse.
const CRITICAL: u8 = 5;
/// A stick that is moved by more than this, us, is the pilot's.
const MOVED_US: u16 = 100;
/// Autopilots that are distinguished.
const MOST_AUTOPILOTS: usize = 16;
/// Questions for the clock that may be under way.
const UNANSWERED: usize = 8;

#[derive(Debug, Default)]
pub(super) struct Heard {
    pub vehicle: Option<Sender>,
    pub heartbeat: Option<Heartbeat>,
    /// The kind that its first heartbeat told. A vehicle does not become another; who forges its heartbeats may say so.
    pub profile: Option<Profile>,
    pub heartbeats: u32,
    /// A heartbeat has said so. Before, the flag may lag behind the arming.
    has_been_armed: bool,
    pub sys_status: Option<SysStatus>,
    pub ekf: Option<EkfStatusReport>,
    pub estimator: Option<EstimatorStatus>,
    pub gps: Option<GpsRawInt>,
    /// Pulses of the first eight outputs, us.
    pub outputs: Option<[u16; 8]>,
    pub remote_control: Option<RcChannels>,
    /// What ArduSub makes of a full stick, as a fraction of full thrust.
    pub pilot_gain: Option<f64>,
    /// The sticks when the vehicle was taken.
    pub sticks: Option<[u16; 18]>,
    /// The mode in which we steer.
    pub our_mode: Option<u32>,
    /// The autopilot steers to our headings.
    pub is_guided: bool,
    pub failsafe: Option<String>,
    /// Round trip, s, on whichever clock runs faster, and how far the vehicle's clock is ahead of ours, s: the quickest answer.
    pub clock: Option<(f64, f64)>,
    /// Questions for the clock: our time, ns, and the vehicle's newest, s.
    asked: VecDeque<(i64, f64)>,
    /// Another ground station has our system id.
    pub double: Option<Sender>,
    /// What we override, and what of that the vehicle reports.
    pub overrides: Overrides,
    /// Every autopilot that was heard.
    pub autopilots: BTreeSet<Sender>,
    /// Refused requests for message rates.
    pub denied: u32,
}

impl Heard {
    /// Is it from the vehicle? The first autopilot that is heard, of the system that is wanted.
    pub fn is_vehicle(&mut self, sender: Sender, message: &Message, wanted: Option<u8>) -> bool {
        if let Message::Heartbeat(heartbeat) = message
            && heartbeat.autopilot != NO_AUTOPILOT
            && self.autopilots.len() < MOST_AUTOPILOTS
        {
            self.autopilots.insert(sender);
            if self.vehicle.is_none() && wanted.is_none_or(|system| system == sender.system) {
                self.vehicle = Some(sender);
            }
        }
        self.vehicle == Some(sender)
    }

    /// Takes the sticks as they were last reported for where the pilot left them.
    pub fn note_sticks(&mut self) {
        self.sticks = self.remote_control.map(|channels| channels.pulses);
    }

    /// Does the vehicle hear a remote control?
    pub fn has_sticks(&self) -> bool {
        self.remote_control.is_some_and(|rc| rc.count > 0)
    }

    pub fn ask_clock(&mut self, here_ns: i64, clock_s: f64) {
        self.asked.push_back((here_ns, clock_s));
        if self.asked.len() > UNANSWERED {
            self.asked.pop_front();
        }
    }

    pub fn take(&mut self, message: &Message, now_s: f64, clock_s: f64) {
        match *message {
            Message::Heartbeat(heartbeat) => {
                self.heartbeat = Some(heartbeat);
                self.profile.get_or_insert(Profile::of(&heartbeat));
                self.heartbeats += 1;
                self.has_been_armed |= self.is_armed();
            }
            Message::SysStatus(status) => self.sys_status = Some(status),
            Message::EkfStatusReport(report) => self.ekf = Some(report),
            Message::EstimatorStatus(status) => self.estimator = Some(status),
            Message::GpsRawInt(fix) => self.gps = Some(fix),
            Message::ServoOutputRaw(servo) if servo.port == 0 => self.outputs = Some(servo.pulses),
            Message::RcChannels(channels) => {
                self.overrides.reported(&channels, self.sticks);
                self.remote_control = Some(channels);
            }
            Message::NamedValueFloat(number) if number.name.text() == "PilotGain" => {
                self.pilot_gain = Some(number.value.into());
            }
            Message::CommandAck(ack) if ack.result > 0 && ack.command == 511 => self.denied += 1,
            Message::Timesync(answer) if answer.there_ns != 0 => {
                let (there_s, here_s) = (answer.there_ns as f64 / 1e9, answer.here_ns as f64 / 1e9);
                let asked = self.asked.iter().find(|(ns, _)| *ns == answer.here_ns);
                let passed_s = asked.map_or(0.0, |(_, asked_s)| clock_s - asked_s);
                let round_trip_s = (now_s - here_s).max(passed_s);
                let is_better = self.clock.is_none_or(|(best_s, _)| round_trip_s < best_s);
                if (0.0..10.0).contains(&round_trip_s) && is_better {
                    self.clock = Some((round_trip_s, there_s - 0.5 * (here_s + now_s)));
                }
            }
            Message::Statustext(text) => {
                let text = text.text.text();
                let words = text.to_lowercase();
                let is_over = words.contains("clear") || words.contains(" off");
                if words.contains("failsafe") && !is_over {
                    self.failsafe = Some(text);
                }
            }
            _ => {}
        }
    }

    pub fn mode(&self) -> Option<u32> {
        self.heartbeat.map(|heartbeat| heartbeat.custom_mode)
    }

    pub fn is_armed(&self) -> bool {
        self.heartbeat.is_some_and(|heartbeat| heartbeat.base_mode & ARMED != 0)
    }

    pub fn is_critical(&self) -> bool {
        self.heartbeat.is_some_and(|heartbeat| heartbeat.system_status >= CRITICAL)
    }

    /// Percent; `None` where it is not measured.
    pub fn battery_percent(&self) -> Option<i8> {
        let percent = self.sys_status?.battery_percent;
        (percent >= 0).then_some(percent)
    }

    /// A reason to give the vehicle back.
    pub fn danger(&self, profile: Profile, settings: &Settings) -> Option<Stop> {
        if let (Some(ours), Some(mode)) = (self.our_mode, self.mode())
            && mode != ours
        {
            return Some(Stop::PilotMode(mode));
        }
        if let Some(stop) = self.interference(profile, settings) {
            return Some(stop);
        }
        if let Some(text) = &self.failsafe {
            return Some(Stop::Failsafe(text.clone()));
        }
        if self.is_critical() {
            return Some(Stop::Failsafe("its state is critical".into()));
        }
        self.low_battery(settings)
    }

    /// A reason to give the vehicle back while it shows its failsafe, as it should when it hears nothing from us.
    pub fn danger_in_silence(&self, profile: Profile, settings: &Settings) -> Option<Stop> {
        self.interference(profile, settings).or_else(|| self.low_battery(settings))
    }

    /// The pilot or another station acts on the vehicle.
    fn interference(&self, profile: Profile, settings: &Settings) -> Option<Stop> {
        if self.has_been_armed && !self.is_armed() {
            return Some(Stop::Disarmed);
        }
        let second = self.overrides.is_foreign().then_some(Stop::SecondStation(settings.system_id));
        self.moved_stick(profile).map(Stop::PilotStick).or(second)
    }

    fn low_battery(&self, settings: &Settings) -> Option<Stop> {
        self.battery_percent()
            .filter(|percent| *percent < settings.lowest_battery_percent)
            .map(Stop::Battery)
    }

    /// Number of a channel, from 1, that is not ours and is not where it was.
    fn moved_stick(&self, profile: Profile) -> Option<usize> {
        let (before, now) = (self.sticks?, self.remote_control?);
        let count = usize::from(now.count).min(before.len());
        let is_moved = |channel: &usize| {
            let (before, now) = (before[*channel], now.pulses[*channel]);
            let is_known = ![0, u16::MAX].contains(&before) && ![0, u16::MAX].contains(&now);
            is_known && now.abs_diff(before) > MOVED_US
        };
        // Rover goes at the speed that we ask for; Sub's thrust ahead is a stick of ours.
        let is_free = self.is_guided && profile == Profile::Rover;
        (0..count)
            .filter(|channel| is_free || !profile.is_ours(*channel))
            .find(is_moved)
            .map(|channel| channel + 1)
    }
}
