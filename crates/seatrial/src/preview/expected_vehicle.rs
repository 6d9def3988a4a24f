//! The vehicle believed in: first order, noise free.

use std::convert::Infallible;

use seatrial_core::model::YawState;
use seatrial_core::{Action, Manoeuvre, Real, Sample, Steering, Vehicle};

use super::{Prior, PriorSpeed};

/// A noise-free vehicle that follows the model of its thrust exactly.
///
/// Like every vehicle it takes the rudder asked for after one sample from the next sample on; it holds its heading by
/// rudder = -K (heading - wanted heading), limited. A change of thrust changes the model at once and the
/// speed with a first-order lag. It begins on its heading, at rest in yaw, with the rudder that keeps it so.
#[derive(Clone, Debug)]
pub struct ExpectedVehicle<'a> {
    prior: &'a Prior,
    speed: PriorSpeed,
    yaw: YawState<f64>,
    surge_speed_m_s: Option<f64>,
    position_m: [f64; 2],
    rudder_rad: f64,
    steering: Steering<f64>,
    asked: Option<Action<f64>>,
    ticks: u64,
}

impl<'a> ExpectedVehicle<'a> {
    /// The vehicle at the first of its speeds.
    pub fn new(prior: &'a Prior) -> Option<Self> {
        let speed = *prior.speeds.first()?;
        Some(Self {
            surge_speed_m_s: prior.speed_before_m_s.or(speed.surge_speed_m_s),
            ..Self::steady(prior, speed)
        })
    }

    /// The vehicle settled at a speed.
    fn steady(prior: &'a Prior, speed: PriorSpeed) -> Self {
        Self {
            prior,
            speed,
            yaw: YawState { heading_rad: prior.heading_rad, yaw_rate_rad_s: 0.0 },
            surge_speed_m_s: speed.surge_speed_m_s,
            position_m: [0.0; 2],
            rudder_rad: -speed.model.delta0_rad().unwrap_or(0.0),
            steering: Steering::HoldHeading(prior.heading_rad),
            asked: None,
            ticks: 0,
        }
    }

    /// The record of a training stage alone, begun where a long hold of the heading ends.
    pub(super) fn train(
        prior: &'a Prior,
        speed: PriorSpeed,
        manoeuvre: &Manoeuvre<f64>,
    ) -> Vec<Sample<f64>> {
        let mut vehicle = Self::steady(prior, speed);
        let hold = vehicle.steering;
        // Where the rudder of the heading controller balances delta0.
        let offset_rad = speed.model.delta0_rad().unwrap_or(0.0) / speed.hold_gain;
        if offset_rad.is_finite() {
            vehicle.yaw.heading_rad += offset_rad;
        }
        let samples = (manoeuvre.duration_s() / prior.sample_interval_s).round();
        let mut record = Vec::with_capacity(samples as usize);
        for k in 0..samples as u64 {
            let Ok(Some(sample)) = vehicle.next_sample() else {
                break;
            };
            record.push(sample);
            let elapsed_s = k as f64 * prior.sample_interval_s - manoeuvre.lead_in_s;
            let steering =
                manoeuvre.excitation.rudder_rad(elapsed_s).map_or(hold, Steering::Rudder);
            let Ok(()) = vehicle.act(&Action { steering, thrust: None, outcome: None });
        }
        record
    }

    fn advance(&mut self) {
        let interval_s = self.prior.sample_interval_s;
        let yaw = self.speed.model.advance(self.yaw, self.rudder_rad, interval_s);
        if let (Some(speed_m_s), Some(steady_m_s)) =
            (&mut self.surge_speed_m_s, self.speed.surge_speed_m_s)
        {
            let time_constant_s = self.prior.surge_time_constant_s;
            let left =
                if time_constant_s > 0.0 { libm::exp(-interval_s / time_constant_s) } else { 0.0 };
            let before_m_s = *speed_m_s;
            *speed_m_s = steady_m_s + (before_m_s - steady_m_s) * left;
            let way_m = 0.5 * (before_m_s + *speed_m_s) * interval_s;
            let course_rad = 0.5 * (self.yaw.heading_rad + yaw.heading_rad);
            self.position_m[0] += way_m * libm::cos(course_rad);
            self.position_m[1] += way_m * libm::sin(course_rad);
        }
        self.yaw = yaw;
    }

    fn carry_out(&mut self) {
        let Some(action) = self.asked.take() else { return };
        self.steering = action.steering;
        let named = |thrust: f64| self.prior.speeds.iter().find(|s| s.thrust == thrust);
        if let Some(speed) = action.thrust.and_then(named) {
            self.speed = *speed;
        }
    }
}

impl Vehicle<f64> for ExpectedVehicle<'_> {
    type Error = Infallible;

    /// Never `None`.
    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        if self.ticks > 0 {
            self.advance();
        }
        self.carry_out();
        let wanted_rad = match self.steering {
            Steering::Rudder(rudder_rad) => rudder_rad,
            Steering::HoldHeading(heading_rad) => {
                let error_rad = (self.yaw.heading_rad - heading_rad).wrapped();
                (-self.speed.hold_gain * error_rad).limited_to(self.prior.hold_limit_rad)
            }
        };
        self.rudder_rad = wanted_rad.limited_to(self.prior.rudder_limit_rad);
        let time_s = self.ticks as f64 * self.prior.sample_interval_s;
        self.ticks += 1;
        let position = |axis: usize| self.surge_speed_m_s.map(|_| self.position_m[axis]);
        Ok(Some(Sample {
            time_s,
            heading_rad: self.yaw.heading_rad.wrapped(),
            rudder_rad: self.rudder_rad,
            surge_speed_m_s: self.surge_speed_m_s,
            depth_m: self.prior.depth_m,
            yaw_rate_rad_s: Some(self.yaw.yaw_rate_rad_s),
            north_m: position(0),
            east_m: position(1),
            ..Sample::default()
        }))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        self.asked = Some(*action);
        Ok(())
    }
}
