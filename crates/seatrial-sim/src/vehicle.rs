//! The first-order vehicle.

use std::convert::Infallible;

use seatrial_core::{Action, Real, Sample, Steering, Vehicle};

use crate::config::{ConfigError, VehicleConfig};
use crate::plant::{Plant, Truth};
use crate::sensors::Chance;

/// A vehicle whose yaw follows psi'' = a22 psi' + b2 delta + C0 exactly, with a truth known at every speed.
///
/// At each sampling instant t_k it measures itself, sets the rudder that it will keep until
/// t_k+1, and reports both: [`Sample::rudder_rad`] is the rudder commanded over [t_k, t_k+1). A
/// rudder angle or thrust asked for after the sample of t_k-1 therefore acts from t_k on: one
/// sample of delay, exactly known because the sample says what acts. The vehicle's own heading
/// controller has the heading of t_k when it sets the rudder of t_k.
/// A servo with a lag is not in the sample: the rudder reported is the command.
///
/// The same seed gives the same samples bit for bit on every platform.
#[derive(Clone, Debug)]
pub struct FirstOrderVehicle {
    config: VehicleConfig,
    plant: Plant,
    disturbance_rad_s2: f64,
    chance: Sources,
    /// Sampling instants so far.
    ticks: u64,
    time_s: f64,
    rudder_command_rad: f64,
    steering: Steering<f64>,
    thrust: f64,
    asked: Option<Action<f64>>,
}

/// What is left to chance.
#[derive(Clone, Debug)]
struct Sources {
    timing: Chance,
    missing: Chance,
    disturbance: Chance,
    compass: Chance,
    gyro: Chance,
    speed: Chance,
    depth: Chance,
    attitude: Chance,
}

impl FirstOrderVehicle {
    /// A vehicle that runs straight at its own thrust, holding its heading.
    pub fn new(config: VehicleConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let [
            timing,
            missing,
            mut disturbance,
            compass,
            gyro,
            speed,
            depth,
            attitude,
        ] = Chance::sources(seed);
        let plant = Plant::new(
            config.speeds.clone(),
            config.surge_time_constant_s,
            config.servo,
            config.initial_thrust,
            config.initial_heading_rad,
        );
        Ok(Self {
            disturbance_rad_s2: config.disturbance.standard_deviation_rad_s2 * disturbance.normal(),
            chance: Sources {
                timing,
                missing,
                disturbance,
                compass,
                gyro,
                speed,
                depth,
                attitude,
            },
            ticks: 0,
            time_s: 0.0,
            rudder_command_rad: plant.fin_rad,
            steering: Steering::HoldHeading(config.initial_heading_rad),
            thrust: config.initial_thrust,
            asked: None,
            plant,
            config,
        })
    }

    /// The truth at a thrust.
    pub fn truth(&self, thrust: f64) -> Truth {
        self.plant.truth(thrust)
    }

    /// The true state.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// What it was made from.
    pub fn config(&self) -> &VehicleConfig {
        &self.config
    }

    /// Goes on to the next sampling instant.
    fn tick(&mut self) {
        let timing = self.config.timing;
        let late_s = self.chance.timing.uniform() * timing.jitter_s;
        let time_s = self.ticks as f64 * timing.sample_interval_s + late_s;
        if self.ticks > 0 {
            self.advance(time_s - self.time_s);
        }
        self.ticks += 1;
        self.time_s = time_s;
    }

    /// Measures, sets the rudder and reports both.
    fn measure(&mut self) -> Sample<f64> {
        self.carry_out();
        let compass_rad = self.config.sensors.compass(
            self.plant.yaw.heading_rad
                + self.config.sensors.compass_noise_rad * self.chance.compass.normal(),
        );
        self.rudder_command_rad = self.rudder(compass_rad);
        self.sample(compass_rad)
    }

    fn advance(&mut self, interval_s: f64) {
        self.plant.advance(
            self.rudder_command_rad,
            self.thrust,
            self.disturbance_rad_s2,
            interval_s,
        );
        let disturbance = self.config.disturbance;
        let decay = libm::exp(-interval_s / disturbance.correlation_time_s);
        self.disturbance_rad_s2 = decay * self.disturbance_rad_s2
            + (1.0 - decay * decay).sqrt()
                * disturbance.standard_deviation_rad_s2
                * self.chance.disturbance.normal();
    }

    /// What was asked for since the last sample takes effect.
    fn carry_out(&mut self) {
        if let Some(action) = self.asked.take() {
            self.steering = action.steering;
            self.thrust = action
                .thrust
                .unwrap_or(self.config.initial_thrust)
                .clamp(0.0, 1.0);
        }
    }

    fn rudder(&self, compass_rad: f64) -> f64 {
        let wanted = match self.steering {
            Steering::Rudder(rudder_rad) => rudder_rad,
            Steering::HoldHeading(heading_rad) => {
                let hold = self.config.heading_hold;
                (-hold.gain * Real::wrapped(compass_rad - heading_rad))
                    .limited_to(hold.rudder_limit_rad)
            }
        };
        wanted.limited_to(self.config.rudder_limit_rad)
    }

    fn sample(&mut self, compass_rad: f64) -> Sample<f64> {
        let sensors = self.config.sensors;
        let [north_m, east_m] = self.plant.position_m;
        let mut noise = |deviation: f64, chance: fn(&mut Sources) -> &mut Chance| {
            deviation * chance(&mut self.chance).normal()
        };
        Sample {
            time_s: self.time_s,
            heading_rad: compass_rad,
            rudder_rad: self.rudder_command_rad,
            surge_speed_m_s: Some(
                self.plant.surge_speed_m_s + noise(sensors.surge_speed_noise_m_s, |c| &mut c.speed),
            ),
            depth_m: Some(self.config.depth_m + noise(sensors.depth_noise_m, |c| &mut c.depth)),
            altitude_m: None,
            roll_rad: Some(noise(sensors.attitude_noise_rad, |c| &mut c.attitude)),
            pitch_rad: Some(noise(sensors.attitude_noise_rad, |c| &mut c.attitude)),
            yaw_rate_rad_s: sensors
                .yaw_rate_noise_rad_s
                .map(|deviation| self.plant.yaw.yaw_rate_rad_s + noise(deviation, |c| &mut c.gyro)),
            north_m: Some(north_m),
            east_m: Some(east_m),
        }
    }
}

impl Vehicle<f64> for FirstOrderVehicle {
    type Error = Infallible;

    /// Never `None`: a simulated vehicle runs for ever.
    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        self.tick();
        while self.chance.missing.uniform() < self.config.timing.missing_fraction {
            self.tick();
        }
        Ok(Some(self.measure()))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        self.asked = Some(*action);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(config: VehicleConfig, seed: u64, count: usize) -> Vec<Sample<f64>> {
        let mut vehicle = FirstOrderVehicle::new(config, seed).unwrap();
        (0..count)
            .map(|_| {
                let Ok(sample) = vehicle.next_sample();
                sample.unwrap()
            })
            .collect()
    }

    #[test]
    fn prop_same_seed_same_samples() {
        let config = VehicleConfig::starfish;
        assert_eq!(samples(config(), 7, 500), samples(config(), 7, 500));
        assert_ne!(samples(config(), 7, 500), samples(config(), 8, 500));
    }

    /// A rudder asked for after sample k is the one that sample k+1 reports, and acts from there.
    #[test]
    fn exact_the_sample_says_what_acts_from_it_on() {
        let config = VehicleConfig::starfish().noise_free();
        let mut vehicle = FirstOrderVehicle::new(config, 1).unwrap();
        let model = vehicle.truth(0.6).model;
        let mut next = || {
            let Ok(sample) = vehicle.next_sample();
            let Ok(()) = vehicle.act(&Action {
                steering: Steering::Rudder(0.2),
                thrust: None,
                outcome: None,
            });
            sample.unwrap()
        };
        let first = next();
        assert_ne!(first.rudder_rad, 0.2);
        let mut before = next();
        for _ in 0..50 {
            assert_eq!(before.rudder_rad, 0.2);
            let after = next();
            let state = seatrial_core::model::YawState {
                heading_rad: before.heading_rad,
                yaw_rate_rad_s: before.yaw_rate_rad_s.unwrap(),
            };
            let expected = model.advance(state, 0.2, after.time_s - before.time_s);
            // The rounding of ten exact steps.
            assert!((after.heading_rad - expected.heading_rad).abs() < 1e-13);
            before = after;
        }
    }

    #[test]
    fn recover_noise_has_the_stated_size() {
        let mut config = VehicleConfig::starfish();
        config.sensors.compass_noise_rad = 0.02;
        config.sensors.compass_resolution_rad = 0.0;
        config.disturbance.standard_deviation_rad_s2 = 0.0;
        config.heading_hold.gain = 0.0;
        // Without steering the heading drifts by C0; the noise is in the differences.
        let heading: Vec<f64> = samples(config, 3, 4000)
            .iter()
            .map(|s| s.heading_rad)
            .collect();
        let differences: Vec<f64> = heading
            .windows(2)
            .map(|w| Real::wrapped(w[1] - w[0]))
            .collect();
        let mean = differences.iter().sum::<f64>() / 3999.0;
        let variance = differences
            .iter()
            .map(|d| (d - mean) * (d - mean))
            .sum::<f64>()
            / 3999.0;
        // The deviation of a difference is sqrt 2 times the noise; 4000 samples know it to 1.4 %, four times that is allowed.
        assert!((variance.sqrt() / (0.02 * 2.0_f64.sqrt()) - 1.0).abs() < 0.056);
    }

    #[test]
    fn exact_missing_and_jittered_samples() {
        let mut config = VehicleConfig::starfish();
        config.timing.missing_fraction = 0.2;
        config.timing.jitter_s = 0.02;
        let taken = samples(config, 1, 4000);
        assert!(taken.windows(2).all(|w| w[1].time_s > w[0].time_s));
        let arrived = 4000.0 * 0.05 / taken.last().unwrap().time_s;
        // 5000 draws of 0.8: standard deviation 0.6 %, four times that is allowed.
        assert!((arrived - 0.8).abs() < 0.024, "{arrived}");
    }
}
