//! Strokes: the rudder laid to one hand and held, and chains of them.

use super::trace::Trace;
use crate::record::Window;

/// Fewer samples do not show that the rudder was held.
const LEAST_SAMPLES: usize = 4;

/// Half of a held stroke lies within this share of its median angle.
const HELD_WITHIN: f64 = 0.1;

/// The angles of successive strokes differ by less than this factor: the neutral angle is known to a tenth or so.
const SAME_ANGLE: f64 = 1.3;

/// Strokes follow each other within this share of the shorter one: the time that a servo takes.
const LARGEST_PAUSE: f64 = 0.5;

/// A peak of less than this share of the stroke before is none, and the last strokes of a chain are a
/// controller's way back where each is shorter than this share of the one before.
const BRIEF: f64 = 0.25;
const RECOVERY: f64 = 0.5;

/// The rudder beyond half a level on one hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub window: Window,
    pub is_positive: bool,
    /// Median angle from neutral, rad; `None` where the rudder was not held at about the level.
    pub held_rad: Option<f64>,
}

impl Stroke {
    pub fn duration_s(&self) -> f64 {
        self.window.to_s - self.window.from_s
    }

    fn is_followed_by(&self, next: &Self) -> bool {
        let (Some(angle), Some(next_angle)) = (self.held_rad, next.held_rad) else {
            return false;
        };
        let pause_s = next.window.from_s - self.window.to_s;
        let shorter_s = self.duration_s().min(next.duration_s());
        self.is_positive != next.is_positive
            && pause_s <= LARGEST_PAUSE * shorter_s
            && angle.max(next_angle) < SAME_ANGLE * angle.min(next_angle)
    }
}

/// Held strokes from hand to hand, at least one.
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
        let angles = self.strokes.iter().filter_map(|stroke| stroke.held_rad);
        angles.sum::<f64>() / self.strokes.len() as f64
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
    for stroke in trace.excursions(0.5 * level_rad) {
        if let Some(last) = chain.strokes.last()
            && stroke.window.to_s - stroke.window.from_s < BRIEF * last.duration_s()
        {
            continue;
        }
        let stroke = Stroke {
            window: stroke.window,
            is_positive: stroke.is_positive,
            held_rad: held_rad(trace, stroke.window, level_rad, &mut scratch),
        };
        let goes_on = chain
            .strokes
            .last()
            .is_some_and(|last| last.is_followed_by(&stroke));
        if !goes_on && !chain.strokes.is_empty() {
            chains.push(std::mem::take(&mut chain).without_recovery());
        }
        if stroke.held_rad.is_some() {
            chain.strokes.push(stroke);
        }
    }
    if !chain.strokes.is_empty() {
        chains.push(chain.without_recovery());
    }
    chains
}

/// The median angle from neutral, where it is near the level and the rudder was held there.
fn held_rad(trace: &Trace, window: Window, level_rad: f64, scratch: &mut Vec<f64>) -> Option<f64> {
    scratch.clear();
    scratch.extend(
        trace
            .rudder_rad(trace.indices(window))
            .iter()
            .map(|d| d.abs()),
    );
    if scratch.len() < LEAST_SAMPLES {
        return None;
    }
    let middle = scratch.len() / 2;
    let (_, median, _) = scratch.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    let root = std::f64::consts::SQRT_2;
    let is_near_level = (level_rad / root..level_rad * root).contains(&median);
    let held = scratch
        .iter()
        .filter(|angle| (**angle - median).abs() <= HELD_WITHIN * median)
        .count();
    (is_near_level && 2 * held >= scratch.len()).then_some(median)
}
