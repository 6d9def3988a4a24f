//! Trials of the pitch axis, each entered whole when it is over.

use rusqlite::params;
use serde::{Deserialize, Serialize};

use super::chain::pitch_link;
use super::pitch_rows::{ALL, StoredPitchTrial, samples, stored};
use super::row::{Exact, from_json, to_json};
use super::write::{Durability, exact_json};
use super::{Error, Logbook};
use seatrial::pitch::{PitchPlan, PitchRun, PitchTrial};

/// What a pitch trial ran on.
#[derive(Clone, Copy, Debug)]
pub struct NewPitchTrial<'a> {
    /// Name of the configuration (payload).
    pub configuration: &'a str,
    /// The version of seatrial.
    pub software_version: &'a str,
    /// The vehicle as given on the command line.
    pub vehicle: &'a str,
    /// Seed of a simulated vehicle.
    pub seed: Option<u64>,
}

/// A pitch trial without its samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PitchEntry {
    /// Its number among the pitch trials of the logbook.
    pub number: i64,
    /// Name of the configuration (payload).
    pub configuration: String,
    /// When it was entered, UTC, ISO 8601.
    pub entered: String,
    /// The version of seatrial that ran it.
    pub software_version: String,
    /// The vehicle as given on the command line.
    pub vehicle: String,
    /// Seed of a simulated vehicle.
    pub seed: Option<u64>,
    /// The plan.
    pub plan: PitchPlan,
    /// One entry a thrust.
    pub runs: Vec<PitchRun>,
    /// Why it ended early, where it did.
    pub aborted: Option<String>,
    /// SHA-256 over all of it and its samples.
    pub sha256: String,
}

/// The column `result`.
#[derive(Serialize, Deserialize)]
struct PitchResult {
    runs: Vec<PitchRun>,
    aborted: Option<String>,
}

impl Logbook {
    /// Enters a pitch trial and seals it; its number. Once this has returned it survives a loss of power.
    pub fn enter_pitch_trial(
        &mut self,
        new: &NewPitchTrial,
        trial: &PitchTrial,
    ) -> Result<i64, Error> {
        for (run, number) in trial.runs.iter().zip(1..) {
            exact_json(number, run)?;
        }
        let result = PitchResult {
            runs: trial.runs.clone(),
            aborted: trial.aborted.clone(),
        };
        self.write(Durability::Power, |transaction| {
            transaction.execute(
                "INSERT INTO pitch_trial
                 VALUES (NULL, ?, strftime('%Y-%m-%dT%H:%M:%SZ'), ?, ?, ?, ?, ?, '')",
                params![
                    new.configuration,
                    new.software_version,
                    new.vehicle,
                    new.seed.map(u64::cast_signed),
                    to_json(&trial.plan)?,
                    to_json(&result)?,
                ],
            )?;
            let number = transaction.last_insert_rowid();
            let mut insert = transaction
                .prepare_cached("INSERT INTO pitch_sample VALUES (?, ?, ?, ?, ?, ?, ?)")?;
            for (sample, index) in trial.samples.iter().zip(0_i64..) {
                insert.execute(params![
                    number,
                    index,
                    Exact(sample.time_s),
                    Exact(sample.pitch_rad),
                    Exact(sample.elevator_rad),
                    sample.depth_m.map(Exact),
                    sample.surge_speed_m_s.map(Exact),
                ])?;
            }
            for stored in stored(transaction, number)? {
                transaction.execute(
                    "UPDATE pitch_trial SET sha256 = ? WHERE id = ?",
                    params![pitch_link(&stored, &trial.samples), number],
                )?;
            }
            Ok(number)
        })
    }

    /// The pitch trials in the order in which they were entered.
    pub fn pitch_trials(&self) -> Result<Vec<PitchEntry>, Error> {
        self.reading(
            stored(&self.connection, ALL)
                .and_then(|trials| trials.into_iter().map(PitchEntry::read).collect()),
        )
    }

    /// The pitch trial of that number with its samples.
    pub fn pitch_trial(&self, number: i64) -> Result<(PitchEntry, PitchTrial), Error> {
        let entry = self
            .pitch_trials()?
            .into_iter()
            .find(|entry| entry.number == number)
            .ok_or_else(|| Error::NoCampaign {
                path: self.path.clone(),
                wanted: format!("{number} of the pitch axis"),
                held: "others; see `seatrial logbook list`".into(),
            })?;
        let samples = self.reading(samples(&self.connection, number))?;
        let trial = PitchTrial {
            plan: entry.plan.clone(),
            runs: entry.runs.clone(),
            aborted: entry.aborted.clone(),
            samples,
        };
        Ok((entry, trial))
    }
}

impl PitchEntry {
    fn read(stored: StoredPitchTrial) -> Result<Self, rusqlite::Error> {
        let result: PitchResult = from_json(7, &stored.result)?;
        Ok(Self {
            plan: from_json(6, &stored.plan)?,
            number: stored.number,
            configuration: stored.configuration,
            entered: stored.entered,
            software_version: stored.software_version,
            vehicle: stored.vehicle,
            seed: stored.seed,
            runs: result.runs,
            aborted: result.aborted,
            sha256: stored.sha256,
        })
    }
}
