//! The heading from the gyro, where the compass jumped and the gyro shows that the vehicle did not.
//!
//! ```text
//! psi(t) = alpha + beta t + P(t) + e(t),   P = int r dt;   the heading becomes alpha + beta t + P(t)
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | psi, r | heading of the compass and yaw rate of the gyro, rad and rad/s |
//! | alpha, beta | first heading; bias of the gyro, which the compass tells |
//! | e | error of the compass: noise in most rows, a jump, a halt or a disturbance in some |
//!
//! beta is the median slope of psi - P between rows a quarter of the record apart, and alpha the median of what is left (after Theil and Sen),
//! so that a quarter of the rows may be disturbed.

use seatrial_core::{Real, Sample};

use super::compass::{CompassError, Jump, LEAST_ERROR_RAD, MEAN_OVER_S, Path};
use super::joint_estimate::JointEstimate;
use super::{IdentifyError, RecordSurvey, ValidationData};
use crate::figures::{degrees, with_decimals};
use crate::identification::{Identification, Outcome, Reason, ReasonCode, Subject};
use crate::record::{Record, Window, between_gaps, median};

/// Gyro and compass turn by the same but for this share: beyond it either may be wrong.
const SCALE: f64 = 0.03;
/// Share of a22 that a shift between the two may take.
const LATE_EFFECT: f64 = 0.08;
/// A compass at fault moves this many times as fast as the gyro ever does: a gyro that fails for a while misses no more than once that. Those
/// of the Esso Osaka move 1.3 times as fast and more.
const TOO_FAST: f64 = 1.2;
/// Rows are far apart from this many usual intervals on.
const LONG_INTERVALS: f64 = 3.0;

/// An identification, and how manoeuvres were joined for it.
type Answer = (Identification, Option<JointEstimate>);

/// The identification of windows of a record, by the gyro's heading where the compass jumped and that makes the verdict a better one.
pub(super) fn where_the_compass_jumped(
    survey: &RecordSurvey,
    windows: &[Window],
    data: Option<ValidationData>,
    identify: impl Fn(&RecordSurvey, Option<ValidationData>) -> Result<Answer, IdentifyError>,
) -> Result<Answer, IdentifyError> {
    let record = survey.record();
    let (found, joined) = identify(survey, data)?;
    let is_refused = found.verdict.outcome() == Outcome::DoNotUse;
    if !(is_refused && found.verdict.has(&ReasonCode::CompassError)) {
        return Ok((found, joined));
    }
    let own = data.filter(|data| std::ptr::eq(data.record, record));
    let spans = windows.iter().copied().chain(own.map(|data| data.window));
    let a22_per_s = found.online.model.a22_per_s;
    let Some((by_gyro, jump)) = spans
        .reduce(|a, b| Window { from_s: a.from_s.min(b.from_s), to_s: a.to_s.max(b.to_s) })
        .and_then(|span| by_the_gyro(record, span, a22_per_s))
    else {
        return Ok((found, joined));
    };
    let data =
        data.map(|data| ValidationData { record: own.map_or(data.record, |_| &by_gyro), ..data });
    Ok(match identify(&RecordSurvey::of(&by_gyro), data) {
        Ok((again, joined)) if again.verdict.outcome() != Outcome::DoNotUse => {
            (with_the_remark(again, jump), joined)
        }
        _ => (found, joined),
    })
}

/// In place of the remark that no yaw rate checks the heading.
fn with_the_remark(mut found: Identification, jump: Jump) -> Identification {
    let (size, time) = (degrees(jump.size_rad), with_decimals(jump.time_s, 1));
    let reasons = &mut found.verdict.reasons;
    reasons.retain(|reason| reason.kind() != ReasonCode::Unchecked.of(Subject::Heading));
    let jumped = Reason {
        text: format!(
            "At {time} s the compass jumped, stuck or was disturbed by {size} deg, and the gyro did not: the integral of the yaw rate was used for the heading."
        ),
        ..Reason::new(
            ReasonCode::CompassError,
            "the bias of the gyro comes from the compass, and its scale is as good as the two agree: 3 %",
        )
    };
    reasons.insert(reasons.len().min(1), jumped);
    found
}

/// The samples of a span with the integral of the yaw rate for the heading, and the jump of the compass. `None` where no gyro is in
/// every row, the record has a gap, the compass did not jump, or the two do not agree elsewhere.
fn by_the_gyro(record: &Record, span: Window, a22_per_s: f64) -> Option<(Record, Jump)> {
    let mut samples = record.usable(span);
    if between_gaps(&samples).nth(1).is_some() {
        return None;
    }
    let jump = CompassError::of(&samples).largest_jump?;
    let fit = Fit::of(&samples)?;
    let jump_s = jump.time_s - samples[0].time_s;
    let is_proven =
        fit.clock_goes_on(jump_s) && fit.compass_is_too_fast(jump) && fit.agrees(a22_per_s);
    if !is_proven {
        return None;
    }
    for (sample, heading_rad) in samples.iter_mut().zip(fit.heading_rad()) {
        sample.heading_rad = Real::wrapped(heading_rad);
        sample.yaw_rate_rad_s = None;
    }
    let by_gyro = Record { samples, rudder_unit: record.rudder_unit, units: record.units };
    Some((by_gyro, jump))
}

/// The line that the compass leaves of the integral of the yaw rate over a span.
struct Fit {
    path: Path,
    /// What the compass shows beyond that integral, rad.
    error_rad: Vec<f64>,
    alpha_rad: f64,
    beta_rad_s: f64,
    /// Half of what the compass differs from that over a quarter of the span, rad, is less.
    typical_rad: f64,
}

impl Fit {
    fn of(samples: &[Sample<f64>]) -> Option<Self> {
        let path = Path::of(samples)?;
        let first_rad = samples.first()?.heading_rad;
        let (headings, turned) = (path.heading_rad.iter(), &path.turned_rad);
        let error_rad: Vec<f64> =
            headings.zip(turned).map(|(heading, turned)| first_rad + heading - turned).collect();
        let times_s = &path.times_s;
        let apart = (samples.len() / 4).max(1);
        let changes = |of: &[f64]| -> Vec<f64> {
            (of.iter().zip(&of[apart.min(of.len())..])).map(|(from, to)| to - from).collect()
        };
        let (passed_s, changed_rad) = (changes(times_s), changes(&error_rad));
        let slopes = changed_rad.iter().zip(&passed_s).map(|(e, t)| e / t);
        let beta_rad_s = median(slopes.collect())?;
        let left = changed_rad.iter().zip(&passed_s);
        let typical_rad = median(left.map(|(e, t)| (e - beta_rad_s * t).abs()).collect())?;
        let rest = error_rad.iter().zip(times_s);
        Some(Self {
            alpha_rad: median(rest.map(|(e, t)| e - beta_rad_s * t).collect())?,
            beta_rad_s,
            typical_rad,
            error_rad,
            path,
        })
    }

    fn heading_rad(&self) -> impl Iterator<Item = f64> {
        let line = self.path.times_s.iter().map(|t| self.alpha_rad + self.beta_rad_s * t);
        line.zip(&self.path.turned_rad).map(|(line, turned)| line + turned)
    }

    /// Are there no rows about the jump whose times are far apart? The clock may have jumped then.
    fn clock_goes_on(&self, jump_s: f64) -> bool {
        let interval_s = |pair: &[f64]| pair[1] - pair[0];
        let usual_s = median(self.path.times_s.windows(2).map(interval_s).collect());
        let is_near =
            |pair: &&[f64]| pair[0] < jump_s + MEAN_OVER_S && pair[1] > jump_s - MEAN_OVER_S;
        let near = self.path.times_s.windows(2).filter(is_near).map(interval_s);
        usual_s.is_some_and(|usual_s| near.fold(0.0, f64::max) < LONG_INTERVALS * usual_s)
    }

    /// Does the compass turn by more within the jump than the gyro ever does in that time?
    fn compass_is_too_fast(&self, jump: Jump) -> bool {
        let fastest_rad_s =
            (self.path.rates_rad_s.iter()).fold(0.0_f64, |most, rate| most.max(rate.abs()));
        jump.size_rad > TOO_FAST * fastest_rad_s * MEAN_OVER_S
    }

    /// Do the two turn by the same at the same time in the rows where the compass is not disturbed?
    fn agrees(&self, a22_per_s: f64) -> bool {
        let left =
            |k: usize| self.error_rad[k] - self.alpha_rad - self.beta_rad_s * self.path.times_s[k];
        let sound = (0..self.path.times_s.len()).filter(|k| left(*k).abs() < LEAST_ERROR_RAD);
        let columns = |k: usize| {
            [self.path.turned_rad[k], self.path.rates_rad_s[k], 1.0, self.path.times_s[k]]
        };
        let mut normal = nalgebra::Matrix4::zeros();
        let mut right = nalgebra::Vector4::zeros();
        for k in sound {
            let row = nalgebra::Vector4::from(columns(k));
            normal += row * row.transpose();
            right += row * left(k);
        }
        let found = normal.cholesky().map(|normal| normal.solve(&right));
        found.is_some_and(|found| {
            let (scale, late_s) = (found[0], found[1]);
            self.typical_rad < LEAST_ERROR_RAD
                && scale.abs() < SCALE
                && 2.0 * (late_s * a22_per_s).abs() < LATE_EFFECT
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::identify::{IdentifySettings, identify};

    const TURN_S: f64 = 20.0;

    /// Two doublets at 10 Hz of a vehicle with a22 = -0.9 and b2 = 0.9: what compass and gyro show at a time of heading and yaw rate.
    fn record(compass: impl Fn(f64, f64) -> f64, gyro: impl Fn(f64, f64) -> f64) -> Record {
        let (mut heading, mut rate, mut draw) = (0.5_f64, 0.0_f64, Draw::new(3));
        let interval_s = 0.1_f64;
        let decay = (-0.9 * interval_s).exp();
        let row = |k: i32| {
            let time_s = f64::from(k) * interval_s;
            let rudder_rad = match time_s % TURN_S {
                t if (4.0..6.0).contains(&t) => 0.3,
                t if (6.0..8.0).contains(&t) => -0.3,
                _ => 0.0,
            };
            let sample = Sample {
                time_s,
                heading_rad: Real::wrapped(compass(time_s, heading) + 0.002 * draw.normal()),
                yaw_rate_rad_s: Some(gyro(time_s, rate) + 0.001 * draw.normal()),
                rudder_rad,
                ..Sample::default()
            };
            heading += rudder_rad * interval_s + (rate - rudder_rad) * (1.0 - decay) / 0.9;
            rate = rudder_rad + (rate - rudder_rad) * decay;
            sample
        };
        (0..400).map(row).collect()
    }

    fn identified(record: &Record) -> Identification {
        let [training, window] =
            [0.0, TURN_S].map(|from_s| Window { from_s, to_s: from_s + TURN_S });
        let data = Some(ValidationData { record, window });
        identify(record, training, data, &IdentifySettings::default()).unwrap()
    }

    /// Off by 14 deg for a second and a half in the middle of a turn.
    fn disturbed(time_s: f64, heading_rad: f64) -> f64 {
        let is_disturbed = (6.0..7.5).contains(&time_s);
        heading_rad + if is_disturbed { 0.25 } else { 0.0 }
    }

    #[test]
    fn recover_a_vehicle_whose_compass_jumped_from_its_gyro() {
        let found = identified(&record(disturbed, |_, rate| rate + 0.003));
        assert_eq!(found.verdict.outcome(), Outcome::UseWithCare, "{found:?}");
        assert_eq!(found.verdict.cause().unwrap().code, ReasonCode::CompassError);
        let refined = found.refined.unwrap();
        let holds = |[low, high]: [f64; 2], truth: f64| low < truth && truth < high;
        assert!(holds(refined.interval_95.a22_per_s, -0.9), "{refined:?}");
        assert!(holds(refined.interval_95.b2_per_s2, 0.9), "{refined:?}");
    }

    /// The gyro that reads nothing for a second and a half, that has another scale, or that is not there, proves nothing.
    #[test]
    fn regress_a_gyro_that_fails_does_not_replace_the_compass() {
        let reads_nothing = |time_s: f64, rate: f64| match time_s {
            t if (6.0..7.5).contains(&t) => 0.0,
            _ => rate,
        };
        let without = Record {
            samples: (record(disturbed, |_, rate| rate).samples.into_iter())
                .map(|sample| Sample { yaw_rate_rad_s: None, ..sample })
                .collect(),
            ..Record::default()
        };
        for record in [
            record(|_, heading| heading, reads_nothing),
            record(disturbed, |_, rate| 1.1 * rate),
            without,
        ] {
            let found = identified(&record);
            let is_by_gyro = |reason: &Reason| reason.text.contains("the gyro did not");
            assert!(!found.verdict.reasons.iter().any(is_by_gyro), "{found:?}");
        }
    }
}
