//! An ordinary log as the likelihood takes it: legs without a gap, while the vehicle makes way.

use seatrial_core::Sample;

use crate::identify::pace::Pace;
use crate::likelihood::Leg;
use crate::likelihood::leg::deviation;
use crate::record::{GAP, logged_s, median, median_interval_s, turned_rad};

/// Most comparisons of a log: of more, those where the rudder works most are taken.
const MOST_COMPARISONS: usize = 20_000;

/// Comparisons of a part of a long log.
const PART: usize = 1_000;

/// Under this share of the usual speed the vehicle stops, drifts or turns on the spot.
const LEAST_SPEED: f64 = 0.4;

/// Fewest comparisons of a leg.
const FEWEST: usize = 20;

/// Samples of the speed that are averaged, s.
const SPEED_MEAN_S: f64 = 0.6;

/// All legs of a log.
#[derive(Clone, Debug)]
pub struct Legs {
    /// The legs.
    pub legs: Vec<Leg>,
    /// The usual interval between comparisons, s.
    pub interval_s: f64,
    /// The median speed of the legs, m/s, where it is logged: parameters are those at it.
    pub speed_m_s: Option<f64>,
    /// Share of the log that the legs hold.
    pub share: f64,
}

impl Legs {
    /// Of finite samples whose time increases. `None` where no leg is long enough.
    pub fn of(samples: &[Sample<f64>]) -> Option<Self> {
        let usual_s = median_interval_s(samples).filter(|h| *h > 0.0)?;
        let step = step(samples, usual_s);
        let speeds = usual_speeds(samples, usual_s);
        let total_s = logged_s(samples);
        let has_rate = has_gyro(samples);
        let mut parts: Vec<Vec<usize>> = vec![Vec::new()];
        for (i, sample) in samples.iter().enumerate() {
            let is_usable =
                speeds.as_ref().is_none_or(|(usual, speeds)| speeds[i] > LEAST_SPEED * usual)
                    && (!has_rate || sample.yaw_rate_rad_s.is_some_and(f64::is_finite));
            let last = parts.last().and_then(|part| part.last());
            let follows = last.is_none_or(|last| {
                *last + 1 == i && sample.time_s - samples[*last].time_s < GAP * usual_s
            });
            if !is_usable {
                continue;
            }
            if !follows {
                parts.push(Vec::new());
            }
            if let Some(part) = parts.last_mut() {
                part.push(i);
            }
        }
        let speed_m_s = speeds
            .as_ref()
            .and_then(|(_, speeds)| median(parts.iter().flatten().map(|i| speeds[*i]).collect()));
        let legs: Vec<Leg> = parts
            .iter()
            .filter(|part| part.len() / step >= FEWEST)
            .map(|part| {
                let own: Vec<Sample<f64>> = part.iter().map(|i| samples[*i]).collect();
                let speed = |i: usize| match (&speeds, speed_m_s) {
                    (Some((_, speeds)), Some(usual)) => speeds[part[i]] / usual,
                    _ => 1.0,
                };
                Leg::picked(&own, step, has_rate, speed)
            })
            .collect();
        let used_s: f64 = legs.iter().map(Leg::duration_s).sum();
        let interval_s = step as f64 * usual_s;
        (!legs.is_empty()).then_some(Self {
            legs: most_excited(legs, interval_s),
            interval_s,
            speed_m_s,
            share: used_s / total_s,
        })
    }

    /// From the first to the last comparison of the longest leg, s.
    pub fn longest_s(&self) -> f64 {
        self.legs.iter().map(Leg::duration_s).fold(0.0, f64::max)
    }

    /// Comparisons of all legs.
    pub fn len(&self) -> usize {
        self.legs.iter().map(Leg::len).sum()
    }

    /// The first part of the legs' time, and the rest.
    pub fn split(&self, share: f64) -> [Self; 2] {
        let wanted = (share * self.len() as f64) as usize;
        let mut parts = [Vec::new(), Vec::new()];
        let mut before = 0;
        for leg in &self.legs {
            let at = wanted.saturating_sub(before).min(leg.len());
            for (part, range) in parts.iter_mut().zip([0..at, at..leg.len()]) {
                if range.len() >= FEWEST {
                    part.push(leg.part(range));
                }
            }
            before += leg.len();
        }
        parts.map(|legs| Self { legs, ..self.clone() })
    }

    /// The legs with the rudder that its command leaves behind this play, rad.
    pub fn behind_play(&self, play_rad: f64) -> Self {
        Self {
            legs: (self.legs.iter()).map(|leg| leg.behind_play(play_rad)).collect(),
            ..self.clone()
        }
    }

    /// Largest command that acts for a hundredth of the time on either side of the middle one, rad.
    pub fn rudder_amplitude_rad(&self) -> f64 {
        let commands = self.commands().flatten().collect();
        let [least, most] = at_shares([0.01, 0.99], commands);
        0.5 * (most - least)
    }

    /// Rate of the command that it exceeds for a hundredth of the time, rad/s.
    pub fn rudder_rate_rad_s(&self) -> f64 {
        let moved_rad = |commands: Vec<f64>| -> Vec<f64> {
            let pairs = commands.windows(2);
            pairs.map(|pair| (pair[1] - pair[0]).abs()).collect()
        };
        let [fast] = at_shares([0.99], self.commands().flat_map(moved_rad).collect());
        fast / self.interval_s
    }

    fn commands(&self) -> impl Iterator<Item = Vec<f64>> {
        (self.legs.iter()).map(|leg| leg.smooth_commands(0.0, self.interval_s))
    }

    /// Mean size of the yaw rate that a filter saw, rad/s; 0 before one ran.
    pub fn mean_turning_rad_s(&self) -> f64 {
        let all = self.legs.iter().flat_map(|leg| &leg.turning_rad_s);
        all.sum::<f64>() / self.len().max(1) as f64
    }

    /// Standard deviation of the speed over its mean.
    pub fn speed_change(&self) -> f64 {
        let speeds: Vec<f64> = self.legs.iter().flat_map(|leg| leg.speed.iter().copied()).collect();
        deviation(&speeds)
    }

    /// The legs with speeds over the median speed of others.
    pub fn over_speed_of(&self, others: &Self) -> Self {
        let ratio = self.speed_m_s.zip(others.speed_m_s).map_or(1.0, |(own, other)| own / other);
        let mut scaled = self.clone();
        scaled.legs.iter_mut().flat_map(|leg| &mut leg.speed).for_each(|speed| *speed *= ratio);
        scaled
    }

    /// Standard deviation of the yaw rate, rad/s, by differences of the heading over several comparisons.
    pub fn yaw_rate_deviation_rad_s(&self) -> f64 {
        const OVER: usize = 5;
        let rates: Vec<f64> = self
            .legs
            .iter()
            .flat_map(|leg| {
                (OVER..leg.len()).map(|i| {
                    (leg.heading_rad[i] - leg.heading_rad[i - OVER])
                        / (leg.time_s[i] - leg.time_s[i - OVER])
                })
            })
            .collect();
        deviation(&rates).max(f64::MIN_POSITIVE)
    }
}

/// Samples from one comparison to the next: as often as the rudder is renewed. Closer ones would compare with a rudder that the log holds, and what
/// is left out between two of them the pilot has seen.
fn step(samples: &[Sample<f64>], usual_s: f64) -> usize {
    let renewed_s = Pace::of(samples).map_or(usual_s, |pace| pace.rudder_s);
    ((renewed_s / usual_s).round() as usize).max(1)
}

/// The parts of long legs in which the rudder works most, in order of time.
fn most_excited(legs: Vec<Leg>, interval_s: f64) -> Vec<Leg> {
    let total: usize = legs.iter().map(Leg::len).sum();
    if total <= MOST_COMPARISONS {
        return legs;
    }
    let mut parts: Vec<(f64, Leg)> = Vec::new();
    for leg in &legs {
        let commands = leg.smooth_commands(0.0, interval_s);
        for from in (0..leg.len()).step_by(PART) {
            let to = (from + PART).min(leg.len());
            if to - from > PART / 2 {
                let work = deviation(&commands[from..to - 1]);
                parts.push((work, leg.part(from..to)));
            }
        }
    }
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    parts.truncate(MOST_COMPARISONS / PART);
    let mut legs: Vec<Leg> = parts.into_iter().map(|(_, leg)| leg).collect();
    legs.sort_by(|a, b| a.time_s[0].total_cmp(&b.time_s[0]));
    legs
}

/// Most of a gyro's gain may be missing or too much, of what the heading turns.
const GYRO_ERROR: f64 = 0.1;

/// Is there a yaw rate that turns as the heading does?
fn has_gyro(samples: &[Sample<f64>]) -> bool {
    const OVER: usize = 10;
    let rated: Vec<&Sample<f64>> =
        samples.iter().filter(|s| s.yaw_rate_rad_s.is_some_and(f64::is_finite)).collect();
    if 2 * rated.len() < samples.len() {
        return false;
    }
    let (mut product, mut square) = (0.0, 0.0);
    for part in rated.windows(OVER + 1).step_by(OVER) {
        let turned: f64 = part.windows(2).map(|p| turned_rad(p[0], p[1])).sum();
        let rate = |s: &Sample<f64>| s.yaw_rate_rad_s.unwrap_or(0.0);
        let by_gyro: f64 = part
            .windows(2)
            .map(|p| 0.5 * (rate(p[0]) + rate(p[1])) * (p[1].time_s - p[0].time_s))
            .sum();
        product += turned * by_gyro;
        square += by_gyro * by_gyro;
    }
    (product / square - 1.0).abs() < GYRO_ERROR
}

/// The usual speed and the speed of each sample, averaged. `None` where most samples have none, or where the vehicle hardly moves.
fn usual_speeds(samples: &[Sample<f64>], usual_s: f64) -> Option<(f64, Vec<f64>)> {
    let known: Vec<f64> =
        samples.iter().filter_map(|s| s.surge_speed_m_s).filter(|u| u.is_finite()).collect();
    if 2 * known.len() < samples.len() {
        return None;
    }
    let usual = median(known.iter().copied().filter(|u| *u > 0.0).collect())?;
    let half = ((0.5 * SPEED_MEAN_S / usual_s) as usize).max(1);
    let mut last = usual;
    let filled: Vec<f64> = samples
        .iter()
        .map(|s| {
            last = s.surge_speed_m_s.filter(|u| u.is_finite()).unwrap_or(last);
            last
        })
        .collect();
    let mut sums = vec![0.0];
    for speed in &filled {
        sums.push(sums[sums.len() - 1] + speed);
    }
    let smooth = (0..filled.len())
        .map(|i| {
            let (from, to) = (i.saturating_sub(half), (i + half + 1).min(filled.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect();
    (usual > 0.0).then_some((usual, smooth))
}

/// The values that these shares of all are less than; 0 of none.
fn at_shares<const N: usize>(shares: [f64; N], mut values: Vec<f64>) -> [f64; N] {
    values.sort_by(f64::total_cmp);
    shares.map(|share| {
        let at = (share * values.len() as f64) as usize;
        values.get(at).copied().unwrap_or(0.0)
    })
}
