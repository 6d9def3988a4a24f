//! Between a trial and a simulated body: clock, instruments, steering and chance.

use seatrial_core::{Action, Real, Sample, Steering};

use crate::body::{Body, Motion};
use crate::config::HelmConfig;
use crate::faults::Upset;
use crate::instruments::Instruments;
use crate::sensors::Chance;

/// At each sampling instant it measures, sets the rudder until the next one and reports both.
#[derive(Clone, Debug)]
pub(crate) struct Helm {
    config: HelmConfig,
    disturbance_rad_s2: f64,
    chance: Unsteadiness,
    instruments: Instruments,
    /// Sampling instants so far.
    ticks: u64,
    time_s: f64,
    rudder_command_rad: f64,
    steering: Steering<f64>,
    thrust: f64,
    asked: Option<Action<f64>>,
    upset: Upset,
    /// The last number that the compass gave, rad.
    compass_rad: f64,
    /// Where the rudder is jammed, rad.
    jammed_rad: f64,
}

/// What is left to chance, but for the instruments.
#[derive(Clone, Debug)]
struct Unsteadiness {
    timing: Chance,
    missing: Chance,
    disturbance: Chance,
}

impl Helm {
    /// A helm that holds the heading and thrust of the start.
    pub fn new(config: HelmConfig, rudder_command_rad: f64, seed: u64) -> Self {
        let [timing, missing, mut disturbance, instruments @ ..] = Chance::sources::<11>(seed);
        Self {
            disturbance_rad_s2: config.disturbance.standard_deviation_rad_s2 * disturbance.normal(),
            chance: Unsteadiness { timing, missing, disturbance },
            instruments: Instruments::new(config.sensors, instruments),
            ticks: 0,
            time_s: 0.0,
            rudder_command_rad,
            steering: Steering::HoldHeading(config.initial_heading_rad),
            thrust: config.initial_thrust,
            asked: None,
            upset: Upset::default(),
            compass_rad: config.initial_heading_rad,
            jammed_rad: rudder_command_rad,
            config,
        }
    }

    /// The next sample of the body.
    pub fn next_sample(&mut self, body: &mut impl Body) -> Sample<f64> {
        self.tick(body);
        while self.chance.missing.uniform() < self.config.timing.missing_fraction {
            self.tick(body);
        }
        let sample = self.measure(&body.motion());
        body.measured(&sample);
        sample
    }

    /// What is asked for takes effect at the next sample.
    pub fn act(&mut self, action: &Action<f64>) {
        self.asked = Some(*action);
    }

    /// What is wrong from now on.
    pub fn upset(&mut self, upset: &Upset, body: &mut impl Body) {
        if upset.rudder_jammed && !self.upset.rudder_jammed {
            self.jammed_rad = self.rudder_rad();
        }
        if upset.damage != self.upset.damage {
            body.suffer(&upset.damage);
        }
        if upset.is_taken_over && !self.upset.is_taken_over {
            self.steering = Steering::HoldHeading(self.compass_rad);
            self.thrust = self.config.initial_thrust;
        }
        self.upset = *upset;
    }

    /// Goes on to the next sampling instant.
    fn tick(&mut self, body: &mut impl Body) {
        let timing = self.config.timing;
        let late_s = self.chance.timing.uniform() * timing.jitter_s;
        let time_s = self.ticks as f64 * timing.sample_interval_s + late_s;
        if self.ticks > 0 {
            self.advance(body, time_s - self.time_s);
        }
        self.ticks += 1;
        self.time_s = time_s;
        self.instruments.follow(time_s, &body.motion());
    }

    fn advance(&mut self, body: &mut impl Body, interval_s: f64) {
        body.advance(
            self.rudder_rad(),
            self.thrust * self.upset.thrust_left,
            self.disturbance_rad_s2,
            interval_s,
        );
        self.disturbance_rad_s2 = self.config.disturbance.after(
            self.disturbance_rad_s2,
            interval_s,
            self.chance.disturbance.normal(),
        );
    }

    /// What the rudder does with its command, rad.
    fn rudder_rad(&self) -> f64 {
        let upset = &self.upset;
        if upset.rudder_jammed {
            return self.jammed_rad;
        }
        let sense = if upset.rudder_reversed { -1.0 } else { 1.0 };
        sense * self.rudder_command_rad + upset.rudder_offset_rad
    }

    /// Measures, sets the rudder and reports both.
    fn measure(&mut self, motion: &Motion) -> Sample<f64> {
        self.carry_out();
        let compass_rad = self.compass();
        if compass_rad.is_finite() {
            self.compass_rad = compass_rad;
            self.rudder_command_rad = self.rudder(compass_rad);
        } else if let Steering::Rudder(_) = self.steering {
            self.rudder_command_rad = self.rudder(self.compass_rad);
        }
        self.sample(motion, compass_rad)
    }

    /// What the compass says, which may be no number.
    fn compass(&mut self) -> f64 {
        let read_rad = self.instruments.compass(self.time_s, self.upset.compass_error_rad);
        match (self.upset.compass_lost, self.upset.compass_frozen) {
            (true, _) => f64::NAN,
            (false, true) => self.compass_rad,
            (false, false) => read_rad,
        }
    }

    /// What was asked for since the last sample takes effect.
    fn carry_out(&mut self) {
        if let Some(action) = self.asked.take().filter(|_| !self.upset.is_taken_over) {
            self.steering = action.steering;
            self.thrust = action.thrust.unwrap_or(self.config.initial_thrust).clamp(0.0, 1.0);
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

    fn sample(&mut self, motion: &Motion, compass_rad: f64) -> Sample<f64> {
        let readings = self.instruments.read(self.time_s);
        Sample {
            time_s: self.time_s,
            heading_rad: compass_rad,
            rudder_rad: self.rudder_command_rad,
            surge_speed_m_s: readings.surge_speed_m_s,
            depth_m: Some(readings.depth_m),
            altitude_m: readings.altitude_m,
            roll_rad: Some(readings.roll_rad),
            pitch_rad: Some(readings.pitch_rad),
            yaw_rate_rad_s: readings.yaw_rate_rad_s,
            north_m: Some(motion.north_m),
            east_m: Some(motion.east_m),
            thrust: None,
        }
    }
}
