//! Is the record good enough? Rejected samples, speed, clock, rudder, compass.

use super::Weighing;
use crate::figures::{degrees, three_figures};
use crate::identification::{Reason, ReasonCode, Subject};
use crate::identify::log_statistics::LogStatistics;
use crate::identify::model_evidence::ModelEvidence;
use crate::record::{RudderUnit, rudder_text};

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

/// Longest interval between new values of a channel, in time constants of the vehicle: up to there the intervals hold, whether the rudder moves at
/// the samples' own times or between them.
const LONGEST_INTERVAL: f64 = 0.4;

/// One side of the rudder this share short of the other is noted.
const NOTED_SHORT_SIDE: f64 = 0.25;

/// The step of a heading that comes in coarse ones, rad.
pub(super) fn coarse_step_rad(log: &LogStatistics) -> Option<f64> {
    log.heading_step_rad.filter(|step_rad| *step_rad > NOTED_QUANTISATION * log.heading_range_rad)
}

/// Rows that come evenly and have uneven times were not lost.
fn rounded_time([step_s, even_s]: [f64; 2]) -> Reason {
    let (step, even) = (three_figures(step_s), three_figures(even_s));
    let measured = format!(
        "the time is written in steps of {step} s, and rows come every {even} s: their intervals are uneven by that, and no row is missing; write the time with more digits"
    );
    Reason {
        text: format!("The time is written in steps of {step} s, while rows come every {even} s."),
        action: "Write the time with more digits.".into(),
        ..Reason::new(ReasonCode::ClockJitter, measured)
    }
}

impl Weighing {
    pub(super) fn record(&mut self, evidence: &ModelEvidence) {
        let log = evidence.log;
        self.rejected_samples(log);
        if let Some([first, last]) = log.surge_speed_m_s {
            self.speed(first, last);
        }
        if let Some(rounded_s) = log.rounded_time_s {
            self.notes.push(rounded_time(rounded_s));
        } else if let Some([usual, long]) = log.interval_s
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
        if let Some(sides) = log.rudder_sides_rad {
            self.rudder_sides(sides, log.rudder_unit);
        }
        self.pace(evidence);
        self.compass(evidence);
        if let Some(step_rad) = coarse_step_rad(log) {
            self.heading_step(step_rad, log.heading_range_rad);
        }
    }

    fn rejected_samples(&mut self, log: &LogStatistics) {
        let counts = log.rejected;
        let read = log.samples_used + counts.total() as usize;
        let share = f64::from(counts.total()) / read.max(1) as f64;
        let untimely = counts.repeated_time + counts.reversed_time;
        let reason = Reason::new(
            ReasonCode::Damaged.of(Subject::Samples),
            format!(
                "{} of {read} samples were rejected: {untimely} came twice or out of order, {} had a heading that no rudder makes, {} were no numbers",
                counts.total(),
                counts.spike,
                counts.non_finite
            ),
        );
        let reason = match 2 * untimely > counts.total() {
            true => Reason {
                text: "Many samples came twice or out of order.".into(),
                action: "Check the link and the clock: each sample needs its own time.".into(),
                ..reason
            },
            false => reason,
        };
        if share > LARGEST_REJECTED_SHARE {
            self.rejections.push(reason);
        } else if share > NOTED_REJECTED_SHARE {
            self.notes.push(reason);
        }
    }

    fn speed(&mut self, first: f64, last: f64) {
        let change = (last - first).abs() / (0.5 * (first + last));
        if change > NOTED_SPEED_CHANGE {
            self.note(
                ReasonCode::Drifted.of(Subject::Speed),
                format!(
                    "the speed went from {} to {} m/s within the training, and b2 goes with its square: the model is that of a mean speed; settle longer, or use less rudder",
                    three_figures(first),
                    three_figures(last)
                ),
            );
        }
    }

    fn rudder_sides(&mut self, sides: [f64; 2], unit: RudderUnit) {
        let [positive, negative] = sides;
        let (less, more) = (positive.min(negative), positive.max(negative));
        if less < (1.0 - NOTED_SHORT_SIDE) * more {
            let [positive, negative] = sides.map(|side| rudder_text(unit, side));
            let text = format!(
                "the rudder went {positive} to the positive side and {negative} to the other"
            );
            let reason = Reason::new(
                ReasonCode::RudderNotFollowed,
                format!(
                    "{text}: if it was asked for the same, it stops at the lesser; train with less than that, or trim the rudder"
                ),
            );
            // Who asked for that knows whether it stopped.
            self.notes.push(Reason {
                text: format!("T{}.", &text[1..]),
                action: "If it was asked for the same, it stops at the lesser: look at the measured rudder angle.".into(),
                ..reason
            });
        }
    }

    fn heading_step(&mut self, step_rad: f64, range_rad: f64) {
        let text = format!(
            "the heading comes in steps of {} deg over a range of {} deg; log it finer or turn further",
            degrees(step_rad),
            degrees(range_rad)
        );
        if step_rad > COARSEST_QUANTISATION * range_rad {
            self.reject(ReasonCode::Quantised, text);
        } else {
            self.note(ReasonCode::Quantised, text);
        }
    }
    /// A heading that was interpolated or held is why it is new too seldom.
    fn held_comes_first(&mut self) {
        let is_held =
            |reason: &Reason| reason.kind() == ReasonCode::SampledTooSeldom.of(Subject::Heading);
        if let Some(held) = self.notes.iter().position(is_held) {
            self.rejections.push(self.notes.remove(held));
        }
    }

    /// A vehicle's time constant must hold several samples of each channel: how the rudder moved in between is not known.
    fn pace(&mut self, evidence: &ModelEvidence) {
        let Some(pace) = evidence.log.pace else {
            return;
        };
        // The slowest vehicle of the interval: it is refused where even that one is sampled too seldom.
        let slowest_per_s = match &evidence.choice.refined {
            Some(refined) => {
                let [low, high] = refined.interval_95.a22_per_s;
                // 0 where the interval holds it.
                low.max(-high).max(0.0)
            }
            // A vehicle that turns ever faster has no time constant.
            None => (-evidence.choice.model.a22_per_s).max(0.0),
        };
        let longest_s = LONGEST_INTERVAL / slowest_per_s;
        // Of rows so far apart the heading is enough.
        let rudder_s = match pace.rudder_s > pace.heading_s || pace.heading_s <= longest_s {
            true => pace.rudder_s,
            false => 0.0,
        };
        for (channel, interval_s) in [("heading", pace.heading_s), ("rudder", rudder_s)] {
            if interval_s > longest_s {
                self.held_comes_first();
                self.reject(
                    ReasonCode::SampledTooSeldom,
                    format!(
                        "the {channel} is new every {} s only, and the vehicle's time constant is {} s: log it at {} Hz or faster (ArduPilot: its own log has the rudder, RCOU, ten times a second whatever LOG_BITMASK says, and the heading at the loop's rate with fast attitude in it; a telemetry log has both with SERVO_OUTPUT_RAW and ATTITUDE requested at that rate)",
                        three_figures(interval_s),
                        three_figures(LONGEST_INTERVAL.recip() * longest_s),
                        three_figures((1.0 / longest_s).ceil())
                    ),
                );
            }
        }
    }
}
