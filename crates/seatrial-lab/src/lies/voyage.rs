//! The voyage as it was.

use seatrial_core::YawModel;
use seatrial_core::model::YawState;

use super::draw::Draw;
use super::setup::{Hull, Pattern, Setup};

/// Steps of the truth in one interval of the controller.
const STEPS: usize = 10;
/// Lead-in, training and validation, in time constants.
const LEAD_IN: f64 = 8.0;
const STAGE: f64 = 16.5;
/// From the begin of a stage to its manoeuvre, and half the period of a doublet.
const BEFORE: f64 = 2.0;
const HALF_PERIOD: f64 = 2.0;
/// Time to turn before a window that begins in a turn.
const TURNING: f64 = 3.0;

/// The truth at a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    pub heading_rad: f64,
    pub yaw_rate_rad_s: f64,
    /// The command to the fin, rad.
    pub command_rad: f64,
    /// Where it stands.
    pub fin_rad: f64,
    pub speed_m_s: f64,
}

/// A voyage at the steps of the truth.
pub struct Voyage {
    pub step_s: f64,
    pub moments: Vec<Moment>,
    /// Compass noise at each instant of the controller, rad.
    pub noise_rad: Vec<f64>,
    pub training_s: [f64; 2],
    pub validation_s: [f64; 2],
}

/// The fin behind its command.
#[derive(Default)]
struct Fin {
    /// The horn with the servo's lag.
    servo_rad: f64,
    /// The fin behind play and dead band.
    fin_rad: f64,
}

impl Fin {
    fn advance(&mut self, command_rad: f64, setup: &Setup, limit_rad: f64, interval_s: f64) -> f64 {
        let commanded_rad = if (command_rad - self.servo_rad).abs() < setup.dead_band_rad {
            self.servo_rad
        } else {
            command_rad
        };
        self.servo_rad = if setup.servo_lag_s > 0.0 {
            commanded_rad
                + (self.servo_rad - commanded_rad) * libm::exp(-interval_s / setup.servo_lag_s)
        } else {
            commanded_rad
        };
        let play = 0.5 * setup.backlash_rad;
        self.fin_rad = self.fin_rad.clamp(self.servo_rad - play, self.servo_rad + play);
        self.fin_rad.clamp(-limit_rad, limit_rad)
    }
}

/// The pilot that steers a voyage.
struct Pilot {
    reference_rad: f64,
    zig_zag_side: f64,
    legs: usize,
    /// The random test's rudder, as a share of the amplitude, in each third of a time constant.
    random: Vec<f64>,
}

impl Pilot {
    /// The rudder command at a time of a stage.
    fn command_rad(
        &mut self,
        setup: &Setup,
        hull: &Hull,
        amplitude_rad: f64,
        since_s: f64,
        heading_rad: f64,
    ) -> f64 {
        let time_constant_s = setup.time_constant_s();
        let at = since_s / time_constant_s - BEFORE;
        let turned_rad = heading_rad - self.reference_rad;
        let hold = || {
            let gain = hull.a22_per_s * hull.a22_per_s / (4.0 * 0.8 * hull.b2_per_s2);
            (-hull.delta0_rad - gain * turned_rad).clamp(-amplitude_rad, amplitude_rad)
        };
        let turning = setup.begins_in_turn && (-BEFORE - TURNING..0.0).contains(&at);
        match setup.pattern {
            _ if turning => 0.7 * amplitude_rad,
            _ if at < 0.0 => hold(),
            Pattern::Doublet if at < HALF_PERIOD => amplitude_rad,
            Pattern::Doublet if at < 2.0 * HALF_PERIOD => -amplitude_rad,
            Pattern::ZigZag(angle_rad) if at < STAGE - BEFORE - 3.0 => {
                if self.zig_zag_side * turned_rad > angle_rad && self.legs < 20 {
                    self.zig_zag_side = -self.zig_zag_side;
                    self.legs += 1;
                }
                self.zig_zag_side * amplitude_rad
            }
            Pattern::Random if at < STAGE - BEFORE - 3.0 => {
                self.random[((3.0 * at) as usize).min(self.random.len() - 1)] * amplitude_rad
            }
            Pattern::Doublet | Pattern::ZigZag(_) | Pattern::Random => hold(),
        }
    }
}

impl Voyage {
    /// Sails it.
    pub fn sail(setup: &Setup, seed: u64) -> Self {
        let mut chance = Draw::new(seed ^ 0x05ea_0000);
        let time_constant_s = setup.time_constant_s();
        let [training_s, validation_s, end_s] =
            [LEAD_IN, LEAD_IN + STAGE, LEAD_IN + 2.0 * STAGE].map(|t| t * time_constant_s);
        let step_s = setup.control_s / STEPS as f64;
        let hull = setup.hulls[0];
        let heading_rad = setup.start_rad;
        let mut yaw = YawState { heading_rad, yaw_rate_rad_s: 0.0 };
        let mut pilot = Pilot {
            reference_rad: heading_rad,
            zig_zag_side: 1.0,
            legs: 0,
            random: random_test(seed),
        };
        let mut fin = Fin { servo_rad: -hull.delta0_rad, fin_rad: -hull.delta0_rad };
        let mut sea = Sea::new(setup, &mut chance);
        let mut voyage = Self {
            step_s,
            moments: Vec::new(),
            noise_rad: Vec::new(),
            training_s: [training_s, validation_s],
            validation_s: [validation_s, end_s],
        };
        let change_s = training_s + (BEFORE + 1.5) * time_constant_s;
        let ticks = (end_s / setup.control_s).ceil() as usize;
        for tick in 0..ticks {
            let tick_s = tick as f64 * setup.control_s;
            let stage = usize::from(tick_s >= validation_s);
            let hull = &setup.hulls[stage];
            let amplitude_rad = setup.amplitudes_rad[stage];
            let since_s = tick_s - [training_s, validation_s][stage];
            let noise_rad = setup.noise_rad * chance.normal();
            let read_rad = yaw.heading_rad + noise_rad;
            let command_rad = pilot.command_rad(setup, hull, amplitude_rad, since_s, read_rad);
            voyage.noise_rad.push(noise_rad);
            let limit_rad = hull.stop.map_or(f64::INFINITY, |share| share * amplitude_rad);
            for step in 0..STEPS {
                let time_s = tick_s + step as f64 * step_s;
                let changed = (change_s..validation_s).contains(&time_s);
                let speed = if changed { hull.speed_change } else { 1.0 };
                let fin_rad = fin.advance(command_rad, setup, limit_rad, step_s);
                voyage.moments.push(Moment {
                    heading_rad: yaw.heading_rad,
                    yaw_rate_rad_s: yaw.yaw_rate_rad_s,
                    command_rad,
                    fin_rad,
                    speed_m_s: speed * setup.speed_m_s,
                });
                let effect = hull.b2_per_s2 * setup.amplitudes_rad[0];
                let step_of_current = if changed { setup.current_step } else { 0.0 };
                let model = YawModel {
                    a22_per_s: hull.a22_per_s * speed,
                    b2_per_s2: hull.b2_per_s2 * speed * speed,
                    c0_rad_per_s2: hull.b2_per_s2 * hull.delta0_rad * speed * speed
                        + effect * (sea.advance(time_s, step_s, &mut chance) + step_of_current),
                };
                yaw = model.advance(yaw, fin_rad, step_s);
            }
        }
        voyage
    }

    /// The truth at a time, linear between its steps.
    pub fn at(&self, time_s: f64) -> Moment {
        let place = (time_s / self.step_s).clamp(0.0, (self.moments.len() - 1) as f64);
        let below = self.moments[place as usize];
        let above = self.moments[(place as usize + 1).min(self.moments.len() - 1)];
        let share = place - libm::floor(place);
        let between = |of: fn(&Moment) -> f64| of(&below) + share * (of(&above) - of(&below));
        Moment {
            heading_rad: between(|m| m.heading_rad),
            yaw_rate_rad_s: between(|m| m.yaw_rate_rad_s),
            speed_m_s: between(|m| m.speed_m_s),
            ..below
        }
    }
}

/// Rudder angles as shares of the amplitude, each for one to six thirds of a time constant and away from the one before.
fn random_test(seed: u64) -> Vec<f64> {
    let mut chance = Draw::new(seed ^ 0x7e57_0000);
    let mut side = 1.0;
    let mut angles = Vec::new();
    while angles.len() < 3 * STAGE as usize {
        let angle = side * chance.one_of(&[0.6, 0.8, 1.0]);
        angles.resize(angles.len() + chance.one_of(&[1, 2, 3, 4, 6]), angle);
        side = -side;
    }
    angles
}

/// The yaw acceleration that is not the rudder's, as a share of the rudder's effect.
struct Sea {
    disturbance: f64,
    strength: f64,
    correlation_s: f64,
    /// Amplitude, frequency and phase of each wave.
    waves: Vec<[f64; 3]>,
}

/// Sines that make up the waves.
const WAVES: usize = 6;

impl Sea {
    fn new(setup: &Setup, chance: &mut Draw) -> Self {
        let waves = setup.waves.map_or_else(Vec::new, |waves| {
            (0..WAVES)
                .map(|k| {
                    let spread = 0.85 + 0.3 * k as f64 / (WAVES - 1) as f64;
                    [
                        waves.share * libm::sqrt(2.0 / WAVES as f64),
                        waves.frequency_rad_s * spread,
                        chance.within(0.0, std::f64::consts::TAU),
                    ]
                })
                .collect()
        });
        Self {
            disturbance: setup.disturbance * chance.normal(),
            strength: setup.disturbance,
            correlation_s: 2.0 * setup.time_constant_s(),
            waves,
        }
    }

    fn advance(&mut self, time_s: f64, step_s: f64, chance: &mut Draw) -> f64 {
        let decay = libm::exp(-step_s / self.correlation_s);
        self.disturbance = decay * self.disturbance
            + libm::sqrt(1.0 - decay * decay) * self.strength * chance.normal();
        let waves: f64 = self
            .waves
            .iter()
            .map(|[amplitude, frequency, phase]| amplitude * libm::sin(frequency * time_s + phase))
            .sum();
        self.disturbance + waves
    }
}
