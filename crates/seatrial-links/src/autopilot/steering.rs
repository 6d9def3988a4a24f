//! Steering: what is asked for, again and again until something else is; a heading that is held; the [`Vehicle`].

use seatrial_core::{AbortReason, Action, Sample, Steering, Vehicle};

use super::parameters::LONGEST_OVERRIDE_S;
use super::profile::Demand;
use super::{Autopilot, Stop};
use crate::handover::{FOLLOWS, HeadingHold, WAIT_S};
use crate::link::{Message, Wire, message};

/// A rudder that is held this long without a demand from the trial, s, ends it.
const DEFLECTED_ALONE_S: f64 = 1.0;
/// A heading that is held this long without a demand from the trial, s, ends it. Judging a run takes seconds.
const HOLDING_ALONE_S: f64 = 10.0;

impl<W: Wire> Autopilot<W> {
    /// Asks for this, until something else is asked for.
    pub(super) fn ask(&mut self, demand: Demand) {
        self.attended_s = self.wire.now_s();
        self.held_heading_rad = None;
        self.demand = Some(demand);
        self.sampler.thrust = Some(demand.thrust);
        self.send_demand();
    }

    fn send_demand(&mut self) {
        self.repeat_course();
        let Some(demand) = self.demand else {
            return;
        };
        let now_s = self.wire.now_s();
        self.demanded_s = now_s;
        self.following.asked(now_s, demand.steer);
        let message = self.profile().demand(demand, &self.parameters, self.system());
        if let Message::RcChannelsOverride(asked) = message {
            self.heard.overrides.asked(now_s, &asked.pulses);
        }
        self.send(message);
    }

    /// What was asked for, or the rudder that holds the heading now.
    pub(super) fn ask_again(&mut self) {
        if let (Some(demand), Some(heading_rad)) = (self.demand, self.held_heading_rad) {
            let steer = self.holding_steer(heading_rad);
            self.demand = Some(Demand { steer, ..demand });
        }
        self.send_demand();
    }

    /// Has the trial forgotten that it steers?
    pub(super) fn absence(&self, now_s: f64) -> Option<Stop> {
        if self.demand.is_none() && self.course.is_none() {
            return None;
        }
        let steer = self.demand.map_or(0.0, |demand| demand.steer);
        let is_deflected = steer != 0.0 && self.held_heading_rad.is_none();
        let longest_s = if is_deflected { DEFLECTED_ALONE_S } else { HOLDING_ALONE_S };
        let absent_s = now_s - self.attended_s;
        (absent_s > longest_s).then_some(Stop::NotAttended(absent_s))
    }

    /// Was this program held up for so long that the autopilot has let go?
    pub(super) fn suspension(&self, now_s: f64) -> Option<Stop> {
        let absent_s = now_s - self.pumped_s;
        let asks = self.demand.is_some() || self.course.is_some();
        (asks && absent_s > LONGEST_OVERRIDE_S).then_some(Stop::NotAttended(absent_s))
    }

    pub(super) fn hear_servo(&mut self, servo: &message::ServoOutputRaw, now_s: f64) {
        let Some(rudder) = &self.rudder else {
            return;
        };
        let pulse = |number: usize| match number {
            1..=8 => f64::from(servo.pulses[number - 1]),
            9..=16 => f64::from(servo.more_pulses[number - 9]),
            _ => f64::NAN,
        };
        let found = rudder.fraction(pulse) / self.stick_gain;
        let rudder_rad = found * self.settings.full_rudder_rad;
        self.sampler.rudder(servo.time_us, self.earlier_s, rudder_rad);
        if let Some(interval_s) = self.sampler.thinned_interval_s() {
            self.stop_on_guard(Stop::RareOutputs(interval_s));
        }
        let Some(demand) = self.demand else {
            self.following.restart(now_s);
            return;
        };
        if self.following.is_lost(now_s, found, FOLLOWS) {
            let asked = demand.steer;
            self.stop_on_guard(Stop::NotFollowed { asked, found });
        }
    }

    /// The steering that holds a heading, as a fraction of full.
    fn holding_steer(&self, heading_rad: f64) -> f64 {
        let Some((now_rad, rate_rad_s)) = self.sampler.newest_heading() else {
            return 0.0;
        };
        let settings = &self.settings;
        let hold = HeadingHold {
            gain: settings.heading_gain,
            yaw_rate_gain_s: settings.yaw_rate_gain_s,
            largest_rad: settings.heading_rudder_rad,
            is_reversed: settings.is_reversed,
        };
        hold.rudder_rad(now_rad, rate_rad_s, heading_rad) / settings.full_rudder_rad
    }
}

impl<W: Wire> Vehicle<f64> for Autopilot<W> {
    type Error = Stop;

    /// What came before a stop still comes after it. `None`: the vehicle is not ours.
    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Stop> {
        loop {
            let now_s = self.wire.now_s();
            self.attended_s = now_s;
            if let Some(sample) = self.sampler.take() {
                return Ok(Some(sample));
            }
            if let Some(stop) = &self.stopped {
                return Err(stop.clone());
            }
            if !self.on_guard {
                return Ok(None);
            }
            self.pump(now_s + WAIT_S);
        }
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Stop> {
        if self.stopped.is_some() || self.demand.is_none() {
            return Ok(());
        }
        let (steer, held_heading_rad) = match action.steering {
            Steering::Rudder(rudder_rad) => (rudder_rad / self.settings.full_rudder_rad, None),
            Steering::HoldHeading(heading_rad) => {
                (self.holding_steer(heading_rad), Some(heading_rad))
            }
        };
        self.ask(Demand { steer, thrust: action.thrust.unwrap_or(0.0) });
        self.held_heading_rad = held_heading_rad;
        self.response.took(self.wire.now_s() - self.sampler.arrived_s);
        if action.outcome.is_some() {
            self.let_go();
        }
        Ok(())
    }

    fn is_live(&self) -> bool {
        true
    }

    fn ended_for(&self) -> Option<AbortReason> {
        self.stopped.as_ref().map(Stop::reason)
    }
}
