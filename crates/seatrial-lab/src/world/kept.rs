//! A logbook on a disk that a trial is kept in, and copies of it as a killed process or lost power leave it.

use std::fs;
use std::path::{Path, PathBuf};

use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial_app::Error;
use seatrial_app::trials::replay::Replay;
use seatrial_core::{InvalidSetting, Plan};
use seatrial_logbook::{Logbook, NewCampaign, Recorder};
use seatrial_sim::sensors::Chance;
use tempfile::TempDir;

use super::drawn::Interrupted;

/// A logbook in a folder of its own, in which a campaign has begun.
pub fn begun(about: &Campaign, plan: &str) -> Result<(TempDir, Recorder), Error> {
    let cannot = |error| Error::Input(format!("the folder of a world: {error}"));
    let folder = tempfile::Builder::new().prefix("seatrial-world-").tempdir();
    let folder = folder.map_err(cannot)?;
    let new = NewCampaign {
        configuration: &about.configuration,
        notes: Some("played"),
        software_version: &about.software_version,
        vehicle: &about.vehicle,
        seed: about.seed,
        rudder_limit_rad: about.rudder_limit_rad,
        full_rudder: None,
        scenario: None,
        plan,
    };
    let recorder = Recorder::begin(Logbook::open(folder.path().join(LOGBOOK))?, &new)?;
    Ok((folder, recorder))
}

/// What was promised at an instant: so many runs have their result.
struct Copy {
    path: PathBuf,
    finished: u32,
    kind: Interrupted,
}

/// A logbook of one trial.
pub struct Kept {
    folder: TempDir,
    recorder: Option<Recorder>,
    finished: u32,
    /// Bytes of the write-ahead log that were synchronised with the disk.
    synchronised: u64,
    copies: Vec<Copy>,
    /// What could not be kept.
    pub unsaved: Vec<String>,
}

impl Kept {
    /// An empty logbook for a trial of this plan.
    pub fn new(about: &Campaign, plan: &str) -> Result<Self, Error> {
        let (folder, begun) = begun(about, plan)?;
        let mut kept = Self {
            folder,
            recorder: Some(begun),
            finished: 0,
            synchronised: 0,
            copies: Vec::new(),
            unsaved: Vec::new(),
        };
        kept.synchronised = kept.log_bytes();
        Ok(kept)
    }

    fn log_bytes(&self) -> u64 {
        fs::metadata(self.folder.path().join(LOG)).map_or(0, |about| about.len())
    }

    fn note(&mut self, write: impl FnOnce(&mut Recorder) -> Result<(), seatrial_logbook::Error>) {
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = write(recorder)
        {
            self.unsaved.push(error.to_string());
        }
    }

    /// A run began.
    pub fn begin_run(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.note(|recorder| recorder.begin_run(number, thrust, attempt));
    }

    /// The trial took a step.
    pub fn step(&mut self, step: &Step) {
        self.note(|recorder| recorder.step(*step));
    }

    /// A run has its result.
    pub fn end_run(&mut self, run: &Run) {
        self.note(|recorder| recorder.finish_run(run));
        self.finished += 1;
        self.synchronised = self.log_bytes();
    }

    /// Copies the files as they are when the process is killed or the power goes.
    pub fn interrupt(&mut self, kind: Interrupted, chance: &mut Chance) {
        let number = self.copies.len();
        let folder = self.folder.path().join(format!("{kind:?}{number}"));
        if let Err(error) = self.copy(&folder, kind, chance) {
            self.unsaved.push(format!("the copy: {error}"));
        }
        self.copies.push(Copy { path: folder.join(LOGBOOK), finished: self.finished, kind });
    }

    fn copy(&self, folder: &Path, kind: Interrupted, chance: &mut Chance) -> std::io::Result<()> {
        fs::create_dir_all(folder)?;
        fs::copy(self.folder.path().join(LOGBOOK), folder.join(LOGBOOK))?;
        let mut log = fs::read(self.folder.path().join(LOG))?;
        if kind == Interrupted::PowerLost {
            let safe = usize::try_from(self.synchronised).unwrap_or(log.len()).min(log.len());
            let left = safe + ((log.len() - safe) as f64 * chance.uniform()) as usize;
            log.truncate(left);
            // Some of what was left may never have been written.
            let garbled = safe + ((left - safe) as f64 * chance.uniform()) as usize;
            log[garbled..].iter_mut().for_each(|byte| *byte = (256.0 * chance.uniform()) as u8);
        }
        fs::write(folder.join(LOG), log)
    }

    /// What is not as it must be of the logbook and of its copies. `replays`: a trial that was judged whole is conducted again.
    pub fn broken(mut self, campaign: &Campaign, plan: Plan<f64>, replays: bool) -> Vec<String> {
        let mut broken = std::mem::take(&mut self.unsaved);
        if let (Some(recorder), Some(outcome)) = (self.recorder.take(), campaign.outcome)
            && let Err(error) = recorder.finish(outcome)
        {
            broken.push(error.to_string());
        }
        let logbook = self.folder.path().join(LOGBOOK);
        match compared(&logbook, campaign) {
            Ok(found) => broken.extend(found),
            Err(error) => broken.push(format!("the logbook: {error}")),
        }
        for copy in &self.copies {
            let name = format!("the logbook after {:?}", copy.kind);
            match looked_into(&copy.path, copy.finished) {
                Ok(found) => broken.extend(found.iter().map(|found| format!("{name}: {found}"))),
                Err(error) => broken.push(format!("{name}: {error}")),
            }
        }
        if replays {
            let paths = self.copies.iter().map(|copy| &copy.path);
            for path in [&logbook].into_iter().chain(paths) {
                match replayed(path, plan) {
                    Ok(found) => broken.extend(found),
                    Err(error) => broken.push(format!("the replay: {error}")),
                }
            }
        }
        broken
    }
}

/// The logbook in its folder.
pub const LOGBOOK: &str = "seatrial.db";
const LOG: &str = "seatrial.db-wal";

pub fn compared(path: &Path, campaign: &Campaign) -> Result<Vec<String>, Error> {
    let logbook = Logbook::open_read_only(path)?;
    let mut broken: Vec<String> = damage(&logbook)?;
    let Some(entry) = logbook.entries()?.pop() else {
        return Ok(vec!["the campaign is not in the logbook".into()]);
    };
    let read = logbook.campaign(entry.id)?;
    if read.outcome != campaign.outcome {
        broken.push(format!("the logbook ends with {:?}", read.outcome));
    }
    let text = |run: &Run| format!("{:?} {:?}", run.number, run.verdict);
    let of = |campaign: &Campaign| campaign.runs.iter().map(text).collect::<Vec<_>>();
    if of(&read) != of(campaign) {
        broken.push("the runs of the logbook are not those of the trial".into());
    }
    Ok(broken)
}

fn looked_into(path: &Path, finished: u32) -> Result<Vec<String>, Error> {
    let logbook = Logbook::open_read_only(path)?;
    let mut broken = damage(&logbook)?;
    let kept = logbook.entries()?.first().map_or(0, |entry| entry.runs_finished);
    if kept < finished {
        broken.push(format!("{finished} runs were finished, {kept} are left"));
    }
    drop(logbook);
    // And it goes on.
    Logbook::open(path)?;
    Ok(broken)
}

fn damage(logbook: &Logbook) -> Result<Vec<String>, Error> {
    let damage = logbook.verify()?.damage;
    let damage = damage.into_iter();
    Ok(damage.map(|damage| format!("{}: {}", damage.place, damage.found)).collect())
}

/// How a replay of the logbook's trial differs from it.
fn replayed(path: &Path, plan: Plan<f64>) -> Result<Option<String>, Error> {
    let logbook = Logbook::open_read_only(path)?;
    let Some(entry) = logbook.entries()?.pop() else {
        return Ok(None);
    };
    let recording = logbook.recording(entry.id)?;
    let unusable = |error: InvalidSetting| Error::Setting(error.to_string());
    let replay = Replay::of(plan, &recording).map_err(unusable)?;
    let difference = replay.first_difference;
    Ok(difference.map(|difference| format!("the replay differs: {}", difference.found)))
}
