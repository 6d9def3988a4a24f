//! What comes out of a logbook.

use super::damage::Damage;
use super::row::number;
use super::stored::{
    CampaignEntry, State, StoredRun, campaign_entries, collect, steps, stored_run,
};
use super::{CampaignId, Error, Logbook, RunId};
use seatrial::Step;
use seatrial::campaign::{Campaign, Run};

/// A run without its data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunEntry {
    /// Key of the run.
    pub id: RunId,
    /// 1 for the first run of the campaign.
    pub number: u32,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// Does it have its result?
    pub finished: bool,
    /// Samples kept.
    pub samples: usize,
}

impl Logbook {
    /// Every campaign, oldest first. What is damaged says so, and none of its runs counts as accepted.
    pub fn campaigns(&self) -> Result<Vec<CampaignEntry>, Error> {
        self.viewing(|| {
            let of_file = self.damage_of_file();
            let entries = self.entries()?.into_iter();
            Ok(entries.map(|entry| self.checked(entry, &of_file)).collect())
        })
    }

    /// Every campaign as it stands there, oldest first, unchecked, because all samples are read to check them.
    pub fn entries(&self) -> Result<Vec<CampaignEntry>, Error> {
        self.reading(campaign_entries(&self.connection))
    }

    /// One campaign without its runs, checked.
    pub fn entry(&self, campaign: CampaignId) -> Result<CampaignEntry, Error> {
        self.viewing(|| {
            let of_file = self.damage_of_file();
            Ok(self.checked(self.entry_as_found(campaign)?, &of_file))
        })
    }

    /// What is damaged of these campaigns, or of the file that they are in; of every campaign where none is named.
    pub fn damage_among(&self, campaigns: &[CampaignId]) -> Result<Option<Damage>, Error> {
        self.viewing(|| {
            let is_asked =
                |entry: &CampaignEntry| campaigns.is_empty() || campaigns.contains(&entry.id);
            let asked: Vec<CampaignEntry> = self.entries()?.into_iter().filter(is_asked).collect();
            let of_file = self.damage_of_file();
            let damage = asked.iter().find_map(|entry| self.damage_of(entry));
            let of_asked = |id: &Option<i64>| match id {
                Some(id) => asked.iter().any(|entry| entry.id.0 == *id),
                None => true,
            };
            Ok(damage.or_else(|| of_file.into_iter().find(|found| of_asked(&found.campaign()))))
        })
    }

    fn entry_as_found(&self, campaign: CampaignId) -> Result<CampaignEntry, Error> {
        let campaigns = self.entries()?;
        let held = match campaigns.as_slice() {
            [] => "none".into(),
            [only] => format!("campaign {}", only.id.0),
            [first, .., last] => format!("campaigns {} to {}", first.id.0, last.id.0),
        };
        campaigns.into_iter().find(|entry| entry.id == campaign).ok_or_else(|| Error::NoCampaign {
            path: self.path.clone(),
            wanted: campaign.0.to_string(),
            held,
        })
    }

    /// What is damaged of another campaign alone is not its damage.
    fn checked(&self, mut entry: CampaignEntry, of_file: &[Damage]) -> CampaignEntry {
        let of_entry = |damage: &&Damage| damage.campaign().is_none_or(|id| id == entry.id.0);
        entry.damage = self.damage_of(&entry).or_else(|| of_file.iter().find(of_entry).cloned());
        if entry.damage.is_some() {
            entry.runs_accepted = 0;
        }
        entry
    }

    /// A whole campaign with its records and traces. An unfinished run has no model and is not accepted; of one that an
    /// operator has reviewed the last review is the verdict. Of a campaign that is damaged no run is accepted.
    pub fn campaign(&self, campaign: CampaignId) -> Result<Campaign, Error> {
        self.viewing(|| self.campaign_of(&self.entry(campaign)?))
    }

    /// [`campaign`](Self::campaign) of an entry that was checked already, which costs as much as reading it.
    pub fn campaign_of(&self, entry: &CampaignEntry) -> Result<Campaign, Error> {
        self.viewing(|| {
            let mut whole = self.as_found(entry.id)?;
            for (number, review) in self.reviews(entry.id)? {
                for run in whole.runs.iter_mut().filter(|run| run.number == number) {
                    review.decide(run);
                }
            }
            if let Some(damage) = &entry.damage {
                whole.runs.iter_mut().for_each(|run| damage.decide(run));
            }
            Ok(whole)
        })
    }

    /// A campaign with the verdicts that the program found, whatever operators decided.
    pub(super) fn as_found(&self, campaign: CampaignId) -> Result<Campaign, Error> {
        let entry = self.entry_as_found(campaign)?;
        let runs =
            self.runs(campaign)?.iter().map(|run| self.run(run.id)).collect::<Result<_, _>>()?;
        Ok(Campaign {
            axis: entry.axis(),
            software_version: entry.software_version,
            vehicle: entry.vehicle,
            configuration: entry.configuration,
            seed: entry.seed,
            rudder_limit_rad: entry.rudder_limit_rad,
            full_rudder: entry.full_rudder,
            scenario: entry.scenario,
            runs,
            outcome: match entry.state {
                State::Ended { outcome } => Some(outcome),
                State::Unfinished | State::Interrupted => None,
            },
        })
    }

    /// Puts back the records and traces that were [taken out](super::Keeper::release) of a campaign's runs.
    pub fn fill(&self, id: CampaignId, campaign: &mut Campaign) -> Result<(), Error> {
        for entry in self.runs(id)?.iter().filter(|entry| entry.finished) {
            let run = campaign
                .runs
                .iter_mut()
                .find(|run| run.number == entry.number && run.record.samples.is_empty());
            if let Some(run) = run {
                let kept = self.run(entry.id)?;
                run.record.samples = kept.record.samples;
                if let (Some(identification), Some(kept)) =
                    (&mut run.identification, kept.identification)
                {
                    identification.online.trace = kept.online.trace;
                }
            }
        }
        Ok(())
    }

    /// The runs of a campaign in the order in which they were made.
    pub fn runs(&self, campaign: CampaignId) -> Result<Vec<RunEntry>, Error> {
        self.reading(collect(
            &self.connection,
            "SELECT id, number, thrust, attempt, sha256 IS NOT NULL,
                    (SELECT count(*) FROM sample WHERE sample.run = run.id)
             FROM run WHERE campaign = ? ORDER BY number",
            campaign.0,
            |row| {
                Ok(RunEntry {
                    id: RunId(row.get(0)?),
                    number: row.get(1)?,
                    thrust: number(row, 2)?,
                    attempt: row.get(3)?,
                    finished: row.get(4)?,
                    samples: row.get::<_, u32>(5)? as usize,
                })
            },
        ))
    }

    /// One run with its record and trace.
    pub fn run(&self, run: RunId) -> Result<Run, Error> {
        self.reading(stored_run(&self.connection, run.0).and_then(StoredRun::into_run))
    }

    /// Every step of a campaign, from its first sample to its last, with the number of its run.
    pub fn steps(&self, campaign: CampaignId) -> Result<Vec<(Option<u32>, Step)>, Error> {
        self.reading(steps(&self.connection, "sample.campaign = ?", campaign.0))
    }
}
