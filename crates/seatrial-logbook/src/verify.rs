//! Proof that a logbook is whole.

use rusqlite::Connection;
use serde::Serialize;

use super::chain::{campaign_link, outcome_link, pitch_link, run_link, sha256};
use super::damage::{Damage, unreadable};
use super::row::to_json;
use super::stored::{CampaignEntry, State, campaign_entries, collect, steps_outside, stored_run};
use super::trail::Trail;
use super::{CampaignId, Error, Logbook, row_places};

const OVERWRITTEN: &str = "a part of it was overwritten, cut off or lost";

/// What was checked and what was found wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Verification {
    /// Campaigns checked.
    pub campaigns: u32,
    /// Campaigns without an outcome: interrupted, or still running.
    pub campaigns_unfinished: u32,
    /// Finished runs whose hash was recomputed.
    pub runs_finished: u32,
    /// Runs without a result.
    pub runs_unfinished: u32,
    /// Samples read.
    pub samples: usize,
    /// What the file lacks, where it was copied or moved without the write-ahead log beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<String>,
    /// Nothing, in a whole logbook.
    pub damage: Vec<Damage>,
}

impl Verification {
    /// Is nothing damaged and nothing missing?
    pub fn is_whole(&self) -> bool {
        self.damage.is_empty() && self.missing.is_none()
    }
}

impl Logbook {
    /// Checks the file's structure, its references, the place of every row, every sample count and every hash.
    pub fn verify(&self) -> Result<Verification, Error> {
        self.viewing(|| Ok(self.verified()))
    }

    fn verified(&self) -> Verification {
        let mut found = Verification { missing: self.missing.clone(), ..Verification::default() };
        if self.was_empty {
            found
                .add("file", "it holds no logbook: none was made in it yet, or all of it was lost");
        }
        self.verify_file(&mut found);
        match campaign_entries(&self.connection) {
            Ok(campaigns) => {
                for campaign in &campaigns {
                    self.verify_campaign(campaign, &mut found);
                }
            }
            Err(error) => found.add("the list of campaigns", unreadable(&error)),
        }
        found
    }

    /// What is damaged of a campaign alone.
    pub(super) fn damage_of(&self, campaign: &CampaignEntry) -> Option<Damage> {
        let mut found = Verification::default();
        self.verify_campaign(campaign, &mut found);
        found.damage.into_iter().next()
    }

    /// What is damaged beside what each campaign holds: the file's structure, a row in no place, what operators commanded and decided.
    pub(super) fn damage_of_file(&self) -> Vec<Damage> {
        let mut found = Verification::default();
        self.verify_file(&mut found);
        found.damage
    }

    fn verify_file(&self, found: &mut Verification) {
        self.verify_structure(found);
        for (place, wrong) in row_places::misplaced(&self.connection) {
            found.add(&place, wrong);
        }
        self.verify_trails(found);
        self.verify_pitch_trials(found);
    }

    /// Trials of the pitch axis as earlier builds kept them.
    fn verify_pitch_trials(&self, found: &mut Verification) {
        let trials = collect(
            &self.connection,
            "SELECT id, sha256 FROM pitch_trial WHERE ? ORDER BY id",
            1,
            |row| Ok((row.get(0)?, row.get(1)?)),
        );
        let trials: Vec<(i64, String)> = match trials {
            Ok(trials) => trials,
            Err(error) => return found.add("pitch trials", unreadable(&error)),
        };
        for (id, seal) in trials {
            match pitch_link(&self.connection, id) {
                Ok(link) if link == seal => {}
                Ok(_) => found.add(&format!("pitch trial {id}"), "it was put in or changed"),
                Err(error) => found.add(&format!("pitch trial {id}"), unreadable(&error)),
            }
        }
    }

    fn verify_trails(&self, found: &mut Verification) {
        for trail in [Trail::Commands, Trail::Reviews] {
            self.verify_trail(trail, found);
        }
    }

    fn verify_trail(&self, trail: Trail, found: &mut Verification) {
        let (kept, recomputed) = (trail.head(&self.connection), trail.recomputed(&self.connection));
        match kept.and_then(|kept| Ok(kept == recomputed?)) {
            Ok(true) => {}
            Ok(false) => found.add(trail.name(), "one was put in, changed or taken out"),
            Err(error) => found.add(trail.name(), unreadable(&error)),
        }
    }

    fn verify_structure(&self, found: &mut Verification) {
        let complaints = self.connection.prepare("PRAGMA integrity_check").and_then(|mut check| {
            check.query_map([], |row| row.get::<_, String>(0))?.collect::<Result<Vec<_>, _>>()
        });
        match complaints {
            Ok(complaints) if complaints.iter().all(|complaint| complaint == "ok") => {}
            Ok(_) => found.add("the file", OVERWRITTEN),
            Err(error) => found.add("the file", unreadable(&error)),
        }
        let orphans = self.connection.prepare("PRAGMA foreign_key_check").and_then(|mut check| {
            check
                .query_map([], |row| Ok((row.get(0)?, row.get(2)?)))?
                .collect::<Result<Vec<(String, String)>, _>>()
        });
        match orphans {
            Ok(orphans) => orphans.into_iter().for_each(|(table, parent)| {
                let [table, parent] = [table, parent].map(|name| name.replace('_', " "));
                found.add(
                    &format!("entries of the kind {table}"),
                    format!("the {parent} that one belongs to is missing"),
                );
            }),
            Err(error) => found.add("the file", unreadable(&error)),
        }
    }

    fn verify_campaign(&self, campaign: &CampaignEntry, found: &mut Verification) {
        let place = format!("campaign {}", campaign.id.0);
        found.campaigns += 1;
        if sha256(&campaign.plan) != campaign.plan_sha256 {
            found.add(&place, "the plan was changed since it began");
        }
        if campaign_link(campaign) != campaign.sha256 {
            found.add(&place, "what it ran on was changed since it began");
        }
        let mut head = campaign.sha256.clone();
        match sealed_runs(&self.connection, campaign.id) {
            Ok(runs) => {
                for run in &runs {
                    self.verify_run(&place, run, &head, found);
                    // The next link was made of this one: one changed run is reported once.
                    if let Some(seal) = &run.sha256 {
                        head.clone_from(seal);
                    }
                }
            }
            Err(error) => found.add(&place, unreadable(&error)),
        }
        let outside = match steps_outside(&self.connection, campaign.id.0) {
            Ok(outside) => outside,
            Err(error) => return found.add(&place, unreadable(&error)),
        };
        found.samples += outside.len();
        match campaign.state {
            State::Ended { outcome } => {
                let link = to_json(&outcome).and_then(|text| {
                    outcome_link(&self.connection, campaign.id.0, &head, &text, &outside)
                });
                match link {
                    Ok(link) => head = link,
                    Err(error) => found.add(&place, unreadable(&error)),
                }
            }
            State::Unfinished | State::Interrupted => found.campaigns_unfinished += 1,
        }
        if head != campaign.head_sha256 {
            found.add(
                &place,
                "its outcome, its runs or a sample outside them was changed, or one was put in",
            );
        }
    }

    fn verify_run(&self, campaign: &str, run: &SealedRun, head: &str, found: &mut Verification) {
        let place = format!("{campaign}, run {}", run.number);
        match run.sha256 {
            Some(_) => found.runs_finished += 1,
            None => found.runs_unfinished += 1,
        }
        let stored = match stored_run(&self.connection, run.id) {
            Ok(stored) => stored,
            Err(error) => return found.add(&place, unreadable(&error)),
        };
        let samples = stored.steps.len();
        found.samples += samples;
        let Some(seal) = &run.sha256 else { return };
        match run.sample_count {
            Some(count) if count as usize == samples => {}
            Some(count) => found
                .add(&place, format!("it has {samples} samples, and had {count} when it was kept")),
            None => found.add(&place, "how many samples it had is missing"),
        }
        match run_link(head, &stored) {
            Ok(link) if link == *seal => {}
            Ok(_) => found.add(
                &place,
                "a sample, an action, an estimate or the result was changed since it was kept",
            ),
            Err(error) => found.add(&place, unreadable(&error)),
        }
    }
}

/// What a run was sealed with.
struct SealedRun {
    id: i64,
    number: u32,
    sample_count: Option<u32>,
    sha256: Option<String>,
}

fn sealed_runs(
    connection: &Connection,
    campaign: CampaignId,
) -> Result<Vec<SealedRun>, rusqlite::Error> {
    collect(
        connection,
        "SELECT id, number, sample_count, sha256 FROM run WHERE campaign = ? ORDER BY number",
        campaign.0,
        |row| {
            Ok(SealedRun {
                id: row.get(0)?,
                number: row.get(1)?,
                sample_count: row.get(2)?,
                sha256: row.get(3)?,
            })
        },
    )
}

impl Verification {
    fn add(&mut self, place: &str, found: impl ToString) {
        self.damage.push(Damage { place: place.into(), found: found.to_string() });
    }
}
