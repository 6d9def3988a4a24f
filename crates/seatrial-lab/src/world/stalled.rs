//! A terminal that is stopped and a logbook whose disk hangs, both from some instant of the trial to its end.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};

use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial_core::Trial;
use seatrial_logbook::{Keeper, Logbook, WriteLock};
use seatrial_sim::sensors::Chance;

use seatrial_app::Error;
use seatrial_app::conduct::Watch;
use seatrial_app::text_queue::TextQueue;
use tempfile::TempDir;

use super::drawn::World;
use super::ending::about;
use super::kept::{LOGBOOK, begun, compared};

/// Share of the worlds in which something is held up.
const SHARE: f64 = 0.25;

/// Writes each step to a terminal and into a logbook; in most worlds neither is there.
pub struct Stalled(Option<Outside>);

struct Outside {
    folder: TempDir,
    keeper: Keeper,
    hangs_from_s: f64,
    disk: Option<WriteLock>,
    terminal: TextQueue,
    stopped_from_s: f64,
    /// Dropped, it lets the terminal go on.
    stopped: Option<Sender<()>>,
    written: Arc<AtomicU64>,
    steps: u64,
    unsaved: Vec<String>,
}

impl Stalled {
    /// What a world has of them; they are held up within this time of the vehicle, s.
    pub fn drawn(world: &World, chance: &mut Chance, within_s: f64) -> Result<Self, Error> {
        let is_there = chance.uniform() < SHARE;
        let [hangs_from_s, stopped_from_s] = [chance.uniform(), chance.uniform()];
        if !is_there {
            return Ok(Self(None));
        }
        let plan =
            toml::to_string(&world.plan).map_err(|error| Error::Setting(error.to_string()))?;
        let (folder, recorder) = begun(&about(world), &plan)?;
        Ok(Self(Some(Outside {
            folder,
            keeper: Keeper::new(recorder, true),
            hangs_from_s: within_s * hangs_from_s,
            disk: None,
            terminal: TextQueue::default(),
            stopped_from_s: within_s * stopped_from_s,
            stopped: None,
            written: Arc::default(),
            steps: 0,
            unsaved: Vec::new(),
        })))
    }

    /// What is not as it must be once both go on: a run that was conducted and neither kept nor given back.
    pub fn broken(self, campaign: &Campaign) -> Result<Vec<String>, Error> {
        let Some(mut outside) = self.0 else {
            return Ok(Vec::new());
        };
        (outside.disk, outside.stopped) = (None, None);
        outside.terminal.finish();
        let left_out = u64::from(outside.terminal.left_out());
        let written = outside.written.load(Ordering::Relaxed);
        if written + left_out < outside.steps {
            let steps = outside.steps;
            let text = format!("{steps} texts, {written} written, {left_out} left out");
            outside.unsaved.push(text);
        }
        let kept = outside.keeper.end(campaign.outcome, || false);
        outside.unsaved.extend(kept.unsaved);
        outside.unsaved.extend(compared(&outside.folder.path().join(LOGBOOK), campaign)?);
        Ok(outside.unsaved)
    }
}

impl Outside {
    fn hold_up(&mut self, time_s: f64) {
        if time_s >= self.hangs_from_s && self.disk.is_none() {
            match Logbook::hold(&self.folder.path().join(LOGBOOK)) {
                Ok(held) => self.disk = Some(held),
                Err(error) => self.unsaved.push(format!("the disk: {error}")),
            }
        }
        if time_s >= self.stopped_from_s && self.stopped.is_none() {
            let (go_on, stopped) = channel::<()>();
            self.terminal.write(move || {
                let _ = stopped.recv();
            });
            self.stopped = Some(go_on);
        }
    }
}

impl Watch for Stalled {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        if let Some(outside) = &mut self.0 {
            outside.keeper.begin_run(number, thrust, attempt);
        }
    }

    fn step(&mut self, step: &Step, _: &Trial<f64>) {
        let Some(outside) = &mut self.0 else { return };
        outside.hold_up(step.sample.time_s);
        outside.keeper.keep(step);
        let written = Arc::clone(&outside.written);
        outside.steps += 1;
        outside.terminal.write(move || {
            written.fetch_add(1, Ordering::Relaxed);
        });
    }

    fn run_ended(&mut self, run: &mut Run) {
        if let Some(outside) = &mut self.0 {
            outside.keeper.end_run(run);
        }
    }
}
