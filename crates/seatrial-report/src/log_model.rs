//! A model of a log as it is shown.

use super::speed_figures;
use seatrial::gain_allowance::GainAllowance;
use seatrial::identification::{Identification, Verdict};

/// A model of one speed of a log.
#[derive(Clone, Copy, Debug)]
pub struct LogModel<'a> {
    /// A fraction of full.
    pub thrust: Option<f64>,
    /// Mean forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The model, where there is one.
    pub identification: Option<&'a Identification>,
    /// May it be used?
    pub verdict: &'a Verdict,
}

impl LogModel<'_> {
    /// K_p of an accepted model of yaw, for a damping ratio of 0.71.
    pub fn gain(&self) -> Option<f64> {
        let is_steered =
            |found: &&Identification| self.verdict.accepted && found.restoring.is_none();
        let identification = self.identification.filter(is_steered)?;
        GainAllowance::of(identification)
            .design(&identification.model(), speed_figures::DAMPING_RATIO)
            .ok()
            .map(|gain| gain.proportional_gain)
    }
}
