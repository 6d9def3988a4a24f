//! The logbook: exact, durable, provable, and clear about files that are none.

mod changed;
mod draw;
mod lost;

use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use rusqlite::Connection;
use seatrial::Step;
use seatrial::campaign::{Campaign, Run, Stage};
use seatrial::identification::{Identification, ReasonCode};
use seatrial_core::{Action, Outcome, Sample, Steering, YawModel};
use seatrial_logbook::{CampaignId, Error, Logbook, NewCampaign, NewCommand, Recorder, State};

use draw::Draw;

const NEW: NewCampaign = NewCampaign {
    configuration: "bare hull",
    notes: None,
    software_version: "0.1.0",
    vehicle: "sim:starfish",
    seed: Some(u64::MAX),
    rudder_limit_rad: 0.26,
    full_rudder: None,
    scenario: None,
    plan: "speeds = [0.6, 0.8]\n",
};

/// Any double at all: subnormal, -0, infinite, every NaN.
fn any_bits() -> impl Strategy<Value = f64> {
    prop_oneof![any::<u64>().prop_map(f64::from_bits), any::<i8>().prop_map(f64::from), Just(-0.0)]
}

fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NORMAL, SUBNORMAL, ZERO};
    NORMAL | SUBNORMAL | ZERO
}

/// Writes one campaign of the given runs, each with its steps.
fn write(path: &Path, runs: &[(Run, Vec<Step>)]) -> CampaignId {
    let mut recorder = Recorder::begin(Logbook::open(path).unwrap(), &NEW).unwrap();
    let campaign = recorder.campaign();
    for (run, steps) in runs {
        recorder.begin_run(run.number, run.thrust, run.attempt).unwrap();
        for step in steps {
            recorder.step(*step).unwrap();
        }
        recorder.finish_run(run).unwrap();
    }
    recorder.step(example_step(7)).unwrap();
    recorder.finish(Outcome::Finished).unwrap();
    campaign
}

proptest! {
    // Each case writes a file: fewer cases than usual keep this to seconds.
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn prop_every_step_and_run_comes_back_bit_for_bit(
        steps in vec(vec(any_bits(), 60), 0..40),
        results in vec(vec(finite(), 200), 1..4),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("seatrial.db");
        let steps: Vec<Step> = steps.into_iter().map(|n| Draw::from(n).step()).collect();
        let runs: Vec<(Run, Vec<Step>)> = (1..)
            .zip(results)
            .map(|(number, n)| (Draw::from(n).run(number, &steps), steps.clone()))
            .collect();
        let id = write(&path, &runs);

        let logbook = Logbook::open_read_only(&path).unwrap();
        let campaign = logbook.campaign(id).unwrap();
        prop_assert_eq!(campaign.seed, NEW.seed);
        prop_assert_eq!(campaign.outcome, Some(Outcome::Finished));
        prop_assert_eq!(campaign.runs.len(), runs.len());
        let read_steps = logbook.steps(id).unwrap();
        prop_assert_eq!(read_steps.len(), steps.len() * runs.len() + 1);
        let written = runs.iter().flat_map(|(run, steps)| {
            steps.iter().map(|step| (Some(run.number), step))
        });
        for ((read_run, read), (run, step)) in read_steps.iter().zip(written) {
            prop_assert!(read.same_bits(step));
            prop_assert_eq!(*read_run, run);
        }
        for (read, (run, _)) in campaign.runs.iter().zip(&runs) {
            // The samples are compared above; a NaN is not equal to itself. Debug text tells -0 from 0.
            let result = |run: &Run| format!("{:?}", Run { record: Default::default(), ..run.clone() });
            prop_assert_eq!(result(read), result(run));
        }
        let verification = logbook.verify().unwrap();
        prop_assert_eq!(verification.damage, vec![]);
        prop_assert_eq!(verification.samples, read_steps.len());
    }
}

fn example_step(k: u32) -> Step {
    let t = f64::from(k) * 0.05;
    Step {
        sample: Sample {
            time_s: t,
            heading_rad: (0.4 * t).sin(),
            rudder_rad: 0.26,
            surge_speed_m_s: Some(1.07),
            depth_m: Some(2.0),
            yaw_rate_rad_s: Some((0.4 * t).cos()),
            ..Sample::default()
        },
        stage: Some(Stage::Train),
        action: Action { steering: Steering::Rudder(0.26), thrust: Some(0.6), outcome: None },
        estimate: Some(YawModel::from_theta([-1.0 / 3.0, 1.08, 0.012])),
    }
}

/// A plausible campaign: two runs of 200 samples at 20 Hz.
fn example_runs() -> Vec<(Run, Vec<Step>)> {
    (1..=2)
        .map(|number| {
            let steps: Vec<Step> = (0..200).map(example_step).collect();
            let numbers = (0..200).map(|k| 1.0 / f64::from(k + 3)).collect();
            (Draw::from(numbers).run(number, &steps), steps)
        })
        .collect()
}

/// An identification with a refined model.
fn example_identification() -> Identification {
    (0..)
        .map(|first| (first..first + 200).map(f64::from).collect())
        .map(|numbers| Draw::from(numbers).identification())
        .find(|identification| identification.refined.is_some())
        .unwrap()
}

fn example(path: &Path) -> Campaign {
    let id = write(path, &example_runs());
    Logbook::open_read_only(path).unwrap().campaign(id).unwrap()
}

#[test]
fn io_verify_names_what_was_changed_and_where() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("UPDATE sample SET depth_m = 2.5 WHERE run = 2 AND number = 217", "campaign 1, run 2"),
        (
            "UPDATE sample SET action_thrust = NULL WHERE run = 1 AND number = 3",
            "campaign 1, run 1",
        ),
        (
            "UPDATE sample SET heading_rad = 'north' WHERE run = 2 AND number = 205",
            "campaign 1, run 2",
        ),
        ("DELETE FROM sample WHERE run = 2 AND number = 399", "campaign 1, run 2"),
        ("UPDATE run SET verdict = replace(verdict, 'code', 'cod')", "campaign 1, run 1"),
        ("UPDATE stage SET stage = 'validate' WHERE run = 1", "campaign 1, run 1"),
        ("UPDATE sample SET rudder_rad = 0.2 WHERE run IS NULL", "campaign 1"),
        ("UPDATE campaign SET plan = plan || ' '", "campaign 1"),
        ("UPDATE campaign SET vehicle = 'sim:remus100'", "campaign 1"),
        ("UPDATE campaign SET outcome = NULL", "campaign 1"),
        ("UPDATE run SET sha256 = NULL WHERE number = 2", "campaign 1"),
        (
            "PRAGMA foreign_keys = OFF; DELETE FROM run WHERE number = 2",
            "entries of the kind sample",
        ),
        (
            "DELETE FROM sample; DELETE FROM stage; DELETE FROM trace;
             DELETE FROM estimate; DELETE FROM run",
            "campaign 1",
        ),
    ];
    for (k, (change, place)) in changes.iter().enumerate() {
        let path = folder.path().join(format!("{k}.db"));
        example(&path);
        let damage = || {
            let logbook = Logbook::open_read_only(&path).unwrap();
            logbook.verify().unwrap().damage
        };
        assert_eq!(damage(), []);
        let connection = Connection::open(&path).unwrap();
        connection.execute_batch(change).unwrap();
        let damage = damage();
        assert!(damage.iter().any(|damage| damage.place == *place), "{change}: {damage:?}");
    }
}

/// Whatever byte is flipped: either it is noticed, or nothing that was recorded has changed.
#[test]
fn io_no_flipped_byte_goes_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let campaign = example(&path);
    let bytes = std::fs::read(&path).unwrap();
    let flipped = folder.path().join("flipped.db");
    let mut noticed = 0;
    for k in 0..400 {
        let at = k * 7919 % bytes.len();
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (k % 8);
        std::fs::write(&flipped, damaged).unwrap();
        let verified =
            Logbook::open_read_only(&flipped).and_then(|logbook| Ok((logbook.verify()?, logbook)));
        match verified {
            Ok((verification, logbook)) if verification.damage.is_empty() => {
                let read = logbook.campaign(CampaignId(1)).unwrap();
                assert_eq!(read, campaign, "byte {at} was flipped");
            }
            _ => noticed += 1,
        }
    }
    // About half of so small a file is free space and the schema's comments.
    assert!(noticed > 150, "{noticed} of 400 noticed");
}

#[test]
fn io_an_interrupted_campaign_keeps_its_runs_and_partial_data() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let runs = example_runs();
    let mut recorder = Recorder::begin(Logbook::open(&path).unwrap(), &NEW).unwrap();
    recorder.begin_run(1, runs[0].0.thrust, 1).unwrap();
    for step in &runs[0].1 {
        recorder.step(*step).unwrap();
    }
    recorder.finish_run(&runs[0].0).unwrap();
    recorder.begin_run(2, 0.7, 1).unwrap();
    for step in &runs[1].1 {
        recorder.step(*step).unwrap();
    }
    let reader = Logbook::open_read_only(&path).unwrap();
    assert_eq!(reader.campaigns().unwrap()[0].state, State::Unfinished);
    drop(recorder);

    let logbook = Logbook::open(&path).unwrap();
    let entry = logbook.entry(CampaignId(1)).unwrap();
    assert_eq!(entry.state, State::Interrupted);
    assert_eq!((entry.runs, entry.runs_finished), (2, 1));
    let campaign = logbook.campaign(CampaignId(1)).unwrap();
    assert_eq!(campaign.runs[0], runs[0].0);
    assert!(!campaign.runs[1].verdict.accepted);
    // At most the last second (20 samples) of the unfinished run is lost.
    assert!(campaign.runs[1].record.samples.len() >= 180);
    assert_eq!(campaign.outcome, None);
    let verification = logbook.verify().unwrap();
    assert_eq!(verification.damage, []);
    assert_eq!(verification.campaigns_unfinished, 1);
    assert_eq!(verification.runs_unfinished, 1);
}

/// What is copied of a trial under way: the file alone holds every finished run, and says that more may be missing.
#[test]
fn io_a_copy_without_its_write_ahead_log_holds_finished_runs_and_says_what_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let runs = example_runs();
    let mut recorder = Recorder::begin(Logbook::open(&path).unwrap(), &NEW).unwrap();
    for (run, steps) in &runs {
        recorder.begin_run(run.number, run.thrust, 1).unwrap();
        for step in steps {
            recorder.step(*step).unwrap();
        }
        recorder.finish_run(run).unwrap();
        recorder.step(steps[0]).unwrap();
    }
    let copy = folder.path().join("copy.db");
    std::fs::copy(&path, &copy).unwrap();
    let alone = Logbook::open_read_only(&copy).unwrap();
    let campaign = alone.campaign(CampaignId(1)).unwrap();
    assert_eq!(
        campaign.runs.iter().collect::<Vec<_>>(),
        runs.iter().map(|(run, _)| run).collect::<Vec<_>>()
    );
    let missing = alone.missing().expect("it says so");
    assert!(missing.contains("copy.db-wal"), "{missing}");
    let found = alone.verify().unwrap();
    assert_eq!(found.damage, []);
    assert!(!found.is_whole());
    // Beside a writer, and once the campaign has ended, nothing is missing.
    assert_eq!(Logbook::open_read_only(&path).unwrap().missing(), None);
    recorder.finish(Outcome::Finished).unwrap();
    let ended = Logbook::open_read_only(&path).unwrap();
    assert!(ended.missing().is_none() && ended.verify().unwrap().is_whole());
}

#[test]
fn io_a_logbook_that_is_renamed_during_a_trial_keeps_all_of_it_and_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let (path, renamed) = (folder.path().join("a.db"), folder.path().join("b.db"));
    let (run, steps) = &example_runs()[0];
    let mut recorder = Recorder::begin(Logbook::open(&path).unwrap(), &NEW).unwrap();
    recorder.begin_run(run.number, run.thrust, 1).unwrap();
    std::fs::rename(&path, &renamed).unwrap();
    // Another logbook of the old name would get what is written here.
    for refused in [Logbook::open(&path).map(drop), Logbook::check_writable(&path)] {
        assert!(refused.unwrap_err().to_string().contains("a.db-wal"));
    }
    for step in steps {
        recorder.step(*step).unwrap();
    }
    recorder.finish_run(run).unwrap();
    let told = recorder.finish(Outcome::Finished).unwrap_err();
    assert!(told.is_not_saved() && told.to_string().contains("renamed"), "{told}");
    let logbook = Logbook::open_read_only(&renamed).unwrap();
    assert!(logbook.verify().unwrap().is_whole());
    assert_eq!(logbook.campaign(CampaignId(1)).unwrap().runs, std::slice::from_ref(run));
}

/// A process killed while it writes without WAL, as it does while it makes the file.
#[test]
fn io_what_a_killed_process_left_half_written_is_rolled_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let campaign = example(&path);
    let writer = Connection::open(&path).unwrap();
    // A cache of one page: changes reach the file before they are committed.
    writer
        .execute_batch(
            "PRAGMA journal_mode = DELETE; PRAGMA cache_size = 1;
             BEGIN; UPDATE sample SET depth_m = depth_m + 1",
        )
        .unwrap();
    let killed = folder.path().join("killed.db");
    std::fs::copy(&path, &killed).unwrap();
    let journal = |name: &str| folder.path().join(format!("{name}.db-journal"));
    std::fs::copy(journal("seatrial"), journal("killed")).unwrap();

    let logbook = Logbook::open_read_only(&killed).unwrap();
    assert_eq!(logbook.verify().unwrap().damage, []);
    assert_eq!(logbook.campaign(CampaignId(1)).unwrap(), campaign);
}

/// On a medium that is mounted read-only, say. (The superuser may write anyway.)
#[cfg(unix)]
#[test]
fn io_a_logbook_in_a_folder_that_cannot_be_written_to_is_read() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let allow = |mode| {
        let permissions = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(folder.path(), permissions).unwrap();
    };
    let path = folder.path().join("50 % #1?.db");
    let campaign = example(&path);
    allow(0o555);
    let read = Logbook::open_read_only(&path).and_then(|logbook| logbook.campaign(CampaignId(1)));
    allow(0o755);
    assert_eq!(read.unwrap(), campaign);
}

#[test]
fn io_columns_for_queries_are_the_model_that_goes_to_the_controller() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let mut runs = example_runs();
    let mut identification = example_identification();
    runs[0].0.verdict.accepted = true;
    runs[0].0.identification = Some(identification.clone());
    identification.refined = None;
    runs[1].0.identification = Some(identification);
    write(&path, &runs);
    let connection = Connection::open(&path).unwrap();
    for (run, _) in &runs {
        let columns: ([f64; 3], Option<f64>, bool) = connection
            .query_row(
                "SELECT a22_per_s, b2_per_s2, c0_rad_per_s2, b2_high_per_s2, accepted
                 FROM estimate JOIN run ON run.id = estimate.run WHERE number = ?",
                [run.number],
                |row| {
                    let theta = [row.get(0)?, row.get(1)?, row.get(2)?];
                    Ok((theta, row.get(3)?, row.get(4)?))
                },
            )
            .unwrap();
        let identification = run.identification.as_ref().unwrap();
        let refined = identification.refined.as_ref();
        let high = refined.map(|refined| refined.interval_95.b2_per_s2[1]);
        let theta = identification.model().theta();
        assert_eq!(columns, (theta, high, run.verdict.accepted));
    }
}

#[test]
fn io_a_result_that_cannot_be_kept_exactly_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let (mut run, steps) = example_runs().remove(0);
    let mut logbook = Logbook::open(&path).unwrap();
    let campaign = logbook.begin_campaign(&NEW).unwrap();
    let id = logbook.begin_run(campaign, 1, run.thrust, 1).unwrap();
    let steps: Vec<_> = steps.into_iter().map(|step| (Some(id), step)).collect();
    logbook.append(campaign, &steps[..150]).unwrap();
    let short = logbook.finish_run(id, &run).unwrap_err();
    assert!(short.to_string().contains("200 samples is not the 150"), "{short}");

    logbook.append(campaign, &steps[150..]).unwrap();
    let mut identification = example_identification();
    identification.online.model.b2_per_s2 = f64::INFINITY;
    run.identification = Some(identification);
    let infinite = logbook.finish_run(id, &run).unwrap_err();
    assert!(infinite.to_string().contains("not finite"), "{infinite}");
    assert!(infinite.is_not_saved());
}

#[test]
fn io_files_that_are_no_logbook_are_named_for_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("text"), "time_s,heading_rad\n".repeat(100)).unwrap();
    let foreign = Connection::open(file("foreign")).unwrap();
    foreign.execute_batch("CREATE TABLE songs (name)").unwrap();
    example(&file("newer"));
    let newer = Connection::open(file("newer")).unwrap();
    newer.pragma_update(None, "user_version", 99).unwrap();
    example(&file("cut"));
    let bytes = std::fs::read(file("cut")).unwrap();
    std::fs::write(file("cut"), &bytes[..bytes.len() / 2]).unwrap();

    let missing = Logbook::open_read_only(file("none")).unwrap_err();
    assert!(matches!(missing, Error::Missing(_)));
    for open in [Logbook::open, Logbook::open_read_only] {
        let fails = |path: &Path| open(path.to_path_buf()).unwrap_err();
        for (path, found) in [
            (file("text"), "whose beginning was overwritten"),
            (file("foreign"), "an SQLite database of something else"),
            (folder.path().to_path_buf(), "a directory"),
        ] {
            let error = fails(&path);
            assert!(!error.is_not_saved());
            assert!(error.to_string().contains(found), "{error}");
        }
        let newer = fails(&file("newer"));
        assert!(matches!(newer, Error::Newer { found: 99, .. }));
        assert!(!fails(&file("none/such/folder")).is_not_saved());
    }
    let verified = Logbook::open_read_only(file("cut")).and_then(|logbook| logbook.verify());
    assert!(verified.map_or(true, |found| !found.damage.is_empty()));
    // What was refused was not touched.
    let text = std::fs::read_to_string(file("text")).unwrap();
    assert!(text.starts_with("time_s"));
}

/// A logbook in the field stays readable and provable, whatever the schema and the types become.
#[test]
fn regress_a_logbook_of_schema_1_is_read_migrated_and_continued() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let old = Connection::open(&path).unwrap();
    old.execute_batch(include_str!("schema_1.sql")).unwrap();
    drop(old);
    let holds_the_campaign = |logbook: &Logbook| {
        assert_eq!(logbook.verify().unwrap().damage, []);
        let campaign = logbook.campaign(CampaignId(1)).unwrap();
        let run = &campaign.runs[0];
        assert_eq!(run.record.samples[2].heading_rad, 1.0 / 3.0);
        assert!(run.record.samples[1].heading_rad.is_nan());
        let identification = run.identification.as_ref().unwrap();
        assert_eq!(identification.online.trace[0].theta, [52.0, 53.0, 54.0]);
    };
    holds_the_campaign(&Logbook::open_read_only(&path).unwrap());
    holds_the_campaign(&Logbook::open(&path).unwrap());
    assert_eq!(write(&path, &example_runs()), CampaignId(2));
    holds_the_campaign(&Logbook::open_read_only(&path).unwrap());
    // Its table of samples had no thrust.
    let mut recorder = Recorder::begin(Logbook::open(&path).unwrap(), &NEW).unwrap();
    let mut step = example_step(1);
    step.sample.thrust = Some(0.6);
    recorder.step(step).unwrap();
    recorder.finish(Outcome::Finished).unwrap();
    let logbook = Logbook::open_read_only(&path).unwrap();
    holds_the_campaign(&logbook);
    assert_eq!(logbook.steps(CampaignId(3)).unwrap(), [(None, step)]);
}

#[test]
fn io_an_empty_file_holds_no_logbook_and_reading_leaves_it_empty() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let logbook = Logbook::open_read_only(file.path()).unwrap();
    assert_eq!(logbook.campaigns().unwrap(), []);
    let damage = logbook.verify().unwrap().damage;
    assert_eq!(damage.len(), 1, "{damage:?}");
    assert_eq!(damage[0].place, "file");
    assert_eq!(file.as_file().metadata().unwrap().len(), 0);
    example(file.path());
}

/// One row per sample is paid for in space: this is how much.
#[test]
fn io_a_sample_takes_about_150_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let size = |name: &str, batches| {
        let path = folder.path().join(name);
        let mut logbook = Logbook::open(&path).unwrap();
        let campaign = logbook.begin_campaign(&NEW).unwrap();
        let run = logbook.begin_run(campaign, 1, 0.6, 1).unwrap();
        let steps: Vec<_> = (0..20).map(|k| (Some(run), example_step(k))).collect();
        for _ in 0..batches {
            logbook.append(campaign, &steps).unwrap();
        }
        drop(logbook);
        std::fs::metadata(path).unwrap().len()
    };
    let bytes = (size("full.db", 100) - size("empty.db", 0)) as f64 / 2000.0;
    assert!((120.0..170.0).contains(&bytes), "{bytes} bytes a sample");
}

/// The operator's word counts wherever the run is read, and leaves what the program found provable.
#[test]
fn io_a_review_goes_before_the_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let found = example(&path);
    let id = CampaignId(1);
    let mut logbook = Logbook::open(&path).unwrap();
    let counted = |logbook: &Logbook| {
        let read = logbook.campaign(id).unwrap();
        let accepted = read.runs.iter().filter(|run| run.verdict.accepted).count();
        assert_eq!(logbook.entry(id).unwrap().runs_accepted as usize, accepted);
        read.runs
    };
    counted(&logbook);
    for (run, place) in found.runs.iter().zip(0..) {
        let entered = logbook.review(id, run.number, false, "a ferry passed", "Anna");
        assert_eq!(entered.unwrap(), Some(()));
        let rejected = counted(&logbook)[place].verdict.clone();
        assert!(!rejected.accepted);
        assert_eq!(rejected.reasons[0].code, ReasonCode::RejectedByOperator);
        assert_eq!(rejected.reasons[1..], run.verdict.reasons);
        // Only what has a model can be used.
        let entered = logbook.review(id, run.number, true, "it was far away", "Ben").unwrap();
        assert_eq!(entered.is_some(), run.identification.is_some());
        assert_eq!(counted(&logbook)[place].verdict.accepted, entered.is_some());
    }
    assert_eq!(logbook.review(id, 99, false, "no such run", "Anna").unwrap(), None);
    assert_eq!(logbook.reviews(id).unwrap().len(), found.runs.len());
    assert_eq!(logbook.recording(id).unwrap().campaign, found);
    assert_eq!(logbook.verify().unwrap().damage, []);
}

#[test]
fn io_commands_are_read_newest_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut logbook = Logbook::open(folder.path().join("seatrial.db")).unwrap();
    for command in ["take_control", "start_trial", "abort_trial"] {
        let new = NewCommand {
            actor: "Anna",
            address: "127.0.0.1",
            command,
            details: "{}",
            result: "done",
        };
        logbook.enter_command(&new).unwrap();
    }
    let read = logbook.commands(2).unwrap();
    let names: Vec<(i64, &str)> = read.iter().map(|c| (c.number, c.command.as_str())).collect();
    assert_eq!(names, [(3, "abort_trial"), (2, "start_trial")]);
}
