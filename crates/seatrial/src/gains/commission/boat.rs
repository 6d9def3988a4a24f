//! A boat under the cascade of its autopilot, simulated.

use seatrial_core::model::{Discretisation, YawState};
use seatrial_core::{CascadeSettings, RateCascade, YawModel};

use super::Draw;

/// An empty integral has learnt what holds a straight course after so many of its time constants; more than this is not waited
/// for, s.
const LEARNT_TIMES: f64 = 3.0;
const LONGEST_LEARNING_S: f64 = 300.0;

/// The correlation time of a sea, s.
const SEA_TIME_S: f64 = 2.0;

/// A boat that steers.
///
/// ```text
/// r' = a22 r + B u + C0 + d,   T_l u' = s(t - T_d) - u
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boat {
    /// a22, B (as `b2_per_s2`) and C0, with the steering in fractions of full.
    pub model: YawModel<f64>,
    /// T_l, s.
    pub lag_s: f64,
    /// T_d, s.
    pub delay_s: f64,
    /// White noise of the yaw rate that the controller sees, rad/s.
    pub rate_noise_rad_s: f64,
    /// White noise of its heading, rad.
    pub heading_noise_rad: f64,
    /// Deviation of what the sea turns it with, rad/s^2, which it forgets in 2 s.
    pub disturbance_rad_s2: f64,
    /// The share of full steering that is not left where thrusters drive and steer at once.
    pub steering_taken: f64,
}

/// The heading is held, then moved away by a step, then back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTest {
    /// Size of both steps, rad.
    pub step_rad: f64,
    /// Time before the first, s.
    pub settle_s: f64,
    /// Time for each, s.
    pub hold_s: f64,
    /// Between two samples of the record, s.
    pub sample_interval_s: f64,
    /// Between two loops of the autopilot, s.
    pub loop_interval_s: f64,
}

/// One sample of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepInstant {
    /// Time since the step, s.
    pub time_s: f64,
    /// Heading from the one before the step, positive the way of the step, rad.
    pub turned_rad: f64,
    /// Steering until the next sample, a fraction of full before the outputs scale it, positive the way of the step.
    pub steering: f64,
    /// Yaw rate, positive the way of the step, rad/s.
    pub yaw_rate_rad_s: f64,
}

impl StepTest {
    /// This test with enough time before its first step for settings that have just been written to learn what holds a straight
    /// course.
    pub fn learnt(&self, settings: &CascadeSettings<f64>) -> Self {
        Self { settle_s: self.settle_s.max(learning_s(settings)), ..*self }
    }

    /// The two steps of a boat under these settings.
    ///
    /// ```
    /// use seatrial::gains::commission::{Boat, Response, StepTest};
    /// use seatrial_core::{CascadeSettings, YawModel};
    ///
    /// let boat = Boat { model: YawModel::from_theta([-1.0, 1.0, 0.0]), ..Boat::default() };
    /// let settings =
    ///     CascadeSettings { angle_gain_per_s: 0.4, feed_forward_s: 1.0, ..CascadeSettings::default() };
    /// let test = StepTest {
    ///     step_rad: 0.5,
    ///     settle_s: 5.0,
    ///     hold_s: 30.0,
    ///     sample_interval_s: 0.1,
    ///     loop_interval_s: 0.02,
    /// };
    /// let legs = test.simulate(&boat, &settings, 1);
    /// // s^2 + s + 0.4: a damping ratio of 0.79, which overshoots by less than 2 %.
    /// let response = Response::measure(&legs, 0.5, 0.0, 0.0).ok_or("enough samples")?;
    /// assert!(response.settling_s.is_some() && response.overshoot < 0.03);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn simulate(
        &self,
        boat: &Boat,
        settings: &CascadeSettings<f64>,
        seed: u64,
    ) -> [Vec<StepInstant>; 2] {
        let mut helm = Helm::new(boat, settings, self.loop_interval_s, seed);
        let loops = (self.sample_interval_s / self.loop_interval_s).round().max(1.0) as u32;
        let count = |time_s: f64| (time_s / self.sample_interval_s).ceil().max(1.0) as u32;
        let mut leg = |wanted_rad: f64, from_rad: f64, way: f64, time_s: f64| {
            (0..count(time_s))
                .map(|k| {
                    let (heading_rad, rate_rad_s) = helm.measured();
                    let steering = helm.hold(wanted_rad, loops);
                    StepInstant {
                        time_s: f64::from(k) * self.sample_interval_s,
                        turned_rad: way * (heading_rad - from_rad),
                        steering: way * steering,
                        yaw_rate_rad_s: way * rate_rad_s,
                    }
                })
                .collect::<Vec<_>>()
        };
        leg(0.0, 0.0, 1.0, self.settle_s);
        let away = leg(self.step_rad, 0.0, 1.0, self.hold_s);
        let back = leg(0.0, self.step_rad, -1.0, self.hold_s);
        [away, back]
    }
}

/// How long the empty integral of settings that have just been written is given to learn, s.
///
/// ```
/// use seatrial::gains::commission::learning_s;
/// use seatrial_core::CascadeSettings;
///
/// // Nothing to learn without an integral.
/// assert_eq!(learning_s(&CascadeSettings::default()), 0.0);
/// ```
pub fn learning_s(settings: &CascadeSettings<f64>) -> f64 {
    let time_s = settings.integral_time_s().unwrap_or(0.0);
    (LEARNT_TIMES * time_s).min(LONGEST_LEARNING_S)
}

/// A boat and its controller, one loop at a time.
struct Helm<'a> {
    boat: &'a Boat,
    cascade: RateCascade<f64>,
    step: Discretisation<f64>,
    state: YawState<f64>,
    rudder: f64,
    /// The newest steering first.
    asked: Vec<f64>,
    /// What is left of the rudder's distance after a loop.
    left: f64,
    interval_s: f64,
    noise: Draw,
    sea_rad_s2: f64,
}

impl<'a> Helm<'a> {
    fn new(boat: &'a Boat, settings: &CascadeSettings<f64>, interval_s: f64, seed: u64) -> Self {
        let late = (boat.delay_s / interval_s).round().max(0.0) as usize;
        let left = match boat.lag_s > 0.0 {
            true => libm::exp(-interval_s / boat.lag_s),
            false => 0.0,
        };
        Self {
            boat,
            cascade: RateCascade::new(*settings),
            step: Discretisation::new(boat.model.a22_per_s, interval_s),
            state: YawState::default(),
            rudder: 0.0,
            asked: vec![0.0; late + 1],
            left,
            interval_s,
            noise: Draw::new(seed),
            sea_rad_s2: 0.0,
        }
    }

    fn measured(&mut self) -> (f64, f64) {
        let boat = self.boat;
        if boat.heading_noise_rad == 0.0 && boat.rate_noise_rad_s == 0.0 {
            return (self.state.heading_rad, self.state.yaw_rate_rad_s);
        }
        (
            self.state.heading_rad + boat.heading_noise_rad * self.noise.normal(),
            self.state.yaw_rate_rad_s + boat.rate_noise_rad_s * self.noise.normal(),
        )
    }

    /// Steers for some loops; the mean steering.
    fn hold(&mut self, wanted_rad: f64, loops: u32) -> f64 {
        let mut sum = 0.0;
        for _ in 0..loops {
            let (heading_rad, rate_rad_s) = self.measured();
            let steering = self.cascade.step(wanted_rad, heading_rad, rate_rad_s, self.interval_s);
            let steering = match 1.0 - self.boat.steering_taken {
                most if most < 1.0 => steering.clamp(-most, most),
                _ => steering,
            };
            sum += steering;
            self.asked.rotate_right(1);
            self.asked[0] = steering;
            let asked = self.asked[self.asked.len() - 1];
            let before = self.rudder;
            self.rudder = asked + (before - asked) * self.left;
            let mean = 0.5 * (before + self.rudder);
            let held = if self.left > 0.0 { mean } else { asked };
            let model = &self.boat.model;
            let acceleration = model.b2_per_s2 * held + model.c0_rad_per_s2 + self.sea();
            self.state = self.step.advance(self.state, acceleration);
        }
        sum / f64::from(loops)
    }

    /// What the sea turns the boat with in the next loop, rad/s^2.
    fn sea(&mut self) -> f64 {
        let deviation = self.boat.disturbance_rad_s2;
        if deviation > 0.0 {
            let left = libm::exp(-self.interval_s / SEA_TIME_S);
            let new = deviation * (1.0 - left * left).sqrt();
            self.sea_rad_s2 = left * self.sea_rad_s2 + new * self.noise.normal();
        }
        self.sea_rad_s2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feed-forward alone on a boat of first order: e'' + alpha e' + alpha A e = 0, A = alpha/2, overshoots by e^-pi.
    #[test]
    fn exact_a_small_step_is_that_of_the_linear_loop() {
        let boat = Boat { model: YawModel::from_theta([-1.0, 2.0, 0.0]), ..Boat::default() };
        let settings = CascadeSettings {
            angle_gain_per_s: 0.5,
            feed_forward_s: 0.5,
            ..CascadeSettings::default()
        };
        let test = StepTest {
            step_rad: 0.2,
            settle_s: 1.0,
            hold_s: 20.0,
            sample_interval_s: 0.02,
            loop_interval_s: 0.002,
        };
        for leg in test.simulate(&boat, &settings, 1) {
            let highest = leg.iter().map(|i| i.turned_rad).fold(0.0, f64::max);
            let overshoot = highest / 0.2 - 1.0;
            // A hold of 2 ms delays by 1 ms, which is 0.03 degrees of phase.
            assert!((overshoot - (-std::f64::consts::PI).exp()).abs() < 1e-3);
        }
    }
}
