//! What is known of a training stage.

use crate::{Real, Sample};

/// What is known of the training stage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Training<T> {
    pub(super) enough: bool,
    pub(super) samples_used: u32,
    speed_samples: u32,
    mean_speed_m_s: T,
}

impl<T: Real> Training<T> {
    pub(super) fn add_speed(&mut self, sample: &Sample<T>) {
        if let Some(speed) = sample.surge_speed_m_s.filter(|speed| speed.is_finite()) {
            self.speed_samples = self.speed_samples.saturating_add(1);
            self.mean_speed_m_s +=
                (speed - self.mean_speed_m_s) / T::of(f64::from(self.speed_samples));
        }
    }

    pub(super) fn surge_speed_m_s(&self) -> Option<T> {
        (self.speed_samples > 0).then_some(self.mean_speed_m_s)
    }
}
