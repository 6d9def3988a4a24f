//! Heading control by a proportional gain with feed-forward: design, schedule, loop analysis.

use core::fmt;

use crate::heading_loop::{HeadingLoop, LoopTiming};
use crate::no_gain::NoGain;
use crate::schedule::{Beyond, ScheduleError, ScheduleValue, SpeedSchedule};
use crate::{Real, YawModel};

/// A proportional gain and the rudder that holds a constant heading.
///
/// ```text
/// delta = K_p (psi_d - psi) - delta0
/// K_p   = a22^2 / (4 zeta^2 b2)                   (57) is zeta = 1/sqrt(2)
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | K_p | `proportional_gain` | rad/rad | has the sign of b2 |
/// | -delta0 | `feed_forward_rudder_rad` | rad | that of the rudder |
/// | zeta | `damping_ratio` | 1 | |
///
/// Source: section VI-B. The sign of delta0 is that of (6), so the feed-forward is -delta0. Holds
/// for a22 < 0 only; elsewhere [`NoGain`] says why.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeadingGain<T> {
    /// K_p, rudder per heading error.
    pub proportional_gain: T,
    /// -delta0, rad.
    pub feed_forward_rudder_rad: T,
}

impl<T: Real> HeadingGain<T> {
    /// The gain that gives the closed loop this damping ratio.
    ///
    /// ```
    /// use core::f64::consts::FRAC_1_SQRT_2;
    /// use seatrial_core::{HeadingGain, NoGain, YawModel};
    ///
    /// // (57): a22^2/(2 b2). The rudder that holds a heading is -C0/b2.
    /// let gain = HeadingGain::design(&YawModel::from_theta([-1.0, 2.0, 0.1]), FRAC_1_SQRT_2)?;
    /// assert!((gain.proportional_gain - 0.25).abs() < 1e-12);
    /// assert_eq!(gain.feed_forward_rudder_rad, -0.05);
    /// let unstable = YawModel::from_theta([0.1, 2.0, 0.0]);
    /// assert_eq!(HeadingGain::design(&unstable, 0.7), Err(NoGain::CourseUnstable));
    /// # Ok::<(), NoGain>(())
    /// ```
    pub fn design(model: &YawModel<T>, damping_ratio: T) -> Result<Self, NoGain> {
        let YawModel { a22_per_s: a22, b2_per_s2: b2, .. } = *model;
        if !model.theta().iter().all(|p| p.is_finite()) {
            return Err(NoGain::NonFinite);
        }
        if !damping_ratio.is_finite() || damping_ratio <= T::ZERO {
            return Err(NoGain::DampingRatio);
        }
        if a22 >= T::ZERO {
            return Err(NoGain::CourseUnstable);
        }
        let delta0 = model.delta0_rad().ok_or(NoGain::NoAuthority)?;
        let gain = a22 * a22 / (T::of(4.0) * damping_ratio * damping_ratio * b2);
        if !gain.is_finite() {
            return Err(NoGain::NoAuthority);
        }
        Ok(Self { proportional_gain: gain, feed_forward_rudder_rad: -delta0 })
    }

    /// The gain whose loop, with its delays, keeps the phase margin that the damping ratio gives it without.
    ///
    /// ```text
    /// tan(phi_m) = 2 zeta/sqrt(sqrt(1 + 4 zeta^4) - 2 zeta^2)
    /// atan(-a22/omega_c) - omega_c (tau + h/2) = phi_m
    /// K_p = omega_c sqrt(omega_c^2 + a22^2)/b2
    /// ```
    ///
    /// | symbol | identifier | unit |
    /// |---|---|---|
    /// | phi_m | phase margin of [`HeadingGain::design`]'s loop | rad |
    /// | omega_c | frequency at which the open loop is 1 | rad/s |
    /// | tau | `timing.delay_s`: dead time and the time constant of a rudder that lags | s |
    /// | h | `timing.sample_interval_s`, of which a hold delays by half | s |
    ///
    /// Without delay it is (57). A delay turns omega_c tau of the margin into overshoot, about 1 % of the step for each
    /// degree.
    ///
    /// ```
    /// use seatrial_core::heading_loop::LoopTiming;
    /// use seatrial_core::{HeadingGain, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.07, 1.08, 0.0]);
    /// let timing = LoopTiming { delay_s: 0.3, sample_interval_s: Some(0.05) };
    /// let prompt = HeadingGain::design(&model, 0.7)?.proportional_gain;
    /// let delayed = HeadingGain::design_delayed(&model, 0.7, timing)?.proportional_gain;
    /// // Who waits steers more gently.
    /// assert!(delayed < 0.9 * prompt);
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn design_delayed(
        model: &YawModel<T>,
        damping_ratio: T,
        timing: LoopTiming<T>,
    ) -> Result<Self, NoGain> {
        let prompt = Self::design(model, damping_ratio)?;
        let closed = HeadingLoop::new(model, prompt.proportional_gain)?;
        let omega = closed.crossover_delayed_rad_s(timing)?;
        let a22 = model.a22_per_s;
        Ok(Self {
            proportional_gain: omega * (omega * omega + a22 * a22).sqrt() / model.b2_per_s2,
            ..prompt
        })
    }

    /// This gain without feed-forward.
    ///
    /// ```
    /// use seatrial_core::HeadingGain;
    ///
    /// let gain = HeadingGain { proportional_gain: 0.5, feed_forward_rudder_rad: -0.02 };
    /// assert_eq!(gain.without_feed_forward().feed_forward_rudder_rad, 0.0);
    /// ```
    pub fn without_feed_forward(self) -> Self {
        Self { feed_forward_rudder_rad: T::ZERO, ..self }
    }
}

/// Rudder from heading error, limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadingController<T> {
    gain: HeadingGain<T>,
    rudder_limit_rad: T,
}

impl<T: Real> HeadingController<T> {
    /// A controller that never asks for more than the limit to either side.
    ///
    /// ```
    /// use seatrial_core::{HeadingController, HeadingGain, NoGain};
    ///
    /// let gain = HeadingGain { proportional_gain: 0.5, feed_forward_rudder_rad: 0.0 };
    /// assert_eq!(HeadingController::new(gain, 0.0), Err(NoGain::RudderLimit));
    /// ```
    pub fn new(gain: HeadingGain<T>, rudder_limit_rad: T) -> Result<Self, NoGain> {
        if !rudder_limit_rad.is_finite() || rudder_limit_rad <= T::ZERO {
            return Err(NoGain::RudderLimit);
        }
        if !gain.proportional_gain.is_finite() || !gain.feed_forward_rudder_rad.is_finite() {
            return Err(NoGain::NonFinite);
        }
        Ok(Self { gain, rudder_limit_rad })
    }

    /// The rudder for a heading error (desired minus measured, wrapped here), rad.
    ///
    /// A measurement that is not finite gives the feed-forward alone.
    ///
    /// ```
    /// use seatrial_core::{HeadingController, HeadingGain};
    ///
    /// let gain = HeadingGain { proportional_gain: 0.5, feed_forward_rudder_rad: -0.02 };
    /// let controller = HeadingController::new(gain, 0.26)?;
    /// assert!((controller.step(0.1) - 0.03_f64).abs() < 1e-12);
    /// // Limited; and 350 deg to starboard is 10 deg to port.
    /// assert_eq!(controller.step(3.0), 0.26);
    /// assert!(
    ///     (controller.step(350_f64.to_radians()) - controller.step(-10_f64.to_radians())).abs() < 1e-12
    /// );
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn step(&self, heading_error_rad: T) -> T {
        let proportional = self.gain.proportional_gain * heading_error_rad.wrapped();
        let proportional = if proportional.is_finite() { proportional } else { T::ZERO };
        (proportional + self.gain.feed_forward_rudder_rad).limited_to(self.rudder_limit_rad)
    }
}

/// Gains over speed or thrust, designed for the models of a schedule and for the models between them.
///
/// The paper draws a straight line between gains (Fig. 18). a22 and b2 run as forces do, V and V^2, and a22^2/b2 falls
/// along a curve below that line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainSchedule<T> {
    schedule: SpeedSchedule<T>,
    damping_ratio: T,
    timing: LoopTiming<T>,
}

/// The point of a schedule for which there is no gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoGainAt {
    /// Key of the point.
    pub key: f64,
    /// Why there is no gain.
    pub reason: NoGain,
}

impl fmt::Display for NoGainAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {}: {}", self.key, self.reason)
    }
}

impl core::error::Error for NoGainAt {}

impl<T: Real> GainSchedule<T> {
    /// Designs a gain at every point with [`HeadingGain::design_delayed`]; all must turn the vehicle the same way.
    ///
    /// ```
    /// use seatrial_core::heading_loop::LoopTiming;
    /// use seatrial_core::schedule::{Beyond, ScheduleKey, SchedulePoint};
    /// use seatrial_core::{GainSchedule, SpeedSchedule, YawModel};
    ///
    /// # fn main() -> Result<(), Box<dyn core::error::Error>> {
    /// let at = |speed_m_s, a22, b2| SchedulePoint {
    ///     thrust: None,
    ///     surge_speed_m_s: Some(speed_m_s),
    ///     model: YawModel::from_theta([a22, b2, 0.0]),
    /// };
    /// let models = SpeedSchedule::new(ScheduleKey::Speed, &[at(1.0, -0.5, 0.5), at(2.0, -1.0, 2.0)])?;
    /// let gains = GainSchedule::design(models, 0.5, LoopTiming::default())?;
    /// // a22 runs as V and b2 as V^2: one gain for all speeds, a22^2/b2.
    /// let gain = gains.lookup(1.5, Beyond::Refuse)?;
    /// assert!((gain.value().proportional_gain - 0.5_f64).abs() < 1e-12);
    /// # Ok(())
    /// # }
    /// ```
    pub fn design(
        schedule: SpeedSchedule<T>,
        damping_ratio: T,
        timing: LoopTiming<T>,
    ) -> Result<Self, NoGainAt> {
        let mut sign = T::ZERO;
        for point in schedule.points() {
            let refused = |reason| NoGainAt {
                key: point.key(schedule.key()).unwrap_or_default().to_f64(),
                reason,
            };
            let gain = HeadingGain::design_delayed(&point.model, damping_ratio, timing)
                .map_err(refused)?;
            if sign * gain.proportional_gain < T::ZERO {
                return Err(refused(NoGain::WrongSign));
            }
            sign = gain.proportional_gain;
        }
        Ok(Self { schedule, damping_ratio, timing })
    }

    /// The models behind the gains.
    pub fn models(&self) -> &SpeedSchedule<T> {
        &self.schedule
    }

    /// The gain for the model at a key, refused where extrapolation leaves no model that has one.
    ///
    /// ```
    /// use seatrial_core::heading_loop::LoopTiming;
    /// use seatrial_core::schedule::{Beyond, ScheduleKey, SchedulePoint};
    /// use seatrial_core::{GainSchedule, SpeedSchedule, YawModel};
    ///
    /// # fn main() -> Result<(), Box<dyn core::error::Error>> {
    /// let at = |thrust, b2| SchedulePoint {
    ///     thrust: Some(thrust),
    ///     surge_speed_m_s: None,
    ///     model: YawModel::from_theta([-1.0, b2, 0.0]),
    /// };
    /// let models = SpeedSchedule::new(ScheduleKey::Thrust, &[at(0.6, 1.0), at(1.0, 2.0)])?;
    /// let gains = GainSchedule::<f64>::design(models, 0.7, LoopTiming::default())?;
    /// // 50 % thrust was not tried.
    /// assert!(gains.lookup(0.5, Beyond::Refuse).is_err());
    /// assert!(gains.lookup(0.5, Beyond::Extrapolate)?.is_extrapolated());
    /// # Ok(())
    /// # }
    /// ```
    pub fn lookup(
        &self,
        at: T,
        beyond: Beyond,
    ) -> Result<ScheduleValue<HeadingGain<T>>, ScheduleError> {
        let point = self.schedule.lookup(at, beyond)?;
        let gain =
            HeadingGain::design_delayed(&point.value().model, self.damping_ratio, self.timing)
                .map_err(|_| ScheduleError::TooFar { at: at.to_f64() })?;
        Ok(ScheduleValue::marked(gain, !point.is_extrapolated()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heading_loop::{HeadingLoop, Poles};
    use crate::model::YawState;
    use crate::schedule::{ScheduleKey, tests::points};

    const ZETA_OF_57: f64 = core::f64::consts::FRAC_1_SQRT_2;

    /// [a22, b2, C0] and K_p as printed in Table V.
    const TABLE_V: [([f64; 3], f64); 6] = [
        ([-1.28, 0.65, 0.0129], 1.26),
        ([-1.51, 1.04, 0.0169], 1.09),
        ([-1.70, 1.41, 0.0274], 1.02),
        ([-1.54, 1.30, 0.0273], 0.91),
        ([-1.69, 1.85, 0.0163], 0.77),
        ([-1.48, 2.02, 0.0312], 0.54),
    ];

    #[test]
    fn val_paper_table_v_gains() {
        for (theta, printed) in TABLE_V {
            let gain = HeadingGain::design(&YawModel::from_theta(theta), ZETA_OF_57).unwrap();
            // Half a unit of the printed digit, and half a unit of a22 and b2: at 70 % the inputs as
            // printed give 1.0962, and 1.09 from the unrounded ones.
            let rounding = 0.005 + printed * (2.0 * 0.005 / -theta[0] + 0.005 / theta[1]);
            assert!((gain.proportional_gain - printed).abs() < rounding);
            assert_eq!(gain.feed_forward_rudder_rad, -theta[2] / theta[1]);
        }
    }

    /// (57) places both poles on the line y = -x.
    #[test]
    fn val_paper_poles_of_57_lie_on_the_diagonal() {
        for (theta, _) in TABLE_V {
            let model = YawModel::from_theta(theta);
            let gain = HeadingGain::design(&model, ZETA_OF_57).unwrap();
            let closed = HeadingLoop::new(&model, gain.proportional_gain).unwrap();
            let Poles::Complex { real, imaginary } = closed.poles() else {
                panic!("real poles");
            };
            assert!((real + imaginary).abs() < 1e-15 && real < 0.0);
            assert!((closed.damping_ratio() - ZETA_OF_57).abs() < 1e-15);
            // "approximately 5 %" in the paper; e^-pi = 4.32 %.
            assert!((closed.overshoot() - (-core::f64::consts::PI).exp()).abs() < 1e-15);
        }
    }

    /// Without delay it is (57), with a delay the loop keeps the phase margin of (57).
    #[test]
    fn exact_a_delay_counted_leaves_the_phase_margin() {
        let model = YawModel::from_theta([-1.07, -1.08, 0.012]);
        let prompt = HeadingGain::design(&model, ZETA_OF_57).unwrap();
        let same = HeadingGain::design_delayed(&model, ZETA_OF_57, LoopTiming::default()).unwrap();
        // Rounding of the bisection.
        assert!((same.proportional_gain / prompt.proportional_gain - 1.0).abs() < 1e-14);
        let margin = |gain: HeadingGain<f64>, timing| {
            let closed = HeadingLoop::new(&model, gain.proportional_gain).unwrap();
            closed.margins(timing).unwrap().phase_margin_rad.unwrap()
        };
        let expected = margin(prompt, LoopTiming::default());
        for (delay_s, sample_interval_s) in [(0.3, None), (0.05, Some(0.05)), (0.0, Some(0.1))] {
            let timing = LoopTiming { delay_s, sample_interval_s };
            let gain = HeadingGain::design_delayed(&model, ZETA_OF_57, timing).unwrap();
            assert!(gain.proportional_gain / prompt.proportional_gain < 0.95);
            // A hold is a delay of half an interval but for (omega h)^2 of it, 1e-3 rad here.
            assert!((margin(gain, timing) - expected).abs() < 1e-3);
        }
        let late = LoopTiming { delay_s: f64::NAN, sample_interval_s: None };
        let refused = HeadingGain::design_delayed(&model, ZETA_OF_57, late);
        assert_eq!(refused, Err(NoGain::Timing));
    }

    /// The free-running loop at a small sample interval overshoots by the theoretical 4.3 %.
    #[test]
    fn exact_simulated_overshoot_is_the_theoretical_one() {
        for sign in [1.0, -1.0] {
            let model = YawModel::from_theta([-1.07, sign * 1.08, 0.012]);
            let gain = HeadingGain::design(&model, ZETA_OF_57).unwrap();
            let controller = HeadingController::new(gain, 0.26).unwrap();
            let step = 0.01;
            let mut state = YawState::default();
            let mut highest: f64 = 0.0;
            for _ in 0..60_000 {
                let rudder = controller.step(step - state.heading_rad);
                state = model.advance(state, rudder, 0.001);
                highest = highest.max(state.heading_rad);
            }
            let closed = HeadingLoop::new(&model, gain.proportional_gain).unwrap();
            // The hold delays by half a millisecond: omega_c h/2 = 2e-4 of phase, some 1e-3 of overshoot.
            assert!(((highest - step) / step - closed.overshoot()).abs() < 1e-3);
            // Feed-forward leaves no steady error.
            assert!((state.heading_rad - step).abs() < 1e-9);
        }
    }

    #[test]
    fn exact_controller_limits_wraps_and_survives_bad_measurements() {
        let gain = HeadingGain { proportional_gain: 1.0_f64, feed_forward_rudder_rad: -0.02 };
        let controller = HeadingController::new(gain, 0.26).unwrap();
        assert_eq!(controller.step(1.0), 0.26);
        assert_eq!(controller.step(-1.0), -0.26);
        let turn = 2.0 * core::f64::consts::PI;
        assert!((controller.step(turn - 0.1) + 0.12).abs() < 1e-14);
        assert_eq!(controller.step(f64::NAN), -0.02);
        assert_eq!(controller.step(f64::INFINITY), -0.02);
        assert_eq!(HeadingController::new(gain, 0.0).unwrap_err(), NoGain::RudderLimit);
    }

    #[test]
    fn exact_refusals_have_reasons() {
        let design = |theta, zeta| HeadingGain::design(&YawModel::from_theta(theta), zeta);
        assert_eq!(design([0.0, 1.0, 0.0], 0.7), Err(NoGain::CourseUnstable));
        assert_eq!(design([0.2, 1.0, 0.0], 0.7), Err(NoGain::CourseUnstable));
        assert_eq!(design([-1.0, 0.0, 0.0], 0.7), Err(NoGain::NoAuthority));
        assert_eq!(design([-1.0, f64::NAN, 0.0], 0.7), Err(NoGain::NonFinite));
        assert_eq!(design([-1.0, 1.0, 0.0], 0.0), Err(NoGain::DampingRatio));
        let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
        assert_eq!(HeadingLoop::new(&model, -1.0), Err(NoGain::WrongSign));
    }

    #[test]
    fn exact_a_gain_between_points_is_that_of_the_model_there() {
        let table = points::<f64>(&crate::schedule::tests::TABLE_II);
        let schedule = SpeedSchedule::new(ScheduleKey::Thrust, &[table[0], table[4]]).unwrap();
        let timing = LoopTiming { delay_s: 0.1, sample_interval_s: Some(0.05) };
        let gains = GainSchedule::design(schedule, ZETA_OF_57, timing).unwrap();
        let model = schedule.lookup(0.8, Beyond::Refuse).unwrap().value().model;
        let designed = HeadingGain::design_delayed(&model, ZETA_OF_57, timing).unwrap();
        let found = gains.lookup(0.8, Beyond::Refuse).unwrap();
        assert_eq!(found, ScheduleValue::Interpolated(designed));
        assert!(matches!(gains.lookup(0.5, Beyond::Refuse), Err(ScheduleError::Outside { .. })));
        assert!(gains.lookup(1.1, Beyond::Extrapolate).unwrap().is_extrapolated());
        // b2 would be negative.
        assert!(matches!(
            gains.lookup(0.1, Beyond::Extrapolate),
            Err(ScheduleError::TooFar { .. })
        ));
    }

    #[test]
    fn exact_gain_schedule_names_the_bad_point() {
        let mut table = points::<f64>(&crate::schedule::tests::TABLE_II);
        table[2].model.a22_per_s = 0.1;
        let schedule = SpeedSchedule::new(ScheduleKey::Thrust, &table).unwrap();
        assert_eq!(
            GainSchedule::design(schedule, 0.7, LoopTiming::default()).unwrap_err(),
            NoGainAt { key: 0.8, reason: NoGain::CourseUnstable }
        );
        table[2].model.a22_per_s = -1.0;
        table[2].model.b2_per_s2 = -1.0;
        let schedule = SpeedSchedule::new(ScheduleKey::Thrust, &table).unwrap();
        let error = GainSchedule::design(schedule, 0.7, LoopTiming::default()).unwrap_err();
        assert_eq!(error.reason, NoGain::WrongSign);
    }
}
