//! What may be wrong with a log, and what settles it.

use super::mismatch::RateMismatch;
use crate::figures::{three_figures, with_decimals};
use crate::identification::{Reason, ReasonCode, ReasonKind, Subject};
use crate::stated_units::HeadingJumps;

/// Something in a log that does not mean what it says.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Doubt {
    /// The heading is in degrees by its column, and in radians by its numbers, or the other way round.
    HeadingUnit {
        /// Is the column said to hold degrees?
        said_degrees: bool,
        /// The largest number in the column.
        largest: f64,
        /// Does it wrap at a full turn of the other unit?
        wraps: bool,
        /// Did the user choose the unit?
        is_given: bool,
    },
    /// The heading begins again at 180 deg.
    HeadingHalfTurn,
    /// The heading has no unit and is in whole numbers, as counts are.
    HeadingCounts {
        /// The largest number in the column.
        largest: f64,
    },
    /// The rudder is in degrees by its column, and in radians by its numbers, or the other way round.
    RudderUnit {
        /// Is the column said to hold degrees?
        said_degrees: bool,
        /// The largest number in the column.
        largest: f64,
    },
    /// The rudder was said to be in a unit of another kind than the one that the name of its column says.
    RudderAgainstName,
    /// A share of full rudder is more than all of it.
    RudderBeyondFull {
        /// The largest share.
        largest: f64,
    },
    /// Nothing tells whether the rudder is an angle, a fraction or percent of full.
    RudderScale {
        /// What it was taken for.
        taken_as: &'static str,
        /// The largest number in the column.
        largest: f64,
    },
    /// Units that nobody stated and nothing in the log shows, however plausible they are.
    ScaleAssumed {
        /// The columns and the units that they were taken for.
        columns: Vec<(&'static str, &'static str)>,
    },
    /// Samples are so far apart that the time can hardly be in seconds.
    TimeUnit {
        /// The usual interval, in seconds as the column says.
        interval_s: f64,
    },
    /// The time has no unit and counts 0, 1, 2 as the number of a row does, and nothing shows that a row takes a second.
    TimeIsIndex {
        /// Does the name of the column say its unit?
        is_stated: bool,
    },
    /// The unit of the time was assumed, and nothing in the log shows that it is right.
    TimeAssumed {
        /// The usual interval in that unit, s.
        interval_s: f64,
        /// Units with the usual intervals of loggers, s, the likeliest first.
        units: Vec<(&'static str, f64)>,
    },
    /// The yaw rate contradicts heading and time.
    RateMismatch(RateMismatch),
    /// The heading is refreshed more slowly than rows are written.
    HeadingHeld {
        /// The interval between new headings, s.
        refresh_s: f64,
        /// What that may do to a22, as a share of it.
        effect: f64,
    },
    /// The rudder is refreshed more slowly than rows are written.
    RudderHeld {
        /// The interval between new rudder angles, s.
        refresh_s: f64,
        /// What that may do to a22, as a share of it.
        effect: f64,
    },
    /// Rows that differ share a time.
    TimesShared {
        /// The interval between times, s.
        interval_s: f64,
        /// What that may do to a22, as a share of it.
        effect: f64,
    },
    /// The heading went on over a gap in time as if there were none.
    ClockJumped {
        /// Length of the gap, s.
        gap_s: f64,
    },
    /// The rudder stays on one side of neutral, as a throttle does.
    RudderOfOneSide {
        /// Its ends, shares of full rudder.
        shares: [f64; 2],
    },
    /// The heading was interpolated between measured values; the rows between them were left out.
    HeadingInterpolated {
        /// The interval between measured headings, s.
        every_s: f64,
    },
    /// The heading was smoothed, which looks like a rudder that lags.
    HeadingSmoothed {
        /// The lag that it may explain, s.
        late_s: f64,
        /// That lag over the vehicle's time constant.
        effect: f64,
    },
    /// The heading jumped, as a gyro proves; the jumps were taken off.
    HeadingJumped(HeadingJumps),
    /// Between two headings beside north the log passes through south.
    HeadingThroughSouth {
        /// When it first does, s.
        time_s: f64,
    },
    /// The heading was the same for a time in which the vehicle turned.
    HeadingStood {
        /// Since when, s.
        from_s: f64,
        /// For how long, s.
        for_s: f64,
    },
    /// By the units of time and heading the vehicle turns as no vessel does.
    TurnsTooFast {
        /// The fastest turn that no outlier makes.
        yaw_rate_rad_s: f64,
        /// Is the unit of the heading the only one of the two that nobody stated?
        is_of_heading: bool,
    },
    /// The column of the heading is named a course over ground.
    HeadingIsCourse,
    /// A part of the log was left out because it is damaged.
    Damaged,
    /// Nothing shows whether the rudder goes where its column says.
    RudderUnchecked,
    /// There is no yaw rate to compare the heading with.
    HeadingUnchecked {
        /// Is there one that was computed from the heading?
        is_derived: bool,
    },
}

/// The share of a22 that a late heading may take; one sample of a 20 Hz log is 8 to 11 %.
pub(super) const LARGEST_HEADING_EFFECT: f64 = 0.08;
/// The share of a22 that a held rudder may take where the estimate cannot tell when it moved.
pub(super) const LARGEST_RUDDER_EFFECT: f64 = 0.3;
/// The lag of a smoothed heading, in time constants, up to which the model behind it holds.
const LARGEST_SMOOTHING: f64 = 0.3;

impl Doubt {
    /// Its name for programs.
    pub fn kind(&self) -> ReasonKind {
        match self {
            Self::HeadingUnit { .. } | Self::HeadingHalfTurn | Self::HeadingCounts { .. } => {
                ReasonCode::UnitDoubtful.of(Subject::Heading)
            }
            Self::RudderUnit { .. }
            | Self::RudderAgainstName
            | Self::RudderOfOneSide { .. }
            | Self::RudderBeyondFull { .. } => ReasonCode::UnitDoubtful.of(Subject::Rudder),
            Self::RudderScale { .. } => ReasonCode::UnitUnknown.of(Subject::Rudder),
            Self::ScaleAssumed { columns } => match columns[0].0 {
                "heading" => ReasonCode::UnitDoubtful.of(Subject::Heading),
                "rudder" => ReasonCode::UnitUnknown.of(Subject::Rudder),
                _ => ReasonCode::UnitDoubtful.of(Subject::Time),
            },
            Self::HeadingIsCourse => ReasonCode::CourseForHeading.into(),
            Self::TurnsTooFast { is_of_heading: true, .. } => {
                ReasonCode::UnitDoubtful.of(Subject::Heading)
            }
            Self::TimeIsIndex { is_stated: true } => ReasonCode::Unchecked.of(Subject::Time),
            Self::TimeUnit { .. }
            | Self::TurnsTooFast { .. }
            | Self::TimeIsIndex { .. }
            | Self::TimeAssumed { .. } => ReasonCode::UnitDoubtful.of(Subject::Time),
            Self::RateMismatch(mismatch) if mismatch.is_reversed() => {
                ReasonCode::SignReversed.of(Subject::YawRate)
            }
            Self::RateMismatch(_) => ReasonCode::YawRateContradicts.into(),
            Self::HeadingHeld { .. } | Self::HeadingInterpolated { .. } => {
                ReasonCode::SampledTooSeldom.of(Subject::Heading)
            }
            Self::HeadingSmoothed { .. } => ReasonCode::Late.of(Subject::Heading),
            Self::RudderHeld { .. } => ReasonCode::SampledTooSeldom.of(Subject::Rudder),
            Self::TimesShared { .. } => ReasonCode::SampledTooSeldom.of(Subject::Time),
            Self::ClockJumped { .. } => ReasonCode::ClockJumped.into(),
            Self::HeadingStood { .. }
            | Self::HeadingJumped(_)
            | Self::HeadingThroughSouth { .. } => ReasonCode::CompassError.into(),
            Self::Damaged => ReasonCode::Damaged.into(),
            Self::HeadingUnchecked { .. } => ReasonCode::Unchecked.of(Subject::Heading),
            Self::RudderUnchecked => ReasonCode::Unchecked.of(Subject::Rudder),
        }
    }

    /// May no model of the log be used until it is settled?
    pub fn refuses(&self) -> bool {
        match self {
            Self::HeadingHeld { effect, .. } => *effect > LARGEST_HEADING_EFFECT,
            Self::RudderHeld { effect, .. } => *effect > LARGEST_RUDDER_EFFECT,
            Self::HeadingSmoothed { effect, .. } => *effect > LARGEST_SMOOTHING,
            Self::RateMismatch(mismatch) => !mismatch.is_reversed(),
            // A unit that was given settles what is possible.
            Self::HeadingUnit { said_degrees: true, wraps: false, is_given: true, .. } => false,
            // A column that says seconds is read in seconds.
            Self::TimeIsIndex { is_stated } => !is_stated,
            Self::RudderAgainstName
            | Self::ScaleAssumed { .. }
            | Self::HeadingIsCourse
            | Self::HeadingInterpolated { .. }
            | Self::HeadingJumped(_)
            | Self::Damaged
            | Self::HeadingUnchecked { .. }
            | Self::RudderUnchecked => false,
            _ => true,
        }
    }

    /// What was measured, what it means, and the option that settles it.
    pub fn text(&self) -> String {
        match self {
            Self::HeadingUnit { said_degrees: false, largest, wraps: false, is_given: true } => format!(
                "the heading is said to be in radians, begins more than a turn from north and reaches {}, as degrees would, and there is no yaw rate to show that it is right: say --unit heading=deg, or take full turns of 2 pi off a heading that is in radians",
                three_figures(*largest)
            ),
            Self::HeadingUnit { said_degrees, largest, wraps, .. } => heading_text(*said_degrees, *largest, *wraps),
            Self::HeadingCounts { largest } => format!(
                "the heading has no unit and is in whole numbers up to {}, as whole degrees are and tenths of them, mils and counts of a turn, and neither a turn through north nor a yaw rate shows which: say --unit heading=deg, or --unit heading=ddeg, mil or turn/256",
                three_figures(*largest)
            ),
            Self::ScaleAssumed { columns } => format!(
                "{}, and nothing in the log shows that this is right: T, K and the gains are as wrong as that; {}",
                taken_for(columns),
                say_units(columns)
            ),
            Self::HeadingInterpolated { .. } | Self::HeadingSmoothed { .. } | Self::HeadingJumped(_) | Self::HeadingThroughSouth { .. } | Self::HeadingHalfTurn | Self::TurnsTooFast { is_of_heading: true, .. } => self.text_of_heading(),
            Self::RudderAgainstName | Self::RudderBeyondFull { .. } | Self::RudderHeld { .. } | Self::RudderOfOneSide { .. } | Self::RudderScale { .. } | Self::RudderUnchecked | Self::RudderUnit { .. } => self.text_of_rudder(),
            Self::ClockJumped { .. } | Self::TimeAssumed { .. } | Self::TimeIsIndex { .. } | Self::TimeUnit { .. } | Self::TimesShared { .. } | Self::TurnsTooFast { .. } => self.text_of_time(),
            Self::HeadingIsCourse => "the column taken for the heading is named a course or track, which is where the vehicle goes and not where it points: it is late and smooth, so that a22 and b2 are those of the track; log the heading of a compass".into(),
            Self::RateMismatch(mismatch) => mismatch.text(),
            Self::HeadingStood { from_s, for_s } => format!(
                "the compass stood still from {} s on for {} s while the vehicle turned",
                three_figures(*from_s),
                three_figures(*for_s)
            ),
            Self::HeadingHeld { refresh_s, effect } => format!(
                "the heading changes only every {} s while rows come faster, so that it is late by half of that and a22 is wrong by some {:.0} %: log every heading once, with the time of its measurement",
                three_figures(*refresh_s),
                100.0 * effect
            ),
            Self::Damaged => "a part of the log is damaged and was left out; the warnings say which, and the model is that of the rest".into(),
            Self::HeadingUnchecked { is_derived } => heading_unchecked(*is_derived),
        }
    }
}

impl Doubt {
    /// The reason of a verdict.
    pub(crate) fn reason(&self) -> Reason {
        let reason = Reason::new(self.kind(), self.text());
        match self {
            Self::HeadingStood { from_s, for_s } => Reason {
                text: format!(
                    "From {} s on the compass stood still for {} s while the vehicle turned.",
                    with_decimals(*from_s, 1),
                    with_decimals(*for_s, 1)
                ),
                action: "Check the compass, its filter and its connection, then repeat the run."
                    .into(),
                ..reason
            },
            Self::RateMismatch(mismatch) if !mismatch.explanations().is_empty() => Reason {
                action: format!(
                    "Say so where {}; else leave the yaw rate out with --yaw-rate none.",
                    mismatch.explanations().join(", or ")
                ),
                ..reason
            },
            Self::HeadingUnit { said_degrees: true, wraps: false, is_given: true, .. } => Reason {
                text: "The heading turns little for so much rudder, as one in radians would that is called degrees.".into(),
                action: "Make sure that it is in degrees.".into(),
                ..reason
            },
            Self::HeadingCounts { .. } => Reason {
                text: "The heading has no unit: its whole numbers may be degrees, tenths of them, or counts.".into(),
                action: "Say its unit with --unit heading=deg, or --unit heading=ddeg, mil or turn/256.".into(),
                ..reason
            },
            Self::ScaleAssumed { columns } => Reason {
                text: format!("No unit is given: {}, which nothing in the log shows.", taken_for(columns)),
                action: format!("Where that is right, {}; else give the right units.", say_units(columns)),
                ..reason
            },
            _ => self.reason_of_heading(self.reason_of_rudder(self.reason_of_time(reason))),
        }
    }
}

/// The columns and what they were taken for: `heading was taken for deg, rudder for deg`.
fn taken_for(columns: &[(&str, &str)]) -> String {
    let each = |(column, unit): &(&str, &str)| format!("{column} for {unit}");
    let columns: Vec<String> = columns.iter().map(each).collect();
    columns.join(", ").replacen(" for", " was taken for", 1)
}

/// The options that settle the units of columns.
fn say_units(columns: &[(&str, &str)]) -> String {
    let options = columns.iter().map(|(quantity, unit)| format!("--unit {quantity}={unit}"));
    format!("say {}", options.collect::<Vec<_>>().join(" "))
}

fn heading_unchecked(is_derived: bool) -> String {
    let (no_rate, of_course) = match is_derived {
        true => ("the yaw rate is computed from the heading and shows nothing of it", ""),
        false => (
            "the log has no yaw rate to compare the heading with",
            ", and a course over ground is not a heading",
        ),
    };
    format!(
        "{no_rate}, so faults of the heading stay hidden: deviation of the compass makes b2 wrong, a late or filtered heading makes a22 wrong{of_course}; log a gyro's yaw rate, or swing the compass"
    )
}

fn heading_text(said_degrees: bool, largest: f64, wraps: bool) -> String {
    let (said, other, option, turn) = match said_degrees {
        true => ("degrees", "radians", "rad", "2 pi"),
        false => ("radians", "degrees", "deg", "360"),
    };
    if wraps {
        return format!(
            "the heading is said to be in {said} and wraps at {turn}: it is in {other}; say so with --unit heading={option}"
        );
    }
    let settles = if said_degrees {
        "--unit heading=rad or --unit heading=deg"
    } else {
        "--unit heading=deg or --unit heading=rad"
    };
    format!(
        "the heading is said to be in {said} and stays within {}, as {other} would: say which with {settles}",
        three_figures(largest)
    )
}
