//! Records that cannot give any model at all.

use crate::figures::degrees;
use crate::identification::{Reason, ReasonCode, Subject};
use crate::record::{RudderUnit, rudder_text};

/// Three parameters, two initial conditions and a noise level need some samples each.
const LEAST_SAMPLES: usize = 30;

/// A rudder or a heading that moves less than this, rad (0.1 deg), did not move.
const LEAST_MOVEMENT_RAD: f64 = 0.0017;

/// A record that cannot give any model at all: the reason, or `None` where one may be tried.
pub fn refuse_record(
    samples: usize,
    rudder_amplitude_rad: f64,
    rudder_unit: RudderUnit,
    heading_range_rad: f64,
    times_are_shared: bool,
) -> Option<Reason> {
    if samples < LEAST_SAMPLES && times_are_shared {
        return Some(Reason::new(
            ReasonCode::SampledTooSeldom.of(Subject::Time),
            format!(
                "{samples} usable samples in the training window, since rows that differ have the same time: write the time with more digits, or choose the column that holds it"
            ),
        ));
    }
    if samples < LEAST_SAMPLES {
        return Some(Reason::new(
            ReasonCode::TooFewSamples,
            format!(
                "{samples} usable samples in the training window, at least {LEAST_SAMPLES} are needed; widen the window or log faster"
            ),
        ));
    }
    if rudder_amplitude_rad < LEAST_MOVEMENT_RAD {
        return Some(rudder_constant(rudder_amplitude_rad, rudder_unit));
    }
    if heading_range_rad < LEAST_MOVEMENT_RAD {
        return Some(Reason::new(
            ReasonCode::Constant.of(Subject::Heading),
            format!(
                "the heading stays within {} deg while the rudder moves {} either side; check that the heading channel is alive",
                degrees(heading_range_rad),
                rudder_text(rudder_unit, rudder_amplitude_rad)
            ),
        ));
    }
    None
}

/// The reason to refuse a record in which the rudder stays where it is.
pub fn rudder_constant(rudder_amplitude_rad: f64, rudder_unit: RudderUnit) -> Reason {
    Reason::new(
        ReasonCode::Constant.of(Subject::Rudder),
        format!(
            "the rudder stays within {}: nothing excites the vehicle; command a doublet, or choose a window with one",
            rudder_text(rudder_unit, rudder_amplitude_rad)
        ),
    )
}
