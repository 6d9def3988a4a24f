//! When the estimate has stopped moving.

use crate::Real;

/// When an estimate counts as converged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConvergenceSettings<T> {
    /// Largest step of Theta, Euclidean norm over a22 (1/s), b2 (1/s^2) and C0 (rad/s^2).
    pub threshold: T,
    /// Samples in a row that must stay under it.
    pub consecutive: u32,
}

/// Criterion (39), met several times in a row.
///
/// ```text
/// |Theta(t_k) - Theta(t_k-1)|_2 < threshold          (39)
/// ```
///
/// An estimate that nothing excites does not move either: (39) alone fires before the doublet
/// begins. [`arm`](Self::arm) it when the doublet is over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence {
    armed: bool,
    in_a_row: u32,
    detected_s: Option<f64>,
}

impl Convergence {
    /// Counts from the next sample on.
    pub fn arm(&mut self) {
        self.armed = true;
    }

    /// Takes in one step of the estimate, `elapsed_s` after the start of the training.
    pub fn observe<T: Real>(
        &mut self,
        step_norm: T,
        elapsed_s: f64,
        settings: &ConvergenceSettings<T>,
    ) {
        if !self.armed || self.detected_s.is_some() {
            return;
        }
        if step_norm < settings.threshold {
            self.in_a_row += 1;
        } else {
            self.in_a_row = 0;
        }
        if self.in_a_row >= settings.consecutive {
            self.detected_s = Some(elapsed_s);
        }
    }

    /// Seconds from the start of the training to the detection.
    pub fn detected_s(&self) -> Option<f64> {
        self.detected_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_only_a_full_row_after_arming_counts() {
        let settings = ConvergenceSettings {
            threshold: 0.001,
            consecutive: 3,
        };
        let mut convergence = Convergence::default();
        let steps = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5];
        for (k, step) in (0_u32..).zip(steps) {
            if k == 4 {
                assert_eq!(convergence.detected_s(), None);
                convergence.arm();
            }
            convergence.observe(step, f64::from(k), &settings);
        }
        assert_eq!(convergence.detected_s(), Some(9.0));
    }
}
