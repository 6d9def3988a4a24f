//! What a logbook holds of a trial, to conduct it again.

use seatrial::Step;
use seatrial::campaign::Campaign;

use super::{CampaignId, Error, Logbook};

/// What a logbook holds of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The campaign, with its finished runs only.
    pub campaign: Campaign,
    /// Every step with the number of its run.
    pub steps: Vec<(Option<u32>, Step)>,
}

impl Logbook {
    /// Everything of a campaign that can be replayed.
    pub fn recording(&self, campaign: CampaignId) -> Result<Recording, Error> {
        let steps = self.steps(campaign)?;
        let finished = self.runs(campaign)?;
        let mut campaign = self.as_found(campaign)?;
        campaign.runs.retain(|run| {
            finished.iter().any(|entry| entry.finished && entry.number == run.number)
        });
        Ok(Recording { campaign, steps })
    }
}
