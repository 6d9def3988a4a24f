//! Jobs over simulated logs: rows, error rows, resuming, runs in one file.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use seatrial_app::fleet::{
    Entry, Estimate, Job, Journal, Options, Row, Source, Summary, find, work_on,
};
use seatrial_app::logs::{NoObserver, ReadSettings, open};
use seatrial_core::{List, Plan, Sample, Trial, Vehicle};
use seatrial_logs::write_csv;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// A run of the paper's plan at one speed: a manoeuvre to train, one to validate.
pub fn run(seed: u64) -> Vec<Sample<f64>> {
    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), seed).unwrap();
    let plan = Plan { thrusts: List::from_slice(&[0.8]).unwrap(), max_repeats: 0, ..Plan::paper() };
    let mut trial = Trial::new(plan).unwrap();
    let mut samples = Vec::new();
    while let Some(sample) = vehicle.next_sample().unwrap() {
        samples.push(sample);
        let action = trial.step(&sample);
        vehicle.act(&action).unwrap();
        if action.outcome.is_some() {
            break;
        }
    }
    samples
}

fn write(path: &Path, samples: &[Sample<f64>]) {
    let rows: Vec<_> = samples.iter().copied().map(Into::into).collect();
    write_csv(fs::File::create(path).unwrap(), &rows).unwrap();
}

/// Six logs, one cut off in the middle of a number, one of text, one without a rudder.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str| folder.path().join(name);
    for seed in 1..=6 {
        write(&of(&format!("run{seed}.csv")), &run(seed));
    }
    let mut text = fs::read_to_string(of("run1.csv")).unwrap();
    text.push_str("1e9,what,0\n");
    fs::write(of("bad_number.csv"), text).unwrap();
    fs::write(of("empty.csv"), "").unwrap();
    fs::write(of("no_rudder.csv"), "time_s,heading_rad\n0,0\n1,0\n").unwrap();
    fs::write(of("notes.md"), "not a log").unwrap();
    folder
}

fn job(folder: &Path, workers: usize) -> Job {
    let found = find(&[folder.display().to_string()], &folder.join("fleet.out")).unwrap();
    assert_eq!(found.passed_over, 1);
    let mut options = Options::default();
    options.estimate = Estimate::Online;
    Job { sources: found.sources, options, out: folder.join("fleet.out"), workers, resume: false }
}

/// Runs it; the Parquet file's bytes say whether two jobs gave the same rows.
fn done(job: &Job) -> (Summary, Vec<u8>) {
    let summary = job.run(|_| ControlFlow::Continue(())).unwrap().unwrap();
    let bytes = fs::read(&job.out).unwrap();
    fs::remove_file(&job.out).unwrap();
    (summary, bytes)
}

#[test]
fn io_every_log_has_its_rows_and_every_bad_one_its_error() {
    let folder = folder();
    let (summary, _) = done(&job(folder.path(), 2));
    assert_eq!((summary.logs, summary.errors), (9, 3));
    // Each run has a manoeuvre to train and one to validate.
    assert_eq!((summary.manoeuvres, summary.accepted), (12, 12), "{summary:?}");
    let codes: Vec<&str> = summary.error_codes.keys().map(String::as_str).collect();
    assert_eq!(codes, ["invalid_row", "missing_channel", "no_samples"]);
}

/// A row says in what its rudder is, and warns as `identify` does.
#[test]
fn exact_rows_say_how_their_log_was_read() {
    let folder = folder();
    let angles = folder.path().join("run1.csv");
    let pulses = folder.path().join("pulses.csv");
    let samples = run(1);
    let mut text = String::from("time_s,heading_rad,rudder_pwm\n");
    for Sample { time_s, heading_rad, rudder_rad, .. } in &samples {
        let pulse_us = 1500.0 + 1000.0 * rudder_rad;
        text += &format!("{time_s},{heading_rad},{pulse_us}\n");
    }
    fs::write(&pulses, text).unwrap();
    for (path, unit) in [(angles, "rad"), (pulses, "full_rudder")] {
        let settings = ReadSettings::default();
        let opened = open(&path, &settings, None, &mut NoObserver).unwrap();
        let source = &Source::of(&path);
        let entries = work_on(source, &job(folder.path(), 1).options);
        assert!(!entries[0].rows.is_empty());
        for row in &entries[0].rows {
            assert_eq!(row.rudder_unit.as_deref(), Some(unit));
            let warned = row.warnings.iter().flatten().flat_map(|text| text.lines());
            assert!(warned.eq(opened.warnings.iter().flat_map(|text| text.lines())));
        }
        assert_eq!(opened.warnings.is_empty(), unit == "rad");
    }
}

#[test]
fn prop_rows_do_not_depend_on_the_workers() {
    let folder = folder();
    assert_eq!(done(&job(folder.path(), 1)), done(&job(folder.path(), 3)));
}

/// Broken off after every number of logs, with the last line of the journal cut off as by a kill.
#[test]
fn io_a_job_that_was_broken_off_goes_on_where_it_stopped() {
    let folder = folder();
    let mut job = job(folder.path(), 1);
    let (whole, bytes) = done(&job);
    let journal = folder.path().join("fleet.out.journal");
    for stop_after in 1..8 {
        job.resume = false;
        let seen = std::sync::atomic::AtomicUsize::new(0);
        let stopped = job.run(|_| {
            let count = 1 + seen.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            match count < stop_after {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        });
        assert_eq!(stopped.unwrap(), None);
        let kept = fs::read(&journal).unwrap();
        fs::write(&journal, &kept[..kept.len() - 7]).unwrap();
        assert!(job.run(|_| ControlFlow::Continue(())).is_err());
        job.resume = true;
        let (resumed, again) = done(&job);
        assert_eq!(resumed.done_before, stop_after as u64 - 1);
        assert_eq!(Summary { done_before: 0, ..resumed }, whole);
        assert_eq!(again, bytes);
        assert!(!journal.exists());
    }
}

/// A second job reads what is new, changed or unreadable, and gives what a first one would.
#[test]
fn io_a_second_job_reads_only_what_is_new_or_changed() {
    let (folder, tables) = (folder(), tempfile::tempdir().unwrap());
    let of = |name: &str| folder.path().join(name);
    let run_again = |out: &str| {
        let mut job = job(folder.path(), 1);
        job.out = tables.path().join(out);
        let read = std::sync::atomic::AtomicUsize::new(0);
        let summary = job.run(|_| {
            read.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            ControlFlow::Continue(())
        });
        let table = fs::read(&job.out).unwrap();
        (summary.unwrap().unwrap(), read.into_inner(), table)
    };
    let (_, read, first) = run_again("fleet.out");
    assert_eq!(read, 9);
    // The three that cannot be read are tried again.
    let (summary, read, second) = run_again("fleet.out");
    assert_eq!((summary.logs, summary.done_before, read), (9, 6, 3));
    assert_eq!(second, first);

    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(9);
    let touch = |name: &str| {
        let file = fs::File::options().append(true).open(of(name)).unwrap();
        file.set_modified(later).unwrap();
    };
    // Of another time: the same bytes, and as many others.
    touch("run1.csv");
    write(&of("run2.csv"), &run(7)[..300]);
    fs::write(of("run3.csv"), fs::read_to_string(of("run3.csv")).unwrap().replace("0.1", "0.2"))
        .unwrap();
    touch("run3.csv");
    fs::remove_file(of("run4.csv")).unwrap();
    write(&of("run8.csv"), &run(8));
    let (summary, read, second) = run_again("fleet.out");
    assert_eq!((summary.logs, summary.done_before, read), (9, 3, 6));
    let (summary, read, fresh) = run_again("fresh.out");
    assert_eq!((summary.done_before, read), (0, 9));
    assert!(second == fresh, "{summary:?}");

    let mut other = job(folder.path(), 1);
    other.out = tables.path().join("fleet.out");
    other.options.estimate = Estimate::Refined;
    let summary = other.run(|_| ControlFlow::Continue(())).unwrap().unwrap();
    assert_eq!(summary.done_before, 0);
}

/// The runs of an unchanged file are not looked for again, whatever the table is called.
#[test]
fn io_a_second_job_keeps_the_runs_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = String::from("time_s,heading_rad,rudder_rad,mission\n");
    for seed in 1..=3 {
        for sample in run(seed) {
            let Sample { time_s, heading_rad, rudder_rad, .. } = sample;
            rows += &format!("{time_s},{heading_rad},{rudder_rad},m{seed}\n");
        }
    }
    fs::write(folder.path().join("season.csv"), rows).unwrap();
    let out = folder.path().join("fleet.parquet");
    let inputs = [folder.path().display().to_string()];
    let mut options = Options::default();
    options.estimate = Estimate::Online;
    options.run_column = Some("mission".into());
    let mut tables = Vec::new();
    for kept in [0, 3] {
        let job = Job {
            sources: find(&inputs, &out).unwrap().sources,
            options: options.clone(),
            out: out.clone(),
            workers: 2,
            resume: kept > 0,
        };
        let summary = job.run(|_| ControlFlow::Continue(())).unwrap().unwrap();
        assert_eq!((summary.logs, summary.done_before), (3, kept));
        tables.push(fs::read(&out).unwrap());
    }
    assert!(tables[0] == tables[1]);
}

#[test]
fn io_a_journal_of_other_options_is_not_gone_on_with() {
    let folder = folder();
    let mut job = job(folder.path(), 1);
    assert_eq!(job.run(|_| ControlFlow::Break(())).unwrap(), None);
    job.resume = true;
    job.options.estimate = Estimate::Refined;
    let error = job.run(|_| ControlFlow::Continue(())).unwrap_err();
    assert!(error.to_string().contains("other options"), "{error}");
}

/// What workers elsewhere send, some of it twice, gives the same file.
#[test]
fn io_entries_from_elsewhere_are_kept_once() {
    let folder = folder();
    let job = job(folder.path(), 2);
    let (_, bytes) = done(&job);
    let mut journal = Journal::open(&job.out, &job.sources, &job.options, false).unwrap();
    for source in job.sources.iter().rev().chain(&job.sources[..3]) {
        for entry in work_on(source, &job.options) {
            let sent = serde_json::to_vec(&entry).unwrap();
            let entry: Entry = serde_json::from_slice(&sent).unwrap();
            journal.keep(&entry).unwrap();
        }
    }
    journal.finish().unwrap();
    assert_eq!(fs::read(&job.out).unwrap(), bytes);
}

/// The estimates of a run within a file are those of the run as a log of its own.
#[test]
fn io_runs_of_one_file_are_logs_of_their_own() {
    let folder = folder();
    let mut together = String::new();
    for seed in 1..=3 {
        let text = fs::read_to_string(folder.path().join(format!("run{seed}.csv"))).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap();
        if seed == 1 {
            together += &format!("{header},mission\n");
        }
        for line in lines {
            together += &format!("{line},m{seed}\n");
        }
    }
    // Rows of a run that is over.
    let again = together.lines().nth(1).unwrap().to_owned();
    together += &format!("{again}\n");
    let path = folder.path().join("season.csv");
    fs::write(&path, together).unwrap();
    let mut options = job(folder.path(), 1).options;
    options.run_column = Some("mission".into());
    let sources = [Source::of(&path)];
    let entries = work_on(&sources[0], &options);
    assert_eq!(entries.len(), 4);
    for (entry, seed) in entries.iter().zip(1..=3) {
        let alone = Source::of(&folder.path().join(format!("run{seed}.csv")));
        let alone = work_on(&alone, &job(folder.path(), 1).options);
        let theta = |row: &Row| (row.from_s, row.a22_per_s, row.b2_per_s2, row.c0_rad_per_s2);
        let of_run: Vec<_> = entry.rows.iter().map(theta).collect();
        let of_log: Vec<_> = alone[0].rows.iter().map(theta).collect();
        assert_eq!(of_run, of_log);
        assert_eq!(entry.rows[0].run, Some(format!("m{seed}")));
    }
    assert_eq!(entries[3].rows[0].error.as_deref(), Some("run"));
}
