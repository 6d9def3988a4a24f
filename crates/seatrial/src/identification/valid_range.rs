//! What a record showed its model to hold for.

use seatrial_core::RudderUnit;
use serde::{Deserialize, Serialize};

use crate::figures::three_figures;
use crate::record::rudder_text;

/// A use this much beyond what was seen is reported.
const NOTED_BEYOND: f64 = 1.2;

/// The rudder, headings, speeds and frequencies of the training and validation data.
///
/// A model of first order is the tangent of a hull whose damping grows with its yaw rate: it is known for the amplitudes that it
/// was seen at, not for others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValidRange {
    /// Least and greatest rudder angle, rad or share of full rudder.
    pub rudder: [f64; 2],
    /// Half of the heading's range, rad.
    pub heading_amplitude_rad: f64,
    /// Least and greatest speed, m/s, where it was logged.
    pub surge_speed_m_s: Option<[f64; 2]>,
    /// The speed that the model is of, m/s: the median, where the record has nearly one speed.
    #[serde(default)]
    pub usual_surge_speed_m_s: Option<f64>,
    /// Lowest and highest angular frequency, rad/s: one period in the record, and where the response to the rudder's amplitude
    /// falls below the noise of the heading (or half the sample rate).
    pub band_rad_s: [f64; 2],
}

impl ValidRange {
    /// The largest rudder angle to either side, rad or share of full rudder.
    pub fn largest_rudder(&self) -> f64 {
        self.rudder.into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    /// Why a rudder of this angle either side is beyond the range, in words.
    ///
    /// ```
    /// use seatrial::identification::ValidRange;
    /// use seatrial::log::RudderUnit;
    ///
    /// let range = ValidRange {
    ///     rudder: [-0.26, 0.2],
    ///     heading_amplitude_rad: 0.35,
    ///     surge_speed_m_s: Some([1.2, 1.5]),
    ///     usual_surge_speed_m_s: None,
    ///     band_rad_s: [0.1, 4.0],
    /// };
    /// assert_eq!(range.largest_rudder(), 0.26);
    /// // A fifth beyond is not noted.
    /// assert_eq!(range.beyond_rudder(0.3, RudderUnit::Rad), None);
    /// let beyond = range.beyond_rudder(0.52, RudderUnit::Rad);
    /// assert!(beyond.is_some_and(|words| words.ends_with("29.8 deg is beyond")));
    /// ```
    pub fn beyond_rudder(&self, angle: f64, unit: RudderUnit) -> Option<String> {
        let seen = self.largest_rudder();
        (angle > NOTED_BEYOND * seen).then(|| {
            format!(
                "the model was seen with at most {} of rudder; {} is beyond",
                rudder_text(unit, seen),
                rudder_text(unit, angle)
            )
        })
    }

    /// Why a speed, m/s, is beyond the range, in words.
    ///
    /// ```
    /// use seatrial::identification::ValidRange;
    ///
    /// let range = ValidRange {
    ///     rudder: [-0.26, 0.26],
    ///     heading_amplitude_rad: 0.35,
    ///     surge_speed_m_s: Some([1.2, 1.5]),
    ///     usual_surge_speed_m_s: None,
    ///     band_rad_s: [0.1, 4.0],
    /// };
    /// assert_eq!(range.beyond_speed(1.6), None);
    /// let beyond = range.beyond_speed(3.0);
    /// assert_eq!(beyond.as_deref(), Some("the model was seen at 1.20 to 1.50 m/s; 3.00 m/s is beyond"));
    /// ```
    pub fn beyond_speed(&self, speed_m_s: f64) -> Option<String> {
        let [low, high] = self.surge_speed_m_s?;
        let is_beyond = speed_m_s > NOTED_BEYOND * high || NOTED_BEYOND * speed_m_s < low;
        is_beyond.then(|| {
            let [low, high, speed] = [low, high, speed_m_s].map(three_figures);
            format!("the model was seen at {low} to {high} m/s; {speed} m/s is beyond")
        })
    }

    /// Where another range leaves this one, in words.
    ///
    /// ```
    /// use seatrial::identification::ValidRange;
    /// use seatrial::log::RudderUnit;
    ///
    /// let of = |rudder_rad: f64, heading_amplitude_rad| ValidRange {
    ///     rudder: [-rudder_rad, rudder_rad],
    ///     heading_amplitude_rad,
    ///     surge_speed_m_s: None,
    ///     usual_surge_speed_m_s: None,
    ///     band_rad_s: [0.1, 4.0],
    /// };
    /// // Twice the rudder and twice the heading: two remarks.
    /// assert_eq!(of(0.2, 0.3).left_by(&of(0.4, 0.6), RudderUnit::Rad).len(), 2);
    /// assert!(of(0.4, 0.6).left_by(&of(0.2, 0.3), RudderUnit::Rad).is_empty());
    /// ```
    pub fn left_by(&self, other: &Self, unit: RudderUnit) -> Vec<String> {
        let rudder = self.beyond_rudder(other.largest_rudder(), unit);
        let headings = [self, other].map(|range| range.heading_amplitude_rad.to_degrees());
        let heading = (headings[1] > NOTED_BEYOND * headings[0]).then(|| {
            format!(
                "the model was seen within {} deg of heading either side; these data have {}",
                three_figures(headings[0]),
                three_figures(headings[1])
            )
        });
        let speeds = self.surge_speed_m_s.zip(other.surge_speed_m_s);
        let speed = speeds.and_then(|([low, high], [least, most])| {
            (most > NOTED_BEYOND * high || NOTED_BEYOND * least < low).then(|| {
                let [low, high, least, most] = [low, high, least, most].map(three_figures);
                format!(
                    "the model was seen at {low} to {high} m/s; these data have {least} to {most} m/s"
                )
            })
        });
        [rudder, heading, speed].into_iter().flatten().collect()
    }

    /// `rudder -14.9 to 14.9 deg, heading within 20 deg, 1.2 to 1.5 m/s, 0.1 to 4 rad/s`
    ///
    /// ```
    /// use seatrial::identification::ValidRange;
    /// use seatrial::log::RudderUnit;
    ///
    /// let range = ValidRange {
    ///     rudder: [-0.5, 0.5],
    ///     heading_amplitude_rad: 0.35,
    ///     surge_speed_m_s: None,
    ///     usual_surge_speed_m_s: None,
    ///     band_rad_s: [0.1, 4.0],
    /// };
    /// let text = range.text(RudderUnit::FullRudder);
    /// assert!(text.starts_with("rudder -50.0 to 50.0 % of full, heading within 20.1 deg"));
    /// ```
    pub fn text(&self, unit: RudderUnit) -> String {
        let (scale, name) = unit.for_people();
        let [low, high] = self.rudder.map(|angle| three_figures(scale * angle));
        let heading = three_figures(self.heading_amplitude_rad.to_degrees());
        let speed = self.surge_speed_m_s.map_or_else(String::new, |speeds| {
            let [least, most] = speeds.map(three_figures);
            format!(", {least} to {most} m/s")
        });
        let [slowest, fastest] = self.band_rad_s.map(three_figures);
        format!(
            "rudder {low} to {high} {name}, heading within {heading} deg{speed}, {slowest} to {fastest} rad/s"
        )
    }
}
