//! Strokes: the rudder deflected to one side and held, and chains of them.

use super::trace::{Excursion, Trace};
use crate::record::Window;

/// Fewer samples do not show that the rudder was held, nor what the vehicle made of it.
const LEAST_SAMPLES: usize = 8;

/// A stroke is beyond this share of its level, and is held between these. They overlap those of the next level by
/// [`SAME_ANGLE`], so that strokes alike lie at one level.
const BEYOND: f64 = 0.4;
const HELD_AT_LEVEL: (f64, f64) = (0.58, 1.51);

/// Half of a held stroke lies within this share of its median angle.
const HELD_WITHIN: f64 = 0.1;

/// The angles of successive strokes from neutral differ by less than this factor: the neutral angle is known to a tenth or so.
const SAME_ANGLE: f64 = 1.3;

/// A program that deflects a trimmed rudder by as much from zero to either side is this precise.
const SAME_FROM_ZERO: f64 = 1.05;

/// Strokes follow each other within this share of the shorter one: the time that a servo takes.
const LARGEST_PAUSE: f64 = 0.5;

/// A peak of less than this share of the stroke before is none, and the last strokes of a chain are a
/// controller's way back where each is shorter than this share of the one before.
const BRIEF: f64 = 0.25;
const RECOVERY: f64 = 0.5;

/// The rudder beyond a share of a level on one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub window: Window,
    pub is_positive: bool,
    /// `None` where the rudder was not held at about the level.
    pub held: Option<Hold>,
}

/// The part of a stroke in which the rudder was held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold {
    /// Median angle of the stroke from neutral, rad.
    pub angle_rad: f64,
    /// From the first to the last sample near that angle, s.
    pub duration_s: f64,
}

impl Stroke {
    pub fn duration_s(&self) -> f64 {
        self.window.to_s - self.window.from_s
    }

    /// Is this a brief peak right after the stroke, as of a controller that takes over?
    fn ends_in_peak(&self, excursion: &Excursion) -> bool {
        let length_s = excursion.window.to_s - excursion.window.from_s;
        let pause_s = excursion.window.from_s - self.window.to_s;
        length_s < BRIEF * self.duration_s() && pause_s <= length_s
    }

    fn is_followed_by(&self, next: &Self, trace: &Trace) -> bool {
        let (Some(held), Some(next_held)) = (self.held, next.held) else {
            return false;
        };
        let trim_rad = trace.trim_rad(self.is_positive);
        let from_neutral = [held.angle_rad, next_held.angle_rad];
        let from_zero = [held.angle_rad + trim_rad, next_held.angle_rad - trim_rad];
        let are_alike = |[a, b]: [f64; 2], factor: f64| a.max(b) < factor * a.min(b);
        let pause_s = next.window.from_s - self.window.to_s;
        let shorter_s = self.duration_s().min(next.duration_s());
        self.is_positive != next.is_positive
            && pause_s <= LARGEST_PAUSE * shorter_s
            && (are_alike(from_neutral, SAME_ANGLE) || are_alike(from_zero, SAME_FROM_ZERO))
    }
}

/// Hold strokes from side to side, at least one.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    pub strokes: Vec<Stroke>,
}

impl Chain {
    pub fn window(&self) -> Window {
        Window {
            from_s: self.strokes.first().map_or(0.0, |s| s.window.from_s),
            to_s: self.strokes.last().map_or(0.0, |s| s.window.to_s),
        }
    }

    pub fn amplitude_rad(&self) -> f64 {
        let held = self.strokes.iter().filter_map(|stroke| stroke.held);
        held.map(|held| held.angle_rad).sum::<f64>() / self.strokes.len() as f64
    }

    fn without_recovery(mut self) -> Self {
        while let [.., before, last] = self.strokes.as_slice()
            && last.duration_s() < RECOVERY * before.duration_s()
        {
            self.strokes.pop();
        }
        self
    }
}

/// The chains of strokes at one level of rudder.
pub(super) fn chains(trace: &Trace, level_rad: f64) -> Vec<Chain> {
    let mut chains = Vec::new();
    let mut chain = Chain::default();
    let mut scratch = Vec::new();
    for excursion in trace.excursions(BEYOND * level_rad) {
        if chain.strokes.last().is_some_and(|last| last.ends_in_peak(&excursion)) {
            continue;
        }
        let stroke = Stroke {
            window: excursion.window,
            is_positive: excursion.is_positive,
            held: held(trace, &excursion, level_rad, &mut scratch),
        };
        let goes_on = chain.strokes.last().is_some_and(|last| last.is_followed_by(&stroke, trace));
        if !goes_on && !chain.strokes.is_empty() {
            chains.push(std::mem::take(&mut chain).without_recovery());
        }
        if stroke.held.is_some() {
            chain.strokes.push(stroke);
        }
    }
    if !chain.strokes.is_empty() {
        chains.push(chain.without_recovery());
    }
    chains
}

/// How the rudder was held, if it was, and near the level.
fn held(
    trace: &Trace,
    excursion: &Excursion,
    level_rad: f64,
    scratch: &mut Vec<f64>,
) -> Option<Hold> {
    let indices = trace.indices(excursion.window);
    scratch.clear();
    scratch.extend(trace.rudder_rad(indices.clone()).iter().map(|d| d.abs()));
    if scratch.len() < LEAST_SAMPLES {
        return None;
    }
    let middle = scratch.len() / 2;
    let (_, median, _) = scratch.select_nth_unstable_by(middle, f64::total_cmp);
    let angle_rad = *median;
    let (least, most) = HELD_AT_LEVEL;
    let from_zero_rad = angle_rad + trace.trim_rad(excursion.is_positive);
    let is_near_level = [angle_rad, from_zero_rad]
        .iter()
        .any(|angle_rad| (least * level_rad..most * level_rad).contains(angle_rad));
    let is_near = |d: &f64| (d.abs() - angle_rad).abs() <= HELD_WITHIN * angle_rad;
    let rudder_rad = trace.rudder_rad(indices.clone());
    let count = rudder_rad.iter().filter(|d| is_near(d)).count();
    if !is_near_level || 2 * count < rudder_rad.len() {
        return None;
    }
    let first = rudder_rad.iter().position(is_near)?;
    let last = rudder_rad.iter().rposition(is_near)?;
    Some(Hold {
        angle_rad,
        duration_s: trace.duration_s(&(indices.start + first..indices.start + last + 1)),
    })
}
