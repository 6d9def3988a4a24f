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
    ///
    /// ```
    /// use seatrial::identify::{IdentifySettings, identify};
    /// use seatrial::{GainAllowance, Window};
    ///
    /// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// # let mut state = seatrial_core::model::YawState::<f64>::default();
    /// # let sample = |k: u32| {
    /// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
    /// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
    /// #     state = vehicle.advance(state, rudder_rad, 0.05);
    /// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
    /// # };
    /// # let record: seatrial::Record = (0..660).map(sample).collect();
    /// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
    /// let found = identify(&record, Window::ALL, None, &IdentifySettings::default())?;
    /// let allowance = GainAllowance::of(&found);
    /// // A clean record leaves little to allow for, and the loop waits for a sample of 0.05 s.
    /// assert!(allowance.damping_per_s < 0.05);
    /// assert!((allowance.timing.delay_s - 0.05).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(identification: &Identification) -> Self {
        let refined = identification.refined.as_ref();
        let may_be_unstable = identification.verdict.has(&ReasonCode::Unstable);
        Self {
            damping_per_s: refined.map_or(0.0, |refined| {
                let least_damped = identification.least_damped_per_s();
                Self::damping_of(refined.model.a22_per_s, least_damped, may_be_unstable)
            }),
            timing: identification.loop_timing.unwrap_or_default(),
        }
    }

    /// The damping to allow for, 1/s, by a22 and that of the [least damped](Identification::least_damped_per_s) vehicle, 1/s, and a verdict:
    /// none where that is not known; all of it, and so no gain, where the verdict says that the vehicle may be
    /// [unstable](ReasonCode::Unstable).
    ///
    /// ```
    /// use seatrial::GainAllowance;
    ///
    /// // a22 = -1.0 with an interval that ends at -0.8 1/s.
    /// assert!((GainAllowance::damping_of(-1.0, Some(-0.8), false) - 0.2).abs() < 1e-12);
    /// assert_eq!(GainAllowance::damping_of(-1.0, None, false), 0.0);
    /// // All of it, and so no gain, for a vehicle that may be unstable.
    /// assert_eq!(GainAllowance::damping_of(-1.0, Some(-0.8), true), 1.0);
    /// ```
    pub fn damping_of(
        a22_per_s: f64,
        least_damped_per_s: Option<f64>,
        may_be_unstable: bool,
    ) -> f64 {
        match may_be_unstable {
            true => a22_per_s.abs(),
            false => least_damped_per_s.map_or(0.0, |end| Self::damping_per_s(a22_per_s, end)),
        }
    }

    /// From a22 to that of the least damped vehicle, 1/s. All of a22, and so no gain, where that leaves next to
    /// [nothing](Self::LEAST_DAMPING) of it: the vehicle may be undamped.
    ///
    /// ```
    /// use seatrial::GainAllowance;
    ///
    /// assert_eq!(GainAllowance::damping_per_s(-1.0, -0.75), 0.25);
    /// // The interval leaves 2 % of a22: the vehicle may be undamped.
    /// assert_eq!(GainAllowance::damping_per_s(-1.0, -0.02), 1.0);
    /// ```
    pub fn damping_per_s(a22_per_s: f64, least_damped_per_s: f64) -> f64 {
        match -least_damped_per_s >= Self::LEAST_DAMPING * -a22_per_s {
            true => (least_damped_per_s - a22_per_s).max(0.0),
            false => a22_per_s.abs(),
        }
    }

    /// The least part of a22 that its interval leaves where there is a gain. K_p falls with the square of it, here to a 400th.
    pub const LEAST_DAMPING: f64 = 0.05;

    /// The gain.
    ///
    /// ```
    /// use seatrial::GainAllowance;
    /// use seatrial::gains::DAMPING_RATIO;
    /// use seatrial_core::{NoGain, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
    /// let gain = |damping_per_s| {
    ///     let allowance = GainAllowance { damping_per_s, ..GainAllowance::default() };
    ///     allowance.design(&model, DAMPING_RATIO).map(|gain| gain.proportional_gain)
    /// };
    /// // (57) of a22, and of the half of it that is certain: a quarter.
    /// assert!((gain(0.0)? - 0.5).abs() < 1e-9 && (gain(0.5)? - 0.125).abs() < 1e-9);
    /// assert_eq!(gain(1.0), Err(NoGain::CourseUnstable));
    /// # Ok::<(), NoGain>(())
    /// ```
    pub fn design(
        &self,
        model: &YawModel<f64>,
        damping_ratio: f64,
    ) -> Result<HeadingGain<f64>, NoGain> {
        HeadingGain::design_delayed(&self.least_damped(model), damping_ratio, self.timing)
    }

    fn least_damped(&self, model: &YawModel<f64>) -> YawModel<f64> {
        YawModel { a22_per_s: model.a22_per_s + self.damping_per_s, ..*model }
    }
}

/// What a loop waits for that is as fast as the samples: one until a rudder asked for acts, the lag of the rudder, and the
/// hold over one.
///
/// ```
/// use seatrial::gains::sampled;
///
/// let timing = sampled(0.1, 0.3);
/// // One sample and the lag of the rudder; the hold over a sample comes beside.
/// assert!((timing.delay_s - 0.4).abs() < 1e-12);
/// assert_eq!(timing.sample_interval_s, Some(0.1));
/// ```
pub fn sampled(interval_s: f64, rudder_lag_s: f64) -> LoopTiming<f64> {
    LoopTiming { delay_s: interval_s + rudder_lag_s, sample_interval_s: Some(interval_s) }
}

/// The least damped models of a schedule and the longest that its loops wait, for a
/// [`GainSchedule`](seatrial_core::GainSchedule).
///
/// ```
/// use seatrial::GainAllowance;
/// use seatrial::gains::least_damped_schedule;
/// use seatrial_core::YawModel;
/// use seatrial_core::schedule::{ScheduleError, ScheduleKey, SchedulePoint};
///
/// let at = |thrust| {
///     let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
///     let allowance = GainAllowance { damping_per_s: 0.25, ..GainAllowance::default() };
///     (SchedulePoint { thrust: Some(thrust), surge_speed_m_s: None, model }, allowance)
/// };
/// let (schedule, _) = least_damped_schedule(ScheduleKey::Thrust, [at(0.6), at(1.0)])?;
/// assert_eq!(schedule.points()[0].model.a22_per_s, -0.75);
/// # Ok::<(), ScheduleError>(())
/// ```
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
///
/// ```
/// use seatrial::GainAllowance;
/// use seatrial::gains::{longest, sampled};
///
/// let at =
///     |interval_s, lag_s| GainAllowance { damping_per_s: 0.0, timing: sampled(interval_s, lag_s) };
/// let timing = longest([at(0.1, 0.0), at(0.05, 0.5)]);
/// assert_eq!((timing.delay_s, timing.sample_interval_s), (0.55, Some(0.1)));
/// ```
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
    use crate::identification::{WIDEST_A22, WIDEST_B2};
    use crate::propagation::drawn;
    use seatrial_core::heading_loop::HeadingLoop;

    #[test]
    fn exact_an_interval_that_leaves_no_damping_gives_no_gain() {
        assert_eq!(GainAllowance::damping_per_s(-1.0, -0.75), 0.25);
        assert_eq!(GainAllowance::damping_per_s(-1.0, -0.0625), 0.9375);
        let model = YawModel::from_theta([-1.0, 1.08, 0.012]);
        for least_damped_per_s in [0.25, 0.0, -0.0001, f64::NAN] {
            let allowance = GainAllowance {
                damping_per_s: GainAllowance::damping_per_s(-1.0, least_damped_per_s),
                timing: LoopTiming::default(),
            };
            let gain = allowance.design(&model, DAMPING_RATIO);
            assert_eq!(gain, Err(NoGain::CourseUnstable), "{least_damped_per_s}");
        }
    }

    /// A gain for the less damped end of any interval that is accepted keeps 6 dB and 25 deg in each
    /// of 10,000 vehicles drawn, where the loop waits for at most 1.5 time constants.
    #[test]
    fn prop_a_gain_is_stable_in_every_vehicle_drawn() {
        let mut draw = crate::draw::Draw::new(3);
        let mut between = |low: f64, high: f64| low + (high - low) * draw.uniform();
        for _ in 0..200 {
            let time_s = between(0.3, 100.0);
            let model = YawModel::from_theta([-1.0 / time_s, between(0.1, 2.0) / time_s, 0.0]);
            let timing = LoopTiming {
                delay_s: between(0.0, 1.5) * time_s,
                sample_interval_s: Some(between(0.01, 0.5) * time_s),
            };
            let [of_a22, of_b2] = [between(0.0, WIDEST_A22), between(0.0, WIDEST_B2)];
            let deviation = [-of_a22 * model.a22_per_s, of_b2 * model.b2_per_s2].map(|w| w / 1.96);
            let shared = between(-0.95, 0.95) * deviation[0] * deviation[1];
            let mut covariance = [[0.0; 3]; 3];
            covariance[0] = [deviation[0].powi(2), shared, 0.0];
            covariance[1] = [shared, deviation[1].powi(2), 0.0];
            let least_damped_per_s = (1.0 - of_a22) * model.a22_per_s;
            let allowance = GainAllowance {
                damping_per_s: GainAllowance::damping_per_s(model.a22_per_s, least_damped_per_s),
                timing,
            };
            let gain = allowance.design(&model, DAMPING_RATIO).unwrap();
            let vehicles = drawn(&model, &covariance, least_damped_per_s, 10_000).unwrap();
            for vehicle in least_stable(vehicles) {
                let closed = HeadingLoop::new(&vehicle, gain.proportional_gain).unwrap();
                let margins = closed.margins(timing).unwrap();
                let phase = margins.phase_margin_rad.unwrap();
                assert!(margins.gain_margin.unwrap() >= 2.0, "{vehicle:?} {timing:?}");
                assert!(phase.to_degrees() >= 25.0, "{vehicle:?} {timing:?}");
            }
        }
    }

    /// Those than which no other is both less damped and answers more to the rudder: the margins of all others are larger.
    fn least_stable(mut vehicles: Vec<YawModel<f64>>) -> Vec<YawModel<f64>> {
        vehicles.sort_by(|one, other| other.a22_per_s.total_cmp(&one.a22_per_s));
        let mut strongest = 0.0_f64;
        vehicles.retain(|vehicle| {
            let counts = vehicle.b2_per_s2 > strongest;
            strongest = strongest.max(vehicle.b2_per_s2);
            counts
        });
        vehicles
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
        let damping = GainAllowance { damping_per_s: 0.07, ..none };
        assert!((gain(damping).proportional_gain / (1.0 / 2.16) - 1.0).abs() < 1e-14);
        let delay = GainAllowance {
            timing: LoopTiming { delay_s: 0.1, sample_interval_s: Some(0.05) },
            ..none
        };
        assert!(gain(delay).proportional_gain < 0.95 * paper);
        assert_eq!(gain(delay).feed_forward_rudder_rad, -0.012 / 1.08);
    }

    #[test]
    fn exact_the_longest_of_each_counts() {
        let of = |delay_s, sample_interval_s| GainAllowance {
            damping_per_s: 0.0,
            timing: LoopTiming { delay_s, sample_interval_s },
        };
        assert_eq!(
            longest([of(0.2, None), of(0.1, Some(0.05)), of(0.0, Some(0.02))]),
            of(0.2, Some(0.05)).timing
        );
    }
}
