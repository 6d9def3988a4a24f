//! Where in a record the rudder worked, read from the rudder alone.

use seatrial_core::Sample;

use crate::record::Window;

/// The rudder's work in a stretch of samples.
///
/// The rudder counts as laid to a hand while it is beyond half of its largest deviation from the
/// middle of its range. Nothing here is a constant in seconds or radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Manoeuvre {
    /// Middle of the rudder's range, rad.
    pub middle_rad: f64,
    /// Half of the rudder's range, rad.
    pub amplitude_rad: f64,
    /// When the rudder first left the angle that it had at the start by more than half of
    /// `amplitude_rad`, s: what comes before is the lead-in.
    pub starts_s: f64,
    /// Each time the rudder was laid to one hand, in order.
    pub strokes: Vec<Stroke>,
}

/// The rudder laid to one hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Towards positive rudder angles?
    pub positive: bool,
    /// When, half open.
    pub window: Window,
}

impl Manoeuvre {
    /// Finds the strokes. `None` where the rudder does not move or there is nothing finite.
    pub fn find(samples: &[Sample<f64>]) -> Option<Self> {
        let usable = || {
            samples
                .iter()
                .filter(|s| s.rudder_rad.is_finite() && s.time_s.is_finite())
        };
        let low = usable().map(|s| s.rudder_rad).fold(f64::INFINITY, f64::min);
        let high = usable()
            .map(|s| s.rudder_rad)
            .fold(f64::NEG_INFINITY, f64::max);
        let (middle_rad, amplitude_rad) = (0.5 * (high + low), 0.5 * (high - low));
        if !amplitude_rad.is_finite() || amplitude_rad <= 0.0 {
            return None;
        }
        let first_rad = usable().next()?.rudder_rad;
        let starts_s = usable()
            .find(|s| (s.rudder_rad - first_rad).abs() >= 0.5 * amplitude_rad)?
            .time_s;
        let mut strokes: Vec<Stroke> = Vec::new();
        let mut laid: Option<bool> = None;
        for sample in usable() {
            let deviation = sample.rudder_rad - middle_rad;
            let hand = (deviation.abs() >= 0.5 * amplitude_rad).then_some(deviation > 0.0);
            if let (Some(_), Some(stroke)) = (laid, strokes.last_mut()) {
                stroke.window.to_s = sample.time_s;
            }
            if let Some(positive) = hand.filter(|_| hand != laid) {
                strokes.push(Stroke {
                    positive,
                    window: Window {
                        from_s: sample.time_s,
                        to_s: sample.time_s,
                    },
                });
            }
            laid = hand;
        }
        Some(Self {
            middle_rad,
            amplitude_rad,
            starts_s,
            strokes,
        })
    }

    /// When the rudder came back from its first stroke to the other hand: the end of a doublet, or of
    /// the first full cycle of a zig-zag. `None` where it was laid to one hand only.
    pub fn both_hands_used_s(&self) -> Option<f64> {
        let first = self.strokes.first()?;
        self.strokes
            .iter()
            .find(|stroke| stroke.positive != first.positive)
            .map(|stroke| stroke.window.to_s)
    }

    /// The median time from one hand to the other, s; the longest stroke where there is no change of
    /// hands.
    pub fn half_period_s(&self) -> Option<f64> {
        let mut halves: Vec<f64> = self
            .strokes
            .windows(2)
            .filter(|pair| pair[0].positive != pair[1].positive)
            .map(|pair| pair[1].window.from_s - pair[0].window.from_s)
            .filter(|half| *half > 0.0)
            .collect();
        if halves.is_empty() {
            return self
                .strokes
                .iter()
                .map(|stroke| stroke.window.to_s - stroke.window.from_s)
                .reduce(f64::max)
                .filter(|longest| *longest > 0.0);
        }
        halves.sort_by(f64::total_cmp);
        Some(halves[halves.len() / 2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rudder: impl Fn(f64) -> f64) -> Vec<Sample<f64>> {
        (0..330)
            .map(|k| f64::from(k) * 0.05)
            .map(|time_s| Sample {
                time_s,
                rudder_rad: rudder(time_s),
                ..Sample::default()
            })
            .collect()
    }

    #[test]
    fn exact_doublet_is_found() {
        let doublet = |t: f64| match t {
            t if t < 1.999 => -0.011,
            t if t < 3.999 => 0.26,
            t if t < 5.999 => -0.26,
            t => -0.1 * (-t + 6.0).exp(),
        };
        let found = Manoeuvre::find(&samples(doublet)).unwrap();
        assert_eq!(found.strokes.len(), 2);
        // Times are sums of sample intervals.
        assert!((found.starts_s - 2.0).abs() < 1e-9);
        assert!((found.both_hands_used_s().unwrap() - 6.0).abs() < 1e-9);
        assert!((found.half_period_s().unwrap() - 2.0).abs() < 1e-9);
        assert!((found.amplitude_rad - 0.26).abs() < 1e-12);
    }

    #[test]
    fn exact_zig_zag_is_found() {
        let zig_zag = |t: f64| {
            if (t / 3.0).floor() % 2.0 == 0.0 {
                0.2
            } else {
                -0.2
            }
        };
        let found = Manoeuvre::find(&samples(zig_zag)).unwrap();
        assert_eq!(found.strokes.len(), 6);
        // Within the one sample by which rounding moves a reversal.
        assert!((found.half_period_s().unwrap() - 3.0).abs() < 0.051);
        assert!((found.both_hands_used_s().unwrap() - 6.0).abs() < 0.051);
    }

    #[test]
    fn prop_still_rudder_has_no_manoeuvre() {
        assert_eq!(Manoeuvre::find(&samples(|_| 0.1)), None);
        assert_eq!(Manoeuvre::find(&samples(|_| f64::NAN)), None);
        assert_eq!(Manoeuvre::find(&[]), None);
    }

    #[test]
    fn exact_pulse_to_one_hand_is_found() {
        let pulse = |t: f64| if (1.999..5.0).contains(&t) { 0.2 } else { 0.0 };
        let found = Manoeuvre::find(&samples(pulse)).unwrap();
        // Times are sums of sample intervals.
        assert!((found.starts_s - 2.0).abs() < 1e-9);
        assert!((found.both_hands_used_s().unwrap() - 5.0).abs() < 0.051);
    }
}
