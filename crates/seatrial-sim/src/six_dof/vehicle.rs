//! The vehicle of six degrees of freedom.

use std::convert::Infallible;

use nalgebra::Vector3;
use seatrial_core::{Action, Axis, Sample, Steering, Vehicle, YawModel};

use super::actuator::ActuatorState;
use super::commands::Commands;
use super::config::SixDofConfig;
use super::depth_hold::DepthHoldState;
use super::dynamics::{Dynamics, Inputs, State};
use super::fins::Deflections;
use crate::body::{Body, Motion};
use crate::config_error::ConfigError;
use crate::faults::{Damage, Kind, Rehearsable, Upset};
use crate::helm::Helm;

/// Longest step of the integration, s.
pub const STEP_S: f64 = 0.01;
/// Time that a vehicle runs before its clock starts, s: speed, trim and depth have settled.
const RUN_IN_S: f64 = 120.0;

/// A vehicle that obeys the equations of motion of a rigid body in water.
///
/// Sampling and steering are those of [`FirstOrderVehicle`](crate::FirstOrderVehicle): the rudder reported is
/// the command that acts until the next sample, and lag, limits, dead band and backlash of the fin are not in
/// the sample. Depth is held by the elevator from measured depth and pitch; nothing controls roll.
/// Forward speed is over ground along the hull's axis.
///
/// A seed gives equal samples, bit for bit, on every platform.
#[derive(Clone, Debug)]
pub struct SixDofVehicle {
    body: SixDofBody,
    helm: Helm,
    axis: Axis,
}

/// The moving vehicle: its state, its actuators and its depth controller.
#[derive(Clone, Debug)]
pub struct SixDofBody {
    config: SixDofConfig,
    dynamics: Dynamics,
    /// Position, attitude and velocity.
    pub state: State,
    /// The rudder's actuator.
    pub rudder: ActuatorState,
    /// The elevator's actuator.
    pub elevator: ActuatorState,
    /// Shaft speed, rev/s.
    pub shaft_rev_s: f64,
    elevator_command_rad: f64,
    /// Elevator that is held instead of the depth, rad.
    elevator_asked_rad: Option<f64>,
    depth_hold: DepthHoldState,
    /// Time in the sea, s.
    pub time_s: f64,
    /// Did it run into the bottom? There it stays.
    pub is_aground: bool,
}

impl SixDofVehicle {
    /// A vehicle that runs straight and level at its own thrust, holding heading and depth.
    pub fn new(config: SixDofConfig, seed: u64) -> Result<Self, ConfigError> {
        let mut body = SixDofBody::at_rest(config.in_waves_of(seed)?)?;
        body.run_in();
        Ok(Self {
            helm: Helm::new(body.config.helm, body.rudder.horn_rad, seed),
            body,
            axis: Axis::Yaw,
        })
    }

    /// Steered on this axis. On that of pitch the elevator reported is the command that acts until the next sample, and
    /// the heading is held throughout.
    pub fn on_axis(self, axis: Axis) -> Self {
        Self { axis, ..self }
    }

    /// The true state.
    pub fn body(&self) -> &SixDofBody {
        &self.body
    }

    /// The body alone, without instruments and noise.
    pub(super) fn into_body(self) -> SixDofBody {
        self.body
    }

    /// What it was made from.
    pub fn config(&self) -> &SixDofConfig {
        &self.body.config
    }
}

impl Vehicle<f64> for SixDofVehicle {
    type Error = Infallible;

    /// Never `None`: a simulated vehicle runs for ever.
    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        let sample = self.helm.next_sample(&mut self.body);
        Ok(Some(match self.axis {
            Axis::Yaw => sample,
            Axis::Pitch => Sample {
                heading_rad: sample.pitch_rad.unwrap_or(f64::NAN),
                rudder_rad: self.body.elevator_command_rad,
                yaw_rate_rad_s: None,
                ..sample
            },
        }))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        match self.axis {
            Axis::Yaw => self.helm.act(action),
            Axis::Pitch => {
                self.body.elevator_asked_rad = match action.steering {
                    Steering::Rudder(elevator_rad) => Some(elevator_rad),
                    Steering::HoldHeading(_) => None,
                };
                let heading_rad = self.body.config.helm.initial_heading_rad;
                self.helm.act(&Action { steering: Steering::HoldHeading(heading_rad), ..*action });
            }
        }
        Ok(())
    }
}

impl Rehearsable for SixDofVehicle {
    fn refuses(&self, _kind: Kind) -> Option<&'static str> {
        None
    }

    fn upset(&mut self, upset: &Upset) {
        self.helm.upset(upset, &mut self.body);
    }

    /// None: what is identified of it hangs on the manoeuvre.
    fn yaw_model(&self) -> Option<YawModel<f64>> {
        None
    }
}

impl SixDofBody {
    /// The vehicle at its depth and heading, at rest.
    pub fn at_rest(config: SixDofConfig) -> Result<Self, ConfigError> {
        Ok(Self {
            dynamics: Dynamics::new(&config)?,
            state: State::level(config.helm.initial_heading_rad, config.depth_hold.depth_m, 0.0),
            rudder: ActuatorState::default(),
            elevator: ActuatorState::default(),
            shaft_rev_s: 0.0,
            elevator_command_rad: 0.0,
            elevator_asked_rad: None,
            depth_hold: DepthHoldState::default(),
            time_s: 0.0,
            is_aground: false,
            config,
        })
    }

    /// Its equations of motion.
    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// Goes on for `interval_s` under these commands instead of the helm's.
    pub(crate) fn drive(
        &mut self,
        commands: &Commands,
        yaw_disturbance_rad_s2: f64,
        interval_s: f64,
    ) {
        let [_, pitch_rad, _] = self.state.euler_rad();
        self.elevator_asked_rad = commands.elevator_rad;
        self.measured(&Sample {
            time_s: self.time_s,
            depth_m: Some(self.state.position_m.z),
            pitch_rad: Some(pitch_rad),
            ..Sample::default()
        });
        self.advance(commands.rudder_rad, commands.thrust, yaw_disturbance_rad_s2, interval_s);
    }

    /// What an accelerometer at the origin measures, m/s^2.
    pub(crate) fn specific_force_m_s2(&self, yaw_disturbance_rad_s2: f64) -> Vector3<f64> {
        let inputs = self.inputs(yaw_disturbance_rad_s2);
        self.dynamics.specific_force_m_s2(&self.state, &inputs, self.is_aground)
    }

    /// Runs with exact instruments over no bottom until everything has settled, then calls the place it is at the
    /// origin.
    fn run_in(&mut self) {
        let bottom = self.config.sea.bottom.take();
        let mut helm = Helm::new(self.config.helm.noise_free(), 0.0, 0);
        while helm.next_sample(self).time_s < RUN_IN_S {}
        self.state.position_m.x = 0.0;
        self.state.position_m.y = 0.0;
        self.config.sea.bottom = bottom;
        self.depth_hold.restart_clock();
    }
}

impl Body for SixDofBody {
    fn motion(&self) -> Motion {
        let [roll_rad, pitch_rad, heading_rad] = self.state.euler_rad();
        let [north_m, east_m, depth_m] = self.state.position_m.into();
        Motion {
            heading_rad,
            roll_rad,
            pitch_rad,
            yaw_rate_rad_s: self.state.velocity[5],
            surge_speed_m_s: self.state.velocity[0],
            north_m,
            east_m,
            depth_m,
            altitude_m: self.config.sea.altitude_m(&self.state.position_m),
        }
    }

    fn advance(
        &mut self,
        rudder_command_rad: f64,
        thrust: f64,
        yaw_disturbance_rad_s2: f64,
        interval_s: f64,
    ) {
        // Steps of the longest length, but for rounding, that fill the interval.
        let steps = (interval_s / STEP_S - 1e-6).ceil().max(1.0);
        let h = interval_s / steps;
        for _ in 0..steps as u32 {
            if self.is_aground {
                return;
            }
            let start = self.inputs(yaw_disturbance_rad_s2);
            self.advance_actuators(rudder_command_rad, thrust, 0.5 * h);
            self.time_s += 0.5 * h;
            let middle = self.inputs(yaw_disturbance_rad_s2);
            self.advance_actuators(rudder_command_rad, thrust, 0.5 * h);
            self.time_s += 0.5 * h;
            let end = self.inputs(yaw_disturbance_rad_s2);
            self.state = self.dynamics.step(&self.state, &[start, middle, end], h);
            self.strand();
        }
    }

    fn suffer(&mut self, damage: &Damage) {
        // Fins, inertia and current in the ranges of faults leave the mass matrix positive.
        if let Ok(dynamics) = Dynamics::new(&self.config.damaged(damage)) {
            self.dynamics = dynamics;
        }
    }

    fn measured(&mut self, sample: &Sample<f64>) {
        if let Some(elevator_rad) = self.elevator_asked_rad {
            self.elevator_command_rad = elevator_rad;
            self.depth_hold.restart_clock();
            return;
        }
        if let Some(elevator_rad) =
            self.config.depth_hold.elevator_rad(&mut self.depth_hold, sample)
        {
            self.elevator_command_rad = elevator_rad;
        }
    }
}

impl SixDofBody {
    fn advance_actuators(&mut self, rudder_command_rad: f64, thrust: f64, interval_s: f64) {
        let config = &self.config;
        self.rudder = config.rudder.advance(self.rudder, rudder_command_rad, interval_s);
        self.elevator =
            config.elevator.advance(self.elevator, self.elevator_command_rad, interval_s);
        self.shaft_rev_s = config.propeller.advance(self.shaft_rev_s, thrust, interval_s);
    }

    /// A vehicle that reaches the bottom lies there.
    fn strand(&mut self) {
        let altitude_m = self.config.sea.altitude_m(&self.state.position_m);
        if altitude_m.is_some_and(|altitude_m| altitude_m <= 0.0) {
            self.is_aground = true;
            self.state.velocity.fill(0.0);
        }
    }

    fn inputs(&self, yaw_disturbance_rad_s2: f64) -> Inputs {
        Inputs {
            deflections: Deflections {
                rudder_rad: self.rudder.fin_rad,
                elevator_rad: self.elevator.fin_rad,
            },
            shaft_rev_s: self.shaft_rev_s,
            yaw_disturbance_rad_s2,
            time_s: self.time_s,
        }
    }
}
