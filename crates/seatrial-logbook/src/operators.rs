//! What operators commanded, and their word on runs.

use rusqlite::params;
use serde::{Deserialize, Serialize};

use super::stored::collect;
use super::trail::Trail;
use super::write::Durability;
use super::{CampaignId, Error, Logbook};
use seatrial::campaign::Run;
use seatrial::identification::{Reason, ReasonCode};

/// A command for the audit trail.
#[derive(Clone, Copy, Debug)]
pub struct NewCommand<'a> {
    /// Who.
    pub actor: &'a str,
    /// From which network address.
    pub address: &'a str,
    /// The command.
    pub command: &'a str,
    /// With which particulars, JSON.
    pub details: &'a str,
    /// `done`, or the code of the refusal.
    pub result: &'a str,
}

/// A command as the logbook keeps it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = AuditEntry))]
pub struct CommandEntry {
    /// 1 for the first.
    pub number: i64,
    /// UTC.
    pub time: String,
    /// The name of who had control, or the role.
    pub actor: String,
    /// Network address that it came from.
    pub address: String,
    /// `start_trial`, `abort_trial`, `review_run`, ...
    pub command: String,
    /// What was asked for, JSON as text.
    pub details: String,
    /// `done`, or the code of the refusal.
    pub result: String,
}

/// An operator's word on a run, which goes before the verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Review {
    /// May it be used?
    pub accepted: bool,
    /// The reviewer's reason.
    pub note: String,
    /// Name of the reviewer.
    pub reviewer: String,
    /// UTC, ISO 8601.
    pub time: String,
}

/// The operator of a trial, its place, and the firmware. What was not stated is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Circumstances {
    /// Who.
    pub operator: Option<String>,
    /// Where, in the operator's words.
    pub place: Option<String>,
    /// What the vehicle's autopilot says that it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub firmware: Option<String>,
}

/// The command under which the circumstances of a campaign stand in the audit trail.
const CONDUCT: &str = "conduct_trial";

/// What the audit trail says of a campaign's circumstances.
#[derive(Serialize, Deserialize)]
struct CampaignCircumstances {
    campaign: i64,
    #[serde(flatten)]
    circumstances: Circumstances,
}

impl Circumstances {
    /// Is nothing known?
    pub fn is_unknown(&self) -> bool {
        *self == Self::default()
    }
}

impl Review {
    /// Lets the review decide about the run, and says so first of all reasons.
    pub(super) fn decide(&self, run: &mut Run) {
        let (judged, code) = if self.accepted {
            ("accepted", ReasonCode::AcceptedByOperator)
        } else {
            ("rejected", ReasonCode::RejectedByOperator)
        };
        run.verdict.accepted = self.accepted;
        run.verdict.reasons.insert(
            0,
            Reason::new(
                code,
                format!("{judged} by {} on {}: {}", self.reviewer, self.time, self.note),
            ),
        );
    }
}

impl Logbook {
    /// Enters a command.
    pub fn enter_command(&mut self, new: &NewCommand) -> Result<(), Error> {
        self.write(Durability::Process, |transaction| {
            transaction.execute(
                "INSERT INTO command (time, actor, address, command, details, result)
                 VALUES (strftime('%Y-%m-%dT%H:%M:%SZ'), ?, ?, ?, ?, ?)",
                params![new.actor, new.address, new.command, new.details, new.result],
            )?;
            Trail::Commands.seal(transaction, transaction.last_insert_rowid())
        })
    }

    /// The newest commands, at most so many, newest first.
    pub fn commands(&self, at_most: u32) -> Result<Vec<CommandEntry>, Error> {
        self.reading(collect(
            &self.connection,
            "SELECT id, time, actor, address, command, details, result FROM command
             ORDER BY id DESC LIMIT ?",
            at_most.into(),
            |row| {
                Ok(CommandEntry {
                    number: row.get(0)?,
                    time: row.get(1)?,
                    actor: row.get(2)?,
                    address: row.get(3)?,
                    command: row.get(4)?,
                    details: row.get(5)?,
                    result: row.get(6)?,
                })
            },
        ))
    }

    /// Enters who conducts a campaign, and where, in the audit trail.
    pub fn enter_circumstances(
        &mut self,
        campaign: CampaignId,
        circumstances: &Circumstances,
    ) -> Result<(), Error> {
        let conducted =
            CampaignCircumstances { campaign: campaign.0, circumstances: circumstances.clone() };
        self.enter_command(&NewCommand {
            actor: circumstances.operator.as_deref().unwrap_or_default(),
            address: "",
            command: CONDUCT,
            details: &serde_json::to_string(&conducted).unwrap_or_default(),
            result: "done",
        })
    }

    /// The operator, place and firmware of a campaign; all `None` where they were not stated.
    pub fn circumstances(&self, campaign: CampaignId) -> Result<Circumstances, Error> {
        let entered: Vec<String> = self.reading(collect(
            &self.connection,
            "SELECT details FROM command WHERE command = 'conduct_trial'
                 AND details ->> '$.campaign' = ? ORDER BY id DESC LIMIT 1",
            campaign.0,
            |row| row.get(0),
        ))?;
        let conducted = entered.first().and_then(|details| serde_json::from_str(details).ok());
        Ok(conducted.map_or_else(Circumstances::default, |conducted: CampaignCircumstances| {
            conducted.circumstances
        }))
    }

    /// Enters an operator's word on a run of a campaign. `None` where there is no such run, or where one without a model
    /// is to be accepted.
    pub fn review(
        &mut self,
        campaign: CampaignId,
        run: u32,
        accepted: bool,
        note: &str,
        reviewer: &str,
    ) -> Result<Option<()>, Error> {
        let entered = self.write(Durability::Power, |transaction| {
            let entered = transaction.execute(
                "INSERT INTO review (run, accepted, note, reviewer, time)
                 SELECT id, ?3, ?4, ?5, strftime('%Y-%m-%dT%H:%M:%SZ') FROM run
                 WHERE campaign = ?1 AND number = ?2 AND sha256 IS NOT NULL
                   AND (NOT ?3 OR EXISTS (SELECT 1 FROM estimate WHERE estimate.run = run.id))",
                params![campaign.0, run, accepted, note, reviewer],
            )?;
            if entered == 1 {
                Trail::Reviews.seal(transaction, transaction.last_insert_rowid())?;
            }
            Ok(entered)
        })?;
        Ok((entered == 1).then_some(()))
    }

    /// The last review of each reviewed run of a campaign.
    pub fn reviews(&self, campaign: CampaignId) -> Result<Vec<(u32, Review)>, Error> {
        self.reading(collect(
            &self.connection,
            "SELECT run.number, review.accepted, note, reviewer, time
             FROM review JOIN run ON run.id = review.run
             WHERE run.campaign = ?
               AND review.id = (SELECT max(id) FROM review AS newest WHERE newest.run = run.id)
             ORDER BY run.number",
            campaign.0,
            |row| {
                Ok((
                    row.get(0)?,
                    Review {
                        accepted: row.get(1)?,
                        note: row.get(2)?,
                        reviewer: row.get(3)?,
                        time: row.get(4)?,
                    },
                ))
            },
        ))
    }
}
