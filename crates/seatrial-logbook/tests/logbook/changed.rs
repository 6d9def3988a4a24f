//! Every value of every row, changed one at a time: verification tells it, or what is read is as it was.

use std::path::Path;

use rusqlite::Connection;
use rusqlite::types::Value;
use seatrial::Step;
use seatrial::campaign::Campaign;
use seatrial_core::Outcome;
use seatrial_logbook::{CampaignEntry, Circumstances, Error, Logbook, NewCampaign, Recorder};

use crate::{NEW, example_runs, example_step};

/// Two campaigns with notes, each with commands and reviews.
fn write_example(path: &Path) {
    for notes in [Some("clean hull"), None] {
        let new = NewCampaign { notes, ..NEW };
        let mut recorder = Recorder::begin(Logbook::open(path).unwrap(), &new).unwrap();
        recorder.step(example_step(0)).unwrap();
        for (run, mut steps) in example_runs() {
            recorder.begin_run(run.number, run.thrust, 1).unwrap();
            let mut run = run;
            run.identification = Some(crate::example_identification());
            run.record.samples.truncate(5);
            steps.truncate(5);
            for step in steps {
                recorder.step(step).unwrap();
            }
            recorder.finish_run(&run).unwrap();
        }
        let mut last = example_step(9);
        last.action.outcome = Some(Outcome::Finished);
        recorder.step(last).unwrap();
        let campaign = recorder.campaign();
        recorder.finish(Outcome::Finished).unwrap();
        let mut logbook = Logbook::open(path).unwrap();
        for accepted in [false, true] {
            let note = "a ferry passed";
            let entered = logbook.review(campaign, 1, accepted, note, "Anna");
            assert_eq!(entered.unwrap(), Some(()));
            let circumstances =
                Circumstances { operator: Some("Anna".into()), ..Circumstances::default() };
            logbook.enter_circumstances(campaign, &circumstances).unwrap();
        }
    }
}

/// Steps with the numbers of their runs.
type Steps = Vec<(Option<u32>, Step)>;

/// All that anybody reads.
#[derive(Debug, PartialEq)]
struct Read {
    entries: Vec<CampaignEntry>,
    campaigns: Vec<(Campaign, Steps)>,
}

fn read(path: &Path) -> Result<(usize, Read), seatrial_logbook::Error> {
    let logbook = Logbook::open_read_only(path)?;
    let damage = logbook.verify()?.damage.len();
    let entries = logbook.campaigns()?;
    let campaigns = entries
        .iter()
        .map(|entry| Ok((logbook.campaign(entry.id)?, logbook.steps(entry.id)?)))
        .collect::<Result<_, seatrial_logbook::Error>>()?;
    Ok((damage, Read { entries, campaigns }))
}

fn rows(connection: &Connection, sql: &str) -> Vec<Vec<Value>> {
    let mut query = connection.prepare(sql).unwrap();
    let columns = query.column_count();
    let rows = query.query_map([], |row| (0..columns).map(|k| row.get(k)).collect());
    rows.unwrap().collect::<Result<_, _>>().unwrap()
}

fn text(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        value => panic!("no text: {value:?}"),
    }
}

/// The values that a value is changed to.
fn changed(value: &Value) -> Vec<Value> {
    match value {
        Value::Null => vec![Value::Integer(1), Value::Real(0.5), Value::Text("x".into())],
        Value::Integer(number) => vec![Value::Integer(number + 1), Value::Null],
        Value::Real(number) => vec![Value::Real(f64::from_bits(number.to_bits() ^ 1)), Value::Null],
        Value::Text(text) => [format!("{text} "), format!(" {text}"), text.to_uppercase()]
            .into_iter()
            .filter(|other| other != text)
            .map(Value::Text)
            .chain([Value::Null])
            .collect(),
        Value::Blob(bytes) => vec![Value::Blob(bytes.iter().map(|byte| !byte).collect())],
    }
}

/// A value of a row.
struct Place {
    table: String,
    column: String,
    /// `id = 1`
    row: String,
    value: Value,
}

/// Every value of the first, the middle and the last row of a table: the rows between are like them.
fn places(connection: &Connection, table: &str) -> Vec<Place> {
    let columns = rows(connection, &format!("SELECT name, pk FROM pragma_table_info('{table}')"));
    let names: Vec<String> = columns.iter().map(|column| text(&column[0])).collect();
    let is_key = |k: &usize| columns[*k][1] != Value::Integer(0);
    let keys: Vec<usize> = (0..columns.len()).filter(is_key).collect();
    let all = rows(connection, &format!("SELECT {} FROM {table}", names.join(", ")));
    let mut chosen = vec![0, all.len() / 2, all.len().saturating_sub(1)];
    chosen.dedup();
    let rows = chosen.into_iter().filter_map(|k| all.get(k));
    rows.flat_map(|row| {
        let condition: Vec<String> = keys
            .iter()
            .map(|&k| match row[k] {
                Value::Integer(number) => format!("{} = {number}", names[k]),
                ref other => panic!("{table}: a key {other:?}"),
            })
            .collect();
        let condition = condition.join(" AND ");
        names.iter().zip(row).map(move |(column, value)| Place {
            table: table.into(),
            column: column.clone(),
            row: condition.clone(),
            value: value.clone(),
        })
    })
    .collect()
}

#[test]
fn io_no_changed_value_of_any_table_goes_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let copy = folder.path().join("changed.db");
    write_example(&path);
    let (damage, before) = read(&path).unwrap();
    assert_eq!(damage, 0);
    let connection = Connection::open(&path).unwrap();
    let tables = rows(&connection, "SELECT name FROM sqlite_schema WHERE type = 'table'");
    let tables = tables.iter().map(|table| text(&table[0]));
    let all: Vec<Place> = tables.flat_map(|table| places(&connection, &table)).collect();
    drop(connection);
    let (mut tried, mut found) = (0, 0);
    let mut missed = Vec::new();
    for place in &all {
        for other in changed(&place.value) {
            std::fs::copy(&path, &copy).unwrap();
            let connection = Connection::open(&copy).unwrap();
            connection
                .execute_batch("PRAGMA foreign_keys = OFF; PRAGMA synchronous = OFF")
                .unwrap();
            let change =
                format!("UPDATE {} SET {} = ? WHERE {}", place.table, place.column, place.row);
            if connection.execute(&change, [&other]).is_err() {
                continue;
            }
            drop(connection);
            tried += 1;
            match read(&copy) {
                Ok((0, now)) if now == before => {}
                Ok((0, _)) => missed.push(format!("{change}, {:?} to {other:?}", place.value)),
                _ => found += 1,
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
    assert!(found > 300 && found * 10 > tried * 9, "{found} of {tried}");
}

/// Beside a logbook that was read nothing is left, and the file is as it was.
#[test]
fn io_reading_leaves_no_file_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    write_example(&path);
    let names = || {
        let entries = std::fs::read_dir(folder.path()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.collect::<Vec<_>>()
    };
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(names(), ["seatrial.db"]);
    for is_read_only in [false, true] {
        let mut permissions = path.metadata().unwrap().permissions();
        permissions.set_readonly(is_read_only);
        std::fs::set_permissions(&path, permissions).unwrap();
        assert_eq!(read(&path).unwrap().0, 0);
        Logbook::check_writable(&path).unwrap_or_default();
        assert_eq!(names(), ["seatrial.db"], "read-only: {is_read_only}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }
}

/// A copy of the example, changed.
fn altered(folder: &Path, change: &str) -> std::path::PathBuf {
    let (path, copy) = (folder.join("seatrial.db"), folder.join("altered.db"));
    if !path.exists() {
        write_example(&path);
    }
    std::fs::copy(&path, &copy).unwrap();
    let connection = Connection::open(&copy).unwrap();
    connection.execute_batch(change).unwrap();
    copy
}

#[test]
fn io_reviews_and_commands_that_nobody_entered_are_told_and_decide_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for change in [
        "INSERT INTO review (run, accepted, note, reviewer, time) SELECT id, 1, '', '', '' FROM run",
        "DELETE FROM review WHERE id = (SELECT max(id) FROM review)",
        "DELETE FROM review; DELETE FROM command",
        "UPDATE command SET actor = 'Ben' WHERE id = 1",
        // Made to look like a logbook from before there were chains.
        "PRAGMA user_version = 6; DROP TABLE trail; DELETE FROM review WHERE id = 2",
    ] {
        let copy = altered(folder.path(), change);
        let logbook = Logbook::open_read_only(&copy).unwrap();
        assert!(!logbook.verify().unwrap().damage.is_empty(), "{change}");
        for entry in logbook.campaigns().unwrap() {
            assert!(entry.damage.is_some(), "{change}");
            assert_eq!(entry.runs_accepted, 0);
            let campaign = logbook.campaign(entry.id).unwrap();
            assert!(campaign.runs.iter().all(|run| !run.verdict.accepted), "{change}");
            assert!(!campaign.verdict().accepted);
        }
        drop(logbook);
        // What is entered later does not heal it.
        let mut logbook = Logbook::open(&copy).unwrap();
        let id = logbook.entries().unwrap()[0].id;
        logbook.review(id, 1, true, "", "Anna").unwrap();
        logbook.enter_circumstances(id, &Circumstances::default()).unwrap();
        assert!(!logbook.verify().unwrap().damage.is_empty(), "{change}");
    }
}

#[test]
fn io_a_schema_that_no_seatrial_writes_is_refused_before_anything_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for (change, part) in [
        ("CREATE TRIGGER accept AFTER UPDATE ON run BEGIN UPDATE run SET verdict = ''; END", "the trigger \"accept\""),
        ("CREATE TRIGGER no BEFORE INSERT ON campaign BEGIN SELECT raise(ABORT, ''); END", "the trigger \"no\""),
        (
            "ALTER TABLE campaign RENAME TO other;
             CREATE VIEW campaign AS WITH RECURSIVE n (x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)
                 SELECT other.* FROM other, n",
            "the ",
        ),
        (
            "PRAGMA writable_schema = ON;
             UPDATE sqlite_schema SET sql = replace(sql, '$.accepted', '$.reasons') WHERE name = 'run'",
            "the table \"run\" was changed",
        ),
        ("DROP INDEX review_of_run", "the index \"review_of_run\" is missing"),
    ] {
        let copy = altered(folder.path(), change);
        let opened = [
            Logbook::open_read_only(&copy).map(drop),
            Logbook::open(&copy).map(drop),
            Logbook::check_writable(&copy),
        ];
        for opened in opened {
            let error = opened.unwrap_err();
            assert!(matches!(error, Error::Altered { .. }), "{error}");
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}

#[test]
fn io_a_damaged_campaign_is_shown_with_its_damage_and_without_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let change = "UPDATE sample SET rudder_rad = 0.1 WHERE campaign = 1 AND number = 3";
    let logbook = Logbook::open_read_only(altered(folder.path(), change)).unwrap();
    let entries = logbook.campaigns().unwrap();
    assert!(entries[0].damage.is_some() && entries[1].damage.is_none());
    let verdict = logbook.campaign(entries[0].id).unwrap().verdict();
    assert!(!verdict.accepted);
    let runs = logbook.campaign(entries[1].id).unwrap().runs;
    assert!(runs.iter().any(|run| run.verdict.accepted));
}

/// Rows out of their places, which no hash covers, are told of their own campaign alone.
#[test]
fn io_what_is_damaged_of_one_campaign_is_not_told_of_another() {
    for change in [
        "UPDATE stage SET number = number + 5 WHERE run = 1",
        "UPDATE trace SET number = number + 5 WHERE run = 1",
        "UPDATE campaign SET interrupted = 1 WHERE id = 1",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let logbook = Logbook::open_read_only(altered(folder.path(), change)).unwrap();
        let entries = logbook.campaigns().unwrap();
        let damage = entries[0].damage.as_ref().unwrap();
        assert_eq!(damage.campaign(), Some(1), "{change}: {damage:?}");
        assert_eq!(entries[1].damage, None, "{change}");
        let ids = [entries[1].id];
        assert_eq!(logbook.damage_among(&ids).unwrap(), None, "{change}");
    }
}

/// A row that belongs to nothing, and pages that two tables share: no campaign of such a file is shown as sound.
#[test]
fn io_a_damaged_file_is_told_with_every_campaign_of_it() {
    let changes = [
        "PRAGMA foreign_keys = OFF;
         INSERT INTO pitch_sample (trial, number, time_s, pitch_rad, elevator_rad) VALUES (9, 1, 0, 0, 0)",
        "PRAGMA writable_schema = ON;
         UPDATE sqlite_schema SET rootpage = (SELECT rootpage FROM sqlite_schema WHERE name = 'command') WHERE name = 'pitch_trial'",
    ];
    for change in changes {
        let folder = tempfile::tempdir().unwrap();
        let logbook = Logbook::open_read_only(altered(folder.path(), change)).unwrap();
        for entry in logbook.campaigns().unwrap() {
            assert!(entry.damage.is_some(), "{change}");
            let verdict = logbook.campaign(entry.id).unwrap().verdict();
            assert!(!verdict.accepted, "{change}");
        }
    }
}
