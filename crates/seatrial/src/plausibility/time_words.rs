//! The words of doubts about the time.

use super::doubt::Doubt;
use crate::figures::three_figures;
use crate::identification::Reason;

impl Doubt {
    pub(super) fn text_of_time(&self) -> String {
        match self {
            Self::TimeUnit { interval_s } if *interval_s < 1.0 => format!(
                "samples are {} s apart by the time column, closer than any log has them: say which unit it is in with --unit time=d (the days of a spreadsheet), time=h, time=min or time=s",
                three_figures(*interval_s)
            ),
            Self::TimeUnit { interval_s } => format!(
                "samples are {} s apart by the time column, as if it held milliseconds: say which with --unit time=ms or --unit time=s",
                three_figures(*interval_s)
            ),
            Self::TimeAssumed { interval_s, units } => format!(
                "the time has no unit, and nothing in the log shows that its samples are {} s apart, as they were taken to be: say {}",
                three_figures(*interval_s),
                time_units(units)
            ),
            Self::TurnsTooFast { yaw_rate_rad_s, .. } => format!(
                "by the time column the heading turns by {} deg/s, which no vessel does: say the unit of the time, such as --unit time=s, or name another column with --time",
                three_figures(yaw_rate_rad_s.to_degrees())
            ),
            Self::TimeIsIndex { is_stated: true } => "the time counts 0, 1, 2 and was read in seconds, as its column says; if it is the number of a row, a22 and b2 are as wrong as that: say --unit time=s where a row is a second".into(),
            Self::TimeIsIndex { is_stated: false } => "the time counts 0, 1, 2 like the number of a row, and there is no yaw rate to show that a row takes a second: say so with --unit time=s, or choose another column with --time".into(),
            Self::TimesShared { interval_s, effect } => format!(
                "rows that differ have the same time, which is new every {} s only: when the rudder moved is not known, and a22 may be wrong by some {:.0} %; write the time with more digits, or name another column with --time",
                three_figures(*interval_s),
                100.0 * effect
            ),
            Self::ClockJumped { gap_s } => format!(
                "over {} s without samples the heading went on as if a row had passed: the clock jumped; identify from the part before or behind it with --from and --to",
                three_figures(*gap_s)
            ),
            _ => String::new(),
        }
    }

    pub(super) fn reason_of_time(&self, reason: Reason) -> Reason {
        match self {
            Self::TimeIsIndex { is_stated: true } => Reason {
                text: "The time counts 0, 1, 2 and was read in seconds, as its column says.".into(),
                action: "Where a row is a second, say so with --unit time=s; else give the time of a row as scale of the time in a [channels] file.".into(),
                ..reason
            },
            Self::TimeIsIndex { is_stated: false } => Reason {
                text: "The time counts rows, as 0, 1, 2: how long a row takes is not in the log.".into(),
                action: "Name the column of the time with --time. Where a row is one second, say so with --unit time=s; else give the seconds of a row as scale of the time in a [channels] file.".into(),
                ..reason
            },
            Self::TimeAssumed { interval_s, units } => Reason {
                text: format!(
                    "The time has no unit, and nothing shows that samples are {} s apart.",
                    three_figures(*interval_s)
                ),
                action: format!("Say {}.", time_units(units)),
                ..reason
            },
            Self::TimeUnit { interval_s } => Reason {
                text: format!(
                    "By the time column samples are {} s apart: the time is in another unit.",
                    three_figures(*interval_s)
                ),
                ..reason
            },
            Self::TurnsTooFast { yaw_rate_rad_s, .. } => Reason {
                text: format!(
                    "By the time column the vehicle turns by {} deg/s, which no vessel does.",
                    three_figures(yaw_rate_rad_s.to_degrees())
                ),
                action: "The time counts something longer than it was taken for: give its unit with --unit time=min (or h, d), or name another column with --time.".into(),
                ..reason
            },
            _ => reason,
        }
    }
}

/// The options that settle the unit of the time, with the interval that each makes of the rows.
fn time_units(units: &[(&str, f64)]) -> String {
    let options = units.iter().map(|(unit, interval_s)| {
        format!("--unit time={unit} where rows are {} s apart", three_figures(*interval_s))
    });
    options.collect::<Vec<_>>().join(", or ")
}
