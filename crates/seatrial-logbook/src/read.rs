//! What comes out of a logbook.

use rusqlite::{Connection, OptionalExtension, Row};
use seatrial_core::{Axis, Outcome};
use serde::{Deserialize, Serialize};

use super::row::{Exact, from_json, json_column, stage, step_of};
use super::{CampaignId, Damage, Error, Logbook, RunId};
use seatrial::Step;
use seatrial::campaign::{Campaign, FullRudder, Run, StageSpan};
use seatrial::identification::{Identification, Reason, ReasonCode, TracePoint, Verdict};
use seatrial::record::Window;

/// How far a campaign came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum State {
    /// The campaign ended in an orderly way.
    Ended {
        /// How it ended.
        outcome: Outcome,
    },
    /// The campaign has no outcome yet: it is running, or was killed since the logbook was last opened for writing.
    Unfinished,
    /// The campaign was killed: its finished runs and the samples of the unfinished one are kept.
    Interrupted,
}

/// What a campaign ran on and how far it came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CampaignEntry {
    /// Its number in the logbook.
    pub id: CampaignId,
    /// Name of the configuration (payload).
    pub configuration: String,
    /// Notes on the configuration as they stood when it began.
    pub notes: Option<String>,
    /// What its hash covers: 1 the notes, 2 also that commands and reviews have hash chains. 0 in campaigns of older schemas,
    /// which show the configuration's newest notes.
    #[serde(skip)]
    pub(super) sealed: i64,
    /// When it began, UTC, ISO 8601.
    pub started: String,
    /// The version of seatrial that ran it.
    pub software_version: String,
    /// The vehicle as given on the command line.
    pub vehicle: String,
    /// Seed of a simulated vehicle.
    pub seed: Option<u64>,
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// The vehicle's rudder at full steering, where it is known.
    pub full_rudder: Option<FullRudder>,
    /// The file of the faults that a simulated vehicle met.
    pub scenario: Option<String>,
    /// The plan as it was given to the trial.
    pub plan: String,
    /// SHA-256 of the plan.
    pub plan_sha256: String,
    /// How far it came.
    #[serde(flatten)]
    pub state: State,
    /// Runs begun.
    pub runs: u32,
    /// Runs finished.
    pub runs_finished: u32,
    /// Runs accepted.
    pub runs_accepted: u32,
    /// The first link of its hash chain: what it ran on.
    pub sha256: String,
    /// The newest link of its hash chain: its last finished run, then its outcome.
    pub head_sha256: String,
    /// What is damaged of it, where that was looked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<Damage>,
}

impl CampaignEntry {
    /// Was it a rehearsal on a simulator?
    pub fn is_rehearsal(&self) -> bool {
        self.seed.is_some()
    }

    /// The motion that its plan identifies.
    pub fn axis(&self) -> Axis {
        #[derive(Deserialize)]
        struct AxisOfPlan {
            #[serde(default)]
            axis: Axis,
        }
        toml::from_str(&self.plan).map_or(Axis::Yaw, |plan: AxisOfPlan| plan.axis)
    }
}

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
            let entries = self.entries()?.into_iter();
            Ok(entries.map(|entry| self.checked(entry)).collect())
        })
    }

    /// Every campaign as it stands there, oldest first, unchecked, because all samples are read to check them.
    pub fn entries(&self) -> Result<Vec<CampaignEntry>, Error> {
        self.reading(campaign_entries(&self.connection))
    }

    /// One campaign without its runs, checked.
    pub fn entry(&self, campaign: CampaignId) -> Result<CampaignEntry, Error> {
        self.viewing(|| Ok(self.checked(self.entry_as_found(campaign)?)))
    }

    fn entry_as_found(&self, campaign: CampaignId) -> Result<CampaignEntry, Error> {
        let campaigns = self.entries()?;
        let held = match campaigns.as_slice() {
            [] => "none".into(),
            [only] => format!("campaign {}", only.id.0),
            [first, .., last] => format!("campaigns {} to {}", first.id.0, last.id.0),
        };
        campaigns
            .into_iter()
            .find(|entry| entry.id == campaign)
            .ok_or_else(|| Error::NoCampaign {
                path: self.path.clone(),
                wanted: campaign.0.to_string(),
                held,
            })
    }

    fn checked(&self, mut entry: CampaignEntry) -> CampaignEntry {
        entry.damage = self.damage_of(&entry);
        if entry.damage.is_some() {
            entry.runs_accepted = 0;
        }
        entry
    }

    /// A whole campaign with its records and traces. An unfinished run has no model and is not accepted; of one that an
    /// operator has reviewed the last review is the verdict. Of a campaign that is damaged no run is accepted.
    pub fn campaign(&self, campaign: CampaignId) -> Result<Campaign, Error> {
        self.viewing(|| {
            let mut whole = self.as_found(campaign)?;
            for (number, review) in self.reviews(campaign)? {
                for run in whole.runs.iter_mut().filter(|run| run.number == number) {
                    review.decide(run);
                }
            }
            if let Some(damage) = self.entry(campaign)?.damage {
                whole.runs.iter_mut().for_each(|run| damage.decide(run));
            }
            Ok(whole)
        })
    }

    /// A campaign with the verdicts that the program found, whatever operators decided.
    pub(super) fn as_found(&self, campaign: CampaignId) -> Result<Campaign, Error> {
        let entry = self.entry_as_found(campaign)?;
        let runs = self
            .runs(campaign)?
            .iter()
            .map(|run| self.run(run.id))
            .collect::<Result<_, _>>()?;
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
                    thrust: row.get::<_, Exact>(2)?.0,
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

/// A run as it stands in the tables: what its hash is made of.
pub(super) struct StoredRun {
    pub number: u32,
    pub thrust: f64,
    pub attempt: u32,
    pub surge_speed_m_s: Option<f64>,
    pub verdict: Option<String>,
    pub identification: Option<String>,
    pub stages: Vec<StageSpan>,
    pub trace: Vec<TracePoint>,
    pub steps: Vec<Step>,
}

impl StoredRun {
    fn into_run(self) -> Result<Run, rusqlite::Error> {
        let samples = self.steps.len();
        let mut identification: Option<Identification> = self
            .identification
            .map(|text| from_json(0, &text))
            .transpose()?;
        if let Some(identification) = &mut identification {
            identification.online.trace = self.trace;
        }
        let verdict = match self.verdict {
            Some(text) => from_json(5, &text)?,
            None => Verdict {
                accepted: false,
                reasons: vec![Reason::new(
                    ReasonCode::Interrupted,
                    format!("the run was not finished; {samples} samples of it are kept"),
                )],
            },
        };
        Ok(Run {
            number: self.number,
            thrust: self.thrust,
            attempt: self.attempt,
            surge_speed_m_s: self.surge_speed_m_s,
            stages: self.stages,
            record: self.steps.into_iter().map(|step| step.sample).collect(),
            identification,
            verdict,
        })
    }
}

pub(super) fn stored_run(connection: &Connection, run: i64) -> Result<StoredRun, rusqlite::Error> {
    let identification = connection
        .query_row(
            "SELECT identification FROM estimate WHERE run = ?",
            [run],
            |row| row.get(0),
        )
        .optional()?;
    let stages = collect(
        connection,
        "SELECT stage, from_s, to_s FROM stage WHERE run = ? ORDER BY number",
        run,
        |row| {
            Ok(StageSpan {
                stage: stage(0, &row.get::<_, String>(0)?)?,
                window: Window {
                    from_s: row.get::<_, Exact>(1)?.0,
                    to_s: row.get::<_, Exact>(2)?.0,
                },
            })
        },
    )?;
    let trace = collect(
        connection,
        "SELECT time_s, a22_per_s, b2_per_s2, c0_rad_per_s2, step_norm
         FROM trace WHERE run = ? ORDER BY number",
        run,
        |row| {
            let number = |column| row.get::<_, Exact>(column).map(|Exact(value)| value);
            Ok(TracePoint {
                time_s: number(0)?,
                theta: [number(1)?, number(2)?, number(3)?],
                step_norm: number(4)?,
            })
        },
    )?;
    let steps = steps_of_run(connection, run)?;
    connection.query_row(
        "SELECT number, thrust, attempt, surge_speed_m_s, verdict FROM run WHERE id = ?",
        [run],
        |row| {
            Ok(StoredRun {
                number: row.get(0)?,
                thrust: row.get::<_, Exact>(1)?.0,
                attempt: row.get(2)?,
                surge_speed_m_s: row.get::<_, Option<Exact>>(3)?.map(|Exact(value)| value),
                verdict: row.get(4)?,
                identification,
                stages,
                trace,
                steps,
            })
        },
    )
}

pub(super) fn campaign_entries(
    connection: &Connection,
) -> Result<Vec<CampaignEntry>, rusqlite::Error> {
    collect(
        connection,
        "SELECT campaign.id, configuration.name,
                CASE WHEN notes_sealed IS NOT NULL THEN campaign.notes ELSE configuration.notes END,
                started, software_version,
                vehicle, seed, rudder_limit_rad, plan, plan_sha256, outcome, interrupted,
                campaign.sha256, head_sha256,
                (SELECT count(*) FROM run WHERE run.campaign = campaign.id),
                (SELECT count(sha256) FROM run WHERE run.campaign = campaign.id),
                (SELECT coalesce(sum(coalesce(
                    (SELECT review.accepted FROM review WHERE review.run = run.id
                     ORDER BY review.id DESC LIMIT 1), run.accepted)), 0)
                 FROM run WHERE run.campaign = campaign.id),
                full_rudder_rad, full_rudder_assumed, scenario, notes_sealed
         FROM campaign JOIN configuration ON configuration.id = campaign.configuration
         WHERE ? ORDER BY campaign.id",
        1,
        |row| {
            let state = match (json_column(row, 10)?, row.get(11)?) {
                (Some(outcome), _) => State::Ended { outcome },
                (None, false) => State::Unfinished,
                (None, true) => State::Interrupted,
            };
            let angle: Option<Exact> = row.get(17)?;
            let is_assumed: Option<bool> = row.get(18)?;
            Ok(CampaignEntry {
                id: CampaignId(row.get(0)?),
                configuration: row.get(1)?,
                notes: row.get(2)?,
                started: row.get(3)?,
                software_version: row.get(4)?,
                vehicle: row.get(5)?,
                seed: row.get::<_, Option<i64>>(6)?.map(i64::cast_unsigned),
                rudder_limit_rad: row.get::<_, Exact>(7)?.0,
                full_rudder: angle.map(|Exact(angle_rad)| FullRudder {
                    angle_rad,
                    is_assumed: is_assumed.unwrap_or(true),
                }),
                scenario: row.get(19)?,
                sealed: row.get::<_, Option<i64>>(20)?.unwrap_or(0),
                plan: row.get(8)?,
                plan_sha256: row.get(9)?,
                state,
                sha256: row.get(12)?,
                head_sha256: row.get(13)?,
                runs: row.get(14)?,
                runs_finished: row.get(15)?,
                runs_accepted: row.get(16)?,
                damage: None,
            })
        },
    )
}

pub(super) fn steps_of_run(
    connection: &Connection,
    run: i64,
) -> Result<Vec<Step>, rusqlite::Error> {
    let steps = steps(connection, "sample.run = ?", run)?;
    Ok(steps.into_iter().map(|(_, step)| step).collect())
}

/// The steps before the first run and after the last.
pub(super) fn steps_outside(
    connection: &Connection,
    campaign: i64,
) -> Result<Vec<Step>, rusqlite::Error> {
    let steps = steps(
        connection,
        "sample.campaign = ? AND sample.run IS NULL",
        campaign,
    )?;
    Ok(steps.into_iter().map(|(_, step)| step).collect())
}

fn steps(
    connection: &Connection,
    condition: &str,
    parameter: i64,
) -> Result<Vec<(Option<u32>, Step)>, rusqlite::Error> {
    let sql = format!(
        "SELECT {}, stage, action_outcome, (SELECT run.number FROM run WHERE run.id = sample.run)
         FROM sample WHERE {condition} ORDER BY number",
        Step::COLUMNS.join(", "),
    );
    collect(connection, &sql, parameter, |row| {
        Ok((row.get(20)?, step_of(row)?))
    })
}

/// The rows of a query with one parameter.
pub(super) fn collect<T>(
    connection: &Connection,
    sql: &str,
    parameter: i64,
    row: impl FnMut(&Row) -> Result<T, rusqlite::Error>,
) -> Result<Vec<T>, rusqlite::Error> {
    connection
        .prepare_cached(sql)?
        .query_map([parameter], row)?
        .collect()
}
