//! How often the vehicle is asked for messages, and how often they come.

use super::{Autopilot, Profile};
use crate::handover::{Controls, Preflight, SLOWER};
use crate::link::Wire;

/// Time over which rates are measured, s of the vehicle.
const RATES_S: f64 = 3.0;
/// Outputs per second that are asked for at most.
const OUTPUT_RATE_HZ: f64 = 50.0;
/// ArduPilot denies messages that are to come more often than in this share of its loops.
const SHARE_OF_LOOPS: f64 = 0.8;
/// A round trip so long, s, is no link to steer through.
const LONGEST_ROUND_TRIP_S: f64 = 1.5;

impl<W: Wire> Autopilot<W> {
    /// The messages that are asked for, by number, and their intervals, s.
    pub(super) fn wanted_messages(&self) -> Vec<(u32, f64)> {
        let sample_s = self.settings.sample_interval_s;
        let mut wanted = vec![
            (30, attitude_interval_s(self.loop_s(), sample_s)),
            (36, self.output_interval_s()),
        ];
        let estimator: &[u32] = match self.profile() {
            Profile::Rover | Profile::Sub => &[193],
            Profile::Px4 => &[230],
            Profile::Generic => &[193, 230],
        };
        wanted.extend([1, 24].iter().chain(estimator).map(|id| (*id, 1.0)));
        wanted.extend([32, 33, 65, 74].map(|id| (id, 0.2_f64.max(sample_s))));
        wanted
    }

    /// Time between two of the autopilot's loops, s; 0 where it does not say.
    fn loop_s(&self) -> f64 {
        let rate_hz = self.parameters.get("SCHED_LOOP_RATE");
        rate_hz.filter(|rate| *rate >= 1.0).map_or(0.0, |rate| 1.0 / rate)
    }

    fn output_interval_s(&self) -> f64 {
        output_interval_s(self.loop_s(), self.settings.sample_interval_s)
    }

    pub(super) fn check_rates(&mut self, found: &mut Preflight) {
        // An output changes half of what lies between two messages before the one that shows it.
        self.earlier_s = 0.5 * (self.output_interval_s() - self.loop_s()).max(0.0);
        let median_s = self.measure_interval();
        let wanted_s = self.settings.sample_interval_s;
        let denied = self.heard.denied;
        let output_s = self.sampler.median_output_interval_s();
        self.sampler.output_interval_s =
            output_s.map(|found_s| found_s.max(self.output_interval_s()));
        let output_s = output_s.unwrap_or(f64::INFINITY);
        match median_s {
            Some(median_s) => found.check(
                "rates",
                median_s <= SLOWER * wanted_s && output_s <= SLOWER * wanted_s,
                format!(
                    "ATTITUDE every {:.0} ms and SERVO_OUTPUT_RAW every {:.0} ms, {:.0} ms asked for: between two of them nobody knows when the rudder moved{}",
                    1e3 * median_s,
                    1e3 * output_s,
                    1e3 * wanted_s,
                    if denied > 0 {
                        "; the autopilot denied some rates"
                    } else {
                        ""
                    }
                ),
            ),
            None => found.check(
                "rates",
                false,
                "no ATTITUDE together with SERVO_OUTPUT_RAW comes; the autopilot must send both",
            ),
        }
        self.wait(3.0, |autopilot| autopilot.heard.clock.is_some());
        match self.heard.clock {
            Some((round_trip_s, ahead_s)) => found.check(
                "clock",
                round_trip_s <= LONGEST_ROUND_TRIP_S,
                format!(
                    "its clock is {ahead_s:.3} s ahead of this trial's, round trip {:.0} ms",
                    1e3 * round_trip_s
                ),
            ),
            None => found.check("clock", false, "TIMESYNC is not answered"),
        }
    }

    /// Asks for the rates; the median time between two samples, s. `None` where none come.
    fn measure_interval(&mut self) -> Option<f64> {
        let wanted = self.wanted_messages();
        let mut times_s: Vec<f64> = Vec::new();
        let mut rates = Vec::new();
        self.sampler.skip();
        self.sampler.output_interval_s = None;
        let mut asked = 0;
        let end_s = self.wire.now_s() + 3.0 * RATES_S;
        let mut start_s = f64::NAN;
        // Requests get lost: three times in all.
        while self.wire.now_s() < end_s
            && times_s.last().is_none_or(|last| start_s.is_nan() || last - start_s <= RATES_S)
        {
            if asked < 3 && times_s.len() >= 10 * asked {
                asked += 1;
                wanted.iter().for_each(|(id, interval_s)| self.set_interval(*id, *interval_s));
            }
            let now_s = self.wire.now_s();
            self.pump(now_s + 0.02);
            while let Some(sample) = self.sampler.take() {
                if sample.rudder_rad.is_nan() {
                    continue;
                }
                if asked == 3 && start_s.is_nan() {
                    start_s = sample.time_s;
                }
                times_s.push(sample.time_s);
                rates.extend(sample.yaw_rate_rad_s);
            }
        }
        self.rate_noise_rad_s = noise(&rates);
        times_s.retain(|time_s| *time_s >= start_s);
        let mut intervals_s: Vec<f64> = times_s.windows(2).map(|w| w[1] - w[0]).collect();
        intervals_s.sort_by(f64::total_cmp);
        intervals_s.get(intervals_s.len() / 2).copied()
    }
}

/// White noise of a series that moves slowly: it is in second differences with variance 6.
fn noise(series: &[f64]) -> Option<f64> {
    let squares = series.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2));
    let count = series.len().saturating_sub(2);
    (count > 0).then(|| (squares.sum::<f64>() / (6.0 * count as f64)).sqrt())
}

/// Between two attitudes, s, of an autopilot with this time between its loops: whole loops, or they would come unevenly.
fn attitude_interval_s(loop_s: f64, sample_s: f64) -> f64 {
    // 0.05 s may be a last bit less than five times 0.01 s.
    let loops = (sample_s / loop_s + 1e-6).floor();
    let even_s = if loops.is_finite() && loops >= 1.0 { loops * loop_s } else { sample_s };
    even_s.max(loop_s / SHARE_OF_LOOPS)
}

/// Between two messages with outputs, s, of an autopilot with this time between its loops.
fn output_interval_s(loop_s: f64, sample_s: f64) -> f64 {
    (1.0 / OUTPUT_RATE_HZ).max(loop_s / SHARE_OF_LOOPS).min(sample_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To and fro by 1 has second differences of 2; a straight line has none.
    #[test]
    fn exact_noise_is_what_a_straight_line_does_not_have() {
        let found = noise(&[0.0, 1.0, 0.0, 1.0, 0.0]).unwrap();
        // 2^2/6
        assert!((found - (4.0_f64 / 6.0).sqrt()).abs() < 1e-15, "{found}");
        assert_eq!(noise(&[1.0, 2.0, 3.0, 4.0]), Some(0.0));
        assert_eq!(noise(&[1.0, 2.0]), None);
    }

    /// At 50 loops a second samples of 20 Hz came 40 and 60 ms apart in turn, which looks like samples lost.
    #[test]
    fn regress_attitudes_come_evenly() {
        for (loop_s, interval_s) in [(0.02, 0.04), (0.01, 0.05), (0.0025, 0.05), (0.0, 0.05)] {
            let found_s = attitude_interval_s(loop_s, 0.05);
            // The last bit of a product.
            assert!((found_s - interval_s).abs() < 1e-15, "{found_s}");
        }
    }

    /// ArduPilot's Rover has 50 loops a second as it comes; its outputs then came at 1 Hz, the rate from before we asked.
    #[test]
    fn regress_no_more_outputs_are_asked_for_than_are_given() {
        for (loop_hz, interval_s) in [(50.0, 0.025), (100.0, 0.02), (400.0, 0.02), (20.0, 0.05)] {
            let found_s = output_interval_s(1.0 / loop_hz, 0.05);
            // The last bit of a quotient.
            assert!((found_s - interval_s).abs() < 1e-15, "{found_s}");
        }
    }
}
