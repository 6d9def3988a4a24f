//! Stopping: the way from the order of the engine to the end of the speed.

use seatrial_core::Sample;
use serde::Serialize;

use super::{Instant, NoManoeuvre, track, track_m};

/// The part of its speed at which a coasting ship counts as stopped.
const COASTED: f64 = 0.2;
/// Thrust below this share of that at the beginning is the order to stop.
const ORDERED: f64 = 0.1;
/// A speed has begun to fall for certain at this share of that at the beginning.
const FALLEN: f64 = 0.9;
/// Samples at the beginning whose mean is the speed before the order.
const FIRST: usize = 5;
/// Deviations of the noise, and the share of the speed, by which it falls where it begins to.
const DEVIATIONS: f64 = 3.0;
const LEAST_FALL: f64 = 1e-3;

/// What a ship needs to stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stopping {
    /// Is it dead in the water at the end? Else it coasted to a fifth of its speed.
    pub is_dead_in_the_water: bool,
    /// Along its track, m.
    pub track_reach_m: f64,
    /// Along its heading at the order, m.
    pub head_reach_m: f64,
    /// Across it, m, positive to starboard.
    pub lateral_deviation_m: f64,
    /// From the order on, s.
    pub time_s: f64,
    /// Speed at the order, m/s.
    pub surge_speed_m_s: f64,
}

/// The stop of a record: from where the thrust is taken away or, where it is not logged, from where the speed begins to fall.
pub(super) fn stopping(samples: &[Sample<f64>]) -> Result<Stopping, NoManoeuvre> {
    let track = track(samples)?;
    let speeds_m_s = speeds_m_s(samples, &track);
    let before_m_s = before_m_s(&speeds_m_s);
    let least_m_s = speeds_m_s.iter().copied().fold(f64::INFINITY, f64::min);
    if !(before_m_s > 0.0 && least_m_s <= COASTED * before_m_s) {
        return Err(NoManoeuvre::NotStopped { percent: 100.0 * least_m_s / before_m_s });
    }
    let order = order(samples, &speeds_m_s, before_m_s);
    let reaches = |end_m_s: f64| {
        let after = |k: &usize| speeds_m_s[*k] <= end_m_s;
        (order + 1..speeds_m_s.len()).find(after)
    };
    let (is_dead_in_the_water, end_m_s, end) = match reaches(0.0) {
        Some(end) => (true, 0.0, end),
        None => {
            let end_m_s = COASTED * before_m_s;
            let end = reaches(end_m_s).ok_or(NoManoeuvre::NotStopped { percent: 100.0 })?;
            (false, end_m_s, end)
        }
    };
    let share = (speeds_m_s[end - 1] - end_m_s) / (speeds_m_s[end - 1] - speeds_m_s[end]);
    let between = |of: fn(&Instant) -> f64| {
        let [a, b] = [end - 1, end].map(|k| of(&track[k]));
        a + share * (b - a)
    };
    let start = track[order];
    let (sin, cos) = libm::sincos(start.heading_rad);
    let north_m = between(|at| at.north_m) - start.north_m;
    let east_m = between(|at| at.east_m) - start.east_m;
    Ok(Stopping {
        is_dead_in_the_water,
        track_reach_m: track_m(&track[order..end]) + share * track_m(&track[end - 1..=end]),
        head_reach_m: north_m * cos + east_m * sin,
        lateral_deviation_m: east_m * cos - north_m * sin,
        time_s: between(|at| at.time_s) - start.time_s,
        surge_speed_m_s: before_m_s,
    })
}

/// The speed before the order, m/s. Where it falls from the first sample on, that sample is the order.
fn before_m_s(speeds_m_s: &[f64]) -> f64 {
    let first = &speeds_m_s[..FIRST.min(speeds_m_s.len())];
    let mean_m_s = first.iter().sum::<f64>() / first.len() as f64;
    let fallen_m_s = first[0] - first[first.len() - 1];
    if fallen_m_s > fall_m_s(speeds_m_s, mean_m_s) { first[0] } else { mean_m_s }
}

/// By how much a speed has to fall so that it is no noise, m/s.
fn fall_m_s(speeds_m_s: &[f64], before_m_s: f64) -> f64 {
    (DEVIATIONS * noise_m_s(speeds_m_s)).max(LEAST_FALL * before_m_s)
}

/// The forward speed of each sample; where it was not measured, the change of position along the heading.
fn speeds_m_s(samples: &[Sample<f64>], track: &[Instant]) -> Vec<f64> {
    let measured: Option<Vec<f64>> = samples.iter().map(|s| s.surge_speed_m_s).collect();
    measured.unwrap_or_else(|| {
        (0..track.len())
            .map(|k| {
                let (from, to) = (k.saturating_sub(1), (k + 1).min(track.len() - 1));
                let (a, b) = (track[from], track[to]);
                let (sin, cos) = libm::sincos(track[k].heading_rad);
                let way_m = (b.north_m - a.north_m) * cos + (b.east_m - a.east_m) * sin;
                way_m / (b.time_s - a.time_s)
            })
            .collect()
    })
}

/// The sample of the order.
fn order(samples: &[Sample<f64>], speeds_m_s: &[f64], before_m_s: f64) -> usize {
    let full = samples.first().and_then(|s| s.thrust).filter(|t| *t > 0.0);
    let ordered = full.and_then(|full| {
        let is_ordered = |s: &Sample<f64>| s.thrust.is_some_and(|now| now <= ORDERED * full);
        samples.iter().position(is_ordered)
    });
    ordered.unwrap_or_else(|| {
        let fallen = speeds_m_s.iter().position(|speed| *speed < FALLEN * before_m_s).unwrap_or(0);
        let least_m_s = before_m_s - fall_m_s(speeds_m_s, before_m_s);
        let holds = |speed: &f64| *speed >= least_m_s;
        speeds_m_s[..fallen].iter().rposition(holds).unwrap_or(0)
    })
}

/// Noise of the speed from its third differences, m/s.
fn noise_m_s(speeds_m_s: &[f64]) -> f64 {
    let squares: f64 =
        speeds_m_s.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).sum();
    (squares / (20.0 * speeds_m_s.len() as f64)).sqrt()
}
