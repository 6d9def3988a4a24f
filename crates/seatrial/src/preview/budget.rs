//! What a preview may cost.

use std::cell::Cell;

use seatrial_core::{InvalidSetting, Plan};

use super::Prior;

/// Between two questions whether a preview is still wanted, samples.
const LOOK_EVERY: usize = 4096;

/// What a preview may cost: samples that it plays and keeps, some 200 bytes and 1 us each, until nobody wants it any more.
pub struct Budget<'a> {
    left: Cell<usize>,
    is_wanted: &'a dyn Fn() -> bool,
    is_given_up: Cell<bool>,
}

impl Budget<'_> {
    /// Samples that a preview on this machine may play: slow ships at quick rates take a million.
    pub const OWN_SAMPLES: usize = 4_000_000;

    /// Samples of somebody who waits for the answer.
    pub fn of(samples: usize) -> Self {
        Self::while_wanted(samples, &|| true)
    }
}

impl<'a> Budget<'a> {
    /// Samples as long as `is_wanted` says so.
    pub fn while_wanted(samples: usize, is_wanted: &'a dyn Fn() -> bool) -> Self {
        Self { left: Cell::new(samples), is_wanted, is_given_up: Cell::new(false) }
    }

    /// Refuses a plan whose shortest course is longer than what is left.
    pub fn check(&self, plan: &Plan<f64>, prior: &Prior) -> Result<(), InvalidSetting> {
        let shortest_s =
            plan.settle.at_least_s + plan.training.duration_s() + plan.validation.duration_s();
        let samples = plan.thrusts.len() as f64 * shortest_s / prior.sample_interval_s;
        // Written so that NaN is refused, too.
        if samples <= self.left.get() as f64 {
            return Ok(());
        }
        Err(Self::too_long())
    }

    /// Refuses where nobody waits for the answer any more; from then on nothing is left.
    ///
    /// ```
    /// use seatrial::preview::Budget;
    ///
    /// assert_eq!(Budget::of(1000).look(), Ok(()));
    /// // Whoever waited has gone: the preview ends.
    /// assert!(Budget::while_wanted(1000, &|| false).look().is_err());
    /// ```
    pub fn look(&self) -> Result<(), InvalidSetting> {
        if !self.is_given_up.get() && (self.is_wanted)() {
            return Ok(());
        }
        self.is_given_up.set(true);
        self.left.set(0);
        Err(InvalidSetting {
            field: "the preview",
            requirement: "ready in time, or still waited for; ask for a shorter plan",
        })
    }

    /// Takes one sample from the budget.
    pub(super) fn take(&self) -> Result<(), InvalidSetting> {
        if self.left.get().is_multiple_of(LOOK_EVERY) {
            self.look()?;
        }
        let left = self.left.get().checked_sub(1).ok_or_else(Self::too_long)?;
        self.left.set(left);
        Ok(())
    }

    /// Is nothing left?
    pub(super) fn is_spent(&self) -> bool {
        self.left.get() == 0
    }

    fn too_long() -> InvalidSetting {
        InvalidSetting {
            field: "the plan",
            requirement: "short enough to be previewed: fewer speeds, shorter stages, a longer sample_interval_s or fewer repeats",
        }
    }
}
