//! The words of doubts about how a heading was made.

use super::doubt::Doubt;
use crate::figures::{three_figures, with_decimals};
use crate::identification::Reason;
use crate::stated_units::HeadingJumps;

impl Doubt {
    pub(super) fn text_of_heading(&self) -> String {
        match self {
            Self::TurnsTooFast {
                yaw_rate_rad_s,
                is_of_heading: true,
            } => format!(
                "the heading has no unit, and as degrees it turns by {} deg/s, which no vessel does: say its unit with --unit heading=ddeg, mil or another",
                three_figures(yaw_rate_rad_s.to_degrees())
            ),
            Self::HeadingInterpolated { every_s } => format!(
                "the heading is interpolated between values {} s apart, as straight lines of the same length show: the rows between them were left out, and the model is that of the values; log every heading once, with the time of its measurement",
                three_figures(*every_s)
            ),
            Self::HeadingSmoothed { late_s, .. } => format!(
                "the noise of the heading is in the rows behind it, too, as a filter or a mean leaves it: the lag of {} s between rudder and heading may be that filter's or a slow rudder's, and no yaw rate tells which; the model is the one behind the lag, which gains must allow for as a delay; log the heading unfiltered, or a gyro's yaw rate",
                three_figures(*late_s)
            ),
            Self::HeadingJumped(jumps) => format!(
                "the heading steps in one row beside the yaw rate {}, which no vehicle does: the steps were taken off, and the model is that of the rest; look at the compass, or at the satellites that it sees",
                how_often(jumps)
            ),
            Self::HeadingThroughSouth { time_s } => format!(
                "at {} s headings between two beside north are those of the numbers between 0 and 360, through south: the heading was averaged or interpolated as a number; do so with its sine and cosine, or log the heading as the compass gives it",
                with_decimals(*time_s, 1)
            ),
            Self::HeadingHalfTurn => "the heading begins again at 180 deg, so that a turn is not told from the one to the other side: log it from 0 to 360 deg".into(),
            _ => String::new(),
        }
    }

    pub(super) fn reason_of_heading(&self, reason: Reason) -> Reason {
        match self {
            Self::HeadingInterpolated { every_s } => Reason {
                text: format!(
                    "The heading was measured every {} s only and is interpolated between: those rows were left out.",
                    three_figures(*every_s)
                ),
                ..reason
            },
            Self::HeadingSmoothed { .. } => Reason {
                text: "The heading was smoothed. It follows the rudder late, and the log does not show whether the smoothing or a slow rudder is the cause.".into(),
                action: "Log the heading unfiltered, or the yaw rate of a gyro beside it.".into(),
                ..reason
            },
            Self::HeadingJumped(jumps) => Reason {
                text: format!(
                    "The compass jumped {}, while the gyro turned on: the jumps were taken off.",
                    how_often(jumps)
                ),
                action: "Look at the compass, or at the satellites that it sees.".into(),
                ..reason
            },
            Self::HeadingThroughSouth { time_s } => Reason {
                text: format!(
                    "At {} s the heading passes north by way of south: it was averaged or interpolated as a number.",
                    with_decimals(*time_s, 1)
                ),
                action: "Average or interpolate its sine and cosine, or log the heading as the compass gives it.".into(),
                ..reason
            },
            Self::HeadingHalfTurn => Reason {
                text: "The heading begins again at 180 deg.".into(),
                action: "Log the heading from 0 to 360 deg.".into(),
                ..reason
            },
            Self::TurnsTooFast {
                yaw_rate_rad_s,
                is_of_heading: true,
            } => Reason {
                text: format!(
                    "The heading has no unit, and as degrees it turns by {} deg/s, which no vessel does.",
                    three_figures(yaw_rate_rad_s.to_degrees())
                ),
                action: "Say its unit with --unit heading=ddeg, mil or another.".into(),
                ..reason
            },
            _ => reason,
        }
    }
}

/// `once, by 2.0 deg at 41.0 s`
fn how_often(jumps: &HeadingJumps) -> String {
    let [times, by] = match jumps.count {
        1 => ["once".to_owned(), "by".to_owned()],
        count => [format!("{count} times"), "by up to".to_owned()],
    };
    format!(
        "{times}, {by} {:.1} deg at {} s",
        jumps.largest_rad.to_degrees(),
        with_decimals(jumps.largest_at_s, 1)
    )
}
