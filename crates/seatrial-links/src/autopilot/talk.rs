//! Messages to the vehicle and from it: heartbeats, questions, parameters, modes.

use std::sync::atomic::Ordering;

use super::cascade::decimal;
use super::profile::Profile;
use super::{Autopilot, ParameterValue, REAL32, REPEAT_S, SET_MODE, Stop};
use crate::handover::{Controls, SILENCE_S};
use crate::link::message::{self, CommandLong, ParamRequestRead, ParamSet, ParamValue, Text};
use crate::link::{Message, Sender, Wire};

/// Between our heartbeats, s: one that is late still comes within a second.
const HEARTBEAT_S: f64 = 0.5;
/// Between heartbeats where a failsafe acts soon after the last one, s.
const QUICK_HEARTBEAT_S: f64 = 0.1;
/// The most parameters that are kept.
const MOST_PARAMETERS: usize = 8192;

impl<W: Wire> Autopilot<W> {
    pub(super) fn send(&mut self, message: impl Into<Message>) {
        let now_s = self.wire.now_s();
        let signing = self.signing.as_mut();
        let frame = self.encoder.encode(&message.into(), signing, now_s);
        self.wire.send(&frame);
    }

    /// Sends what is due, waits for bytes until then at most, and hears what has come. `true`: something has.
    pub(super) fn pump(&mut self, until_s: f64) -> bool {
        let now_s = self.wire.now_s();
        if now_s - self.pumped_s > REPEAT_S {
            self.resumed_s = now_s;
        }
        if let Some(stop) = self.suspension(now_s) {
            // Before what came meanwhile is heard: what the vehicle did then, it did because of us.
            self.stop_on_guard(stop);
        }
        let every_s = match self.beats_quickly {
            true => QUICK_HEARTBEAT_S,
            false => HEARTBEAT_S,
        };
        // A vehicle that steers to our headings is told that we are there only as long as we hear it.
        if self.course.is_none() && now_s - self.beat_s >= every_s {
            self.beat(now_s);
        }
        if self.settings.abort.load(Ordering::Relaxed) {
            self.stop_on_guard(Stop::Operator);
        }
        if now_s - self.demanded_s >= REPEAT_S {
            self.ask_again();
        }
        self.wire.receive(&mut self.received, until_s);
        let has_come = !self.received.is_empty();
        self.decoder.push(&self.received);
        self.received.clear();
        let now_s = self.wire.now_s();
        self.pumped_s = now_s;
        self.sampler.now_s = now_s;
        while let Some(frame) = self.decoder.next(self.signing.as_mut(), now_s) {
            if let Some(message) = frame.message() {
                self.hear(frame.sender, &message, now_s);
            }
        }
        if let Some(stop) = self.silence(has_come).or(self.absence(now_s)) {
            self.stop_on_guard(stop);
        }
        has_come
    }

    fn beat(&mut self, now_s: f64) {
        self.beat_s = now_s;
        self.send(message::Heartbeat::GROUND_STATION);
        let here_ns = (now_s * 1e9) as i64;
        self.heard.ask_clock(here_ns, self.sampler.clock_s());
        self.send(message::Timesync { there_ns: 0, here_ns });
    }

    /// Heartbeats by the vehicle's own clock, which may run faster than ours.
    fn beat_with_vehicle(&mut self) {
        let clock_s = self.sampler.clock_s();
        if self.beats_quickly && (clock_s - self.beat_clock_s).abs() >= QUICK_HEARTBEAT_S - 1e-3 {
            self.beat_clock_s = clock_s;
            self.send(message::Heartbeat::GROUND_STATION);
        }
    }

    /// What came while nobody listened waits to be read; until it is, the silence begins when we listen again.
    fn silence(&self, has_come: bool) -> Option<Stop> {
        let since_s = match has_come {
            true => self.heard_s.max(self.resumed_s),
            false => self.heard_s,
        };
        let silent_s = self.pumped_s - since_s;
        (silent_s > SILENCE_S).then_some(Stop::Silence(silent_s))
    }

    fn hear(&mut self, sender: Sender, message: &Message, now_s: f64) {
        if sender.system == self.settings.system_id {
            self.heard.double = Some(sender);
            self.stop_on_guard(Stop::SecondStation(sender.system));
            return;
        }
        if !self.heard.is_vehicle(sender, message, self.settings.vehicle) {
            return;
        }
        self.wire.is_vehicle();
        self.heard.take(message, now_s, self.sampler.clock_s());
        match *message {
            Message::ParamValue(parameter) => self.hear_parameter(&parameter),
            Message::Attitude(attitude) => {
                if self.sampler.is_restarted(attitude.time_boot_ms) {
                    self.stop_on_guard(Stop::Rebooted);
                    self.sampler.restart();
                }
                self.heard_s = now_s;
                self.sampler.attitude(attitude);
                self.beat_with_vehicle();
            }
            Message::ServoOutputRaw(servo) if servo.port == 0 => self.hear_servo(&servo, now_s),
            Message::VfrHud(hud) => self.sampler.ground_speed(hud.ground_speed_m_s.into()),
            Message::GlobalPositionInt(position) => {
                let velocity = [position.north_cm_s, position.east_cm_s];
                let velocity = velocity.map(|speed| f64::from(speed) / 100.0);
                self.sampler.velocity(position.time_boot_ms, velocity);
            }
            Message::LocalPositionNed(local) => {
                let place = [local.north_m.into(), local.east_m.into()];
                self.sampler.position(local.time_boot_ms, place);
                if !self.profile().is_boat() {
                    let depth_m = local.down_m.into();
                    self.sampler.depth(local.time_boot_ms, depth_m);
                }
            }
            _ => {}
        }
        let danger = match (self.on_guard, self.is_proving) {
            (true, _) => self.heard.danger(self.profile(), &self.settings),
            (false, true) => self.heard.danger_in_silence(self.profile(), &self.settings),
            (false, false) => None,
        };
        if let Some(stop) = danger {
            self.stop_on_guard(stop);
        }
    }

    fn hear_parameter(&mut self, parameter: &ParamValue) {
        let is_integer = parameter.kind != REAL32 && self.profile() == Profile::Px4;
        let value = if is_integer {
            f64::from(parameter.value.to_bits() as i32)
        } else {
            decimal(parameter.value)
        };
        let name = parameter.name.text();
        if self.kinds.len() < MOST_PARAMETERS {
            self.kinds.insert(name.clone(), parameter.kind);
        }
        self.parameters.insert(name, value);
    }

    pub(super) fn stop_on_guard(&mut self, stop: Stop) {
        if self.stopped.is_some() || !(self.on_guard || self.is_proving) {
            return;
        }
        self.stopped = Some(stop);
        self.sampler.is_closed = true;
        if std::mem::take(&mut self.is_proving) {
            // Nothing is demanded any more, but the last demand is still in force until the autopilot lets go.
            self.release_controls();
        }
        self.let_go();
    }

    pub(super) fn ask_parameter(&mut self, name: &str) {
        let (target_system, target_component) = (self.system(), self.component());
        let name = Text::from(name);
        self.send(ParamRequestRead { index: -1, target_system, target_component, name });
    }

    /// Sets a parameter and reads it back. `true`: it is so.
    pub(super) fn set_parameter(
        &mut self,
        name: &str,
        stored: ParameterValue,
        longest_s: f64,
    ) -> bool {
        let wanted = stored.number();
        self.parameters.insert(name.into(), f64::NAN);
        self.insist(
            longest_s,
            |autopilot| {
                let (target_system, target_component) = (autopilot.system(), autopilot.component());
                autopilot.send(ParamSet {
                    value: stored.value(),
                    target_system,
                    target_component,
                    name: Text::from(name),
                    kind: stored.kind,
                });
            },
            |autopilot| autopilot.parameters.get(name) == Some(wanted),
        )
    }

    pub(super) fn command(&mut self, command: u16, [param1, param2, param3]: [f32; 3]) {
        let (target_system, target_component) = (self.system(), self.component());
        self.send(CommandLong {
            param1,
            param2,
            param3,
            param4: 0.0,
            param5: 0.0,
            param6: 0.0,
            param7: 0.0,
            command,
            target_system,
            target_component,
            confirmation: 0,
        });
    }

    /// Sets a mode and waits until a heartbeat has it. `true`: it is so.
    pub(super) fn set_mode(&mut self, mode: u32, longest_s: f64) -> bool {
        // A heartbeat from before may still be on its way, so it is the next one that counts.
        self.insist(
            longest_s,
            |autopilot| {
                let [main, sub] = match autopilot.profile() {
                    Profile::Px4 => [(mode >> 16) & 0xff, mode >> 24],
                    _ => [mode, 0],
                };
                autopilot.command(SET_MODE, [1.0, main as f32, sub as f32]);
            },
            |autopilot| autopilot.heard.mode() == Some(mode),
        )
    }

    /// MAV_CMD_SET_MESSAGE_INTERVAL: 0 is the autopilot's default.
    pub(super) fn set_interval(&mut self, id: u32, interval_s: f64) {
        self.command(511, [id as f32, (interval_s * 1e6) as f32, 0.0]);
    }
}
