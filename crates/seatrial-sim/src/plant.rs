//! The moving vehicle: surge, servo, yaw and position.

use std::collections::VecDeque;

use seatrial_core::YawModel;
use seatrial_core::model::YawState;
use serde::{Deserialize, Serialize};

use crate::config_error::ConfigError;
use crate::faults::Damage;
use crate::range::{check, check_not_negative, check_positive, positive};

/// Longest step over which fin and speed are held, s; both are exact at its end.
const STEP_S: f64 = 0.005;
/// That step of a vehicle whose fastest motion is slow, as a part of its time constant.
const STEP_SHARE: f64 = 0.005;

/// The truth at one thrust.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedPoint {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Steady forward speed, m/s.
    pub surge_speed_m_s: f64,
    /// a22, 1/s.
    pub a22_per_s: f64,
    /// b2, 1/s^2.
    pub b2_per_s2: f64,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: f64,
}

/// What an identification at a thrust should find.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Steady forward speed, m/s.
    pub surge_speed_m_s: f64,
    /// The yaw model at that speed.
    #[serde(flatten)]
    pub model: YawModel<f64>,
}

/// The servo: the fin follows its command with a first-order lag, no faster than its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Servo {
    /// Time constant, s; 0 is at once.
    pub time_constant_s: f64,
    /// Fastest motion, rad/s; absent is unlimited.
    pub rate_limit_rad_s: Option<f64>,
}

/// How the forward speed u follows the steady speed u_s of the thrust.
///
/// ```text
/// u' = (u_s - u)/T                        without drag
/// u' = (u_s^2 - u^2)/l - d r^2            with drag, r the yaw rate
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surge {
    /// T, s.
    pub time_constant_s: f64,
    /// l and d.
    pub drag: Option<SurgeDrag>,
}

/// Drag that grows with the square of the speed, and what a turn costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurgeDrag {
    /// l, mass over drag per speed squared, m.
    pub drag_length_m: f64,
    /// d, m.
    #[serde(default)]
    pub turning_drag_m: f64,
}

impl SurgeDrag {
    /// Names the first field that is out of range, for a vehicle of this speed. A drag that stops it within a few hundredths of a
    /// second is not followed in steps of 5 ms.
    pub(crate) fn check(&self, fastest_m_s: f64) -> Result<(), ConfigError> {
        check(
            "surge_drag.drag_length_m",
            self.drag_length_m,
            positive(self.drag_length_m) && self.drag_length_m >= 0.05 * fastest_m_s,
            "at least the way at the fastest speed in 0.05 s, and at most 1e9",
        )?;
        check_not_negative("surge_drag.turning_drag_m", self.turning_drag_m)
    }
}

impl Surge {
    /// The speed `interval_s` later, exact without drag and by the midpoint with it.
    fn advance(
        &self,
        speed_m_s: f64,
        target_m_s: f64,
        yaw_rate_rad_s: f64,
        interval_s: f64,
    ) -> f64 {
        let Some(drag) = self.drag else {
            let decay = libm::exp(-interval_s / self.time_constant_s);
            return target_m_s + (speed_m_s - target_m_s) * decay;
        };
        let acceleration = |u: f64| {
            (target_m_s * target_m_s.abs() - u * u.abs()) / drag.drag_length_m
                - drag.turning_drag_m * yaw_rate_rad_s * yaw_rate_rad_s * u.signum()
        };
        let midpoint = speed_m_s + 0.5 * interval_s * acceleration(speed_m_s);
        speed_m_s + interval_s * acceleration(midpoint)
    }
}

/// Yaw acceleration that is not the rudder's: a first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Disturbance {
    /// Standard deviation, rad/s^2.
    pub standard_deviation_rad_s2: f64,
    /// Correlation time, s.
    pub correlation_time_s: f64,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self { standard_deviation_rad_s2: 0.003, correlation_time_s: 2.0 }
    }
}

impl Disturbance {
    /// Names the first field that is out of range.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        check_not_negative(
            "disturbance.standard_deviation_rad_s2",
            self.standard_deviation_rad_s2,
        )?;
        check_positive("disturbance.correlation_time_s", self.correlation_time_s)
    }

    /// The disturbance `interval_s` after it was this, by a normal deviate.
    pub(crate) fn after(&self, before_rad_s2: f64, interval_s: f64, normal: f64) -> f64 {
        let decay = libm::exp(-interval_s / self.correlation_time_s);
        decay * before_rad_s2
            + (1.0 - decay * decay).sqrt() * self.standard_deviation_rad_s2 * normal
    }
}

impl Servo {
    /// The fin `interval_s` later.
    pub(crate) fn advance(&self, fin_rad: f64, command_rad: f64, interval_s: f64) -> f64 {
        let wanted = if self.time_constant_s > 0.0 {
            -libm::expm1(-interval_s / self.time_constant_s) * (command_rad - fin_rad)
        } else {
            command_rad - fin_rad
        };
        let limit = self.rate_limit_rad_s.map_or(f64::INFINITY, |rate| rate * interval_s);
        fin_rad + wanted.max(-limit).min(limit)
    }

    fn is_instant(&self) -> bool {
        self.time_constant_s == 0.0 && self.rate_limit_rad_s.is_none()
    }
}

/// Commands on their way to a servo with a dead time.
#[derive(Clone, Debug)]
struct Underway {
    delay_s: f64,
    time_s: f64,
    /// When each acts, s, and the command, rad.
    commands: VecDeque<[f64; 2]>,
    acting_rad: f64,
}

impl Underway {
    fn send(&mut self, command_rad: f64) {
        let last = self.commands.back().map_or(self.acting_rad, |[_, last]| *last);
        if last != command_rad {
            let acts_s = self.time_s + self.delay_s;
            self.commands.push_back([acts_s, command_rad]);
        }
    }

    /// The command that acts over the next step.
    fn next(&mut self, interval_s: f64) -> f64 {
        let middle_s = self.time_s + 0.5 * interval_s;
        while let Some([_, command_rad]) =
            self.commands.pop_front_if(|[acts_s, _]| *acts_s <= middle_s)
        {
            self.acting_rad = command_rad;
        }
        self.time_s += interval_s;
        self.acting_rad
    }
}

/// The true vehicle.
#[derive(Clone, Debug)]
pub struct Plant {
    speeds: Vec<SpeedPoint>,
    surge: Surge,
    servo: Servo,
    longest_step_s: f64,
    /// Is b2 linear in the square of the speed between two points?
    has_fins: bool,
    underway: Option<Underway>,
    /// Heading and yaw rate.
    pub yaw: YawState<f64>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: f64,
    /// Fin angle, rad.
    pub fin_rad: f64,
    /// North and east of the start, m.
    pub position_m: [f64; 2],
    /// What changed of it since it was made.
    pub damage: Damage,
}

impl Plant {
    /// A vehicle that runs straight at the steady speed of `thrust`, with the fin that keeps it so.
    pub fn new(
        speeds: Vec<SpeedPoint>,
        surge: Surge,
        servo: Servo,
        thrust: f64,
        heading_rad: f64,
    ) -> Self {
        let mut plant = Self {
            speeds,
            surge,
            servo,
            longest_step_s: STEP_S,
            has_fins: false,
            underway: None,
            yaw: YawState { heading_rad, yaw_rate_rad_s: 0.0 },
            surge_speed_m_s: 0.0,
            fin_rad: 0.0,
            position_m: [0.0; 2],
            damage: Damage::default(),
        };
        let truth = plant.truth(thrust);
        plant.surge_speed_m_s = truth.surge_speed_m_s;
        plant.fin_rad = -truth.model.delta0_rad().unwrap_or(0.0);
        plant
    }

    /// With a dead time until a command reaches the servo, s, kept to the 5 ms in which the vehicle moves.
    pub fn with_rudder_delay(mut self, delay_s: f64) -> Self {
        self.underway = (delay_s > 0.0).then(|| Underway {
            delay_s,
            time_s: 0.0,
            commands: VecDeque::new(),
            acting_rad: self.fin_rad,
        });
        self
    }

    /// With b2 linear in the square of the speed between two points, as the force of a fin; else it is linear in the speed.
    pub fn with_fins(mut self, has_fins: bool) -> Self {
        self.has_fins = has_fins;
        let model = self.yaw_model(self.surge_speed_m_s);
        self.fin_rad = -model.delta0_rad().unwrap_or(0.0);
        self
    }

    /// In steps that suit a slow vehicle: 1/200 of the shortest time constant of yaw, speed and servo where that is longer than 5 ms.
    pub fn in_its_own_steps(mut self) -> Self {
        let yaw = self.speeds.iter().map(|p| 1.0 / p.a22_per_s.abs());
        let speeds = self.speeds.iter().map(|p| p.surge_speed_m_s);
        let surge = speeds.map(|u| match self.surge.drag {
            Some(drag) => 0.5 * drag.drag_length_m / u,
            None => self.surge.time_constant_s,
        });
        let servo = (self.servo.time_constant_s > 0.0).then_some(self.servo.time_constant_s);
        let shortest_s = yaw.chain(surge).chain(servo).fold(f64::MAX, f64::min);
        self.longest_step_s = (STEP_SHARE * shortest_s).clamp(STEP_S, 1.0);
        self
    }

    /// Steady speed and yaw model at a thrust.
    pub fn truth(&self, thrust: f64) -> Truth {
        let surge_speed_m_s =
            self.between(|p| p.thrust, thrust, |p, scale| p.surge_speed_m_s * scale);
        Truth { thrust, surge_speed_m_s, model: self.yaw_model(surge_speed_m_s) }
    }

    /// The yaw model at a forward speed: linear between the points; beyond them a22 grows with the
    /// speed, b2 and C0 with its square, as the forces on a hull and its fins do. A lost rudder takes its share
    /// of b2; more inertia turns the same moments into less acceleration.
    pub fn yaw_model(&self, surge_speed_m_s: f64) -> YawModel<f64> {
        let at = |value: fn(&SpeedPoint, f64) -> f64| {
            self.between(|p| p.surge_speed_m_s, surge_speed_m_s, value)
        };
        let u = surge_speed_m_s;
        let authority = match self.has_fins {
            true => self.between(
                |p| p.surge_speed_m_s * p.surge_speed_m_s,
                u * u,
                |p, scale| p.b2_per_s2 * scale,
            ),
            false => at(|p, scale| p.b2_per_s2 * scale * scale),
        };
        let rudder_left = 1.0 - self.damage.lost_rudder_area;
        let inertia = self.damage.yaw_inertia_factor;
        YawModel {
            a22_per_s: at(|p, scale| p.a22_per_s * scale) / inertia,
            b2_per_s2: authority * rudder_left / inertia,
            c0_rad_per_s2: at(|p, scale| p.c0_rad_per_s2 * scale * scale) / inertia,
        }
    }

    /// The vehicle `interval_s` later with constant commands and yaw disturbance.
    pub fn advance(
        &mut self,
        rudder_command_rad: f64,
        thrust: f64,
        disturbance_rad_s2: f64,
        interval_s: f64,
    ) {
        let target_m_s = self.truth(thrust).surge_speed_m_s;
        let steps = (interval_s / self.longest_step_s).ceil().max(1.0);
        let h = interval_s / steps;
        if let Some(underway) = &mut self.underway {
            underway.send(rudder_command_rad);
        }
        for _ in 0..steps as u32 {
            let underway = self.underway.as_mut();
            let command_rad = underway.map_or(rudder_command_rad, |underway| underway.next(h));
            let fin_after = self.servo.advance(self.fin_rad, command_rad, h);
            let fin = if self.servo.is_instant() {
                command_rad
            } else {
                (self.fin_rad + fin_after) / 2.0
            };
            let mut model = self.yaw_model(self.surge_speed_m_s);
            model.c0_rad_per_s2 += disturbance_rad_s2;
            let yaw = model.advance(self.yaw, fin, h);
            let course = (self.yaw.heading_rad + yaw.heading_rad) / 2.0;
            self.position_m[0] += self.surge_speed_m_s * h * libm::cos(course);
            self.position_m[1] += self.surge_speed_m_s * h * libm::sin(course);
            self.yaw = yaw;
            self.fin_rad = fin_after;
            self.surge_speed_m_s =
                self.surge.advance(self.surge_speed_m_s, target_m_s, yaw.yaw_rate_rad_s, h);
        }
    }

    /// Linear in `x` between the points; the nearest one, scaled by the ratio of the x, beyond them.
    fn between(
        &self,
        x: fn(&SpeedPoint) -> f64,
        wanted: f64,
        value: impl Fn(&SpeedPoint, f64) -> f64,
    ) -> f64 {
        let above = self.speeds.partition_point(|p| x(p) < wanted);
        match (above.checked_sub(1).map(|k| &self.speeds[k]), self.speeds.get(above)) {
            (Some(low), Some(high)) => {
                let share = (wanted - x(low)) / (x(high) - x(low));
                value(low, 1.0) + share * (value(high, 1.0) - value(low, 1.0))
            }
            (Some(nearest), None) | (None, Some(nearest)) => value(nearest, wanted / x(nearest)),
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VehicleConfig;

    fn starfish() -> Plant {
        let config = VehicleConfig::starfish();
        let surge = config.surge();
        Plant::new(config.speeds, surge, Servo::default(), 0.8, 0.3)
    }

    #[test]
    fn exact_truth_is_table_ii_and_linear_between() {
        let plant = starfish();
        let truth = plant.truth(0.8);
        assert_eq!(truth.surge_speed_m_s, 1.63);
        assert_eq!(truth.model.theta(), [-1.07, 1.08, 0.012]);
        let halfway = plant.truth(0.65);
        assert!((halfway.surge_speed_m_s - 1.215).abs() < 1e-12);
        assert!((halfway.model.b2_per_s2 - 0.735).abs() < 1e-12);
        // Half the slowest speed: a quarter of its rudder authority.
        assert!((plant.yaw_model(0.535).b2_per_s2 - 0.15).abs() < 1e-12);
    }

    #[test]
    fn exact_many_steps_are_one_exact_step() {
        let mut plant = starfish();
        let expected = plant.truth(0.8).model.advance(plant.yaw, 0.2, 1.0);
        plant.advance(0.2, 0.8, 0.0, 1.0);
        // The rounding of 200 exact steps.
        assert!((plant.yaw.heading_rad - expected.heading_rad).abs() < 1e-13);
        assert!((plant.yaw.yaw_rate_rad_s - expected.yaw_rate_rad_s).abs() < 1e-13);
    }

    #[test]
    fn exact_servo_lag_and_rate_limit() {
        let servo = Servo { time_constant_s: 0.1, rate_limit_rad_s: None };
        let mut fin = 0.0;
        for _ in 0..20 {
            fin = servo.advance(fin, 0.2, 0.005);
        }
        assert!((fin - 0.2 * (1.0 - libm::exp(-1.0))).abs() < 1e-12);
        let limited = Servo { time_constant_s: 0.0, rate_limit_rad_s: Some(1.0) };
        assert_eq!(limited.advance(0.0, 0.2, 0.005), 0.005);
    }

    /// A command acts after the dead time, whatever comes between.
    #[test]
    fn exact_a_dead_time_moves_the_turn() {
        let config = VehicleConfig::starfish();
        let surge = config.surge();
        let mut late = Plant::new(config.speeds.clone(), surge, Servo::default(), 0.8, 0.0)
            .with_rudder_delay(0.3);
        let mut prompt = Plant::new(config.speeds, surge, Servo::default(), 0.8, 0.0);
        let straight_rad = prompt.fin_rad;
        prompt.advance(straight_rad, 0.8, 0.0, 0.3);
        for command_rad in [0.2, 0.2, -0.1, -0.1] {
            prompt.advance(command_rad, 0.8, 0.0, 0.1);
        }
        for command_rad in [0.2, 0.2, -0.1, -0.1, 0.0, 0.0, 0.0] {
            late.advance(command_rad, 0.8, 0.0, 0.1);
        }
        // The rounding of 140 exact steps.
        assert!((late.yaw.heading_rad - prompt.yaw.heading_rad).abs() < 1e-13);
    }

    /// u = u_s tanh(u_s t/l) solves u' = (u_s^2 - u^2)/l from rest; a steady turn costs l d r^2 of u^2.
    #[test]
    fn exact_drag_that_grows_with_the_square_of_the_speed() {
        let mut config = VehicleConfig::starfish();
        config.speeds.iter_mut().for_each(|p| p.c0_rad_per_s2 = 0.0);
        config.surge_drag = Some(SurgeDrag { drag_length_m: 9.0, turning_drag_m: 2.0 });
        let surge = config.surge();
        let mut plant = Plant::new(config.speeds, surge, Servo::default(), 0.0, 0.0);
        let steady_m_s = plant.truth(0.8).surge_speed_m_s;
        plant.advance(0.0, 0.8, 0.0, 4.0);
        let expected = steady_m_s * (steady_m_s * 4.0 / 9.0).tanh();
        // The midpoint rule in steps of 5 ms against a time constant of 3 s.
        assert!((plant.surge_speed_m_s / expected - 1.0).abs() < 1e-6);
        plant.advance(0.2, 0.8, 0.0, 60.0);
        let lost = 9.0 * 2.0 * plant.yaw.yaw_rate_rad_s.powi(2);
        let left = (steady_m_s * steady_m_s - lost).sqrt();
        assert!((plant.surge_speed_m_s / left - 1.0).abs() < 1e-6);
    }
}
