//! Campaigns, runs and steps as they stand in the tables, unchecked.

use rusqlite::{Connection, OptionalExtension, Row};
use seatrial_core::{Axis, Outcome};
use serde::{Deserialize, Serialize};

use super::CampaignId;
use super::damage::Damage;
use super::row::{from_json, json_column, number, optional, stage, step_of};
use seatrial::campaign::{FullRudder, Run, StageSpan};
use seatrial::identification::{Identification, Reason, ReasonCode, TracePoint, Verdict};
use seatrial::{Step, Window};

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
    /// What its hash covers: 1 the notes, 2 also that commands and reviews have hash chains, 3 also the runs without a result.
    /// 0 in campaigns of older schemas, which show the configuration's newest notes.
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
    pub fn into_run(self) -> Result<Run, rusqlite::Error> {
        let samples = self.steps.len();
        let mut identification: Option<Identification> =
            self.identification.map(|text| from_json(0, &text)).transpose()?;
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
        .query_row("SELECT identification FROM estimate WHERE run = ?", [run], |row| row.get(0))
        .optional()?;
    let stages = collect(
        connection,
        "SELECT stage, from_s, to_s FROM stage WHERE run = ? ORDER BY number",
        run,
        |row| {
            Ok(StageSpan {
                stage: stage(0, &row.get::<_, String>(0)?)?,
                window: Window { from_s: number(row, 1)?, to_s: number(row, 2)? },
            })
        },
    )?;
    let trace = collect(
        connection,
        "SELECT time_s, a22_per_s, b2_per_s2, c0_rad_per_s2, step_norm
         FROM trace WHERE run = ? ORDER BY number",
        run,
        |row| {
            let number = |column| number(row, column);
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
                thrust: number(row, 1)?,
                attempt: row.get(2)?,
                surge_speed_m_s: optional(row, 3)?,
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
        "SELECT campaign.id, coalesce(configuration.name, ''),
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
         FROM campaign LEFT JOIN configuration ON configuration.id = campaign.configuration
         WHERE ? ORDER BY campaign.id",
        1,
        |row| {
            let state = match (json_column(row, 10)?, row.get(11)?) {
                (Some(outcome), _) => State::Ended { outcome },
                (None, false) => State::Unfinished,
                (None, true) => State::Interrupted,
            };
            let is_assumed: Option<bool> = row.get(18)?;
            Ok(CampaignEntry {
                id: CampaignId(row.get(0)?),
                configuration: row.get(1)?,
                notes: row.get(2)?,
                started: row.get(3)?,
                software_version: row.get(4)?,
                vehicle: row.get(5)?,
                seed: row.get::<_, Option<i64>>(6)?.map(i64::cast_unsigned),
                rudder_limit_rad: number(row, 7)?,
                full_rudder: optional(row, 17)?.map(|angle_rad| FullRudder {
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

/// Number, attempt and thrust of each run without a result.
pub(super) fn unfinished_runs(
    connection: &Connection,
    campaign: i64,
) -> Result<Vec<(u32, u32, f64)>, rusqlite::Error> {
    collect(
        connection,
        "SELECT number, attempt, thrust FROM run WHERE campaign = ? AND sha256 IS NULL ORDER BY number",
        campaign,
        |row| Ok((row.get(0)?, row.get(1)?, number(row, 2)?)),
    )
}

/// The steps before the first run and after the last.
pub(super) fn steps_outside(
    connection: &Connection,
    campaign: i64,
) -> Result<Vec<Step>, rusqlite::Error> {
    let steps = steps(connection, "sample.campaign = ? AND sample.run IS NULL", campaign)?;
    Ok(steps.into_iter().map(|(_, step)| step).collect())
}

pub(super) fn steps(
    connection: &Connection,
    condition: &str,
    parameter: i64,
) -> Result<Vec<(Option<u32>, Step)>, rusqlite::Error> {
    let sql = format!(
        "SELECT {}, stage, action_outcome, (SELECT run.number FROM run WHERE run.id = sample.run)
         FROM sample WHERE {condition} ORDER BY number",
        Step::COLUMNS.join(", "),
    );
    collect(connection, &sql, parameter, |row| Ok((row.get(20)?, step_of(row)?)))
}

/// The rows of a query with one parameter.
pub(super) fn collect<T>(
    connection: &Connection,
    sql: &str,
    parameter: i64,
    row: impl FnMut(&Row) -> Result<T, rusqlite::Error>,
) -> Result<Vec<T>, rusqlite::Error> {
    connection.prepare_cached(sql)?.query_map([parameter], row)?.collect()
}
