//! A simulated vehicle of either kind whose rudder and propeller somebody else commands, step by step.

use crate::config_error::ConfigError;
use crate::plant::{Disturbance, Plant};
use crate::sensors::Chance;
use crate::simulated::SimulatedConfig;
use crate::six_dof::commands::Commands;
use crate::six_dof::rigid_body::GRAVITY_M_S2;
use crate::six_dof::vehicle::SixDofBody;

/// True motion in the axes of inertial sensors and maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics {
    /// Since the start, s.
    pub time_s: f64,
    /// Angular velocity forward, starboard and down, rad/s.
    pub angular_velocity_rad_s: [f64; 3],
    /// Acceleration less gravity forward, starboard and down, m/s^2.
    pub specific_force_m_s2: [f64; 3],
    /// North, east and down, m.
    pub position_m: [f64; 3],
    /// Roll, pitch and heading, rad.
    pub attitude_rad: [f64; 3],
    /// Towards north, east and down, m/s.
    pub velocity_m_s: [f64; 3],
}

/// A vehicle that starts at rest, at its depth and heading, and goes where it is steered. The same seed and commands give the same motion
/// bit for bit on every platform.
#[derive(Clone, Debug)]
pub struct Driven {
    body: DrivenBody,
    sea: Disturbance,
    disturbance: Chance,
    disturbance_rad_s2: f64,
}

#[derive(Clone, Debug)]
enum DrivenBody {
    FirstOrder(Box<Boat>),
    SixDof(Box<SixDofBody>),
}

/// A vehicle whose yaw follows psi'' = a22 psi' + b2 delta + C0, upright. It does not drift: its velocity is along its heading.
#[derive(Clone, Debug)]
struct Boat {
    plant: Plant,
    depth_m: f64,
    time_s: f64,
    surge_acceleration_m_s2: f64,
}

impl Driven {
    /// A vehicle in the disturbance and the waves of a seed.
    pub fn new(config: &SimulatedConfig, seed: u64) -> Result<Self, ConfigError> {
        let body = match config {
            SimulatedConfig::FirstOrder(config) => {
                config.check()?;
                DrivenBody::FirstOrder(Box::new(Boat {
                    plant: config.plant(0.0),
                    depth_m: config.depth_m,
                    time_s: 0.0,
                    surge_acceleration_m_s2: 0.0,
                }))
            }
            SimulatedConfig::SixDof(config) => {
                let config = config.as_ref().clone().in_waves_of(seed)?;
                DrivenBody::SixDof(Box::new(SixDofBody::at_rest(config)?))
            }
        };
        let sea = config.helm().disturbance;
        let [mut disturbance] = Chance::sources(seed);
        Ok(Self {
            disturbance_rad_s2: sea.standard_deviation_rad_s2 * disturbance.normal(),
            body,
            sea,
            disturbance,
        })
    }

    /// Goes on.
    pub fn advance(&mut self, commands: &Commands, interval_s: f64) {
        let disturbance_rad_s2 = self.disturbance_rad_s2;
        match &mut self.body {
            DrivenBody::FirstOrder(boat) => boat.advance(commands, disturbance_rad_s2, interval_s),
            DrivenBody::SixDof(body) => body.drive(commands, disturbance_rad_s2, interval_s),
        }
        let chance = self.disturbance.normal();
        self.disturbance_rad_s2 = self.sea.after(disturbance_rad_s2, interval_s, chance);
    }

    /// What inertial sensors and a map would say.
    pub fn kinematics(&self) -> Kinematics {
        match &self.body {
            DrivenBody::FirstOrder(boat) => boat.kinematics(),
            DrivenBody::SixDof(body) => of_body(body, self.disturbance_rad_s2),
        }
    }
}

impl Boat {
    fn advance(&mut self, commands: &Commands, disturbance_rad_s2: f64, interval_s: f64) {
        let before_m_s = self.plant.surge_speed_m_s;
        let (rudder_rad, thrust) = (commands.rudder_rad, commands.thrust);
        self.plant.advance(rudder_rad, thrust, disturbance_rad_s2, interval_s);
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
            position_m: [north_m, east_m, self.depth_m],
            attitude_rad: [0.0, 0.0, heading_rad],
            velocity_m_s: [
                speed_m_s * libm::cos(heading_rad),
                speed_m_s * libm::sin(heading_rad),
                0.0,
            ],
        }
    }
}

fn of_body(body: &SixDofBody, disturbance_rad_s2: f64) -> Kinematics {
    let state = &body.state;
    let [_, _, _, roll_rate, pitch_rate, yaw_rate] = state.velocity.into();
    Kinematics {
        time_s: body.time_s,
        angular_velocity_rad_s: [roll_rate, pitch_rate, yaw_rate],
        specific_force_m_s2: body.specific_force_m_s2(disturbance_rad_s2).into(),
        position_m: state.position_m.into(),
        attitude_rad: state.euler_rad(),
        velocity_m_s: state.drift_m_s().into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::VehicleConfig;

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
        let commands = Commands { rudder_rad: 0.1, elevator_rad: None, thrust: truth.thrust };
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
