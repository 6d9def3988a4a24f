//! The words of doubts about the rudder.

use super::doubt::Doubt;
use crate::figures::three_figures;
use crate::identification::Reason;

impl Doubt {
    pub(super) fn text_of_rudder(&self) -> String {
        match self {
            Self::RudderUnit { said_degrees: true, largest } if *largest > 1.0 => format!(
                "the column taken for the rudder reaches {} deg, which no rudder does: name another with --rudder",
                three_figures(*largest)
            ),
            Self::RudderUnit { said_degrees: true, largest } => format!(
                "the rudder is said to be in degrees and stays within {}, as radians would: say which with --unit rudder=rad or --unit rudder=deg",
                three_figures(*largest)
            ),
            Self::RudderUnit { said_degrees: false, largest } => format!(
                "the rudder is said to be in radians and reaches {}, which no rudder does: say its unit with --unit rudder=deg",
                three_figures(*largest)
            ),
            Self::RudderScale { taken_as, largest } => format!(
                "nothing says in which unit the rudder is; it reaches {} and was taken for {taken_as}: say which with --unit rudder=rad or --unit rudder=deg, or, for a share of full rudder, --unit rudder=fraction or --unit rudder=percent with --rudder-range-deg DEG",
                three_figures(*largest)
            ),
            Self::RudderAgainstName => "the name of the rudder's column says a unit of another kind than the one that was chosen: b2 and the gains are as wrong as that choice".into(),
            Self::RudderBeyondFull { largest } => format!(
                "the rudder is said to be a share of full and reaches {} of it: say its unit with --unit rudder=percent or --unit rudder=deg",
                three_figures(*largest)
            ),
            Self::RudderOfOneSide { shares: [from, to] } => format!(
                "the rudder goes from {} to {} of full rudder and never through neutral, as the throttle of one motor does or a rudder whose neutral is not 0: of two motors take half the difference, --rudder PORT,STARBOARD; of a rudder give its neutral as offset in a file for --channels, or with --rudder-trim for a pulse width",
                three_figures(*from),
                three_figures(*to)
            ),
            Self::RudderHeld { refresh_s, effect } => format!(
                "the rudder changes only every {} s while rows come faster; if it moved in between, it is late by half of that and a22 is wrong by some {:.0} %: log the rudder as often as the heading",
                three_figures(*refresh_s),
                100.0 * effect
            ),
            Self::RudderUnchecked => "nothing in the log shows that the rudder goes where its column says: a rudder that always stops short of its command looks like a rudder with less effect; log the rudder's own angle".into(),
            _ => String::new(),
        }
    }

    pub(super) fn reason_of_rudder(&self, reason: Reason) -> Reason {
        match self {
            Self::RudderUnit { said_degrees: true, largest } if *largest > 1.0 => Reason {
                text: format!(
                    "The column taken for the rudder reaches {} deg, which no rudder does.",
                    three_figures(*largest)
                ),
                action: "Name the right column for the rudder: it may hold the heading.".into(),
                ..reason
            },
            Self::RudderAgainstName => Reason {
                text: "The unit that was chosen for the rudder contradicts the name of its column."
                    .into(),
                action: "Leave the choice out, unless the name is wrong.".into(),
                ..reason
            },
            Self::RudderBeyondFull { largest } => Reason {
                text: format!(
                    "The rudder reaches {} times full rudder: it is not a share of full.",
                    three_figures(*largest)
                ),
                action: "Give its unit with --unit rudder=percent or --unit rudder=deg.".into(),
                ..reason
            },
            Self::RudderOfOneSide { shares } => of_one_side(*shares, reason),
            _ => reason,
        }
    }
}

/// A throttle in place of a rudder.
fn of_one_side([from, to]: [f64; 2], reason: Reason) -> Reason {
    Reason {
        text: format!(
            "The rudder stays on one side, from {} to {} of full: it is the throttle of one motor, or its neutral is not 0.",
            three_figures(from),
            three_figures(to)
        ),
        action: "Of two motors take half the difference: --rudder PORT,STARBOARD. Of a rudder give its neutral: offset in a file for --channels, or --rudder-trim of a pulse width.".into(),
        ..reason
    }
}
