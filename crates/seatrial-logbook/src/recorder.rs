//! Writes a running trial into its logbook, about once a second.

use std::collections::BTreeMap;

use seatrial_core::Outcome;

use super::{CampaignId, Error, Logbook, NewCampaign, RunId};
use seatrial::Step;
use seatrial::campaign::Run;

/// Keeps steps until a second of vehicle time has passed, then commits them together.
///
/// Steps that could not be written (a full disk) are kept and tried again when they have doubled, and
/// at the end of the run; the caller may go on with the trial after an error.
#[derive(Debug)]
pub struct Recorder {
    logbook: Logbook,
    campaign: CampaignId,
    run: Option<RunId>,
    /// Runs that have begun and have no result yet, by number.
    unfinished: BTreeMap<u32, RunId>,
    unwritten: Vec<(Option<RunId>, Step)>,
    /// Steps to wait for after a failed attempt, so that trying again costs little.
    patience: usize,
}

impl Recorder {
    /// Enters a new campaign.
    pub fn begin(mut logbook: Logbook, new: &NewCampaign) -> Result<Self, Error> {
        let campaign = logbook.begin_campaign(new)?;
        Ok(Self {
            logbook,
            campaign,
            run: None,
            unfinished: BTreeMap::new(),
            unwritten: Vec::new(),
            patience: 0,
        })
    }

    /// The campaign's number in the logbook.
    pub fn campaign(&self) -> CampaignId {
        self.campaign
    }

    /// Enters a new run. The steps that follow belong to it.
    pub fn begin_run(&mut self, number: u32, thrust: f64, attempt: u32) -> Result<(), Error> {
        self.run = None;
        let run = self.logbook.begin_run(self.campaign, number, thrust, attempt)?;
        self.run = Some(run);
        self.unfinished.insert(number, run);
        Ok(())
    }

    /// Takes one step. Before the first run and after the last it belongs to none.
    pub fn step(&mut self, step: Step) -> Result<(), Error> {
        self.unwritten.push((self.run, step));
        let since = self
            .unwritten
            .first()
            .map_or(0.0, |(_, first)| step.sample.time_s - first.sample.time_s);
        // Also where the vehicle's clock jumped or is not a number.
        let second_is_over = !(0.0..1.0).contains(&since);
        if second_is_over && self.unwritten.len() >= self.patience { self.flush() } else { Ok(()) }
    }

    /// Writes what is left of the run and its result, and seals it. The next one may have begun.
    pub fn finish_run(&mut self, result: &Run) -> Result<(), Error> {
        let run = self.unfinished.remove(&result.number);
        self.run = self.run.filter(|newest| Some(*newest) != run);
        self.flush()?;
        match run {
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
        if !self.unwritten.is_empty() {
            self.patience = 2 * self.unwritten.len();
            self.logbook.append(self.campaign, &self.unwritten)?;
            self.unwritten.clear();
            self.patience = 0;
        }
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;

    use seatrial_core::{Action, Sample, Steering};

    use super::*;
    use seatrial::identification::Verdict;

    pub(crate) fn step(second: u32) -> Step {
        Step {
            sample: Sample { time_s: f64::from(second), ..Sample::default() },
            stage: None,
            action: Action { steering: Steering::Rudder(0.0), thrust: None, outcome: None },
            estimate: None,
        }
    }

    /// The first run, with this many steps.
    pub(crate) fn run(steps: u32) -> Run {
        Run {
            number: 1,
            thrust: 0.6,
            attempt: 1,
            surge_speed_m_s: None,
            stages: Vec::new(),
            record: (0..steps).map(|second| step(second).sample).collect(),
            identification: None,
            verdict: Verdict { accepted: false, reasons: Vec::new() },
        }
    }

    /// A campaign has begun in the logbook there.
    pub(crate) fn begun(path: &Path) -> Recorder {
        let new = NewCampaign {
            configuration: "bare hull",
            notes: None,
            software_version: "0.1.0",
            vehicle: "sim:starfish",
            seed: None,
            rudder_limit_rad: 0.26,
            full_rudder: None,
            scenario: None,
            plan: "",
        };
        Recorder::begin(Logbook::open(path).unwrap(), &new).unwrap()
    }

    /// A disk that fills up and is then given space loses nothing.
    #[test]
    fn io_steps_that_a_full_disk_refused_are_written_later() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("seatrial.db");
        let mut recorder = begun(&path);
        recorder.begin_run(1, 0.6, 1).unwrap();
        let limit_pages = |recorder: &Recorder, pages: u32| {
            let connection = &recorder.logbook.connection;
            connection.pragma_update_and_check(None, "max_page_count", pages, |_| Ok(())).unwrap();
        };
        // SQLite takes the present size for a limit below it.
        limit_pages(&recorder, 1);
        let errors: Vec<Error> =
            (0..400).filter_map(|second| recorder.step(step(second)).err()).collect();
        let first = errors.first().expect("the disk is full");
        assert!(first.is_not_saved());
        assert!(first.to_string().contains("free some space"), "{first}");

        limit_pages(&recorder, 10_000);
        let run = run(400);
        recorder.finish_run(&run).unwrap();
        recorder.finish(Outcome::Finished).unwrap();
        let logbook = Logbook::open_read_only(&path).unwrap();
        assert_eq!(logbook.campaign(CampaignId(1)).unwrap().runs, [run]);
        assert_eq!(logbook.verify().unwrap().damage, []);
    }
}
