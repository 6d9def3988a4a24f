//! The overshoot of a course change under the gain of a model, in the words of the trade.
//!
//! ```text
//! delta = K_p (psi_d - psi) - delta0,   psi_d a step of 40 deg,   overshoot = max(psi - psi_d)
//! ```
//!
//! | symbol | identifier | unit |
//! |---|---|---|
//! | psi, psi_d | | heading and the heading that is asked for, rad |
//! | K_p, -delta0 | [`GainAllowance::design`] | rudder per rad, and rad or a share of full rudder |
//!
//! The gain stays, the boat is drawn: [ln a22, ln b2, C0] from their covariance, wider on the side of less damping where the 95 % interval
//! is, and the delay of the loop over one sample. The boats of the hypotheses beyond first order are among the draws. The interval holds 95 % of them.
//! The sea is not in it: waves move the heading besides. One course change costs some 120 steps of the model a draw, 2 ms in all.

use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::model::{Discretisation, YawState};
use seatrial_core::{HeadingGain, YawModel};
use serde::{Deserialize, Serialize};

use crate::draw::Draw;
use crate::gain_allowance::{DAMPING_RATIO, GainAllowance};
use crate::identification::Identification;
use crate::likelihood::free_run::heading_step;
use crate::propagation::drawn;

/// The course change of boatbuilders, 40 deg.
pub const COURSE_CHANGE_RAD: f64 = 40.0 / 180.0 * std::f64::consts::PI;

/// One overshoot of at most this much is good, 5 deg.
pub const GOOD_OVERSHOOT_RAD: f64 = 5.0 / 180.0 * std::f64::consts::PI;

/// Draws: their 2.5 % ends stand on ten each.
const DRAWS: usize = 400;

/// Longest course change, in time constants of the model, and most steps of it.
const LONGEST: f64 = 30.0;
const MOST_STEPS: f64 = 6_000.0;

/// What a course change will do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CourseChange {
    /// Size of the course change, rad.
    pub change_rad: f64,
    /// 95 % interval of how far the heading goes beyond the new course, rad.
    pub overshoot_95_rad: [f64; 2],
    /// One overshoot of at most this much is good, rad.
    pub good_overshoot_rad: f64,
}

impl CourseChange {
    /// Of a model with its own gain. `rudder_limit` is the full rudder in the unit of the record, where it is known: a boat that turns with
    /// full rudder overshoots less. `None` where there is no gain, no interval, or pitch.
    ///
    /// ```
    /// use seatrial::identify::{IdentifySettings, identify};
    /// use seatrial::{CourseChange, Window};
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
    /// let change = CourseChange::of(&found, Some(0.26)).ok_or("a model with a gain")?;
    /// // A gain for a damping ratio of 1/sqrt(2) overshoots 40 deg by less than 5.
    /// assert!(change.overshoot_95_rad[1] < change.good_overshoot_rad);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(found: &Identification, rudder_limit: Option<f64>) -> Option<Self> {
        let refined = found.refined.as_ref().filter(|_| found.restoring.is_none())?;
        let allowance = GainAllowance::of(found);
        let test = Test {
            gain: allowance.design(&refined.model, DAMPING_RATIO).ok()?,
            timing: allowance.timing,
            rudder_limit: rudder_limit.unwrap_or(f64::INFINITY),
        };
        let boats = Boats {
            model: refined.model,
            covariance: refined.covariance,
            least_damped_per_s: refined.interval_95.a22_per_s[1],
        };
        let [mut low, mut high] = boats.overshoot_95_rad(&test)?;
        if let Some(vehicle) = found.gain_vehicle() {
            let [least, most] = vehicle.overshoot_rad;
            (low, high) = (low.min(least), high.max(most));
        } else if let (Some(boat), Some(interval_s)) =
            (found.simulated(), test.timing.sample_interval_s)
        {
            let [share, ..] = heading_step(
                &boat.vehicle(),
                test.gain.proportional_gain,
                COURSE_CHANGE_RAD,
                test.rudder_limit,
                interval_s,
            );
            low = low.min(share * COURSE_CHANGE_RAD);
            high = high.max(share * COURSE_CHANGE_RAD);
        }
        Some(Self::with([low, high]))
    }

    fn with(overshoot_95_rad: [f64; 2]) -> Self {
        Self {
            change_rad: COURSE_CHANGE_RAD,
            overshoot_95_rad,
            good_overshoot_rad: GOOD_OVERSHOOT_RAD,
        }
    }

    /// The interval that holds those of several speeds.
    ///
    /// ```
    /// use seatrial::{COURSE_CHANGE_RAD, CourseChange};
    ///
    /// let of = |overshoot_95_rad| CourseChange {
    ///     change_rad: COURSE_CHANGE_RAD,
    ///     overshoot_95_rad,
    ///     good_overshoot_rad: 0.0873,
    /// };
    /// let all = CourseChange::of_all([of([0.01, 0.03]), of([0.02, 0.05])]);
    /// assert_eq!(all.map(|all| all.overshoot_95_rad), Some([0.01, 0.05]));
    /// assert_eq!(CourseChange::of_all([]), None);
    /// ```
    pub fn of_all(changes: impl IntoIterator<Item = Self>) -> Option<Self> {
        let ends = changes.into_iter().map(|change| change.overshoot_95_rad);
        ends.reduce(|[low, high], [least, most]| [low.min(least), high.max(most)]).map(Self::with)
    }

    /// Whole degrees around the interval, `2 to 4`.
    pub fn range_text(&self) -> String {
        // A hair beyond a whole degree is one.
        let [low, high] = self.overshoot_95_rad.map(f64::to_degrees);
        let [low, high] = [(low + 0.05).floor().max(0.0), (high - 0.05).ceil().max(1.0)];
        let change = self.change_rad.to_degrees();
        match low < high {
            // Beyond this it is the trim that is not known.
            true if high > change => format!("{:.0} to more than {change:.0}", low.min(change)),
            true => format!("{low:.0} to {high:.0}"),
            false => format!("{high:.0}"),
        }
    }

    /// The promise in one sentence.
    ///
    /// ```
    /// use seatrial::gains::GOOD_OVERSHOOT_RAD;
    /// use seatrial::{COURSE_CHANGE_RAD, CourseChange};
    ///
    /// let change = CourseChange {
    ///     change_rad: COURSE_CHANGE_RAD,
    ///     // 1.2 and 3.4 deg.
    ///     overshoot_95_rad: [0.021, 0.059],
    ///     good_overshoot_rad: GOOD_OVERSHOOT_RAD,
    /// };
    /// assert_eq!(change.range_text(), "1 to 4");
    /// assert!(change.sentence().starts_with("A 40 deg course change will overshoot by 1 to 4 deg"));
    /// ```
    pub fn sentence(&self) -> String {
        format!(
            "A {:.0} deg course change will overshoot by {} deg (one overshoot of at most {:.0} deg is good).",
            self.change_rad.to_degrees(),
            self.range_text(),
            self.good_overshoot_rad.to_degrees()
        )
    }
}

/// A course change with a gain that stays.
struct Test {
    gain: HeadingGain<f64>,
    timing: LoopTiming<f64>,
    rudder_limit: f64,
}

impl Test {
    /// Overshoot of a boat that was steady on its old course, rad, to starboard (1) or to port (-1). `late_s` is added to the delay.
    fn overshoot_rad(&self, boat: &YawModel<f64>, late_s: f64, side: f64) -> f64 {
        let span_s = LONGEST / boat.a22_per_s.abs();
        let interval_s = self.timing.sample_interval_s.unwrap_or(0.0);
        let interval_s = interval_s.max(span_s / MOST_STEPS);
        let delay_s = (self.timing.delay_s + late_s).max(0.0);
        let whole = (delay_s / interval_s).floor();
        let late_s = delay_s - whole * interval_s;
        let parts = [late_s, interval_s - late_s];
        let steps = parts.map(|part| Discretisation::new(boat.a22_per_s, part));
        let rudder = |wanted_rad: f64, heading_rad: f64| {
            let asked = self.gain.proportional_gain * (wanted_rad - heading_rad)
                + self.gain.feed_forward_rudder_rad;
            asked.clamp(-self.rudder_limit, self.rudder_limit)
        };
        let push = |rudder: f64| boat.b2_per_s2 * rudder + boat.c0_rad_per_s2;
        // What the feed-forward leaves of the offset turns the old course a little.
        let steady_rad = push(self.gain.feed_forward_rudder_rad)
            / (self.gain.proportional_gain * boat.b2_per_s2);
        let mut state = YawState { heading_rad: steady_rad, yaw_rate_rad_s: 0.0 };
        let wanted_rad = side * COURSE_CHANGE_RAD;
        let mut asked = vec![rudder(0.0, steady_rad); whole as usize + 2];
        let mut most = 0.0_f64;
        for _ in 0..MOST_STEPS as usize {
            asked.rotate_right(1);
            asked[0] = rudder(wanted_rad, state.heading_rad);
            state = steps[0].advance(state, push(asked[whole as usize + 1]));
            state = steps[1].advance(state, push(asked[whole as usize]));
            let beyond_rad = side * (state.heading_rad - wanted_rad);
            most = most.max(beyond_rad);
            let turns_back = side * state.yaw_rate_rad_s <= 0.0;
            if turns_back && beyond_rad > -0.5 * COURSE_CHANGE_RAD {
                break;
            }
        }
        most
    }
}

/// The boats that a record does not tell apart.
struct Boats {
    model: YawModel<f64>,
    covariance: [[f64; 3]; 3],
    /// The less damped end of the 95 % interval of a22, 1/s.
    least_damped_per_s: f64,
}

impl Boats {
    fn overshoot_95_rad(&self, test: &Test) -> Option<[f64; 2]> {
        let interval_s = test.timing.sample_interval_s.unwrap_or(0.0);
        let boats = drawn(&self.model, &self.covariance, self.least_damped_per_s, DRAWS)?;
        let mut draw = Draw::new(2);
        let mut overshoots = Vec::with_capacity(DRAWS);
        for (k, boat) in boats.iter().enumerate() {
            let late_s = (draw.uniform() - 0.5) * interval_s;
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            overshoots.push(test.overshoot_rad(boat, late_s, side));
        }
        overshoots.sort_by(f64::total_cmp);
        let cut = overshoots.len() / 40;
        let (low, high) = (overshoots.get(cut)?, overshoots.iter().nth_back(cut)?);
        Some([*low, *high])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(model: &YawModel<f64>, timing: LoopTiming<f64>) -> Test {
        let allowance = GainAllowance { damping_per_s: 0.0, timing };
        Test {
            gain: allowance.design(model, DAMPING_RATIO).unwrap(),
            timing,
            rudder_limit: f64::INFINITY,
        }
    }

    /// A loop of second order with a damping ratio of 1/sqrt(2) overshoots by e^-pi of the step.
    #[test]
    fn exact_a_boat_that_is_known_overshoots_as_the_closed_form_says() {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let test = test(&model, LoopTiming::default());
        let closed_form = (-std::f64::consts::PI).exp() * COURSE_CHANGE_RAD;
        for side in [1.0, -1.0] {
            let found = test.overshoot_rad(&model, 0.0, side);
            // A hold of 0.005 time constants is a delay of half of it: some 0.2 % of the step in 4.3 %.
            assert!((found / closed_form - 1.0).abs() < 0.05, "{found} {closed_form}");
        }
        let boats = Boats { model, covariance: [[0.0; 3]; 3], least_damped_per_s: model.a22_per_s };
        let [low, high] = boats.overshoot_95_rad(&test).unwrap();
        assert!(high - low < 1e-9, "{low} {high}");
    }

    /// An offset that the feed-forward does not know leaves the heading beside both courses by as much.
    #[test]
    fn exact_an_offset_that_is_not_fed_forward_counts() {
        let model = YawModel::from_theta([-1.07, 1.08, 0.0]);
        let test = test(&model, LoopTiming::default());
        let offset = YawModel::from_theta([-1.07, 1.08, 0.02]);
        let beside_rad = 0.02 / (test.gain.proportional_gain * 1.08);
        let [plain, beyond] = [model, offset].map(|boat| test.overshoot_rad(&boat, 0.0, 1.0));
        // The loop is linear; rounding of some thousand steps.
        assert!((beyond - plain - beside_rad).abs() < 1e-9, "{plain} {beyond}");
    }

    #[test]
    fn exact_a_limited_rudder_overshoots_less_and_a_later_one_more() {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let timing = LoopTiming { delay_s: 0.1, sample_interval_s: Some(0.05) };
        let free = test(&model, timing);
        let limited = Test { rudder_limit: 0.2, ..test(&model, timing) };
        let overshoot = free.overshoot_rad(&model, 0.0, 1.0);
        assert!(limited.overshoot_rad(&model, 0.0, 1.0) < overshoot);
        assert!(free.overshoot_rad(&model, 0.1, 1.0) > overshoot);
    }

    #[test]
    fn exact_the_sentence_holds_the_interval_in_whole_degrees() {
        let of = |degrees: [f64; 2]| CourseChange::with(degrees.map(f64::to_radians));
        assert_eq!(of([2.3, 3.6]).range_text(), "2 to 4");
        assert_eq!(of([0.0, 0.4]).range_text(), "0 to 1");
        assert_eq!(of([0.0, 228.0]).range_text(), "0 to more than 40");
        let all = CourseChange::of_all([of([2.3, 3.6]), of([0.4, 1.2])]).unwrap();
        assert_eq!(
            all.sentence(),
            "A 40 deg course change will overshoot by 0 to 4 deg (one overshoot of at most 5 deg is good)."
        );
        assert_eq!(CourseChange::of_all([]), None);
    }
}
