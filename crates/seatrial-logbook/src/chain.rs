//! The hash chain of a campaign: campaign -> run -> run -> outcome.

use rusqlite::types::ValueRef;
use rusqlite::{Connection, Error};
use sha2::{Digest, Sha256};

use super::row::{number, optional, stage_name, to_json};
use super::stored::{CampaignEntry, StoredRun, collect, unfinished_runs};
use seatrial::Step;

/// SHA-256 over values; each is preceded by its length or kind, so no two sequences of values
/// share their bytes.
struct Link(Sha256);

impl Link {
    fn after(previous: &str) -> Self {
        let mut link = Self(Sha256::new());
        link.text(previous);
        link
    }

    fn integer(&mut self, value: i64) {
        self.0.update(value.to_le_bytes());
    }

    fn length(&mut self, length: usize) {
        self.0.update((length as u64).to_le_bytes());
    }

    fn text(&mut self, value: &str) {
        self.length(value.len());
        self.0.update(value);
    }

    fn optional_text(&mut self, value: Option<&str>) {
        self.integer(value.is_some().into());
        self.text(value.unwrap_or(""));
    }

    fn number(&mut self, value: f64) {
        self.0.update(value.to_bits().to_le_bytes());
    }

    fn optional_number(&mut self, value: Option<f64>) {
        self.0.update([u8::from(value.is_some())]);
        self.number(value.unwrap_or(0.0));
    }

    fn steps(&mut self, steps: &[Step]) -> Result<(), Error> {
        self.length(steps.len());
        for step in steps {
            // Logbooks from before the thrust was kept have the hashes that they had.
            let [before @ .., thrust] = step.numbers();
            for value in before {
                self.optional_number(value);
            }
            if let Some(thrust) = thrust {
                self.text("thrust");
                self.number(thrust);
            }
            self.optional_text(step.stage.map(stage_name));
            let outcome = step.action.outcome.as_ref().map(to_json).transpose()?;
            self.optional_text(outcome.as_deref());
        }
        Ok(())
    }

    fn hex(self) -> String {
        hex(&self.0.finalize())
    }
}

/// SHA-256 of a text, in hexadecimal.
pub(super) fn sha256(text: &str) -> String {
    hex(&Sha256::digest(text))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The first link: what the campaign ran on and its plan.
pub(super) fn campaign_link(campaign: &CampaignEntry) -> String {
    let mut link = Link::after("");
    link.text(&campaign.configuration);
    link.text(&campaign.started);
    link.text(&campaign.software_version);
    link.text(&campaign.vehicle);
    link.integer(campaign.seed.is_some().into());
    link.integer(campaign.seed.unwrap_or(0).cast_signed());
    link.number(campaign.rudder_limit_rad);
    // Logbooks from before these were kept have the hashes that they had.
    if let Some(full) = campaign.full_rudder {
        link.text("full rudder");
        link.number(full.angle_rad);
        link.integer(full.is_assumed.into());
    }
    if let Some(scenario) = &campaign.scenario {
        link.text("scenario");
        link.text(scenario);
    }
    if campaign.sealed > 0 {
        link.text("notes");
        link.optional_text(campaign.notes.as_deref());
    }
    if campaign.sealed > 1 {
        link.text("trails");
        link.integer(campaign.sealed);
    }
    link.text(&campaign.plan);
    link.hex()
}

/// The link of a finished run.
pub(super) fn run_link(previous: &str, run: &StoredRun) -> Result<String, Error> {
    let mut link = Link::after(previous);
    link.integer(run.number.into());
    link.integer(run.attempt.into());
    link.number(run.thrust);
    link.optional_number(run.surge_speed_m_s);
    link.optional_text(run.verdict.as_deref());
    link.optional_text(run.identification.as_deref());
    link.length(run.stages.len());
    for span in &run.stages {
        link.text(stage_name(span.stage));
        link.number(span.window.from_s);
        link.number(span.window.to_s);
    }
    link.length(run.trace.len());
    for point in &run.trace {
        link.number(point.time_s);
        point.theta.iter().for_each(|value| link.number(*value));
        link.number(point.step_norm);
    }
    link.steps(&run.steps)?;
    Ok(link.hex())
}

/// The link of a row of a [trail](super::trail::Trail): its values, each with its kind.
pub(super) fn row_link(previous: &str, values: &[ValueRef]) -> String {
    let mut link = Link::after(previous);
    for value in values {
        link.text(&value.data_type().to_string());
        match value {
            ValueRef::Null => {}
            ValueRef::Integer(value) => link.integer(*value),
            ValueRef::Real(value) => link.number(*value),
            ValueRef::Text(bytes) | ValueRef::Blob(bytes) => {
                link.length(bytes.len());
                link.0.update(bytes);
            }
        }
    }
    link.hex()
}

/// The last link: how the campaign ended, the steps that belong to no run, and the runs without a result where its hash covers them.
pub(super) fn outcome_link(
    connection: &Connection,
    campaign: i64,
    previous: &str,
    outcome: &str,
    outside: &[Step],
) -> Result<String, Error> {
    let mut link = Link::after(previous);
    link.text(outcome);
    link.steps(outside)?;
    let sealed: Option<i64> = connection.query_row(
        "SELECT notes_sealed FROM campaign WHERE id = ?",
        [campaign],
        |row| row.get(0),
    )?;
    if sealed > Some(2) {
        let unfinished = unfinished_runs(connection, campaign)?;
        link.length(unfinished.len());
        for (number, attempt, thrust) in unfinished {
            link.integer(number.into());
            link.integer(attempt.into());
            link.number(thrust);
        }
    }
    Ok(link.hex())
}

/// The only link of a trial of the pitch axis, as earlier builds kept it: what it ran on, its plan, its result and its samples.
pub(super) fn pitch_link(connection: &Connection, trial: i64) -> Result<String, Error> {
    let mut link = Link::after("");
    connection.query_row(
        "SELECT configuration, entered, software_version, vehicle, seed, plan, result FROM pitch_trial WHERE id = ?",
        [trial],
        |row| {
            for column in 0..4 {
                link.text(&row.get::<_, String>(column)?);
            }
            let seed: Option<i64> = row.get(4)?;
            link.integer(seed.is_some().into());
            link.integer(seed.unwrap_or(0));
            link.text(&row.get::<_, String>(5)?);
            link.text(&row.get::<_, String>(6)?);
            Ok(())
        },
    )?;
    let samples = collect(
        connection,
        "SELECT time_s, pitch_rad, elevator_rad, depth_m, surge_speed_m_s FROM pitch_sample WHERE trial = ? ORDER BY number",
        trial,
        |row| {
            Ok((
                [number(row, 0)?, number(row, 1)?, number(row, 2)?],
                [optional(row, 3)?, optional(row, 4)?],
            ))
        },
    )?;
    link.length(samples.len());
    for (known, optional) in samples {
        known.into_iter().for_each(|value| link.number(value));
        optional.into_iter().for_each(|value| link.optional_number(value));
    }
    Ok(link.hex())
}
