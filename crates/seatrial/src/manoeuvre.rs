//! Where in a record the rudder worked, read from the rudder alone.

use seatrial_core::Sample;

use crate::record::{Window, median};

/// Shorter strokes than this share of the second longest are noise. (The longest may be the rest between two
/// pulses to one side.)
const SHORTEST_STROKE: f64 = 0.25;

/// The rudder's work in a segment of samples.
///
/// ```text
/// middle m: sum (delta - m)^3 = 0        amplitude A = sum |delta - m|^3 / sum (delta - m)^2
/// ```
///
/// This middle lies between the two sides however long the rudder stays at each or at rest, and a brief
/// peak counts little in either. The rudder counts as deflected to a side while it is beyond m +- A/2. Nothing
/// here is a constant in seconds or radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Manoeuvre {
    /// The middle between its two sides, rad.
    pub middle_rad: f64,
    /// How far it was deflected to either side, rad.
    pub amplitude_rad: f64,
    /// When the rudder first moved, s: what comes before is the lead-in.
    pub starts_s: f64,
    /// Each time the rudder was deflected to one side, in order.
    pub strokes: Vec<Stroke>,
}

/// The rudder deflected to one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Towards positive rudder angles?
    pub positive: bool,
    /// When, half open.
    pub window: Window,
}

impl Stroke {
    /// How long the rudder was deflected, s.
    ///
    /// ```
    /// use seatrial::Window;
    /// use seatrial::log::Stroke;
    ///
    /// let stroke = Stroke { positive: true, window: Window { from_s: 2.0, to_s: 4.0 } };
    /// assert_eq!(stroke.duration_s(), 2.0);
    /// ```
    pub fn duration_s(&self) -> f64 {
        self.window.to_s - self.window.from_s
    }
}

impl Manoeuvre {
    /// Finds the strokes. `None` where the rudder does not move or there is nothing finite.
    ///
    /// ```
    /// use seatrial::Sample;
    /// use seatrial::log::Manoeuvre;
    ///
    /// // A doublet of 0.26 rad about a trim of 0.02 rad.
    /// let rudder_rad = |k| {
    ///     0.02 + match k {
    ///         40..80 => 0.26,
    ///         80..120 => -0.26,
    ///         _ => 0.0,
    ///     }
    /// };
    /// let samples: Vec<_> = (0..320)
    ///     .map(|k| Sample { time_s: 0.05 * f64::from(k), rudder_rad: rudder_rad(k), ..Sample::default() })
    ///     .collect();
    /// let found = Manoeuvre::find(&samples).ok_or("the rudder moved")?;
    /// assert_eq!((found.strokes.len(), found.starts_s), (2, 2.0));
    /// assert!((found.middle_rad - 0.02).abs() < 1e-6 && (found.amplitude_rad - 0.26).abs() < 1e-6);
    /// assert_eq!(Manoeuvre::find(&samples[..40]), None);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn find(samples: &[Sample<f64>]) -> Option<Self> {
        let usable = || samples.iter().filter(|s| s.rudder_rad.is_finite() && s.time_s.is_finite());
        let (middle_rad, amplitude_rad) = middle_and_amplitude(usable().map(|s| s.rudder_rad))?;
        let mut strokes: Vec<Stroke> = Vec::new();
        let mut deflected: Option<bool> = None;
        for sample in usable() {
            let deviation = sample.rudder_rad - middle_rad;
            let side = (deviation.abs() >= 0.5 * amplitude_rad).then_some(deviation > 0.0);
            if let (Some(_), Some(stroke)) = (deflected, strokes.last_mut()) {
                stroke.window.to_s = sample.time_s;
            }
            if let Some(positive) = side.filter(|_| side != deflected) {
                strokes.push(Stroke {
                    positive,
                    window: Window { from_s: sample.time_s, to_s: sample.time_s },
                });
            }
            deflected = side;
        }
        let mut durations: Vec<f64> = strokes.iter().map(Stroke::duration_s).collect();
        durations.sort_by(|a, b| b.total_cmp(a));
        let second_longest_s = durations.get(1).copied().unwrap_or(0.0);
        strokes.retain(|stroke| stroke.duration_s() >= SHORTEST_STROKE * second_longest_s);
        let first = strokes.first()?;
        let is_deflected_at_the_start =
            usable().next().map(|s| s.time_s) == Some(first.window.from_s);
        let starts_s =
            if is_deflected_at_the_start { first.window.to_s } else { first.window.from_s };
        Some(Self { middle_rad, amplitude_rad, starts_s, strokes })
    }

    /// When the rudder came back from its first stroke to the other side: the end of a doublet, or of
    /// the first full cycle of a zig-zag. `None` where it was deflected to one side only.
    ///
    /// ```
    /// use seatrial::Sample;
    /// use seatrial::log::Manoeuvre;
    ///
    /// let rudder_rad = |k| match k {
    ///     40..80 => 0.26,
    ///     80..120 => -0.26,
    ///     _ => 0.0,
    /// };
    /// let samples: Vec<_> = (0..320)
    ///     .map(|k| Sample { time_s: 0.05 * f64::from(k), rudder_rad: rudder_rad(k), ..Sample::default() })
    ///     .collect();
    /// // The end of the doublet.
    /// assert_eq!(Manoeuvre::find(&samples).and_then(|found| found.both_sides_used_s()), Some(6.0));
    /// ```
    pub fn both_sides_used_s(&self) -> Option<f64> {
        let first = self.strokes.first()?;
        self.strokes
            .iter()
            .find(|stroke| stroke.positive != first.positive)
            .map(|stroke| stroke.window.to_s)
    }

    /// How far the rudder was deflected to the positive and to the negative side, rad: the median of all strokes to the side that it
    /// went further to, and the furthest stroke to the other, beyond which it may stop. They are counted from
    /// where it rested before or from 0, whichever makes the two more equal. A vehicle with a trim rests off the angle
    /// that its manoeuvre is counted from, and one that is turning does not rest. `None` where nothing comes before the
    /// manoeuvre, or where the rudder was deflected to one side only. Time must not go back in the samples.
    pub fn sides_rad(&self, samples: &[Sample<f64>]) -> Option<[f64; 2]> {
        let within = |window: Window| {
            let inside = window.of(samples).iter().map(|s| s.rudder_rad);
            inside.filter(|r| r.is_finite())
        };
        let before = Window { from_s: f64::NEG_INFINITY, to_s: self.starts_s };
        let rest_rad = median(within(before).collect())?;
        let strokes = |positive: bool| self.strokes.iter().filter(move |s| s.positive == positive);
        let usual = |positive: bool| {
            let all = strokes(positive).flat_map(|s| within(s.window));
            median(all.collect())
        };
        let usual_rad: [f64; 2] = [usual(true)?, usual(false)?];
        let furthest = |positive: bool, middle_rad: f64| {
            let angles = strokes(positive).filter_map(|s| median(within(s.window).collect()));
            angles.map(|angle| (angle - middle_rad).abs()).fold(0.0, f64::max)
        };
        let from = |middle_rad: f64| {
            let [positive, negative] = usual_rad.map(|angle_rad| (angle_rad - middle_rad).abs());
            match positive < negative {
                true => [furthest(true, middle_rad).min(negative), negative],
                false => [positive, furthest(false, middle_rad).min(positive)],
            }
        };
        let unevenness = |[positive, negative]: [f64; 2]| (positive - negative).abs();
        let (from_rest, from_zero) = (from(rest_rad), from(0.0));
        Some(match unevenness(from_rest) <= unevenness(from_zero) {
            true => from_rest,
            false => from_zero,
        })
    }

    /// The median time from one side to the other, s; the longest stroke where there is no change of
    /// sides.
    ///
    /// ```
    /// use seatrial::Sample;
    /// use seatrial::log::Manoeuvre;
    ///
    /// let at = |k: u32| Sample {
    ///     time_s: f64::from(k),
    ///     rudder_rad: if k / 10 % 2 == 0 { 0.2 } else { -0.2 },
    ///     ..Sample::default()
    /// };
    /// let found = Manoeuvre::find(&(0..100).map(at).collect::<Vec<_>>());
    /// assert_eq!(found.and_then(|found| found.half_period_s()), Some(10.0));
    /// ```
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
                .map(Stroke::duration_s)
                .reduce(f64::max)
                .filter(|longest| *longest > 0.0);
        }
        halves.sort_by(f64::total_cmp);
        Some(halves[halves.len() / 2])
    }
}

/// m and A of [`Manoeuvre`]. `None` of what does not vary.
fn middle_and_amplitude(rudder_rad: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let low = rudder_rad.clone().fold(f64::INFINITY, f64::min);
    let high = rudder_rad.clone().fold(f64::NEG_INFINITY, f64::max);
    if low >= high {
        return None;
    }
    // The cubic falls with m and its coefficients are sums about one side.
    let [mut count, mut first, mut second, mut third] = [0.0; 4];
    for d in rudder_rad.clone().map(|rudder| rudder - low) {
        count += 1.0;
        first += d;
        second += d * d;
        third += d * d * d;
    }
    let (mut below, mut above) = (0.0, high - low);
    for _ in 0..60 {
        let m = 0.5 * (below + above);
        if third - 3.0 * m * second + 3.0 * m * m * first - m * m * m * count > 0.0 {
            below = m;
        } else {
            above = m;
        }
    }
    let middle = low + 0.5 * (below + above);
    let moment = |power: i32| -> f64 {
        rudder_rad.clone().map(|rudder| (rudder - middle).abs().powi(power)).sum()
    };
    let amplitude = moment(3) / moment(2);
    amplitude.is_finite().then_some((middle, amplitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rudder: impl Fn(f64) -> f64) -> Vec<Sample<f64>> {
        (0..330)
            .map(|k| f64::from(k) * 0.05)
            .map(|time_s| Sample { time_s, rudder_rad: rudder(time_s), ..Sample::default() })
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
        assert!((found.both_sides_used_s().unwrap() - 6.0).abs() < 1e-9);
        assert!((found.half_period_s().unwrap() - 2.0).abs() < 1e-9);
        // The controller's smaller angles take their part in the amplitude.
        assert!((found.amplitude_rad - 0.26).abs() < 0.02);
        // From 0: the vehicle rests at its trim, -0.011.
        assert_eq!(found.sides_rad(&samples(doublet)), Some([0.26, 0.26]));
        let about_the_trim = |t: f64| doublet(t) - if t < 1.999 { 0.1 } else { 0.111 };
        let moved = samples(about_the_trim);
        let [positive, negative] = Manoeuvre::find(&moved).unwrap().sides_rad(&moved).unwrap();
        // Rounding.
        assert!((positive - 0.26).abs() < 1e-12 && (negative - 0.26).abs() < 1e-12);
        let stopping = |t: f64| {
            if t < 5.999 { doublet(t).max(-0.15) } else { 0.0 }
        };
        let stopped = samples(stopping);
        assert_eq!(Manoeuvre::find(&stopped).unwrap().sides_rad(&stopped), Some([0.26, 0.15]));
        // A side that some strokes reach less far to, and one as far as the other side's, does not stop.
        let further = |t: f64| match t {
            t if t < 8.0 => stopping(t),
            t if t < 10.0 => -0.26,
            _ => 0.0,
        };
        let further = samples(further);
        assert_eq!(Manoeuvre::find(&further).unwrap().sides_rad(&further), Some([0.26, 0.26]));
    }

    /// The controller takes over with more rudder than the doublet had, and passes compass noise on.
    #[test]
    fn exact_doublet_is_found_beside_a_peak_and_noise() {
        let doublet = |t: f64| match t {
            t if t < 1.999 => 0.04 * (977.0 * t).sin(),
            t if t < 3.999 => 0.15,
            t if t < 5.999 => -0.15,
            t if t < 6.199 => 0.26,
            t => 0.04 * (977.0 * t).sin(),
        };
        let found = Manoeuvre::find(&samples(doublet)).unwrap();
        // Times are sums of sample intervals.
        assert!((found.starts_s - 2.0).abs() < 1e-9);
        assert!((found.both_sides_used_s().unwrap() - 6.0).abs() < 1e-9);
        assert!((found.half_period_s().unwrap() - 2.0).abs() < 1e-9);
    }

    #[test]
    fn exact_zig_zag_is_found() {
        let zig_zag = |t: f64| {
            if (t / 3.0).floor() % 2.0 == 0.0 { 0.2 } else { -0.2 }
        };
        let found = Manoeuvre::find(&samples(zig_zag)).unwrap();
        assert_eq!(found.strokes.len(), 6);
        // Within the one sample by which rounding moves a reversal.
        assert!((found.half_period_s().unwrap() - 3.0).abs() < 0.051);
        assert!((found.both_sides_used_s().unwrap() - 6.0).abs() < 0.051);
    }

    #[test]
    fn prop_still_rudder_has_no_manoeuvre() {
        for still in [samples(|_| 0.1), samples(|_| f64::NAN), Vec::new()] {
            assert_eq!(Manoeuvre::find(&still), None);
        }
    }

    #[test]
    fn exact_pulse_to_one_hand_is_found() {
        let pulse = |t: f64| if (1.999..5.0).contains(&t) { 0.2 } else { 0.0 };
        let found = Manoeuvre::find(&samples(pulse)).unwrap();
        // Times are sums of sample intervals.
        assert!((found.starts_s - 2.0).abs() < 1e-9);
        assert!((found.both_sides_used_s().unwrap() - 5.0).abs() < 0.051);
    }
}
