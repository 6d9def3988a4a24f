//! Samples from motions, and the rudder that acted in between.
//!
//! A sample is complete when the next motion has come: its rudder is the mean of what acted from its stamp to the next one's.

use std::collections::VecDeque;

use seatrial_core::{Real, Sample};

use super::{Frame, Motion};
use seatrial_core::attitude::euler_rad;

/// A position or speed older than this is none, s.
const STALE_S: f64 = 1.0;
/// A measured rudder without a message for longer is unknown, s.
const RUDDER_STALE_S: f64 = 0.5;
/// A stamp that goes back by more than this is another clock's, s; a late message is not so late.
const CLOCK_BACK_S: f64 = 1.0;
/// Motions and rudders that may wait.
const MOST_WAITING: usize = 4096;
/// The offset of the clocks is the smallest of so long, s: quartz drifts.
const OFFSET_SPAN_S: f64 = 10.0;

/// Our clock less that of the stamps, smallest latency included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    begun_s: f64,
    smallest_s: f64,
    before_s: f64,
}

impl Offset {
    fn new(came_s: f64, offset_s: f64) -> Self {
        Self { begun_s: came_s, smallest_s: offset_s, before_s: offset_s }
    }

    fn take(&mut self, came_s: f64, offset_s: f64) {
        if came_s - self.begun_s > OFFSET_SPAN_S {
            self.before_s = self.smallest_s;
            self.smallest_s = offset_s;
            self.begun_s = came_s;
        }
        self.smallest_s = self.smallest_s.min(offset_s);
    }

    fn offset_s(&self) -> f64 {
        self.smallest_s.min(self.before_s)
    }
}

/// Makes samples.
#[derive(Debug)]
pub(super) struct Sampler {
    frame: Frame,
    has_depth: bool,
    /// Is the rudder measured, or is it what was asked for?
    is_measured: bool,
    motions: VecDeque<Motion>,
    odometry: Option<Motion>,
    /// The stamp's time from which a rudder acts, s, and the rudder, rad.
    rudder: VecDeque<(f64, f64)>,
    ready: VecDeque<Sample<f64>>,
    offset: Option<Offset>,
    /// What is asked for.
    pub thrust: Option<f64>,
    /// Motions in all.
    pub count: u64,
    /// Measured rudders in all.
    pub rudders: u64,
}

impl Sampler {
    pub fn new(frame: Frame, has_depth: bool, is_measured: bool) -> Self {
        Self {
            frame,
            has_depth,
            is_measured,
            motions: VecDeque::new(),
            odometry: None,
            rudder: VecDeque::new(),
            ready: VecDeque::new(),
            offset: None,
            thrust: None,
            count: 0,
            rudders: 0,
        }
    }

    /// The newest stamp, s.
    pub fn clock_s(&self) -> f64 {
        self.motions.back().map_or(0.0, |motion| motion.stamp_s)
    }

    /// The stamp that belongs to a time on our clock, s.
    fn stamp_s(&self, our_s: f64) -> Option<f64> {
        Some(our_s - self.offset?.offset_s())
    }

    /// Does a stamp belong to a clock that was set back?
    pub fn is_set_back(&self, stamp_s: f64) -> bool {
        stamp_s + CLOCK_BACK_S < self.clock_s()
    }

    /// Another clock from now on.
    pub fn forget(&mut self) {
        self.motions.clear();
        self.rudder.clear();
        self.odometry = None;
        self.offset = None;
    }

    /// Takes in the motion of a sample, which came at a time on our clock; one that is not newer than the last is passed over.
    pub fn motion(&mut self, came_s: f64, motion: Motion) {
        let is_newer = |last: &Motion| motion.stamp_s > last.stamp_s;
        if !motion.stamp_s.is_finite() || !self.motions.back().is_none_or(is_newer) {
            return;
        }
        let offset_s = came_s - motion.stamp_s;
        self.offset.get_or_insert(Offset::new(came_s, offset_s)).take(came_s, offset_s);
        self.motions.push_back(motion);
        self.count += 1;
        self.complete();
    }

    /// Takes in an odometry that is not itself a sample.
    pub fn odometry(&mut self, motion: Motion) {
        self.odometry = Some(motion);
    }

    /// Takes in a measured rudder.
    pub fn measured(&mut self, came_s: f64, stamp_s: Option<f64>, rudder_rad: f64) {
        self.rudders += 1;
        if let Some(time_s) = stamp_s.or_else(|| self.stamp_s(came_s)) {
            self.push(time_s, rudder_rad);
            self.complete();
        }
    }

    /// Takes in a rudder that was asked for at a time on our clock.
    pub fn asked(&mut self, our_s: f64, rudder_rad: f64) {
        if !self.is_measured
            && let Some(time_s) = self.stamp_s(our_s)
        {
            self.push(time_s, rudder_rad);
        }
    }

    fn push(&mut self, time_s: f64, rudder_rad: f64) {
        let is_newer = |last: &(f64, f64)| time_s > last.0;
        if time_s.is_finite() && self.rudder.back().is_none_or(is_newer) {
            self.rudder.push_back((time_s, rudder_rad));
            if self.rudder.len() > MOST_WAITING {
                self.rudder.pop_front();
            }
        }
    }

    /// The newest rudder, rad.
    pub fn last_rudder_rad(&self) -> Option<f64> {
        self.rudder.back().map(|(_, rudder_rad)| *rudder_rad)
    }

    /// The next sample.
    pub fn take(&mut self) -> Option<Sample<f64>> {
        self.ready.pop_front()
    }

    /// Forgets samples that nobody took.
    pub fn skip(&mut self) {
        self.ready.clear();
    }

    fn complete(&mut self) {
        while let (Some(&motion), Some(next)) = (self.motions.front(), self.motions.get(1)) {
            let end_s = next.stamp_s;
            let is_known = |last: &(f64, f64)| !self.is_measured || last.0 >= end_s;
            if !self.rudder.back().is_some_and(is_known) && self.motions.len() < 3 {
                return;
            }
            let time_s = motion.stamp_s;
            let has_ended = |next: &(f64, f64)| next.0 <= time_s;
            while self.rudder.get(1).is_some_and(has_ended) {
                self.rudder.pop_front();
            }
            let rudder_rad = self.mean_rudder_rad(time_s, end_s);
            self.ready.push_back(self.sample(&motion, rudder_rad));
            self.motions.pop_front();
            if self.ready.len() > MOST_WAITING {
                self.ready.pop_front();
            }
        }
    }

    /// Mean of the rudders from one stamp to another: what was asked for is held until the next demand, what was measured is
    /// on the line to the next measurement. What acted before the first is not known, nor between measurements far apart.
    fn mean_rudder_rad(&self, from_s: f64, to_s: f64) -> f64 {
        let mut sum = 0.0;
        let mut covered_s = 0.0;
        for (k, &(start_s, start_rad)) in self.rudder.iter().enumerate() {
            let (end_s, slope_rad_s) = match self.rudder.get(k + 1) {
                Some(&(end_s, _)) if !self.is_measured => (end_s, 0.0),
                Some(&(end_s, end_rad)) if end_s - start_s < RUDDER_STALE_S => {
                    (end_s, (end_rad - start_rad) / (end_s - start_s))
                }
                None if !self.is_measured => (f64::INFINITY, 0.0),
                _ => continue,
            };
            let (low_s, high_s) = (start_s.max(from_s), end_s.min(to_s));
            if high_s > low_s {
                let middle_s = 0.5 * (low_s + high_s) - start_s;
                sum += (high_s - low_s) * (start_rad + slope_rad_s * middle_s);
                covered_s += high_s - low_s;
            }
        }
        // Half of the interval must be known.
        if covered_s > 0.5 * (to_s - from_s) { sum / covered_s } else { f64::NAN }
    }

    fn sample(&self, motion: &Motion, rudder_rad: f64) -> Sample<f64> {
        let [roll_rad, pitch_rad, yaw_rad] = euler_rad(motion.quaternion);
        let time_s = motion.stamp_s;
        let is_recent = |other: &&Motion| (time_s - other.stamp_s).abs() < STALE_S;
        let odometry = match motion.position_m {
            Some(_) => Some(motion),
            None => self.odometry.as_ref().filter(is_recent),
        };
        let place_m = odometry.and_then(|odometry| odometry.position_m);
        let enu = self.frame == Frame::Enu;
        let sign = if enu { -1.0 } else { 1.0 };
        Sample {
            time_s,
            heading_rad: match enu {
                true => Real::wrapped(core::f64::consts::FRAC_PI_2 - yaw_rad),
                false => yaw_rad,
            },
            rudder_rad,
            surge_speed_m_s: odometry.and_then(|odometry| odometry.speed_m_s),
            depth_m: place_m.filter(|_| self.has_depth).map(|[_, _, vertical_m]| sign * vertical_m),
            altitude_m: None,
            roll_rad: Some(roll_rad),
            pitch_rad: Some(sign * pitch_rad),
            yaw_rate_rad_s: Some(sign * motion.turn_rate_rad_s),
            north_m: place_m.map(|[x, y, _]| if enu { y } else { x }),
            east_m: place_m.map(|[x, y, _]| if enu { x } else { y }),
            thrust: self.thrust,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(stamp_s: f64, yaw_rad: f64) -> Motion {
        Motion {
            stamp_s,
            quaternion: [Real::cos(0.5 * yaw_rad), 0.0, 0.0, Real::sin(0.5 * yaw_rad)],
            turn_rate_rad_s: 0.2,
            position_m: None,
            speed_m_s: None,
        }
    }

    #[test]
    fn exact_a_measured_rudder_is_on_the_line_between_messages() {
        let mut sampler = Sampler::new(Frame::Enu, false, true);
        sampler.motion(51.0, motion(1.0, 0.5));
        sampler.measured(51.0, Some(0.99), 0.1);
        sampler.measured(51.0, Some(1.01), 0.1);
        sampler.measured(51.0, Some(1.03), 0.3);
        sampler.motion(51.05, motion(1.05, 0.5));
        assert_eq!(sampler.take(), None, "what acts at its end has not come");
        sampler.measured(51.06, Some(1.05), 0.3);
        sampler.motion(51.1, motion(1.1, 0.5));
        let sample = sampler.take().unwrap();
        // 10 ms of 0.1, 20 ms of 0.2 in the mean, 20 ms of 0.3.
        assert!((sample.rudder_rad - 0.22).abs() < 1e-12, "{sample:?}");
        // North is a yaw of a quarter turn; to port is less heading.
        assert!((sample.heading_rad - (core::f64::consts::FRAC_PI_2 - 0.5)).abs() < 1e-12);
        assert_eq!(sample.yaw_rate_rad_s, Some(-0.2));
    }

    #[test]
    fn exact_an_asked_rudder_is_held_on_the_clock_of_the_stamps() {
        let mut sampler = Sampler::new(Frame::Ned, false, false);
        // Our clock is 50 s ahead; the second motion took 30 ms longer.
        sampler.motion(51.0, motion(1.0, 0.5));
        sampler.asked(51.0, 0.1);
        sampler.asked(51.04, 0.2);
        sampler.motion(51.08, motion(1.05, 0.5));
        let sample = sampler.take().unwrap();
        // 40 ms of 0.1, 10 ms of 0.2; the clocks are 50 s apart to a rounding of that.
        assert!((sample.rudder_rad - 0.12).abs() < 1e-9, "{sample:?}");
        assert!((sample.heading_rad - 0.5).abs() < 1e-12);
        assert_eq!(sample.yaw_rate_rad_s, Some(0.2));
    }

    #[test]
    fn io_a_rudder_that_is_silent_is_unknown() {
        let mut sampler = Sampler::new(Frame::Enu, false, true);
        sampler.measured(51.0, Some(1.0), 0.1);
        for k in 0..30 {
            let stamp_s = 1.0 + 0.05 * f64::from(k);
            sampler.motion(50.0 + stamp_s, motion(stamp_s, 0.0));
        }
        let rudders: Vec<f64> =
            std::iter::from_fn(|| sampler.take()).map(|sample| sample.rudder_rad).collect();
        assert_eq!(rudders.len(), 28);
        assert!(rudders.iter().all(|rudder_rad| rudder_rad.is_nan()));
    }
}
