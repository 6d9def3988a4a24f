//! The search for the largest posterior: Gauss and Newton's steps, or Fisher's scoring, with Levenberg's damping.

use nalgebra::{DMatrix, DVector};

/// How carefully a fit is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Most steps.
    pub steps: u32,
    /// A step that lowers the cost by less is the last.
    pub tolerance: f64,
}

impl Effort {
    /// For an answer.
    pub const WHOLE: Self = Self { steps: 25, tolerance: 1e-4 };
    /// For a node of a grid.
    pub const NODE: Self = Self { steps: 6, tolerance: 3e-3 };
}

/// Dampings that one step tries, ten times as much each.
const TRIES: u32 = 8;

/// A cost with its linearisation.
pub trait Landscape {
    /// A point with what was computed there.
    type Point;

    /// The cost there.
    fn cost(&self, at: &Self::Point) -> f64;

    /// Information and slope of the cost there.
    fn linearised(&self, at: &Self::Point) -> (DMatrix<f64>, DVector<f64>);

    /// The point a step further. `None` where it is no number.
    fn moved(&self, from: &Self::Point, step: DVector<f64>) -> Option<Self::Point>;

    /// The place of a parameter in which the cost has corners: where no step helps, the others go on alone.
    fn corner(&self, _: &Self::Point) -> Option<usize> {
        None
    }

    /// The point of least cost downhill from a start.
    fn descend(&self, start: Self::Point, effort: Effort) -> Self::Point {
        let mut here = start;
        let mut damping = 1e-3;
        for _ in 0..effort.steps {
            let (information, slope) = self.linearised(&here);
            let before = self.cost(&here);
            let is_done = |now: f64| before - now < effort.tolerance;
            let corner = self.corner(&here);
            for held in [Some(None), corner.map(Some)].into_iter().flatten() {
                for _ in 0..TRIES {
                    let mut damped = information.clone();
                    for i in 0..damped.nrows() {
                        damped[(i, i)] *= if held == Some(i) { 1e9 } else { 1.0 + damping };
                    }
                    let step = damped.cholesky().map(|factor| -factor.solve(&slope));
                    let next = step.and_then(|step| self.moved(&here, step));
                    if let Some(next) = next.filter(|next| self.cost(next) < before) {
                        here = next;
                        damping = (0.1 * damping).max(1e-9);
                        break;
                    }
                    damping *= 10.0;
                }
                if !is_done(self.cost(&here)) {
                    break;
                }
                damping = 1e-3;
            }
            if is_done(self.cost(&here)) {
                break;
            }
        }
        here
    }
}

/// A step of which no parameter before `shared` moves further than this.
pub fn shortened(mut step: DVector<f64>, shared: usize, longest: f64) -> DVector<f64> {
    let furthest = step.rows(0, shared).amax();
    if furthest > longest {
        step *= longest / furthest;
    }
    step
}
