//! Steering: what is asked for, again and again until something else is; a heading that is held; the [`Vehicle`].

use seatrial_core::{AbortReason, Action, Real, Sample, Steering, Vehicle};

use super::profile::Demand;
use super::talk::WAIT_S;
use super::{Autopilot, Stop};
use crate::link::{Wire, message};

/// An output this near to what was asked for follows, as a fraction of full.
const FOLLOWS: f64 = 0.15;
/// Demands so old may still be on their way, s.
const ON_THE_WAY_S: f64 = 1.5;
/// A rudder that does not follow for so long ends the trial, s.
const NOT_FOLLOWED_S: f64 = 1.0;
/// A rudder that is held for so long without a word from the trial, s, is nobody's.
const DEFLECTED_ALONE_S: f64 = 1.0;
/// Likewise a heading: judging a run takes its time.
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
        let Some(demand) = self.demand else {
            return;
        };
        let now_s = self.wire.now_s();
        self.demanded_s = now_s;
        self.demands.push_back((now_s, demand.steer));
        while self
            .demands
            .front()
            .is_some_and(|(asked_s, _)| now_s - asked_s > ON_THE_WAY_S)
        {
            self.demands.pop_front();
        }
        let message = self
            .profile()
            .demand(demand, &self.parameters, self.system());
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
        let demand = self.demand?;
        let is_deflected = demand.steer != 0.0 && self.held_heading_rad.is_none();
        let longest_s = if is_deflected {
            DEFLECTED_ALONE_S
        } else {
            HOLDING_ALONE_S
        };
        let absent_s = now_s - self.attended_s;
        (absent_s > longest_s).then_some(Stop::NotAttended(absent_s))
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
        self.sampler
            .rudder(servo.time_us, self.earlier_s, rudder_rad);
        let follows = self
            .demands
            .iter()
            .any(|(_, asked)| (asked - found).abs() < FOLLOWS);
        if follows || self.demand.is_none() {
            self.followed_s = now_s;
        } else if now_s - self.followed_s > NOT_FOLLOWED_S {
            let asked = self.demand.map_or(0.0, |demand| demand.steer);
            self.stop_on_guard(Stop::NotFollowed { asked, found });
        }
    }

    /// Our own heading hold, for a vehicle whose rudder we have, as a fraction of full: delta = -(K (psi - psi_d) + D r), within its limit.
    fn holding_steer(&self, heading_rad: f64) -> f64 {
        let Some((now_rad, rate_rad_s)) = self.sampler.newest_heading() else {
            return 0.0;
        };
        let settings = &self.settings;
        let error_rad = Real::wrapped(now_rad - heading_rad);
        let sense = if settings.is_reversed { -1.0 } else { 1.0 };
        let rudder_rad =
            -sense * (settings.heading_gain * error_rad + settings.yaw_rate_gain_s * rate_rad_s);
        let limit_rad = settings.heading_rudder_rad;
        if rudder_rad.is_finite() {
            rudder_rad.clamp(-limit_rad, limit_rad) / settings.full_rudder_rad
        } else {
            0.0
        }
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
        self.ask(Demand {
            steer,
            thrust: action.thrust.unwrap_or(0.0),
        });
        self.held_heading_rad = held_heading_rad;
        self.response
            .took(self.wire.now_s() - self.sampler.arrived_s);
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
