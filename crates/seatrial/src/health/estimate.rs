//! Estimates of watched windows, and of missions as a whole.

use seatrial_core::Sample;

use super::not_compared::NotCompared;
use crate::identification::Refined;
use crate::identify::mission::is_ordinary_steering;
use crate::identify::{IdentifySettings, identify};
use crate::record::{Record, Window, mean, median};

/// The halves of a window differ in mean speed by less than this share of it.
const STEADY_SPEED: f64 = 0.05;

/// The models of a log of ordinary steering, each of a part without a gap this long, s, with its window and its median speed, m/s: the interval
/// allows for the sea and for a rudder that answers the heading. Empty where the log is none, or where no part has an accepted model.
pub(super) fn missions(record: &Record, longest_gap_s: f64) -> Vec<(Window, Option<f64>, Refined)> {
    if !is_ordinary_steering(&record.samples) {
        return Vec::new();
    }
    let is_whole = |a: &Sample<f64>, b: &Sample<f64>| b.time_s - a.time_s < longest_gap_s;
    let parts = record.samples.chunk_by(is_whole);
    parts.filter_map(|part| mission(record, part)).collect()
}

fn mission(record: &Record, part: &[Sample<f64>]) -> Option<(Window, Option<f64>, Refined)> {
    let part = Record { samples: part.to_vec(), ..*record };
    let found = identify(&part, Window::ALL, None, &IdentifySettings::default()).ok()?;
    let refined = found.refined.filter(|_| found.verdict.accepted)?;
    let speeds = part.samples.iter().filter_map(|s| s.surge_speed_m_s);
    let speed = median(speeds.filter(|speed| speed.is_finite()).collect());
    Some((Window::ALL.known_part(&part.samples), speed, refined))
}

/// The estimate of a window in which something else than the rudder turns the vehicle as well. With sway or a slow servo
/// the verdict accepts it, under a disturbance that is too strong it does not. Which of the two it is the window does not say, so
/// the covariance is that of both.
pub(super) fn accepted_estimate(
    record: &Record,
    window: Window,
    refined: &Refined,
) -> Result<Refined, NotCompared> {
    let accepted = identify(record, window, None, &IdentifySettings::default())
        .ok()
        .filter(|identification| identification.verdict.accepted)
        .and_then(|identification| identification.refined)
        .ok_or(NotCompared::Disturbed)?;
    let covariance = std::array::from_fn(|i| {
        std::array::from_fn(|j| accepted.covariance[i][j] + refined.covariance[i][j])
    });
    Ok(Refined { covariance, ..accepted })
}

/// The mean speed of a window, `None` where there is no speed, or why there is none.
pub(super) fn steady_speed_m_s(samples: &[Sample<f64>]) -> Result<Option<f64>, NotCompared> {
    let mean = |samples: &[Sample<f64>]| {
        let speeds = samples.iter().filter_map(|s| s.surge_speed_m_s);
        mean(speeds.filter(|speed| speed.is_finite()))
    };
    let (early, late) = samples.split_at(samples.len() / 2);
    let (Some(early), Some(late)) = (mean(early), mean(late)) else {
        return Ok(mean(samples));
    };
    let speed = 0.5 * (early + late);
    if (late - early).abs() > STEADY_SPEED * speed.abs() {
        return Err(NotCompared::SpeedNotSteady);
    }
    Ok(Some(speed))
}
