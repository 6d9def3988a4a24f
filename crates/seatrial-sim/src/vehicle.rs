//! The first-order vehicle.

use std::convert::Infallible;

use seatrial_core::{Action, Sample, Vehicle, YawModel};

use crate::body::{Body, Motion};
use crate::config::VehicleConfig;
use crate::config_error::ConfigError;
use crate::faults::{Damage, Kind, Rehearsable, Upset};
use crate::helm::Helm;
use crate::plant::{Plant, Truth};

/// A vehicle whose yaw follows psi'' = a22 psi' + b2 delta + C0 exactly, with a truth known at every speed.
///
/// At each sampling instant t_k it measures itself, sets the rudder that it will keep until
/// t_k+1, and reports both: [`Sample::rudder_rad`] is the rudder commanded over [t_k, t_k+1). A
/// rudder angle or thrust asked for after the sample of t_k-1 therefore acts from t_k on: one
/// sample of delay, exactly known because the sample says what acts. The vehicle's own heading
/// controller has the heading of t_k when it sets the rudder of t_k.
/// A servo with a lag is not in the sample: the rudder reported is the command.
///
/// A seed gives equal samples, bit for bit, on every platform.
#[derive(Clone, Debug)]
pub struct FirstOrderVehicle {
    config: VehicleConfig,
    body: FirstOrderBody,
    helm: Helm,
}

/// The plant at the constant depth of its vehicle.
#[derive(Clone, Debug)]
struct FirstOrderBody {
    plant: Plant,
    depth_m: f64,
}

impl FirstOrderVehicle {
    /// A vehicle that runs straight at its own thrust, holding its heading.
    pub fn new(config: VehicleConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let plant = config.plant(config.initial_thrust);
        Ok(Self {
            helm: Helm::new(config.helm(), plant.fin_rad, seed),
            body: FirstOrderBody { plant, depth_m: config.depth_m },
            config,
        })
    }

    /// The truth at a thrust.
    pub fn truth(&self, thrust: f64) -> Truth {
        self.body.plant.truth(thrust)
    }

    /// The true state.
    pub fn plant(&self) -> &Plant {
        &self.body.plant
    }

    /// What it was made from.
    pub fn config(&self) -> &VehicleConfig {
        &self.config
    }
}

impl Body for FirstOrderBody {
    fn motion(&self) -> Motion {
        let plant = &self.plant;
        let [north_m, east_m] = plant.position_m;
        Motion {
            heading_rad: plant.yaw.heading_rad,
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rate_rad_s: plant.yaw.yaw_rate_rad_s,
            surge_speed_m_s: plant.surge_speed_m_s,
            north_m,
            east_m,
            depth_m: self.depth_m,
            altitude_m: None,
        }
    }

    fn advance(
        &mut self,
        rudder_command_rad: f64,
        thrust: f64,
        yaw_disturbance_rad_s2: f64,
        interval_s: f64,
    ) {
        self.plant.advance(rudder_command_rad, thrust, yaw_disturbance_rad_s2, interval_s);
    }

    fn suffer(&mut self, damage: &Damage) {
        self.plant.damage = *damage;
    }
}

impl Rehearsable for FirstOrderVehicle {
    fn refuses(&self, kind: Kind) -> Option<&'static str> {
        (kind == Kind::CurrentStep)
            .then_some("a first-order vehicle has no water to be carried by; one of six degrees of freedom has")
    }

    fn upset(&mut self, upset: &Upset) {
        self.helm.upset(upset, &mut self.body);
    }

    fn yaw_model(&self) -> Option<YawModel<f64>> {
        let plant = &self.body.plant;
        Some(plant.yaw_model(plant.surge_speed_m_s))
    }
}

impl Vehicle<f64> for FirstOrderVehicle {
    type Error = Infallible;

    /// Never `None`: a simulated vehicle runs for ever.
    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        Ok(Some(self.helm.next_sample(&mut self.body)))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        self.helm.act(action);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use seatrial_core::{Real, Steering};

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
        config.sensors.compass.noise_rad = 0.02;
        config.sensors.compass.resolution_rad = 0.0;
        config.disturbance.standard_deviation_rad_s2 = 0.0;
        config.heading_hold.gain = 0.0;
        // Without steering the heading drifts by C0; the noise is in the differences.
        let heading: Vec<f64> = samples(config, 3, 4000).iter().map(|s| s.heading_rad).collect();
        let differences: Vec<f64> =
            heading.windows(2).map(|w| Real::wrapped(w[1] - w[0])).collect();
        let mean = differences.iter().sum::<f64>() / 3999.0;
        let variance = differences.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / 3999.0;
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
