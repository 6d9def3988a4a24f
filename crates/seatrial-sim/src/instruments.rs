//! The sensors at work: what they read of a body that moves.

use std::collections::VecDeque;

use seatrial_core::Real;

use crate::body::Motion;
use crate::sensors::{Chance, Sensors};

/// Part of an interval by which rounding may miss its end.
const ROUNDING: f64 = 1e-6;

/// What the sensors say at an instant, without the faults that befall a compass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Readings {
    pub roll_rad: f64,
    pub pitch_rad: f64,
    pub yaw_rate_rad_s: Option<f64>,
    pub surge_speed_m_s: Option<f64>,
    pub altitude_m: Option<f64>,
    pub depth_m: f64,
}

/// Sensors with their clocks, noise and past.
#[derive(Clone, Debug)]
pub(crate) struct Instruments {
    sensors: Sensors,
    chance: Sources,
    /// The motion as far back as the longest latency needs it.
    past: VecDeque<Moment>,
    clocks: Clocks,
    gyro_bias_rad_s: f64,
    gyro_read_s: Option<f64>,
    compass_rad: f64,
    readings: Readings,
}

/// What is left to chance.
#[derive(Clone, Debug)]
struct Sources {
    compass: Chance,
    gyro: Chance,
    speed: Chance,
    depth: Chance,
    attitude: Chance,
    gyro_bias: Chance,
    dropout: Chance,
    altitude: Chance,
}

/// The true motion at an instant.
#[derive(Clone, Copy, Debug)]
struct Moment {
    time_s: f64,
    motion: Motion,
    /// How far the compass lags behind the heading, rad.
    lag_rad: f64,
}

#[derive(Clone, Debug, Default)]
struct Clocks {
    compass: Clock,
    gyro: Clock,
    dvl: Clock,
    pressure: Clock,
    attitude: Clock,
}

/// When a sensor measured last, in intervals.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    measured: Option<i64>,
}

impl Clock {
    /// The instant of a reading that has arrived since the last call, s.
    fn new_reading(&mut self, now_s: f64, interval_s: f64, latency_s: f64) -> Option<f64> {
        let instant_s = now_s - latency_s;
        if interval_s == 0.0 {
            return Some(instant_s);
        }
        let latest = (instant_s / interval_s + ROUNDING).floor();
        let is_new = self.measured.is_none_or(|k| latest as i64 > k);
        self.measured = Some(latest as i64);
        is_new.then_some(latest * interval_s)
    }
}

impl Instruments {
    pub fn new(sensors: Sensors, chance: [Chance; 8]) -> Self {
        let [compass, gyro, speed, depth, attitude, gyro_bias, dropout, altitude] = chance;
        Self {
            chance: Sources { compass, gyro, speed, depth, attitude, gyro_bias, dropout, altitude },
            past: VecDeque::new(),
            clocks: Clocks::default(),
            gyro_bias_rad_s: sensors.gyro.bias_rad_s,
            gyro_read_s: None,
            compass_rad: 0.0,
            readings: Readings::default(),
            sensors,
        }
    }

    /// Keeps up with the body.
    pub fn follow(&mut self, time_s: f64, motion: &Motion) {
        let lag_rad = self.past.back().map_or(0.0, |before| self.lag(before, time_s, motion));
        self.past.push_back(Moment { time_s, motion: *motion, lag_rad });
        let oldest_s = time_s - self.longest_age_s();
        while self.past.get(1).is_some_and(|second| second.time_s <= oldest_s) {
            self.past.pop_front();
        }
    }

    /// The lag of a compass behind a heading that goes on at a constant rate r: e = tau r + (e_0 - tau r) exp(-t/tau).
    fn lag(&self, before: &Moment, time_s: f64, motion: &Motion) -> f64 {
        let (lag_s, interval_s) = (self.sensors.compass.lag_s, time_s - before.time_s);
        if lag_s == 0.0 || interval_s <= 0.0 {
            return 0.0;
        }
        let turned_rad = Real::wrapped(motion.heading_rad - before.motion.heading_rad);
        let steady_rad = lag_s * turned_rad / interval_s;
        steady_rad + (before.lag_rad - steady_rad) * libm::exp(-interval_s / lag_s)
    }

    fn longest_age_s(&self) -> f64 {
        let sensors = &self.sensors;
        [
            (sensors.compass.interval_s, sensors.compass.latency_s),
            (sensors.gyro.interval_s, sensors.gyro.latency_s),
            (sensors.dvl.interval_s, sensors.dvl.latency_s),
            (sensors.pressure.interval_s, sensors.pressure.latency_s),
            (sensors.attitude.interval_s, sensors.attitude.latency_s),
        ]
        .map(|(interval_s, latency_s)| interval_s + latency_s)
        .into_iter()
        .fold(0.0, f64::max)
    }

    /// The motion at an instant, linear between those that are kept and constant before them.
    fn at(&self, time_s: f64) -> Option<Moment> {
        let after = self.past.partition_point(|moment| moment.time_s <= time_s);
        let Some(before) = after.checked_sub(1).map(|k| &self.past[k]) else {
            return self.past.front().copied();
        };
        let Some(after) = self.past.get(after) else {
            return Some(*before);
        };
        let part = (time_s - before.time_s) / (after.time_s - before.time_s);
        let between = |a: f64, b: f64| a + part * (b - a);
        let turned = |a: f64, b: f64| a + part * Real::wrapped(b - a);
        let (a, b) = (&before.motion, &after.motion);
        Some(Moment {
            time_s,
            motion: Motion {
                heading_rad: turned(a.heading_rad, b.heading_rad),
                roll_rad: turned(a.roll_rad, b.roll_rad),
                pitch_rad: between(a.pitch_rad, b.pitch_rad),
                yaw_rate_rad_s: between(a.yaw_rate_rad_s, b.yaw_rate_rad_s),
                surge_speed_m_s: between(a.surge_speed_m_s, b.surge_speed_m_s),
                north_m: between(a.north_m, b.north_m),
                east_m: between(a.east_m, b.east_m),
                depth_m: between(a.depth_m, b.depth_m),
                altitude_m: a.altitude_m.zip(b.altitude_m).map(|(a, b)| between(a, b)),
            },
            lag_rad: between(before.lag_rad, after.lag_rad),
        })
    }

    /// The compass; a fault adds its error to a new reading.
    pub fn compass(&mut self, now_s: f64, error_rad: f64) -> f64 {
        let compass = self.sensors.compass;
        let instant_s =
            self.clocks.compass.new_reading(now_s, compass.interval_s, compass.latency_s);
        if let Some(moment) = instant_s.and_then(|instant_s| self.at(instant_s)) {
            let noise_rad = compass.noise_rad * self.chance.compass.normal();
            let heading_rad = moment.motion.heading_rad - moment.lag_rad;
            self.compass_rad = compass.reading(heading_rad, noise_rad + error_rad);
        }
        self.compass_rad
    }

    /// All others.
    pub fn read(&mut self, now_s: f64) -> Readings {
        self.read_gyro(now_s);
        self.read_dvl(now_s);
        let Sensors { pressure, attitude, .. } = self.sensors;
        let clocks = &mut self.clocks;
        let of_depth = clocks.pressure.new_reading(now_s, pressure.interval_s, pressure.latency_s);
        let of_attitude =
            clocks.attitude.new_reading(now_s, attitude.interval_s, attitude.latency_s);
        if let Some(moment) = of_depth.and_then(|instant_s| self.at(instant_s)) {
            let noise_m = pressure.noise_m * self.chance.depth.normal();
            self.readings.depth_m = moment.motion.depth_m + pressure.bias_m + noise_m;
        }
        if let Some(moment) = of_attitude.and_then(|instant_s| self.at(instant_s)) {
            let mut noise_rad = || attitude.noise_rad * self.chance.attitude.normal();
            self.readings.roll_rad = moment.motion.roll_rad + noise_rad();
            self.readings.pitch_rad = moment.motion.pitch_rad + noise_rad();
        }
        self.readings
    }

    fn read_gyro(&mut self, now_s: f64) {
        let gyro = self.sensors.gyro;
        let instant_s = self
            .clocks
            .gyro
            .new_reading(now_s, gyro.interval_s, gyro.latency_s)
            .filter(|_| gyro.carried);
        if let Some(moment) = instant_s.and_then(|instant_s| self.at(instant_s)) {
            let interval_s = now_s - self.gyro_read_s.unwrap_or(now_s);
            self.gyro_read_s = Some(now_s);
            self.gyro_bias_rad_s += gyro.bias_walk_rad_s_sqrt_s
                * interval_s.max(0.0).sqrt()
                * self.chance.gyro_bias.normal();
            let noise_rad_s = gyro.noise_rad_s * self.chance.gyro.normal();
            self.readings.yaw_rate_rad_s =
                Some(moment.motion.yaw_rate_rad_s + self.gyro_bias_rad_s + noise_rad_s);
        }
    }

    fn read_dvl(&mut self, now_s: f64) {
        let dvl = self.sensors.dvl;
        let instant_s = self.clocks.dvl.new_reading(now_s, dvl.interval_s, dvl.latency_s);
        if let Some(moment) = instant_s.and_then(|instant_s| self.at(instant_s)) {
            let noise_m_s = dvl.noise_m_s * self.chance.speed.normal();
            let noise_m = dvl.altitude_noise_m * self.chance.altitude.normal();
            let altitude_m = moment.motion.altitude_m;
            let is_seen = dvl.range_m.is_none_or(|[near_m, far_m]| {
                altitude_m.is_some_and(|altitude_m| (near_m..=far_m).contains(&altitude_m))
            });
            let is_read = is_seen && self.chance.dropout.uniform() >= dvl.dropout_fraction;
            self.readings.surge_speed_m_s =
                is_read.then_some(moment.motion.surge_speed_m_s + noise_m_s);
            self.readings.altitude_m =
                altitude_m.filter(|_| is_read).map(|altitude_m| altitude_m + noise_m);
        }
    }
}
