//! Rows that nobody wrote, logs that were cut, files that are gone: told, and never called whole.

use std::fs;
use std::path::{Path, PathBuf};

use rusqlite::Connection;
use seatrial_core::Outcome;
use seatrial_logbook::{CampaignId, Error, Logbook, NewCommand, Recorder};

use crate::{NEW, example_runs};

/// A finished campaign of all runs.
fn write(path: &Path) {
    let mut recorder = begun(path);
    for (run, steps) in &example_runs() {
        recorder.begin_run(run.number, run.thrust, run.attempt).unwrap();
        steps.iter().for_each(|step| recorder.step(*step).unwrap());
        recorder.finish_run(run).unwrap();
    }
    recorder.finish(Outcome::Finished).unwrap();
    let mut logbook = Logbook::open(path).unwrap();
    let entered = logbook.review(CampaignId(1), 1, false, "a ferry passed", "Anna");
    assert_eq!(entered.unwrap(), Some(()));
    let command = NewCommand {
        actor: "Anna",
        address: "",
        command: "review_run",
        details: "{}",
        result: "done",
    };
    logbook.enter_command(&command).unwrap();
}

fn begun(path: &Path) -> Recorder {
    Recorder::begin(Logbook::open(path).unwrap(), &NEW).unwrap()
}

fn altered(folder: &Path, sql: &str) -> PathBuf {
    let path = folder.join("a.db");
    write(&path);
    let connection = Connection::open(&path).unwrap();
    connection.execute_batch("PRAGMA foreign_keys = OFF").unwrap();
    connection.execute_batch(sql).unwrap();
    path
}

#[test]
fn io_a_row_that_nobody_wrote_is_told() {
    for sql in [
        "INSERT INTO run (id, campaign, number, thrust, attempt) SELECT 55, 1, count(*) + 1, 0.5, 1 FROM run",
        "INSERT INTO run (campaign, number, thrust, attempt) SELECT 1, count(*) + 1, 0.5, 1 FROM run",
        "INSERT INTO configuration VALUES (7, 'planted', 'notes')",
        "INSERT INTO configuration VALUES (2, 'planted', 'notes')",
        "UPDATE configuration SET id = 9",
        "INSERT INTO pitch_trial VALUES (1, 'default', '2026-11-27T00:00:00Z', '0.2.0', 'x', 1, '{}', '{}', '')",
        "DELETE FROM review; UPDATE trail SET reviews_sha256 = ''",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = altered(folder.path(), sql);
        let logbook = Logbook::open_read_only(&path).unwrap();
        assert!(!logbook.verify().unwrap().is_whole(), "{sql}");
        let shown = logbook.campaigns().unwrap();
        assert!(shown.len() == 1 && shown[0].damage.is_some(), "{sql}");
        assert!(logbook.damage_among(&[]).unwrap().is_some(), "{sql}");
        assert!(!logbook.campaign(CampaignId(1)).unwrap().verdict().accepted);
        // No gain would be taken from it, so that no trial is kept in it.
        let refused = Logbook::check_writable(&path).unwrap_err();
        assert!(matches!(refused, Error::Damaged { .. }), "{refused}");
        assert!(refused.to_string().contains("--logbook"), "{refused}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = altered(folder.path(), "");
    assert!(Logbook::open_read_only(&path).unwrap().verify().unwrap().is_whole());
    Logbook::check_writable(&path).unwrap();
    Logbook::check_writable(folder.path().join("new.db")).unwrap();
}

/// As after a killed process: the file, its log and, where `with_index`, the shared memory.
fn killed(folder: &Path, with_index: bool) -> PathBuf {
    let path = folder.join("seatrial.db");
    let mut recorder = begun(&path);
    let (run, steps) = &example_runs()[0];
    recorder.begin_run(run.number, run.thrust, run.attempt).unwrap();
    steps.iter().for_each(|step| recorder.step(*step).unwrap());
    let copy = folder.join("killed.db");
    let endings: &[&str] = if with_index { &["", "-wal", "-shm"] } else { &["", "-wal"] };
    for ending in endings {
        let from = folder.join(format!("seatrial.db{ending}"));
        fs::copy(from, folder.join(format!("killed.db{ending}"))).unwrap();
    }
    copy
}

#[test]
fn io_a_write_ahead_log_that_was_cut_or_changed_is_told() {
    // In a process of its own: where other tests have logbooks open, nothing is read beside SQLite.
    const ALONE: &str = "SEATRIAL_TEST_ALONE";
    if std::env::var_os(ALONE).is_none() {
        let name = "lost::io_a_write_ahead_log_that_was_cut_or_changed_is_told";
        let mut alone = std::process::Command::new(std::env::current_exe().unwrap());
        let output = alone.args(["--exact", name]).env(ALONE, "1").output();
        let output = output.unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("1 passed"), "{said}");
        return;
    }
    let cut = |bytes: &mut Vec<u8>, to: usize| bytes.truncate(to);
    let flip = |bytes: &mut Vec<u8>, at: usize| bytes[at] ^= 4;
    type Change<'a> = &'a dyn Fn(&mut Vec<u8>);
    let cases: [(bool, bool, Change); 9] = [
        (true, true, &|_| ()),
        (false, true, &|_| ()),
        // At the end of a frame, within one, and of the header.
        (true, false, &|bytes| {
            let length = bytes.len();
            cut(bytes, length - 4120);
        }),
        (false, false, &|bytes| {
            let length = bytes.len();
            cut(bytes, length - 100);
        }),
        (true, false, &|bytes| cut(bytes, 20)),
        (true, false, &|bytes| cut(bytes, 0)),
        (true, false, &|bytes| flip(bytes, 25)),
        (true, false, &|bytes| flip(bytes, 32 + 200)),
        (false, false, &|bytes| flip(bytes, 32 + 4120 + 200)),
    ];
    for (number, (with_index, is_whole, change)) in cases.into_iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let path = killed(folder.path(), with_index);
        let log = folder.path().join("killed.db-wal");
        let mut bytes = fs::read(&log).unwrap();
        assert!(bytes.len() > 32 + 2 * 4120, "{}", bytes.len());
        change(&mut bytes);
        fs::write(&log, bytes).unwrap();
        let logbook = Logbook::open_read_only(&path).unwrap();
        let found = logbook.verify().unwrap();
        assert_eq!(found.missing.is_none(), is_whole, "{number}: {found:?}");
    }
}

#[cfg(unix)]
#[test]
fn io_a_logbook_that_is_removed_or_replaced_during_a_trial_is_saved_beside() {
    for is_replaced in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        write(&at("other.db"));
        let (run, steps) = &example_runs()[0];
        let mut recorder = begun(&at("a.db"));
        recorder.begin_run(run.number, run.thrust, run.attempt).unwrap();
        steps.iter().for_each(|step| recorder.step(*step).unwrap());
        match is_replaced {
            true => fs::rename(at("other.db"), at("a.db")).unwrap(),
            false => fs::remove_file(at("a.db")).unwrap(),
        }
        recorder.finish_run(run).unwrap();
        let told = recorder.finish(Outcome::Finished).unwrap_err();
        assert!(told.is_not_saved(), "{told}");
        assert!(told.to_string().contains("a-1.db"), "{told}");
        let saved = Logbook::open_read_only(at("a-1.db")).unwrap();
        assert!(saved.verify().unwrap().is_whole());
        let runs = saved.campaign(CampaignId(1)).unwrap().runs;
        assert_eq!(runs, std::slice::from_ref(run));
        if !is_replaced {
            // What is left beside the name holds nothing, and is in nobody's way.
            fs::write(at("a.db-wal"), "").unwrap();
            Logbook::check_writable(at("a.db")).unwrap();
            begun(&at("a.db")).finish(Outcome::Finished).unwrap();
        }
    }
}

#[cfg(unix)]
#[test]
fn io_a_logbook_that_something_else_writes_into_during_a_trial_is_not_called_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    let (run, steps) = &example_runs()[0];
    let mut recorder = begun(&path);
    recorder.begin_run(run.number, run.thrust, run.attempt).unwrap();
    steps.iter().for_each(|step| recorder.step(*step).unwrap());
    fs::OpenOptions::new().write(true).truncate(true).open(&path).unwrap();
    // Where the run itself cannot be written, that is told.
    let told = recorder.finish_run(run).and(recorder.finish(Outcome::Finished));
    assert!(told.is_err(), "{told:?}");
}
