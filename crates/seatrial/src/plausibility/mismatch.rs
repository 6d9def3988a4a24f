//! How a yaw rate and a heading disagree, and the units that would explain it.

use crate::figures::three_figures;

/// Ratios this close to a factor between units are that factor: a compass may deviate by 15 % and a gyro's scale by 3 %.
const CLOSE: f64 = 0.25;

/// Units of time by their counts in a second.
const TIMES: [(f64, &str); 5] = [
    (1.0, "the time is in seconds (--unit time=s)"),
    (1e2, "the time is in hundredths of a second (--unit time=cs)"),
    (1e3, "the time is in milliseconds (--unit time=ms)"),
    (1e6, "the time is in microseconds (--unit time=us)"),
    (1e9, "the time is in nanoseconds (--unit time=ns)"),
];

/// How the yaw rate and the heading disagree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateMismatch {
    /// Change of heading over the integral of the yaw rate.
    pub ratio: f64,
    /// The usual interval, in seconds as the column says.
    pub interval_s: f64,
    /// Does the time count rows?
    pub is_index: bool,
    /// Counts of the time in a second, where its unit was assumed.
    pub time_per_s: Option<f64>,
}

impl RateMismatch {
    /// A yaw rate of the opposite sense and the right size.
    pub(super) const REVERSED: Self =
        Self { ratio: -1.0, interval_s: 0.0, is_index: false, time_per_s: None };

    /// Is the sense of the yaw rate all that is wrong?
    pub fn is_reversed(&self) -> bool {
        is_close(-self.ratio, 1.0)
    }

    /// Units that would explain the ratio, each with its option.
    pub(super) fn explanations(&self) -> Vec<&'static str> {
        // A time whose unit nobody stated is the first to be wrong.
        let of_time = |(per_s, _): &&(f64, &'static str)| {
            let is_it = |taken: f64| is_close(self.ratio.abs(), taken / per_s);
            self.time_per_s.is_some_and(is_it)
        };
        if let Some((_, text)) = TIMES.iter().find(of_time) {
            return vec![text];
        }
        let degree = std::f64::consts::PI / 180.0;
        let known = [
            (10.0, "the heading is in tenths of a degree (--unit heading=ddeg)"),
            (6400.0 / 360.0, "the heading is in mils (--unit heading=mil or mrad)"),
            (65_536.0 / 360.0, "the heading is in counts (--unit heading=turn/65536 or 1e-4rad)"),
            (1e-3, "the time is in milliseconds (--unit time=ms)"),
            (1e-6, "the time is in microseconds (--unit time=us)"),
            (1e-9, "the time is in nanoseconds (--unit time=ns)"),
            (60.0, "the time is in minutes (--unit time=min) or the yaw rate in degrees a second"),
            (
                degree,
                "the yaw rate is in degrees a second (--unit yaw_rate=deg/s), or the heading in radians (--unit heading=rad)",
            ),
            (
                1.0 / degree,
                "the yaw rate is in radians a second (--unit yaw_rate=rad/s), or the heading in degrees (--unit heading=deg)",
            ),
        ];
        known
            .into_iter()
            .filter(|(factor, _)| is_close(self.ratio.abs(), *factor))
            .map(|(_, text)| text)
            .collect()
    }

    pub(super) fn text(&self) -> String {
        if self.is_reversed() {
            return "the yaw rate has the opposite sense of the heading: one of the two counts to the other side, and the yaw rate was not used; turn the wrong one with `reversed` in a [channels] file, or leave the yaw rate out with --yaw-rate none".into();
        }
        let explanations = self.explanations();
        let because = if self.is_index {
            format!(
                "the time counts rows, each of some {} s",
                three_figures(self.ratio.abs() * self.interval_s)
            )
        } else if explanations.is_empty() {
            "time, heading or yaw rate is not in the unit that its column says".into()
        } else {
            explanations.join(", or ")
        };
        format!(
            "the heading changes by {} times what the yaw rate says: {because}; if the yaw rate alone is wrong, leave it out with --yaw-rate none",
            three_figures(self.ratio)
        )
    }
}

fn is_close(ratio: f64, factor: f64) -> bool {
    ratio > 0.0 && libm::log(ratio / factor).abs() < CLOSE
}
