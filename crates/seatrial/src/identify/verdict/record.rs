//! Is the record good enough? Rejected samples, speed, clock, rudder, compass.

use super::Weighing;
use crate::figures::{degrees, three_figures};
use crate::identification::ReasonCode;
use crate::identify::checked::Checked;
use crate::record::rudder_text;

/// Share of rejected samples from which the record is noted, and from which it is refused.
const NOTED_REJECTED_SHARE: f64 = 0.01;
const LARGEST_REJECTED_SHARE: f64 = 0.25;

/// Steps of the heading over its range from which the record is noted, and from which it is refused.
const NOTED_QUANTISATION: f64 = 0.02;
const COARSEST_QUANTISATION: f64 = 0.2;

/// Change of speed within the training, as a fraction of its mean, from which it is noted: b2 goes with the
/// square of the speed, so this is 20 % of b2.
const NOTED_SPEED_CHANGE: f64 = 0.1;

/// Intervals between samples this many times the usual, one in twenty, are noted.
const NOTED_JITTER: f64 = 1.5;

/// One side of the rudder this share short of the other is noted.
const NOTED_SHORT_HAND: f64 = 0.25;

impl Weighing {
    pub(super) fn record(&mut self, checked: &Checked) {
        let log = checked.log;
        let read = log.samples_used + log.samples_rejected as usize;
        let share = f64::from(log.samples_rejected) / read.max(1) as f64;
        let text = format!(
            "{} of {read} samples were rejected; check the log's clock and its heading channel",
            log.samples_rejected
        );
        if share > LARGEST_REJECTED_SHARE {
            self.reject(ReasonCode::RejectedSamples, text);
        } else if share > NOTED_REJECTED_SHARE {
            self.note(ReasonCode::RejectedSamples, text);
        }

        if let Some([first, last]) = log.surge_speed_m_s {
            let change = (last - first).abs() / (0.5 * (first + last));
            if change > NOTED_SPEED_CHANGE {
                self.note(
                    ReasonCode::SpeedDrifted,
                    format!(
                        "the speed went from {} to {} m/s within the training, and b2 goes with its square: the model is that of a mean speed; settle longer, or use less rudder",
                        three_figures(first),
                        three_figures(last)
                    ),
                );
            }
        }
        if let Some([usual, long]) = log.interval_s
            && long > NOTED_JITTER * usual
        {
            self.note(
                ReasonCode::ClockJitter,
                format!(
                    "one in twenty intervals between samples is longer than {} s, the usual one is {} s: samples were lost or the clock jitters; log without losses, with the time of the measurement",
                    three_figures(long),
                    three_figures(usual)
                ),
            );
        }

        if let Some(sides @ [positive, negative]) = log.rudder_sides_rad {
            let (less, more) = (positive.min(negative), positive.max(negative));
            if less < (1.0 - NOTED_SHORT_HAND) * more {
                let [positive, negative] = sides.map(|side| rudder_text(log.rudder_unit, side));
                self.note(
                    ReasonCode::RudderSaturated,
                    format!(
                        "from rest the rudder went {positive} to the positive side and {negative} to the other: if it was asked for the same, it stops at the lesser; train with less than that, or trim the rudder"
                    ),
                );
            }
        }

        self.compass(checked);

        let Some(step) = log.heading_step_rad else {
            return;
        };
        let text = format!(
            "the heading comes in steps of {} deg over a range of {} deg; log it finer or turn further",
            degrees(step),
            degrees(log.heading_range_rad)
        );
        if step > COARSEST_QUANTISATION * log.heading_range_rad {
            self.reject(ReasonCode::Quantised, text);
        } else if step > NOTED_QUANTISATION * log.heading_range_rad {
            self.note(ReasonCode::Quantised, text);
        }
    }
}
