//! A simulated vehicle of either kind whose rudder and propeller somebody else commands, step by step.

use crate::config::VehicleConfig;
use crate::config_error::ConfigError;
use crate::plant::Plant;
use crate::sensors::Chance;
use crate::simulated::SimulatedConfig;
use crate::six_dof::DrivenVehicle;
use crate::six_dof::commands::Commands;
use crate::six_dof::driven::Kinematics;
use crate::six_dof::rigid_body::GRAVITY_M_S2;

/// A vehicle that starts at rest and goes where it is steered. The same seed and commands give the same motion bit for bit.
#[derive(Clone, Debug)]
pub enum Driven {
    /// A yaw model at every speed, upright at a constant depth.
    FirstOrder(Box<DrivenBoat>),
    /// Six degrees of freedom.
    SixDof(Box<DrivenVehicle>),
}

impl Driven {
    /// A vehicle in the disturbance and the waves of a seed.
    pub fn new(config: &SimulatedConfig, seed: u64) -> Result<Self, ConfigError> {
        Ok(match config {
            SimulatedConfig::FirstOrder(config) => {
                Self::FirstOrder(Box::new(DrivenBoat::new(config.as_ref().clone(), seed)?))
            }
            SimulatedConfig::SixDof(config) => {
                Self::SixDof(Box::new(DrivenVehicle::new(config.as_ref().clone(), seed)?))
            }
        })
    }

    /// Goes on.
    pub fn advance(&mut self, commands: &Commands, interval_s: f64) {
        match self {
            Self::FirstOrder(boat) => boat.advance(commands, interval_s),
            Self::SixDof(vehicle) => vehicle.advance(commands, interval_s),
        }
    }

    /// What inertial sensors and a map would say.
    pub fn kinematics(&self) -> Kinematics {
        match self {
            Self::FirstOrder(boat) => boat.kinematics(),
            Self::SixDof(vehicle) => vehicle.kinematics(),
        }
    }
}

/// A vehicle whose yaw follows psi'' = a22 psi' + b2 delta + C0. It does not drift: its velocity is along its heading.
#[derive(Clone, Debug)]
pub struct DrivenBoat {
    config: VehicleConfig,
    plant: Plant,
    disturbance: Chance,
    disturbance_rad_s2: f64,
    time_s: f64,
    surge_acceleration_m_s2: f64,
}

impl DrivenBoat {
    fn new(config: VehicleConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let [mut disturbance] = Chance::sources(seed);
        Ok(Self {
            disturbance_rad_s2: config.disturbance.standard_deviation_rad_s2 * disturbance.normal(),
            plant: Plant::new(
                config.speeds.clone(),
                config.surge(),
                config.servo,
                0.0,
                config.initial_heading_rad,
            )
            .with_fins(config.has_fins)
            .with_rudder_delay(config.rudder_delay_s),
            config,
            disturbance,
            time_s: 0.0,
            surge_acceleration_m_s2: 0.0,
        })
    }

    fn advance(&mut self, commands: &Commands, interval_s: f64) {
        let before_m_s = self.plant.surge_speed_m_s;
        self.plant.advance(
            commands.rudder_rad,
            commands.thrust,
            self.disturbance_rad_s2,
            interval_s,
        );
        self.disturbance_rad_s2 = self.config.disturbance.after(
            self.disturbance_rad_s2,
            interval_s,
            self.disturbance.normal(),
        );
        self.surge_acceleration_m_s2 = (self.plant.surge_speed_m_s - before_m_s) / interval_s;
        self.time_s += interval_s;
    }

    fn kinematics(&self) -> Kinematics {
        let plant = &self.plant;
        let (speed_m_s, rate_rad_s) = (plant.surge_speed_m_s, plant.yaw.yaw_rate_rad_s);
        let heading_rad = plant.yaw.heading_rad;
        let [north_m, east_m] = plant.position_m;
        Kinematics {
            time_s: self.time_s,
            angular_velocity_rad_s: [0.0, 0.0, rate_rad_s],
            specific_force_m_s2: [
                self.surge_acceleration_m_s2,
                speed_m_s * rate_rad_s,
                -GRAVITY_M_S2,
            ],
            position_m: [north_m, east_m, self.config.depth_m],
            attitude_rad: [0.0, 0.0, heading_rad],
            velocity_m_s: [
                speed_m_s * libm::cos(heading_rad),
                speed_m_s * libm::sin(heading_rad),
                0.0,
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What its sensors say adds up to where it goes, and its turn is that of its model.
    #[test]
    fn exact_a_boat_turns_and_goes_as_its_sensors_say() {
        let mut config = VehicleConfig::starfish();
        config.disturbance.standard_deviation_rad_s2 = 0.0;
        let truth = config.speeds[1];
        let config = SimulatedConfig::FirstOrder(Box::new(config));
        let mut boat = Driven::new(&config, 1).unwrap();
        assert_eq!(boat.kinematics().velocity_m_s, [0.0; 3]);
        let interval_s = 0.0025;
        let commands = Commands {
            rudder_rad: 0.1,
            elevator_rad: None,
            thrust: truth.thrust,
        };
        let mut before = boat.kinematics();
        for _ in 0..24_000 {
            boat.advance(&commands, interval_s);
            let after = boat.kinematics();
            for i in 0..2 {
                let moved = after.position_m[i] - before.position_m[i];
                let mean_m_s = 0.5 * (before.velocity_m_s[i] + after.velocity_m_s[i]);
                // Half of 2.5 ms squared times 0.8 m/s^2: less than 2 m/s at 0.3 rad/s across, 0.5 m/s^2 ahead.
                let off_m = (moved - mean_m_s * interval_s).abs();
                assert!(off_m < 2.5e-6, "{off_m} m");
            }
            let [ahead, aside, _] = after.specific_force_m_s2;
            let (sin, cos) = after.attitude_rad[2].sin_cos();
            let north = cos * ahead - sin * aside;
            let change = (after.velocity_m_s[0] - before.velocity_m_s[0]) / interval_s;
            assert!((north - change).abs() < 5e-3, "{north} {change}");
            before = after;
        }
        // After 60 s the turn is steady: r = -(b2 delta + C0)/a22.
        let steady = -(truth.b2_per_s2 * 0.1 + truth.c0_rad_per_s2) / truth.a22_per_s;
        assert!((before.angular_velocity_rad_s[2] - steady).abs() < 1e-6);
    }
}
