//! What a compass does to a model where it disagrees with the gyro.
//!
//! Validation data pass through the same compass, so that no validation shows these. Without a gyro in the record nothing does:
//! swing the compass, and read it with its own time.

use super::{Share, Weighing};
use crate::figures::{degrees, percent, three_figures, with_decimals};
use crate::identification::{Reason, ReasonCode, Refined, Subject};
use crate::identify::compass::Jump;
use crate::identify::model_evidence::ModelEvidence;

/// Half widths of the 95 % interval that an error of the compass may take of a parameter, of which 3 are never to be exceeded.
const HALF_WIDTHS: f64 = 1.5;
/// Share of b2 that an error of scale may take whatever the interval, and that it may never take: a gyro's scale is good to 3 %.
const SCALE_ERROR: [f64; 2] = [0.03, 0.05];
/// A yaw rate that is late by this is named, s.
const LATE_YAW_RATE_S: f64 = 0.02;
/// Share of a22 that a late heading may take whatever the interval, and that it may never take: one sample late is 8 to 11 %.
const LATE_EFFECT: [f64; 2] = [0.08, 0.15];

impl Weighing {
    pub(super) fn jump(&mut self, jump: Jump, at: &str) {
        let (size, time) = (degrees(jump.size_rad), with_decimals(jump.time_s, 1));
        let reason = Reason::new(
            ReasonCode::CompassError,
            format!(
                "within a second {at} the heading parts by {size} deg from where the yaw rate takes it, at {time} s, which no vehicle does: the compass jumped, stuck or was disturbed, or the clock jumped; repeat the run, away from iron and electric currents"
            ),
        );
        self.rejections.push(Reason {
            text: format!(
                "At {time} s the compass jumped, stuck or was disturbed: it was off by {size} deg within a second."
            ),
            action: "Repeat the run away from iron and electric currents, or take the gyro's integral for the heading: --heading and the column of the yaw rate.".into(),
            ..reason
        });
    }

    /// A heading that is late by a share of the vehicle's time constant makes a22 smaller by some twice that share.
    pub(super) fn compass(&mut self, evidence: &ModelEvidence) {
        let found = &evidence.log.compass;
        if let Some(jump) = found.largest_jump.filter(|_| !evidence.log.times_are_shared) {
            self.jump(jump, "in training");
        }
        let refined = evidence.choice.refined.as_ref();
        let half_width = |of: fn(&Refined) -> (f64, [f64; 2])| {
            refined
                .map(of)
                .map_or(f64::INFINITY, |(value, interval)| Share::new(value, interval).half_width)
        };
        let limit = |half_width: f64, [least, most]: [f64; 2]| {
            (HALF_WIDTHS * half_width).max(least).min(most)
        };
        let b2 = half_width(|refined| (refined.model.b2_per_s2, refined.interval_95.b2_per_s2));
        if let Some(scale) = found.scale_error.filter(|x| x.abs() > limit(b2, SCALE_ERROR)) {
            let (share, more) = (percent(scale.abs()), if scale > 0.0 { "more" } else { "less" });
            self.reject(
                ReasonCode::YawRateContradicts.of(Subject::Heading),
                format!(
                    "the heading changes by {share} % {more} than the yaw rate says, and b2 is wrong by as much: the compass deviates on these headings, or the gyro's scale is wrong; swing the compass, or turn a full circle and compare the gyro's angle with 360 deg"
                ),
            );
        }
        let a22 = half_width(|refined| (refined.model.a22_per_s, refined.interval_95.a22_per_s));
        let effect = |late_s: f64| 2.0 * late_s * evidence.online.a22_per_s.abs();
        if let Some(late_s) = found.late_s.filter(|x| effect(*x) > limit(a22, LATE_EFFECT)) {
            self.reject(
                ReasonCode::Late.of(Subject::Heading),
                format!(
                    "the heading is {} s later than the yaw rate, which makes the vehicle look slower than it is: the compass is filtered, held, or logged with the time of its arrival; log it with the time of the measurement, or identify from the gyro's attitude",
                    three_figures(late_s)
                ),
            );
        }
        if let Some(late_s) = found.yaw_rate_late_s().filter(|x| *x > LATE_YAW_RATE_S) {
            self.note(
                ReasonCode::Late.of(Subject::YawRate),
                format!(
                    "the yaw rate is {} s later than the heading, as a filter of the gyro makes it (ArduPilot's INS_GYRO_FILTER): it was compared at its own time, and the model does not use it; a controller that does needs it earlier",
                    three_figures(late_s)
                ),
            );
        }
    }
}
