//! A trial killed at any instant loses no finished run and damages nothing.
#![cfg(unix)]

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use seatrial_dev::program;
use seatrial_logbook::{Damage, Logbook};

const SIGKILL: i32 = 9;
const WORKERS: usize = 2;
const KILLS_PER_WORKER: u32 = 110;
const KILLS_PER_LOGBOOK: u32 = 10;

/// Two speeds: a short life, killed more often.
const PLAN: &str = "thrusts = [0.6, 0.8]\n";

fn start_trial(plan: &Path, logbook: &Path) -> Child {
    program()
        .args(["trial", "--yes", "--plan"])
        .arg(plan)
        .arg("--logbook")
        .arg(logbook)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The runs that a trial has reported as finished, and whether it was killed before its end.
fn aftermath(mut trial: Child) -> (usize, bool) {
    let mut log = String::new();
    let stderr = trial.stderr.as_mut().unwrap();
    stderr.read_to_string(&mut log).unwrap();
    let status = trial.wait().unwrap();
    assert!(status.success() || status.signal() == Some(SIGKILL), "{log}");
    (log.lines().filter(|line| line.starts_with("run ")).count(), !status.success())
}

/// Kills trial after trial on the same logbook, each at a random instant of its life; the runs
/// that were reported before.
fn kill_trials(plan: &Path, logbook: &Path, life: &mut Duration) -> usize {
    let (mut kills, mut reported) = (0, 0);
    while kills < KILLS_PER_LOGBOOK {
        let mut trial = start_trial(plan, logbook);
        let fraction = RandomState::new().build_hasher().finish() as f64 / u64::MAX as f64;
        let delay = life.mul_f64(fraction);
        std::thread::sleep(delay);
        trial.kill().unwrap();
        let (runs, killed) = aftermath(trial);
        kills += u32::from(killed);
        reported += runs;
        // Keeps the kills spread over the whole life however busy the machine is: about one trial
        // in five reaches its end.
        *life = life.mul_f64(if killed { 1.05 } else { 0.8 });
        // Killed before the first table was in it.
        let is_made = std::fs::metadata(logbook).is_ok_and(|about| about.len() > 0);
        if !is_made {
            assert_eq!(reported, 0);
            continue;
        }
        let verification = Logbook::open_read_only(logbook).unwrap().verify().unwrap();
        let is_of_file = |damage: &Damage| damage.place == "file";
        if verification.damage.iter().any(is_of_file) {
            assert_eq!(reported, 0);
            continue;
        }
        assert_eq!(verification.damage, [], "killed after {delay:?}");
        assert!(
            verification.runs_finished as usize >= reported,
            "killed after {delay:?}: {reported} runs reported, {verification:?}"
        );
    }
    // A trial can still be written to it.
    Logbook::open(logbook).unwrap();
    reported
}

#[test]
fn cli_a_trial_killed_at_any_instant_keeps_every_finished_run() {
    let folder = tempfile::tempdir().unwrap();
    let plan = &folder.path().join("plan.toml");
    std::fs::write(plan, PLAN).unwrap();
    let start = Instant::now();
    let undisturbed = start_trial(plan, &folder.path().join("undisturbed.db"));
    assert_eq!(aftermath(undisturbed), (2, false));
    let life = start.elapsed();
    let worker = |worker: usize| {
        let mut life = life;
        (0..KILLS_PER_WORKER / KILLS_PER_LOGBOOK)
            .map(|k| folder.path().join(format!("{worker}-{k}.db")))
            .map(|logbook| kill_trials(plan, &logbook, &mut life))
            .sum::<usize>()
    };
    let reported: usize = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..WORKERS).map(|k| scope.spawn(move || worker(k))).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).sum()
    });
    // Half of the kills or so come after a run was finished.
    assert!(reported > 50, "{reported} runs were reported before the kills");
}
