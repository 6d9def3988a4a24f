//! What the recommended heading gain allows for besides the model: the delays of the loop and an uncertain damping.

use seatrial_core::NoGain;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::schedule::{ScheduleError, ScheduleKey};
use seatrial_core::{HeadingGain, SchedulePoint, SpeedSchedule, YawModel};
use serde::{Deserialize, Serialize};

use crate::identification::{Identification, ReasonCode};

/// The damping ratio that gains are proposed for, 1/sqrt(2), that of equation (57): about 5 % overshoot.
pub const DAMPING_RATIO: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// What a gain must allow for so that the vehicle, not only its model, is damped as designed.
///
/// ```text
/// K_p = HeadingGain::design_delayed([a22 + damping_per_s, b2, C0], zeta, timing)
/// ```
///
/// Nothing to allow for gives (57). A gain designed for the end of the 95 % interval of a22 nearer to 0 keeps its damping
/// over the whole interval; where a first-order model misses something (sway, cross-flow drag) the interval is wide, and the
/// gain more cautious.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GainAllowance {
    /// How much less damped than its model the vehicle may be, 1/s.
    pub damping_per_s: f64,
    /// What the loop waits for.
    pub timing: LoopTiming<f64>,
}

impl GainAllowance {
    /// The allowance for an identified model, by [`damping_of`](Self::damping_of).
    pub fn of(identification: &Identification) -> Self {
        let refined = identification.refined.as_ref();
        let may_be_unstable = identification.verdict.has(&ReasonCode::Unstable);
        Self {
            damping_per_s: refined.map_or(0.0, |refined| {
                let interval = refined.interval_95.a22_per_s;
                Self::damping_of(refined.model.a22_per_s, Some(interval), may_be_unstable)
            }),
            timing: identification.loop_timing.unwrap_or_default(),
        }
    }

    /// The damping to allow for, 1/s, by a22 and its 95 % interval, 1/s, and a verdict: none where the interval is not known; all
    /// of it, and so no gain, where the verdict says that the vehicle may be [unstable](ReasonCode::Unstable).
    pub fn damping_of(a22_per_s: f64, interval: Option<[f64; 2]>, may_be_unstable: bool) -> f64 {
        match may_be_unstable {
            true => a22_per_s.abs(),
            false => interval.map_or(0.0, |ends| Self::damping_per_s(a22_per_s, ends)),
        }
    }

    /// From a22 to the end of its 95 % interval nearer to 0, 1/s. All of a22, and so no gain, where that end leaves next to
    /// [nothing](Self::LEAST_DAMPING) of it: the vehicle may be undamped.
    pub fn damping_per_s(a22_per_s: f64, [_, least_damped_per_s]: [f64; 2]) -> f64 {
        match -least_damped_per_s >= Self::LEAST_DAMPING * -a22_per_s {
            true => (least_damped_per_s - a22_per_s).max(0.0),
            false => a22_per_s.abs(),
        }
    }

    /// The least part of a22 that its interval leaves where there is a gain. K_p falls with the square of it, here to a 400th.
    pub const LEAST_DAMPING: f64 = 0.05;

    /// The gain.
    pub fn design(
        &self,
        model: &YawModel<f64>,
        damping_ratio: f64,
    ) -> Result<HeadingGain<f64>, NoGain> {
        HeadingGain::design_delayed(&self.least_damped(model), damping_ratio, self.timing)
    }

    fn least_damped(&self, model: &YawModel<f64>) -> YawModel<f64> {
        YawModel {
            a22_per_s: model.a22_per_s + self.damping_per_s,
            ..*model
        }
    }
}

/// What a loop waits for that is as fast as the samples: one until a rudder asked for acts, the lag of the rudder, and the
/// hold over one.
pub fn sampled(interval_s: f64, rudder_lag_s: f64) -> LoopTiming<f64> {
    LoopTiming {
        delay_s: interval_s + rudder_lag_s,
        sample_interval_s: Some(interval_s),
    }
}

/// The least damped models of a schedule and the longest that its loops wait, for a
/// [`GainSchedule`](seatrial_core::GainSchedule).
pub fn least_damped_schedule(
    key: ScheduleKey,
    points: impl IntoIterator<Item = (SchedulePoint<f64>, GainAllowance)>,
) -> Result<(SpeedSchedule<f64>, LoopTiming<f64>), ScheduleError> {
    let least_damped = |(point, allowance): (SchedulePoint<f64>, GainAllowance)| {
        let model = allowance.least_damped(&point.model);
        (SchedulePoint { model, ..point }, allowance)
    };
    let (points, allowances): (Vec<_>, Vec<_>) = points.into_iter().map(least_damped).unzip();
    Ok((SpeedSchedule::new(key, &points)?, longest(allowances)))
}

/// What a loop over several points waits for: the longest of theirs.
pub fn longest(allowances: impl IntoIterator<Item = GainAllowance>) -> LoopTiming<f64> {
    let timings = allowances.into_iter().map(|allowance| allowance.timing);
    timings.fold(LoopTiming::default(), |longest, timing| LoopTiming {
        delay_s: longest.delay_s.max(timing.delay_s),
        sample_interval_s: [longest.sample_interval_s, timing.sample_interval_s]
            .into_iter()
            .flatten()
            .reduce(f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_interval_that_leaves_no_damping_gives_no_gain() {
        assert_eq!(GainAllowance::damping_per_s(-1.0, [-1.25, -0.75]), 0.25);
        assert_eq!(GainAllowance::damping_per_s(-1.0, [-1.25, -0.0625]), 0.9375);
        let model = YawModel::from_theta([-1.0, 1.08, 0.012]);
        for least_damped_per_s in [0.25, 0.0, -0.0001, f64::NAN] {
            let interval = Some([-2.25, least_damped_per_s]);
            let allowance = GainAllowance {
                damping_per_s: GainAllowance::damping_of(-1.0, interval, false),
                timing: LoopTiming::default(),
            };
            let gain = allowance.design(&model, DAMPING_RATIO);
            assert_eq!(gain, Err(NoGain::CourseUnstable), "{least_damped_per_s}");
        }
    }

    /// The gain is smaller for each thing that it allows for, and (57) for none.
    #[test]
    fn exact_nothing_to_allow_for_is_57() {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let zeta = std::f64::consts::FRAC_1_SQRT_2;
        let gain = |allowance: GainAllowance| allowance.design(&model, zeta).unwrap();
        let none = GainAllowance::default();
        let paper = 1.07 * 1.07 / (2.0 * 1.08);
        // Rounding of the bisection.
        assert!((gain(none).proportional_gain / paper - 1.0).abs() < 1e-14);
        let damping = GainAllowance {
            damping_per_s: 0.07,
            ..none
        };
        assert!((gain(damping).proportional_gain / (1.0 / 2.16) - 1.0).abs() < 1e-14);
        let delay = GainAllowance {
            timing: LoopTiming {
                delay_s: 0.1,
                sample_interval_s: Some(0.05),
            },
            ..none
        };
        assert!(gain(delay).proportional_gain < 0.95 * paper);
        assert_eq!(gain(delay).feed_forward_rudder_rad, -0.012 / 1.08);
    }

    #[test]
    fn exact_the_longest_of_each_counts() {
        let of = |delay_s, sample_interval_s| GainAllowance {
            damping_per_s: 0.0,
            timing: LoopTiming {
                delay_s,
                sample_interval_s,
            },
        };
        assert_eq!(
            longest([of(0.2, None), of(0.1, Some(0.05)), of(0.0, Some(0.02))]),
            of(0.2, Some(0.05)).timing
        );
    }
}
