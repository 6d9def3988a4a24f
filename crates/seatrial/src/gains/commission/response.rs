//! What a boat made of heading steps.

use serde::Serialize;

use super::StepInstant;

/// The heading has settled while it is this near, as a fraction of the step, or within [`NEAR_RAD`].
const NEAR: f64 = 0.05;
/// The heading of a small step has settled while it is this near, rad: a compass is no better.
const NEAR_RAD: f64 = 0.0175;

/// A heading whose scatter is normal stays within this many deviations of its mean.
pub(super) const WITHIN: f64 = 2.5;

/// What a boat made of a step away and a step back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Response {
    /// Farthest heading past the wanted one, as a fraction of the step; the mean of both.
    pub overshoot: f64,
    /// Time after which the heading stays within 5 % of the step, a degree, or what sea and compass move it by, s; the longer of both.
    /// `None`: it does not.
    pub settling_s: Option<f64>,
    /// By how much that time depends on the scatter of the heading, s.
    pub settling_error_s: f64,
    /// Mean heading error over the last quarter, rad; the larger of both.
    pub steady_error_rad: f64,
    /// Travel of the steering in full deflections per second over the last half; the mean of both.
    pub activity_per_s: f64,
    /// Half the range of the heading over the last half less a straight line, as a fraction of the step; the larger of both.
    pub oscillation: f64,
}

impl Response {
    /// Measures steps of this size. `smoothing_s`: the heading is averaged over so long, against the noise of the compass.
    /// `scatter_rad`: what sea and compass move a heading by that is held, after that.
    /// `None` where a leg has too few samples.
    ///
    /// ```
    /// use seatrial::gains::commission::{Response, StepInstant};
    ///
    /// // A heading that swings past a step of 0.5 rad by a tenth of it.
    /// let leg: Vec<_> = (0..300)
    ///     .map(|k| 0.1 * f64::from(k))
    ///     .map(|time_s| StepInstant {
    ///         time_s,
    ///         turned_rad: 0.5 * (1.0 - (-0.733 * time_s).exp() * time_s.cos()),
    ///         ..StepInstant::default()
    ///     })
    ///     .collect();
    /// let response = Response::measure(&[leg.clone(), leg.clone()], 0.5, 0.0, 0.0);
    /// assert!(response.is_some_and(|found| (0.05..0.15).contains(&found.overshoot)));
    /// assert!(Response::measure(&[leg[..1].to_vec()], 0.5, 0.0, 0.0).is_none());
    /// ```
    pub fn measure(
        legs: &[Vec<StepInstant>],
        step_rad: f64,
        smoothing_s: f64,
        scatter_rad: f64,
    ) -> Option<Self> {
        let each = legs
            .iter()
            .map(|leg| Self::of_leg(leg, step_rad, smoothing_s, scatter_rad))
            .collect::<Option<Vec<_>>>()?;
        let count = each.len() as f64;
        let mean = |of: fn(&Self) -> f64| each.iter().map(of).sum::<f64>() / count;
        let largest = |of: fn(&Self) -> f64| each.iter().map(of).fold(0.0, f64::max);
        let settled: Option<Vec<f64>> = each.iter().map(|response| response.settling_s).collect();
        (count > 0.0).then(|| Self {
            overshoot: mean(|r| r.overshoot),
            settling_s: settled.map(|times| times.into_iter().fold(0.0, f64::max)),
            settling_error_s: largest(|r| r.settling_error_s),
            steady_error_rad: largest(|r| r.steady_error_rad),
            activity_per_s: mean(|r| r.activity_per_s),
            oscillation: largest(|r| r.oscillation),
        })
    }

    /// Measures repeated steps: where the heading goes on the mean of them, in which sea and compass are smaller, how it swings and the
    /// rudder works on each.
    pub(super) fn of_repeats(
        repeats: &[[Vec<StepInstant>; 2]],
        step_rad: f64,
        smoothing_s: f64,
        scatter_rad: f64,
    ) -> Option<Self> {
        let count = repeats.len() as f64;
        let each: Option<Vec<Self>> = repeats
            .iter()
            .map(|legs| Self::measure(legs, step_rad, smoothing_s, scatter_rad))
            .collect();
        let each = each?;
        let means = [0, 1].map(|way| {
            let legs: Vec<_> = repeats.iter().map(|legs| &legs[way]).collect();
            mean_leg(&legs)
        });
        let mean = |of: fn(&Self) -> f64| each.iter().map(of).sum::<f64>() / count;
        Some(Self {
            activity_per_s: mean(|r| r.activity_per_s),
            oscillation: mean(|r| r.oscillation),
            ..Self::measure(&means, step_rad, smoothing_s, scatter_rad / count.sqrt())?
        })
    }

    fn of_leg(
        leg: &[StepInstant],
        step_rad: f64,
        smoothing_s: f64,
        scatter_rad: f64,
    ) -> Option<Self> {
        let interval_s = interval_s(leg)?;
        let past_rad = smoothed(leg, (smoothing_s / interval_s) as usize)
            .into_iter()
            .map(|turned_rad| turned_rad - step_rad)
            .collect::<Vec<f64>>();
        let near_rad = (NEAR * step_rad).max(NEAR_RAD).max(WITHIN * scatter_rad);
        let settled_within = |near_rad: f64| {
            let unsettled = past_rad.iter().rposition(|past| past.abs() > near_rad);
            unsettled.map_or(0, |last| last + 1)
        };
        let settled = settled_within(near_rad);
        let sooner = settled_within(near_rad + scatter_rad);
        let half = leg.len() / 2;
        let quarter = &past_rad[3 * leg.len() / 4..];
        let travel: f64 =
            leg[half..].windows(2).map(|pair| (pair[1].steering - pair[0].steering).abs()).sum();
        let half_s = (leg.len() - half - 1) as f64 * interval_s;
        let highest = past_rad.iter().copied().fold(0.0, f64::max);
        Some(Self {
            overshoot: highest / step_rad,
            settling_s: (settled < leg.len()).then_some(settled as f64 * interval_s),
            settling_error_s: settled.saturating_sub(sooner) as f64 * interval_s,
            steady_error_rad: (quarter.iter().sum::<f64>() / quarter.len() as f64).abs(),
            activity_per_s: travel / half_s,
            oscillation: swing(&past_rad[half..]) / step_rad,
        })
    }
}

/// What sea and compass move a heading by that is held: the deviation of the last half of each leg from a straight line, at most a
/// degree, the larger of both. `None` where a leg has too few samples.
pub fn scatter_rad(legs: &[Vec<StepInstant>], smoothing_s: f64) -> Option<f64> {
    let each = legs.iter().map(|leg| {
        let heading_rad = smoothed(leg, (smoothing_s / interval_s(leg)?) as usize);
        let rest = off_the_line(&heading_rad[leg.len() / 2..]);
        let square = rest.iter().map(|off| off * off).sum::<f64>() / rest.len() as f64;
        Some(square.sqrt().min(NEAR_RAD))
    });
    let each: Option<Vec<f64>> = each.collect();
    Some(each?.into_iter().fold(0.0, f64::max))
}

/// The mean over repeated legs, sample by sample, as far as all of them go.
fn mean_leg(legs: &[&Vec<StepInstant>]) -> Vec<StepInstant> {
    let shortest = legs.iter().map(|leg| leg.len()).min().unwrap_or(0);
    let mean = |of: fn(&StepInstant) -> f64, k: usize| {
        legs.iter().map(|leg| of(&leg[k])).sum::<f64>() / legs.len() as f64
    };
    (0..shortest)
        .map(|k| StepInstant {
            time_s: mean(|i| i.time_s, k),
            turned_rad: mean(|i| i.turned_rad, k),
            steering: mean(|i| i.steering, k),
            yaw_rate_rad_s: mean(|i| i.yaw_rate_rad_s, k),
        })
        .collect()
}

/// Between two samples of a leg, s. `None` where it has too few.
fn interval_s(leg: &[StepInstant]) -> Option<f64> {
    let [first, .., last] = leg else {
        return None;
    };
    let interval_s = (last.time_s - first.time_s) / (leg.len() - 1) as f64;
    (leg.len() >= 8 && interval_s > 0.0).then_some(interval_s)
}

/// The heading, each averaged with as many before and after as this time has halves.
fn smoothed(leg: &[StepInstant], samples: usize) -> Vec<f64> {
    let reach = samples / 2;
    (0..leg.len())
        .map(|k| {
            let near = &leg[k.saturating_sub(reach)..(k + reach + 1).min(leg.len())];
            near.iter().map(|instant| instant.turned_rad).sum::<f64>() / near.len() as f64
        })
        .collect()
}

/// Half the range of a series less its straight line.
fn swing(series: &[f64]) -> f64 {
    let (low, high) = (off_the_line(series).into_iter())
        .fold((0.0, 0.0), |(low, high), value| (f64::min(low, value), f64::max(high, value)));
    0.5 * (high - low)
}

/// A series less the straight line through it.
fn off_the_line(series: &[f64]) -> Vec<f64> {
    let count = series.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = series.iter().sum::<f64>() / count;
    let (mut product, mut square) = (0.0, 0.0);
    for (k, value) in series.iter().enumerate() {
        let from_middle = k as f64 - middle;
        product += from_middle * value;
        square += from_middle * from_middle;
    }
    let slope = if square > 0.0 { product / square } else { 0.0 };
    let line = |k: usize| mean + slope * (k as f64 - middle);
    (series.iter().enumerate()).map(|(k, value)| value - line(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leg(turned: impl Fn(f64) -> f64, steering: impl Fn(f64) -> f64) -> Vec<StepInstant> {
        (0..400)
            .map(|k| f64::from(k) * 0.05)
            .map(|time_s| StepInstant {
                time_s,
                turned_rad: turned(time_s),
                steering: steering(time_s),
                yaw_rate_rad_s: 0.0,
            })
            .collect()
    }

    #[test]
    fn exact_a_step_is_measured() {
        // Past by a tenth at 4 s, exactly there from 6 s on; the steering goes up and down by 0.01 each sample.
        let turned = |t: f64| match t {
            t if t < 4.0 => 0.55 * t / 4.0,
            t if t < 6.0 => 0.55 - 0.05 * (t - 4.0) / 2.0,
            _ => 0.5,
        };
        let steering = |t: f64| 0.005 * (-1.0_f64).powf((t / 0.05).round());
        let response = Response::measure(&[leg(turned, steering)], 0.5, 0.0, 0.0).unwrap();
        assert!((response.overshoot - 0.1).abs() < 1e-12);
        // Within 5 % from 5 s on.
        assert!((response.settling_s.unwrap() - 5.0).abs() < 0.06);
        assert!(response.steady_error_rad < 1e-12);
        assert!((response.activity_per_s - 0.2).abs() < 1e-9);
        assert!(response.oscillation < 1e-9);
    }

    #[test]
    fn exact_a_heading_that_swings_has_not_settled() {
        let swings = leg(|t| 0.5 + 0.05 * (2.0 * t).sin(), |_| 0.0);
        let still = leg(|_| 0.5, |_| 0.0);
        let response = Response::measure(&[still, swings], 0.5, 0.0, 0.0).unwrap();
        assert_eq!(response.settling_s, None);
        // A tenth of the step, but for what the straight line takes.
        assert!((response.oscillation - 0.1).abs() < 0.01, "{response:?}");
    }

    #[test]
    fn exact_too_few_samples_are_no_step() {
        assert_eq!(Response::measure(&[vec![]], 0.5, 0.0, 0.0), None);
        assert_eq!(Response::measure(&[], 0.5, 0.0, 0.0), None);
    }
}
