//! Writes a running trial into its logbook, about once a second.

use seatrial_core::Outcome;

use super::{CampaignId, Error, Logbook, NewCampaign, RunId, Step};
use crate::campaign::Run;

/// Keeps steps until a second of vehicle time has passed, then commits them together.
///
/// Steps that could not be written (a full disk) are kept and tried again with the next second, so
/// the caller may go on with the trial after an error.
#[derive(Debug)]
pub struct Recorder {
    logbook: Logbook,
    campaign: CampaignId,
    run: Option<RunId>,
    unwritten: Vec<Step>,
}

impl Recorder {
    /// Enters a new campaign.
    pub fn begin(mut logbook: Logbook, new: &NewCampaign) -> Result<Self, Error> {
        let campaign = logbook.begin_campaign(new)?;
        Ok(Self {
            logbook,
            campaign,
            run: None,
            unwritten: Vec::new(),
        })
    }

    /// The campaign's number in the logbook.
    pub fn campaign(&self) -> CampaignId {
        self.campaign
    }

    /// Enters a new run. The steps that follow belong to it.
    pub fn begin_run(&mut self, number: u32, thrust: f64, attempt: u32) -> Result<(), Error> {
        self.run = None;
        self.unwritten.clear();
        self.run = Some(
            self.logbook
                .begin_run(self.campaign, number, thrust, attempt)?,
        );
        Ok(())
    }

    /// Takes one step of the run.
    pub fn step(&mut self, step: Step) -> Result<(), Error> {
        self.unwritten.push(step);
        let since = self
            .unwritten
            .first()
            .map_or(0.0, |first| step.sample.time_s - first.sample.time_s);
        // Also where the vehicle's clock jumped or is not a number.
        if (0.0..1.0).contains(&since) {
            return Ok(());
        }
        self.flush()
    }

    /// Writes what is left of the run and its result, and seals it.
    pub fn finish_run(&mut self, result: &Run) -> Result<(), Error> {
        self.flush()?;
        match self.run.take() {
            Some(run) => self.logbook.finish_run(run, result),
            None => Err(Error::Inexact {
                run: result.number,
                found: "the run could not be begun".into(),
            }),
        }
    }

    /// Enters how the campaign ended.
    pub fn finish(mut self, outcome: Outcome) -> Result<(), Error> {
        self.flush()?;
        self.logbook.finish_campaign(self.campaign, outcome)
    }

    fn flush(&mut self) -> Result<(), Error> {
        if let Some(run) = self.run
            && !self.unwritten.is_empty()
        {
            self.logbook.append(run, &self.unwritten)?;
            self.unwritten.clear();
        }
        Ok(())
    }
}
