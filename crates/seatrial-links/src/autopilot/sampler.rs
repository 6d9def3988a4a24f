//! Samples from messages that come one by one, late, twice or never.
//!
//! A sample is an ATTITUDE. Its rudder is the mean of the servo output from its instant to the next ATTITUDE's, so it is
//! complete when that has come, and the outputs up to there. Both times are the autopilot's since its boot.

use std::collections::VecDeque;

use seatrial_core::{Real, Sample};

use crate::link::message::Attitude;

/// A position, speed or depth older than this is none, s.
const STALE_S: f64 = 1.0;
/// An output held for longer without a message is unknown, s.
const OUTPUT_STALE_S: f64 = 0.5;
/// An output is held for this many of its usual intervals; what it did in a longer one is not known where it moved.
const HELD_INTERVALS: f64 = 1.5;
/// A rudder that moves by less, rad, in an interval in which outputs were lost has moved smoothly: that of a heading controller.
const EDGE_RAD: f64 = 0.05;
/// Time over which the rate of the outputs is looked at, s, and the share of the usual rate below which they are too few.
const RATE_S: f64 = 3.0;
const LEAST_RATE: f64 = 0.5;
/// A clock that goes back by more than this has started again, s; a late message is not so late.
const RESTART_S: f64 = 5.0;
/// The autopilot's clock of milliseconds in 32 bits begins again after this time, 49.7 days, s.
const TURN_S: f64 = 4_294_967.296;
/// After the longest silence of a vehicle that is not given up, s, its clock still belongs to the same turn.
const SAME_TURN_S: f64 = 60.0;
/// Outputs and attitudes that may wait.
const MOST_WAITING: usize = 4096;

/// Something that was measured at a time of the autopilot's, s.
#[derive(Clone, Copy, Debug, Default)]
struct Latest<T>(Option<(f64, T)>);

impl<T: Copy> Latest<T> {
    fn set(&mut self, time_s: f64, value: T) {
        if self.0.is_none_or(|(last_s, _)| time_s >= last_s) {
            self.0 = Some((time_s, value));
        }
    }

    fn at(&self, time_s: f64) -> Option<T> {
        let (set_s, value) = self.0?;
        (time_s - set_s < STALE_S).then_some(value)
    }
}

/// Makes samples.
#[derive(Debug, Default)]
pub(super) struct Sampler {
    attitudes: VecDeque<(f64, Attitude)>,
    /// The time from which an output acts, s, and the rudder, rad.
    rudder: VecDeque<(f64, f64)>,
    /// Times of the outputs that came of late, as they say, s.
    outputs_s: VecDeque<f64>,
    /// Usual interval of the outputs, s, once it is known.
    pub output_interval_s: Option<f64>,
    /// With the time at which they were complete on our clock, s.
    ready: VecDeque<(f64, Sample<f64>)>,
    ground_speed_m_s: Latest<f64>,
    velocity_m_s: Latest<[f64; 2]>,
    position_m: Latest<[f64; 2]>,
    depth_m: Latest<f64>,
    /// What is asked for.
    pub thrust: Option<f64>,
    /// No sample is made any more.
    pub is_closed: bool,
    /// Our clock, s.
    pub now_s: f64,
    /// When the sample taken last was complete, s on our clock.
    pub arrived_s: f64,
}

impl Sampler {
    /// The newest time, s.
    pub fn clock_s(&self) -> f64 {
        self.attitudes.back().map_or(0.0, |(time_s, _)| *time_s)
    }

    /// Has the clock of an attitude started again?
    pub fn is_restarted(&self, time_boot_ms: u32) -> bool {
        self.since_boot_s(time_boot_ms) + RESTART_S < self.clock_s()
    }

    /// Time since the boot, s, of a clock of 32 bits that may have begun again.
    fn since_boot_s(&self, time_boot_ms: u32) -> f64 {
        let (time_s, clock_s) = (f64::from(time_boot_ms) / 1e3, self.clock_s());
        let nearest_s = time_s + ((clock_s - time_s) / TURN_S).round() * TURN_S;
        match (nearest_s - clock_s).abs() < SAME_TURN_S {
            true => nearest_s,
            false => time_s + (clock_s / TURN_S).floor() * TURN_S,
        }
    }

    /// Forgets what was measured before the clock started again, except for samples that are complete.
    pub fn restart(&mut self) {
        *self = Self {
            ready: std::mem::take(&mut self.ready),
            output_interval_s: self.output_interval_s,
            thrust: self.thrust,
            now_s: self.now_s,
            is_closed: self.is_closed,
            ..Self::default()
        };
    }

    /// Heading, rad, and yaw rate, rad/s.
    pub fn newest_heading(&self) -> Option<(f64, f64)> {
        let (_, attitude) = self.attitudes.back()?;
        Some((attitude.yaw_rad.into(), attitude.yaw_rate_rad_s.into()))
    }

    /// Takes in an attitude; one that is not newer than the last is passed over.
    pub fn attitude(&mut self, attitude: Attitude) {
        let time_s = self.since_boot_s(attitude.time_boot_ms);
        if self.attitudes.back().is_none_or(|(last_s, _)| time_s > *last_s) {
            self.attitudes.push_back((time_s, attitude));
            self.complete();
        }
    }

    /// Takes in a rudder that acts from this time on. Where outputs before it were lost, it moved in the middle of them, or, where it
    /// moved far, at a time that is not known.
    pub fn rudder(&mut self, time_us: u32, earlier_s: f64, rudder_rad: f64) {
        // The clock of 32 bits, nearest to that of the attitudes.
        let turn_s = 2_f64.powi(32) / 1e6;
        let time_s = f64::from(time_us) / 1e6 - earlier_s;
        let time_s = time_s + ((self.clock_s() - time_s) / turn_s).round() * turn_s;
        let last = self.rudder.back().copied();
        if last.is_some_and(|(last_s, _)| time_s <= last_s) {
            return;
        }
        let gap_s = self.outputs_s.back().map_or(0.0, |last_s| time_s - last_s);
        self.outputs_s.push_back(time_s);
        let is_old = |first_s: &f64| time_s - first_s > RATE_S;
        while self.outputs_s.front().is_some_and(is_old) || self.outputs_s.len() > MOST_WAITING {
            self.outputs_s.pop_front();
        }
        let mut acts_s = time_s;
        if let (Some((last_s, last_rad)), Some(usual_s)) = (last, self.output_interval_s)
            && gap_s > HELD_INTERVALS * usual_s
        {
            if (rudder_rad - last_rad).abs() > EDGE_RAD {
                self.rudder.push_back((last_s + 0.5 * usual_s, f64::NAN));
            } else {
                acts_s = last_s.max(time_s - 0.5 * (gap_s - usual_s));
            }
        }
        self.rudder.push_back((acts_s, rudder_rad));
        if self.rudder.len() > MOST_WAITING {
            self.rudder.pop_front();
        }
        self.complete();
    }

    /// The median interval of the outputs of late, s, as they say; `None` where too few came.
    pub fn median_output_interval_s(&self) -> Option<f64> {
        let times_s = self.outputs_s.iter();
        let mut intervals_s: Vec<f64> =
            times_s.clone().zip(times_s.skip(1)).map(|(a, b)| b - a).collect();
        intervals_s.sort_by(f64::total_cmp);
        intervals_s.get(intervals_s.len() / 2).copied()
    }

    /// The mean interval of the outputs, s, where they have become too rare to tell what the rudder did.
    pub fn thinned_interval_s(&self) -> Option<f64> {
        let usual_s = self.output_interval_s?;
        let span_s = self.outputs_s.back()? - self.outputs_s.front()?;
        let mean_s = span_s / (self.outputs_s.len() as f64 - 1.0).max(1.0);
        (span_s > 0.8 * RATE_S && mean_s > usual_s / LEAST_RATE).then_some(mean_s)
    }

    /// The last output that came, rad.
    pub fn last_rudder_rad(&self) -> Option<f64> {
        self.rudder.back().map(|(_, rudder_rad)| *rudder_rad)
    }

    pub fn ground_speed(&mut self, speed_m_s: f64) {
        self.ground_speed_m_s.set(self.clock_s(), speed_m_s);
    }

    /// North and east, m/s.
    pub fn velocity(&mut self, time_boot_ms: u32, velocity_m_s: [f64; 2]) {
        let time_s = self.since_boot_s(time_boot_ms);
        self.velocity_m_s.set(time_s, velocity_m_s);
    }

    /// North and east, m.
    pub fn position(&mut self, time_boot_ms: u32, position_m: [f64; 2]) {
        let time_s = self.since_boot_s(time_boot_ms);
        self.position_m.set(time_s, position_m);
    }

    pub fn depth(&mut self, time_boot_ms: u32, depth_m: f64) {
        self.depth_m.set(self.since_boot_s(time_boot_ms), depth_m);
    }

    /// The next sample.
    pub fn take(&mut self) -> Option<Sample<f64>> {
        let (arrived_s, sample) = self.ready.pop_front()?;
        self.arrived_s = arrived_s;
        Some(sample)
    }

    /// Forgets samples that nobody took.
    pub fn skip(&mut self) {
        self.ready.clear();
    }

    fn complete(&mut self) {
        while let (Some(&(time_s, attitude)), Some(&(end_s, _))) =
            (self.attitudes.front(), self.attitudes.get(1))
        {
            let is_known = self.rudder.back().is_some_and(|(last_s, _)| *last_s >= end_s);
            if !is_known && self.attitudes.len() < 3 {
                return;
            }
            while self.rudder.get(1).is_some_and(|(next_s, _)| *next_s <= time_s) {
                self.rudder.pop_front();
            }
            let rudder_rad = self.mean_rudder_rad(time_s, end_s);
            let heading_rad = f64::from(attitude.yaw_rad);
            let forward = |[north, east]: [f64; 2]| {
                north * Real::cos(heading_rad) + east * Real::sin(heading_rad)
            };
            let position_m = self.position_m.at(time_s);
            let sample = Sample {
                time_s,
                heading_rad,
                rudder_rad,
                surge_speed_m_s: self
                    .velocity_m_s
                    .at(time_s)
                    .map(forward)
                    .or(self.ground_speed_m_s.at(time_s)),
                depth_m: self.depth_m.at(time_s),
                altitude_m: None,
                roll_rad: Some(f64::from(attitude.roll_rad)),
                pitch_rad: Some(f64::from(attitude.pitch_rad)),
                yaw_rate_rad_s: Some(f64::from(attitude.yaw_rate_rad_s)),
                north_m: position_m.map(|[north, _]| north),
                east_m: position_m.map(|[_, east]| east),
                thrust: self.thrust,
            };
            if !self.is_closed {
                self.ready.push_back((self.now_s, sample));
            }
            self.attitudes.pop_front();
            if self.ready.len() > MOST_WAITING {
                self.ready.pop_front();
            }
        }
    }

    /// Mean of the outputs, each held until the next, from one time to another. What acted before the first is not known;
    /// one that was silent for long, or moved unseen, is not either.
    fn mean_rudder_rad(&self, from_s: f64, to_s: f64) -> f64 {
        let mut sum = 0.0;
        let mut covered_s = 0.0;
        let held_s = (self.output_interval_s)
            .map_or(OUTPUT_STALE_S, |usual_s| OUTPUT_STALE_S.min(HELD_INTERVALS * usual_s));
        for (k, (start_s, rudder_rad)) in self.rudder.iter().enumerate() {
            let next_s = self.rudder.get(k + 1).map_or(start_s + held_s, |next| next.0);
            let span_s = next_s.min(to_s) - start_s.max(from_s);
            if span_s > 0.0 {
                sum += span_s * rudder_rad;
                covered_s += span_s;
            }
        }
        // Half of the interval must be known.
        if covered_s > 0.5 * (to_s - from_s) { sum / covered_s } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attitude(time_boot_ms: u32, yaw_rad: f32) -> Attitude {
        Attitude {
            time_boot_ms,
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad,
            roll_rate_rad_s: 0.0,
            pitch_rate_rad_s: 0.0,
            yaw_rate_rad_s: 0.0,
        }
    }

    /// Outputs at 20 ms in attitudes at 50 ms: the mean of what acted, whatever comes first, twice or late.
    #[test]
    fn exact_the_rudder_is_the_mean_of_what_acted() {
        let mut sampler = Sampler::default();
        sampler.attitude(attitude(1000, 0.1));
        for (ms, rudder_rad) in [(1000, 0.0), (1020, 0.0), (1040, 0.2), (1040, 0.9), (1030, 0.9)] {
            sampler.rudder(ms * 1000, 0.0, rudder_rad);
        }
        sampler.attitude(attitude(1050, 0.2));
        assert_eq!(sampler.take(), None, "the output at its end has not come");
        sampler.rudder(1_060_000, 0.0, 0.2);
        let sample = sampler.take().unwrap();
        assert_eq!(sample.time_s, 1.0);
        // 10 ms of 50 ms at 0.2; a few roundings.
        assert!((sample.rudder_rad - 0.04).abs() < 1e-12);
        sampler.attitude(attitude(1050, 0.7));
        sampler.attitude(attitude(1020, 0.7));
        sampler.attitude(attitude(1100, 0.3));
        sampler.rudder(1_100_000, 0.0, 0.2);
        let sample = sampler.take().unwrap();
        assert_eq!((sample.time_s, sample.heading_rad), (1.05, f64::from(0.2_f32)));
        assert!((sample.rudder_rad - 0.2).abs() < 1e-12);
        assert_eq!(sampler.take(), None);
    }

    /// Without outputs a sample still comes, with a rudder that is no number, which the trial refuses.
    #[test]
    fn io_silent_outputs_are_no_rudder() {
        let mut sampler = Sampler::default();
        sampler.rudder(900_000, 0.0, 0.1);
        for ms in [1000, 1050, 1100, 2000, 2050, 2100] {
            sampler.attitude(attitude(ms, 0.0));
        }
        let rudders: Vec<f64> =
            std::iter::from_fn(|| sampler.take()).map(|s| s.rudder_rad).collect();
        assert_eq!(rudders.len(), 4);
        assert!((rudders[0] - 0.1).abs() < 1e-12);
        assert!(rudders[3].is_nan(), "{rudders:?}");
    }

    /// 20 Hz over the instant at which 32 bits of milliseconds are full.
    #[test]
    fn exact_the_clock_of_the_attitudes_turns_after_49_days() {
        let mut sampler = Sampler::default();
        for k in 0..20_u32 {
            let ms = (u32::MAX - 475).wrapping_add(50 * k);
            assert!(!sampler.is_restarted(ms), "{k}");
            sampler.attitude(attitude(ms, 0.0));
            let us = (4_294_966_820_000_u64 + 50_000 * u64::from(k)) as u32;
            sampler.rudder(us, 0.0, 0.1);
            sampler.depth(ms, 3.0);
        }
        let samples: Vec<Sample<f64>> = std::iter::from_fn(|| sampler.take()).collect();
        assert_eq!(samples.len(), 19);
        for pair in samples.windows(2) {
            // The last bit of seven weeks.
            assert!((pair[1].time_s - pair[0].time_s - 0.05).abs() < 1e-8);
            assert!((pair[1].rudder_rad - 0.1).abs() < 1e-12);
            assert_eq!(pair[1].depth_m, Some(3.0));
        }
        // Out of the second turn the autopilot starts again.
        for ms in [10_000, 60_000, 110_000] {
            sampler.attitude(attitude(ms, 0.0));
        }
        assert!(sampler.is_restarted(0));
    }

    #[test]
    fn exact_the_clock_of_the_outputs_turns_after_71_minutes() {
        let mut sampler = Sampler::default();
        for k in 0..4_u32 {
            let ms = 4_294_900 + 50 * k;
            sampler.attitude(attitude(ms, 0.0));
            sampler.rudder((u64::from(ms) * 1000) as u32, 0.0, 0.1);
        }
        assert_eq!(std::iter::from_fn(|| sampler.take()).count(), 3);
        assert!(sampler.is_restarted(1000) && !sampler.is_restarted(4_294_000));
    }
    /// 20 Hz of both: every second output is lost. A rudder that went over meanwhile is not known, one that crept is.
    #[test]
    fn io_a_rudder_that_moved_between_two_outputs_is_not_known() {
        for (moved_rad, is_known) in [(0.2, false), (0.03, true)] {
            let mut sampler = Sampler { output_interval_s: Some(0.05), ..Sampler::default() };
            for k in 0..20_u32 {
                let ms = 1000 + 50 * k;
                if k.is_multiple_of(2) {
                    let rudder_rad = if k > 8 { moved_rad } else { 0.0 };
                    sampler.rudder(ms * 1000, 0.0, rudder_rad);
                }
                sampler.attitude(attitude(ms, 0.0));
            }
            let rudders: Vec<f64> =
                std::iter::from_fn(|| sampler.take()).map(|s| s.rudder_rad).collect();
            // Samples at 1.40 and 1.45 s: the output at 1.40 s is the last before.
            let unknown: Vec<usize> = (0..rudders.len()).filter(|k| rudders[*k].is_nan()).collect();
            assert_eq!(unknown, if is_known { vec![] } else { vec![8, 9] }, "{rudders:?}");
            assert_eq!(sampler.thinned_interval_s(), None, "too short a look");
        }
    }

    #[test]
    fn io_outputs_that_have_become_rare_are_noticed() {
        let mut sampler = Sampler { output_interval_s: Some(0.02), ..Sampler::default() };
        let mut noticed_s = None;
        for k in 0..500_u32 {
            let ms = 1000 + 20 * k;
            // From 5 s on every fourth comes.
            if ms < 5000 || k.is_multiple_of(4) {
                sampler.rudder(ms * 1000, 0.0, 0.0);
                let is_noticed = sampler.thinned_interval_s().is_some();
                noticed_s = noticed_s.or(is_noticed.then_some(f64::from(ms) / 1e3));
            }
        }
        // Half of the outputs of 3 s are missing once two thirds of them are thinned to a quarter: 2 s.
        let noticed_s = noticed_s.unwrap();
        assert!((6.9..7.2).contains(&noticed_s), "{noticed_s}");
    }
}
