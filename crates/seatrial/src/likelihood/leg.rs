//! A stretch of record without a gap, as the likelihood compares it.

use std::ops::Range;
use std::sync::Arc;

use seatrial_core::Sample;

use crate::record_series::RecordSeries;

/// Parts of an interval over which the rudder is a mean, and at most where the gear is not linear and where a stroke begins matters.
pub const PARTS: usize = 3;
const MOST_PARTS: usize = 12;

/// Share of the usual interval over which a smooth command is averaged.
const AVERAGE: f64 = 0.1;

/// A command that stays from one change to the next, before the first as it is there, and its integrals.
#[derive(Clone, Debug)]
struct Commands {
    change_s: Vec<f64>,
    command_rad: Vec<f64>,
    /// First and second integral of the command up to each change, rad s and rad s^2.
    integrals: Vec<[f64; 2]>,
}

/// Integrals of a command up to times that do not go back, each read so much later.
struct Cursor<'a> {
    commands: &'a Commands,
    at: usize,
    by_s: f64,
}

/// Headings at their times, and the command.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Times of the comparisons, s.
    pub time_s: Vec<f64>,
    /// Headings of the comparisons, rad, unwrapped, from the first.
    pub heading_rad: Vec<f64>,
    /// Yaw rates there, rad/s; empty where none is measured or taken.
    pub yaw_rate_rad_s: Vec<f64>,
    /// Speeds there over the usual one; empty where they do not matter.
    pub speed: Vec<f64>,
    /// Size of the yaw rate that a filter saw until then, rad/s; empty before one ran.
    pub turning_rad_s: Vec<f64>,
    /// The command, which the parts of a leg share.
    commands: Arc<Commands>,
    /// Samples of a comparison.
    block: usize,
}

impl Leg {
    /// Means of `block` samples each, with times from the first. The command is kept whole: thinning the heading never thins the rudder.
    ///
    /// `samples` are finite and increase in time; headings may be wrapped.
    ///
    /// ```
    /// use seatrial::Sample;
    /// use seatrial::likelihood::Leg;
    ///
    /// // Means of four samples each, across north.
    /// let samples: Vec<_> = (0..40)
    ///     .map(|k| Sample {
    ///         time_s: 0.1 * f64::from(k),
    ///         heading_rad: (6.2 + 0.01 * f64::from(k)) % 6.2832,
    ///         ..Sample::default()
    ///     })
    ///     .collect();
    /// let leg = Leg::new(&samples, 4);
    /// assert_eq!(leg.len(), 10);
    /// assert!((leg.duration_s() - 3.6).abs() < 1e-9);
    /// assert!((leg.heading_rad[9] - leg.heading_rad[0] - 0.36).abs() < 1e-3);
    /// ```
    pub fn new(samples: &[Sample<f64>], block: usize) -> Self {
        let block = block.max(1);
        let series = RecordSeries::new(samples, 1);
        let start_s = samples.first().map_or(0.0, |s| s.time_s);
        let time_s: Vec<f64> = samples.iter().map(|s| s.time_s - start_s).collect();
        let means = |of: &[f64]| -> Vec<f64> {
            let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
            of.chunks_exact(block).map(mean).collect()
        };
        Self {
            block,
            heading_rad: means(&series.heading_rad),
            time_s: means(&time_s),
            yaw_rate_rad_s: Vec::new(),
            speed: Vec::new(),
            turning_rad_s: Vec::new(),
            commands: Arc::new(Commands::new(time_s, series.rudder_rad)),
        }
    }

    /// Every `step`th sample, with the yaw rate where there `has_rate` and with speeds over the usual one by the place of the sample.
    pub fn picked(
        samples: &[Sample<f64>],
        step: usize,
        has_rate: bool,
        speed: impl Fn(usize) -> f64,
    ) -> Self {
        let times = samples.iter().map(|s| s.time_s).collect();
        let commands = samples.iter().map(|s| s.rudder_rad).collect();
        let unwrapped = RecordSeries::new(samples, 1).heading_rad;
        let picked = || (0..samples.len()).step_by(step);
        let rate = |i: usize| samples[i].yaw_rate_rad_s.unwrap_or(0.0);
        Self {
            block: 1,
            time_s: picked().map(|i| samples[i].time_s).collect(),
            heading_rad: picked().map(|i| unwrapped[i]).collect(),
            yaw_rate_rad_s: picked().filter(|_| has_rate).map(rate).collect(),
            speed: picked().map(speed).collect(),
            turning_rad_s: Vec::new(),
            commands: Arc::new(Commands::new(times, commands)),
        }
    }

    /// The leg with the rudder that its command leaves behind this play, rad.
    pub fn behind_play(&self, play_rad: f64) -> Self {
        let fin_rad = fin_behind(&self.commands.command_rad, play_rad);
        Self {
            commands: Arc::new(Commands::new(self.commands.change_s.clone(), fin_rad)),
            ..self.clone()
        }
    }

    /// Some of the comparisons, with the whole command.
    pub fn part(&self, range: Range<usize>) -> Self {
        let of = |values: &[f64]| values.get(range.clone()).unwrap_or_default().to_vec();
        Self {
            time_s: of(&self.time_s),
            heading_rad: of(&self.heading_rad),
            yaw_rate_rad_s: of(&self.yaw_rate_rad_s),
            speed: of(&self.speed),
            turning_rad_s: of(&self.turning_rad_s),
            ..self.clone()
        }
    }

    /// Number of comparisons.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Has the leg no comparison?
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// From the first to the last comparison, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Parts of an interval at which the record of the rudder is fine enough for a gear that is not linear.
    pub fn fine_parts(&self) -> usize {
        self.block.clamp(PARTS, MOST_PARTS)
    }

    /// Mean command over so many parts of each interval between comparisons, rad, where it acts `shift_s` later than recorded.
    pub fn commands(&self, shift_s: f64, parts: usize) -> Vec<f64> {
        let mut commands = Vec::with_capacity(parts * self.len());
        let Some(first_s) = self.time_s.first() else {
            return commands;
        };
        let mut upto = self.commands.from(*first_s, -shift_s);
        let mut before = upto.once(*first_s);
        for pair in self.time_s.windows(2) {
            let part_s = (pair[1] - pair[0]) / parts as f64;
            for part in 1..=parts {
                let now = upto.once(pair[0] + part as f64 * part_s);
                commands.push((now - before) / part_s);
                before = now;
            }
        }
        commands
    }

    /// Mean command over each interval between comparisons, rad, where it acts `shift_s` later than logged, averaged over a tenth of the usual
    /// interval about each instant.
    ///
    /// A record that is held between samples has corners in the shift. A longer mean would show the likelihood commands that answer what it is
    /// about to predict.
    pub fn smooth_commands(&self, shift_s: f64, usual_s: f64) -> Vec<f64> {
        let mean_s = AVERAGE * usual_s;
        let half_s = 0.5 * mean_s;
        let first_s = self.time_s.first().copied().unwrap_or(0.0);
        let mut upto = [-half_s, half_s].map(|by_s| self.commands.from(first_s, by_s - shift_s));
        let mut smooth = |time_s: f64| (upto[1].twice(time_s) - upto[0].twice(time_s)) / mean_s;
        let mut before = self.time_s.first().map_or(0.0, |first| smooth(*first));
        self.time_s
            .windows(2)
            .map(|pair| {
                let now = smooth(pair[1]);
                let mean = (now - before) / (pair[1] - pair[0]);
                before = now;
                mean
            })
            .collect()
    }

    /// Speed over the usual one in the middle of the interval after a comparison, where it is logged so much late.
    pub fn speed_at(&self, i: usize, late_s: f64) -> f64 {
        let h = self.duration_s() / (self.len().max(2) - 1) as f64;
        let at = (i as f64 + 0.5 + late_s / h).clamp(0.0, (self.len() - 1) as f64);
        let (before, share) = (at as usize, at.fract());
        let after = (before + 1).min(self.len() - 1);
        self.speed[before] + share * (self.speed[after] - self.speed[before])
    }

    /// Angles over parts of the intervals between comparisons, averaged over as long as the headings of a comparison are.
    ///
    /// A mean of `block` samples in a row has the spread of one over sqrt(1 - 1/block^2) of their interval. Without it a step of the rudder is
    /// compared with a heading that turns half a block before: a22 of a slow gear was wrong by 2.5 % where a block was half the time constant.
    pub fn averaged(&self, angles_rad: Vec<f64>, parts: usize) -> Vec<f64> {
        let block = self.block as f64;
        let width = (1.0 - 1.0 / (block * block)).sqrt() * parts as f64;
        let count = angles_rad.len();
        if width == 0.0 || count == 0 {
            return angles_rad;
        }
        // Parts for seconds.
        let angles = Commands::new((0..count).map(|part| part as f64).collect(), angles_rad);
        let mut upto = [-0.5 * width, 0.5 * width].map(|by| angles.from(0.0, by));
        let mut about = |part: usize| upto[1].twice(part as f64) - upto[0].twice(part as f64);
        let mut before = about(0);
        (1..=count)
            .map(|part| {
                let now = about(part);
                let mean = (now - before) / width;
                before = now;
                mean
            })
            .collect()
    }

    /// Standard deviation of the heading, rad.
    pub fn heading_deviation_rad(&self) -> f64 {
        deviation(&self.heading_rad)
    }

    /// Slopes of the heading between comparisons, rad/s.
    pub fn slopes_rad_s(&self) -> Vec<f64> {
        (self.heading_rad.windows(2).zip(self.time_s.windows(2)))
            .map(|(psi, t)| (psi[1] - psi[0]) / (t[1] - t[0]))
            .collect()
    }
}

impl Commands {
    /// Of commands, rad, from their times on, s.
    fn new(change_s: Vec<f64>, command_rad: Vec<f64>) -> Self {
        let (mut once, mut twice) = (0.0, 0.0);
        let mut integrals = vec![[0.0; 2]];
        for (times, command) in change_s.windows(2).zip(&command_rad) {
            let h = times[1] - times[0];
            twice += h * (once + 0.5 * h * command);
            once += h * command;
            integrals.push([once, twice]);
        }
        Self { change_s, command_rad, integrals }
    }

    /// Integrals at times from this one on, s, each read `by_s` later.
    fn from(&self, time_s: f64, by_s: f64) -> Cursor<'_> {
        let after = self.change_s.partition_point(|change_s| *change_s <= time_s + by_s);
        Cursor { commands: self, at: after.saturating_sub(1), by_s }
    }
}

impl Cursor<'_> {
    /// The change before a time, and the seconds since.
    fn since_s(&mut self, time_s: f64) -> f64 {
        let (changes, time_s) = (&self.commands.change_s, time_s + self.by_s);
        while changes.get(self.at + 1).is_some_and(|s| *s <= time_s) {
            self.at += 1;
        }
        time_s - changes[self.at]
    }

    /// The integral of the command, rad s.
    fn once(&mut self, time_s: f64) -> f64 {
        let since_s = self.since_s(time_s);
        self.commands.integrals[self.at][0] + since_s * self.commands.command_rad[self.at]
    }

    /// The integral of that, rad s^2.
    fn twice(&mut self, time_s: f64) -> f64 {
        let since_s = self.since_s(time_s);
        let [once, twice] = self.commands.integrals[self.at];
        twice + since_s * (once + 0.5 * since_s * self.commands.command_rad[self.at])
    }
}

/// The fin behind play, rad: at rest it stands where the first command is.
///
/// ```text
/// f_k = min(max(f_(k-1), u_k - p/2), u_k + p/2),   f_0 = u_0
/// ```
pub fn fin_behind(rudder_rad: &[f64], play_rad: f64) -> Vec<f64> {
    let half_rad = 0.5 * play_rad;
    let mut fin_rad = rudder_rad.first().copied().unwrap_or(0.0);
    (rudder_rad.iter())
        .map(|command_rad| {
            fin_rad = fin_rad.clamp(command_rad - half_rad, command_rad + half_rad);
            fin_rad
        })
        .collect()
}

/// Parts of each interval between comparisons.
pub fn parts_of(angles: &[f64], leg: &Leg) -> usize {
    (angles.len() / leg.len().saturating_sub(1).max(1)).max(1)
}

/// Standard deviation of values; 0 where there are none.
pub fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::filter::innovations;
    use super::super::gear::angles;
    use super::super::motion::Start;
    use super::super::steering_model::{SteeringModel, SteeringState};
    use super::*;

    /// Blocks of half the time constant, a gear that is slower than a block, and no noise: the true vehicle explains the means of headings.
    #[test]
    fn exact_means_of_headings_follow_means_of_the_rudder() {
        let model = SteeringModel {
            a22_per_s: -0.1,
            b2_per_s2: 0.01,
            rate_limit_rad_s: Some(0.04),
            ..SteeringModel::default()
        };
        let rudder_rad = |row: usize| match row / 60 {
            0 => 0.0,
            strokes if strokes % 2 == 1 => 0.6,
            _ => -0.6,
        };
        let mut samples: Vec<Sample<f64>> = (0..600)
            .map(|row| Sample {
                time_s: 0.5 * row as f64,
                rudder_rad: rudder_rad(row),
                ..Sample::default()
            })
            .collect();
        let states = model.simulate(&samples, SteeringState::default());
        for (sample, state) in samples.iter_mut().zip(states) {
            sample.heading_rad = state.heading_rad;
        }
        // Of an odd number, whose middle is a sample: the rudder changes between parts.
        let leg = Leg::new(&samples, 11);
        let (vehicle, range) = (model.vehicle(), [0, leg.len()]);
        let angles = angles(&leg, &vehicle);
        let errors = innovations(&leg, range, &vehicle, &Start::default(), None, &angles);
        let most = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        // 1.4e-4 rad; instants in the place of means are off by 4.4e-3.
        assert!(most < 3e-4, "{most}");
    }
}
