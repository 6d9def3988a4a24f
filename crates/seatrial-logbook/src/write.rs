//! What goes into a logbook.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::backup::Backup;
use rusqlite::{Connection, ErrorCode, OpenFlags, Transaction, TransactionBehavior, params};
use seatrial_core::Outcome;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::chain::{campaign_link, outcome_link, run_link, sha256};
use super::connect::{BUSY_TIMEOUT, file_identity, is_named};
use super::row::{Exact, from_json, stage_name, to_json};
use super::stored::{campaign_entries, steps_of_run, steps_outside, stored_run};
use super::{CampaignId, Error, Logbook, RunId};
use seatrial::Step;
use seatrial::campaign::{FullRudder, Run};

/// What a campaign runs on, known before its first sample.
#[derive(Clone, Copy, Debug)]
pub struct NewCampaign<'a> {
    /// Name of the configuration (payload).
    pub configuration: &'a str,
    /// Notes on the configuration. `None` leaves those of an earlier campaign.
    pub notes: Option<&'a str>,
    /// The version of seatrial.
    pub software_version: &'a str,
    /// The vehicle as given on the command line.
    pub vehicle: &'a str,
    /// Seed of a simulated vehicle.
    pub seed: Option<u64>,
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// The vehicle's rudder at full steering, where it is known.
    pub full_rudder: Option<FullRudder>,
    /// The file of the faults that a simulated vehicle meets.
    pub scenario: Option<&'a str>,
    /// The plan as text, enough to run the trial again.
    pub plan: &'a str,
}

/// How long readers may hold up what is not urgent.
const LONGEST_WAIT_FOR_READERS: Duration = Duration::from_secs(1);

/// What is lost with the power.
pub(super) enum Durability {
    /// The last transactions may be.
    Process,
    /// Nothing that was committed.
    Power,
}

impl Logbook {
    /// Enters a new campaign.
    pub fn begin_campaign(&mut self, new: &NewCampaign) -> Result<CampaignId, Error> {
        self.write(Durability::Power, |transaction| {
            let configuration: i64 = transaction.query_row(
                "INSERT INTO configuration (name, notes) VALUES (?1, ?2)
                 ON CONFLICT (name) DO UPDATE SET notes = coalesce(?2, notes) RETURNING id",
                params![new.configuration, new.notes],
                |row| row.get(0),
            )?;
            transaction.execute(
                "INSERT INTO campaign (configuration, started, software_version, vehicle, seed,
                                       rudder_limit_rad, full_rudder_rad, full_rudder_assumed,
                                       scenario, plan, plan_sha256, sha256, head_sha256,
                                       notes, notes_sealed)
                 VALUES (?1, strftime('%Y-%m-%dT%H:%M:%SZ'), ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, '', '',
                         (SELECT notes FROM configuration WHERE id = ?1), 3)",
                params![
                    configuration,
                    new.software_version,
                    new.vehicle,
                    new.seed.map(u64::cast_signed),
                    Exact(new.rudder_limit_rad),
                    new.full_rudder.map(|full| Exact(full.angle_rad)),
                    new.full_rudder.map(|full| full.is_assumed),
                    new.scenario,
                    new.plan,
                    sha256(new.plan),
                ],
            )?;
            let campaign = CampaignId(transaction.last_insert_rowid());
            for entry in campaign_entries(transaction)? {
                if entry.id == campaign {
                    transaction.execute(
                        "UPDATE campaign SET sha256 = ?1, head_sha256 = ?1 WHERE id = ?2",
                        params![campaign_link(&entry), campaign.0],
                    )?;
                }
            }
            Ok(campaign)
        })
    }

    /// Enters a new run of a campaign.
    pub fn begin_run(
        &mut self,
        campaign: CampaignId,
        number: u32,
        thrust: f64,
        attempt: u32,
    ) -> Result<RunId, Error> {
        self.write(Durability::Process, |transaction| {
            transaction.execute(
                "INSERT INTO run (campaign, number, thrust, attempt) VALUES (?, ?, ?, ?)",
                params![campaign.0, number, Exact(thrust), attempt],
            )?;
            Ok(RunId(transaction.last_insert_rowid()))
        })
    }

    /// Adds steps to a campaign, in order, each with the unfinished run that it belongs to.
    pub fn append(
        &mut self,
        campaign: CampaignId,
        steps: &[(Option<RunId>, Step)],
    ) -> Result<(), Error> {
        self.write(Durability::Process, |transaction| {
            let next: u32 = transaction.query_row(
                "SELECT coalesce(max(number) + 1, 0) FROM sample WHERE campaign = ?",
                [campaign.0],
                |row| row.get(0),
            )?;
            let mut insert = transaction.prepare_cached(
                "INSERT INTO sample
                 VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            )?;
            for (number, (run, step)) in (next..).zip(steps) {
                insert.raw_bind_parameter(1, campaign.0)?;
                insert.raw_bind_parameter(2, number)?;
                insert.raw_bind_parameter(3, run.map(|run| run.0))?;
                // The thrust came to the table later.
                for (column, value) in (4..21).chain([23]).zip(step.numbers()) {
                    insert.raw_bind_parameter(column, value.map(Exact))?;
                }
                insert.raw_bind_parameter(21, step.stage.map(stage_name))?;
                let outcome = step.action.outcome.as_ref().map(to_json).transpose()?;
                insert.raw_bind_parameter(22, outcome)?;
                insert.raw_execute()?;
            }
            Ok(())
        })
    }

    /// Enters the result of a run whose samples were all [appended](Logbook::append), and seals it.
    ///
    /// Once this has returned the run survives a loss of power.
    pub fn finish_run(&mut self, run: RunId, result: &Run) -> Result<(), Error> {
        let inexact = |found| Error::Inexact { run: result.number, found };
        let identification = result
            .identification
            .as_ref()
            .map(|identification| {
                let mut summary = identification.clone();
                summary.online.trace.clear();
                exact_json(result.number, &summary)
            })
            .transpose()?;
        let appended = self.reading(steps_of_run(&self.connection, run.0))?;
        let differs = appended.len() != result.record.samples.len()
            || appended
                .iter()
                .zip(&result.record.samples)
                .any(|(step, &sample)| !step.same_bits(&Step { sample, ..*step }));
        if differs {
            return Err(inexact(format!(
                "its record of {} samples is not the {} that were appended",
                result.record.samples.len(),
                appended.len()
            )));
        }
        self.write(Durability::Power, |transaction| {
            insert_result(transaction, run, result, identification.as_deref())?;
            seal(transaction, run)
        })
    }

    /// Enters how a campaign ended.
    ///
    /// # Errors
    /// Also where the file was renamed, removed or replaced meanwhile; where its runs are is said. Also where something else wrote into it.
    pub fn finish_campaign(&mut self, campaign: CampaignId, outcome: Outcome) -> Result<(), Error> {
        self.end_campaign(campaign, outcome)?;
        let cause = match self.has_moved() {
            true => self.saved_elsewhere(),
            false if self.file.is_some() && !is_sound(&self.path) => {
                "something else wrote into the file during the trial, and runs in it are damaged or lost".into()
            }
            false => return Ok(()),
        };
        Err(Error::NotSaved { path: self.path.clone(), cause })
    }

    /// Where the runs are of a logbook whose name leads to it no more. One that was removed is saved under a new name.
    fn saved_elsewhere(&self) -> String {
        if self.file.and_then(is_named) == Some(true) {
            return "the file was renamed during the trial; all runs are in the renamed one".into();
        }
        let what = "the file was removed or replaced during the trial";
        let free = (1..100).map(|number| numbered(&self.path, number));
        let Some(new) = free.into_iter().find(|path| !path.exists()) else {
            return format!("{what}, and its runs are lost: no name beside it is free");
        };
        match self.copy_to(&new) {
            Ok(()) => format!("{what}; all runs are in {}", new.display()),
            Err(error) => format!("{what}, and its runs are lost: {}: {error}", new.display()),
        }
    }

    fn copy_to(&self, new: &Path) -> Result<(), rusqlite::Error> {
        let mut copy = Connection::open(new)?;
        Backup::new(&self.connection, &mut copy)?.run_to_completion(1024, Duration::ZERO, None)
    }

    fn end_campaign(&mut self, campaign: CampaignId, outcome: Outcome) -> Result<(), Error> {
        self.write(Durability::Power, |transaction| {
            let outcome = to_json(&outcome)?;
            let outside = steps_outside(transaction, campaign.0)?;
            let head = head(transaction, campaign.0)?;
            let link = outcome_link(transaction, campaign.0, &head, &outcome, &outside)?;
            transaction.execute(
                "UPDATE campaign SET outcome = ? WHERE id = ?",
                params![outcome, campaign.0],
            )?;
            set_head(transaction, campaign.0, &link)
        })
    }

    pub(super) fn write<T>(
        &mut self,
        durability: Durability,
        change: impl Fn(&Connection) -> Result<T, rusqlite::Error>,
    ) -> Result<T, Error> {
        let has_moved = self.has_moved();
        let connection = &mut self.connection;
        let written = transact(connection, &durability, &change)
            .or_else(|error| match error.sqlite_error_code() {
                // On a full disk the write-ahead log may give back the room that it takes.
                Some(ErrorCode::DiskFull | ErrorCode::SystemIoFailure) => {
                    connection.execute_batch("PRAGMA wal_checkpoint(TRUNCATE)")?;
                    transact(connection, &durability, &change)
                }
                _ => Err(error),
            })
            .map_err(|error| Error::writing(&self.path, &error))?;
        // Once the file has another name, the log beside the old one belongs to nothing.
        if matches!(durability, Durability::Power) || has_moved {
            settle(connection);
        }
        Ok(written)
    }

    fn has_moved(&self) -> bool {
        self.file.is_some() && self.file != file_identity(&self.path)
    }
}

/// Does somebody who opens the file find its pages in order? Of a large one only the first pages are looked at.
fn is_sound(path: &Path) -> bool {
    const SMALL: u64 = 64 << 20;
    let is_small = std::fs::metadata(path).is_ok_and(|file| file.len() <= SMALL);
    let looked_at = if is_small { "PRAGMA quick_check(1)" } else { "SELECT 'ok' FROM campaign" };
    let found = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)
        .and_then(|other| other.query_row(looked_at, [], |row| row.get::<_, String>(0)));
    match found {
        Ok(said) => said == "ok",
        // Another's lock is no damage.
        Err(error) => !matches!(
            error.sqlite_error_code(),
            Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase)
        ),
    }
}

/// As `seatrial-1.db` of `seatrial.db`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Moves what the write-ahead log holds into the file itself. Where readers or a full disk prevent that, it stays where it is.
fn settle(connection: &Connection) {
    let settle = || {
        connection.busy_timeout(LONGEST_WAIT_FOR_READERS)?;
        connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()))
    };
    let _: Result<(), rusqlite::Error> = settle();
    let _ = connection.busy_timeout(BUSY_TIMEOUT);
}

fn transact<T>(
    connection: &mut Connection,
    durability: &Durability,
    change: impl Fn(&Connection) -> Result<T, rusqlite::Error>,
) -> Result<T, rusqlite::Error> {
    let synchronous = match durability {
        Durability::Process => "NORMAL",
        Durability::Power => "FULL",
    };
    connection.pragma_update(None, "synchronous", synchronous)?;
    let transaction = Transaction::new(connection, TransactionBehavior::Immediate)?;
    let result = change(&transaction)?;
    transaction.commit()?;
    Ok(result)
}

fn insert_result(
    transaction: &Connection,
    run: RunId,
    result: &Run,
    identification: Option<&str>,
) -> Result<(), rusqlite::Error> {
    transaction.execute(
        "UPDATE run SET surge_speed_m_s = ?, verdict = ?, sample_count = ? WHERE id = ?",
        params![
            result.surge_speed_m_s.map(Exact),
            to_json(&result.verdict)?,
            result.record.samples.len() as i64,
            run.0
        ],
    )?;
    for (number, span) in (0_u32..).zip(&result.stages) {
        transaction.execute(
            "INSERT INTO stage VALUES (?, ?, ?, ?, ?)",
            params![
                run.0,
                number,
                stage_name(span.stage),
                Exact(span.window.from_s),
                Exact(span.window.to_s)
            ],
        )?;
    }
    let Some(identification) = identification else {
        return Ok(());
    };
    transaction.execute(
        "INSERT INTO estimate (run, identification) VALUES (?, ?)",
        params![run.0, identification],
    )?;
    let mut insert =
        transaction.prepare_cached("INSERT INTO trace VALUES (?, ?, ?, ?, ?, ?, ?)")?;
    let trace = result.identification.iter().flat_map(|i| &i.online.trace);
    for (number, point) in (0_u32..).zip(trace) {
        let [a22, b2, c0] = point.theta.map(Exact);
        let (time, step_norm) = (Exact(point.time_s), Exact(point.step_norm));
        insert.execute(params![run.0, number, time, a22, b2, c0, step_norm])?;
    }
    Ok(())
}

/// Adds a run, as it stands in the tables, to the hash chain of its campaign.
fn seal(transaction: &Connection, run: RunId) -> Result<(), rusqlite::Error> {
    let campaign: i64 =
        transaction
            .query_row("SELECT campaign FROM run WHERE id = ?", [run.0], |row| row.get(0))?;
    let link = run_link(&head(transaction, campaign)?, &stored_run(transaction, run.0)?)?;
    transaction.execute("UPDATE run SET sha256 = ? WHERE id = ?", params![link, run.0])?;
    set_head(transaction, campaign, &link)
}

fn head(transaction: &Connection, campaign: i64) -> Result<String, rusqlite::Error> {
    transaction
        .query_row("SELECT head_sha256 FROM campaign WHERE id = ?", [campaign], |row| row.get(0))
}

fn set_head(transaction: &Connection, campaign: i64, link: &str) -> Result<(), rusqlite::Error> {
    transaction.execute(
        "UPDATE campaign SET head_sha256 = ?, interrupted = 0 WHERE id = ?",
        params![link, campaign],
    )?;
    Ok(())
}

/// The result of a run as JSON; refused where JSON cannot give it back exactly
/// (a number that is not finite).
pub(super) fn exact_json<T: Serialize + DeserializeOwned + PartialEq>(
    run: u32,
    result: &T,
) -> Result<String, Error> {
    let inexact = |found| Error::Inexact { run, found };
    let text = to_json(result).map_err(|error| inexact(error.to_string()))?;
    match from_json::<T>(0, &text) {
        Ok(read) if read == *result => Ok(text),
        _ => Err(inexact(format!("a number of its result is not finite: {text}"))),
    }
}
