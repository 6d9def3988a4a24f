//! Rows in their places: numbers, references and texts of rows that the hashes do not cover, because they hash what is read.

use rusqlite::Connection;
use seatrial_core::Outcome;

use super::damage::unreadable;
use super::row::{from_json, to_json};

/// A query that gives a row for each place where something is wrong: the place, and what is wrong there.
struct Check {
    sql: &'static str,
    found: &'static str,
}

const NUMBERS: &str =
    "they are not numbered one after the other: one was taken out, put in or moved";
const UNFINISHED: &str = "parts of a result are there, and no result";

/// Tables whose rows are numbered from 1 on, and what they are.
const LISTS: [(&str, &str); 5] = [
    ("review", "reviews"),
    ("command", "commands"),
    ("run", "runs"),
    ("configuration", "configurations"),
    ("pitch_trial", "pitch trials"),
];

const CHECKS: [Check; 12] = [
    Check {
        sql: "SELECT 'configuration ' || name FROM configuration
              WHERE id NOT IN (SELECT configuration FROM campaign)",
        found: "no campaign has it",
    },
    Check {
        sql: "SELECT 'reviews' FROM trail WHERE (SELECT count(*) FROM command WHERE command = 'review_run' AND result = 'done')
              > (SELECT count(*) FROM review)",
        found: "fewer than operators entered: one was taken out",
    },
    Check {
        sql: "SELECT 'the list of campaigns' FROM campaign
              GROUP BY 1 HAVING min(id) <> 1 OR max(id) <> count(*)",
        found: NUMBERS,
    },
    Check {
        sql: "SELECT 'campaign ' || campaign || ', runs' FROM run
              GROUP BY campaign HAVING min(number) <> 1 OR max(number) <> count(*)",
        found: NUMBERS,
    },
    Check {
        sql: "SELECT 'campaign ' || campaign || ', samples' FROM sample
              GROUP BY campaign HAVING min(number) <> 0 OR max(number) <> count(*) - 1",
        found: NUMBERS,
    },
    Check {
        sql: "SELECT 'campaign ' || run.campaign || ', run ' || run.number || ', stages' FROM stage JOIN run ON run.id = stage.run
              GROUP BY stage.run HAVING min(stage.number) <> 0 OR max(stage.number) <> count(*) - 1",
        found: NUMBERS,
    },
    Check {
        sql: "SELECT 'campaign ' || run.campaign || ', run ' || run.number || ', trace' FROM trace JOIN run ON run.id = trace.run
              GROUP BY trace.run HAVING min(trace.number) <> 0 OR max(trace.number) <> count(*) - 1",
        found: NUMBERS,
    },
    Check {
        sql: "SELECT DISTINCT 'campaign ' || sample.campaign || ', samples'
              FROM sample JOIN run ON run.id = sample.run WHERE run.campaign <> sample.campaign",
        found: "a sample belongs to a run of another campaign",
    },
    Check {
        sql: "SELECT 'campaign ' || run.campaign || ', run ' || run.number || ', samples' FROM sample JOIN run ON run.id = sample.run
              GROUP BY sample.run HAVING max(sample.number) - min(sample.number) + 1 <> count(*)",
        found: "its samples do not follow each other: one of another run is among them",
    },
    Check {
        sql: "SELECT DISTINCT 'campaign ' || campaign || ', run ' || number FROM run
              WHERE sha256 IS NULL AND (verdict IS NOT NULL OR sample_count IS NOT NULL
                OR id IN (SELECT run FROM estimate) OR id IN (SELECT run FROM stage) OR id IN (SELECT run FROM trace))",
        found: UNFINISHED,
    },
    Check {
        sql: "SELECT 'campaign ' || id FROM campaign
              WHERE interrupted NOT IN (0, 1) OR (interrupted = 1 AND outcome IS NOT NULL)",
        found: "the mark of an interrupted campaign was changed",
    },
    Check {
        sql: "SELECT 'configuration ' || name FROM configuration
              JOIN (SELECT configuration, notes, notes_sealed, max(id) FROM campaign GROUP BY configuration) AS newest
                ON newest.configuration = configuration.id
              WHERE newest.notes_sealed IS NOT NULL AND newest.notes IS NOT configuration.notes",
        found: "its notes are not those of its newest campaign",
    },
];

/// Every place where a row is not as it was written, and what is wrong there.
pub(super) fn misplaced(connection: &Connection) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let lists = LISTS.map(|(table, rows)| {
        let sql = format!("SELECT 'the list of {rows}' FROM {table} GROUP BY 1 HAVING min(id) <> 1 OR max(id) <> count(*)");
        (sql, NUMBERS)
    });
    let checks = CHECKS.iter().map(|check| (check.sql.into(), check.found));
    for (sql, wrong) in lists.into_iter().chain(checks) {
        match column(connection, &sql) {
            Ok(places) => found.extend(places.into_iter().map(|place| (place, wrong.into()))),
            Err(error) => found.push(("the file".into(), unreadable(&error))),
        }
    }
    match column(connection, OUTCOMES) {
        Ok(texts) => {
            let other = texts.iter().filter(|text| !is_as_written(text));
            let finding = "how a campaign or a run ended is not written as seatrial writes it";
            found.extend(other.map(|_| ("outcomes".into(), finding.into())));
        }
        Err(error) => found.push(("outcomes".into(), unreadable(&error))),
    }
    found
}

const OUTCOMES: &str = "SELECT outcome FROM campaign WHERE outcome IS NOT NULL
     UNION SELECT action_outcome FROM sample WHERE action_outcome IS NOT NULL";

/// Hashes are made of what an outcome says, so that blanks around it would not show.
fn is_as_written(text: &str) -> bool {
    let outcome = from_json::<Outcome>(0, text);
    outcome.and_then(|outcome| to_json(&outcome)).is_ok_and(|again| again == text)
}

fn column(connection: &Connection, sql: &str) -> Result<Vec<String>, rusqlite::Error> {
    let mut query = connection.prepare(sql)?;
    query.query_map([], |row| row.get(0))?.collect()
}
