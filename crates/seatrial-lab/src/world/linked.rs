//! A trial through MAVLink on a bad link: preflight, taking, trial, hand-back, restore.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::Campaign;
use seatrial_app::conduct::{Judging, Watch, conduct_judging};
use seatrial_app::{Error, TrialPlan};
use seatrial_links::autopilot::{Autopilot, Backup, HandBack, Profile, Settings, SteeringOutputs};

use seatrial_sim::sensors::Chance;

use super::drawn::World;
use super::ending::{Ending, about};
use super::stalled::Stalled;
use super::wire::{FULL_RUDDER_RAD, INTERVAL_S, Mishap, Sea, Single, Weather, boat};

/// The mishap comes within this of the beginning, s: preflight, taking, a trial and its hand-back.
const WITHIN_S: f64 = 110.0;
/// From what tells a mishap on this side to neutral rudder, s.
const NEUTRAL_AFTER_SEEN_S: f64 = 0.5;
/// From a link that is cut to neutral rudder, s: the autopilot's own timeout is 0.8 s.
const NEUTRAL_AFTER_CUT_S: f64 = 1.0;
/// From what tells a mishap to the end of the trial, s: a vehicle that no longer follows is given so long.
const NOTICED_AFTER_S: f64 = 3.0;
/// A command that is lost comes again after this, s.
const REPEATED_AFTER_S: f64 = 0.1;
/// The vehicle goes on so long after the end, s.
const AFTERWARDS_S: f64 = 3.0;
/// Most datagrams that may be under way.
const MOST_UNDER_WAY: usize = 1000;

/// What a trial may change on any of the autopilots.
const PARAMETERS: [&str; 7] = [
    "RC_OVERRIDE_TIME",
    "FS_GCS_ENABLE",
    "FS_ACTION",
    "FS_PILOT_INPUT",
    "FS_PILOT_TIMEOUT",
    "COM_RC_LOSS_T",
    "GUID_TIMEOUT",
];

type Parameters = BTreeMap<&'static str, Option<f32>>;

fn parameters(sea: &Sea) -> Parameters {
    PARAMETERS.map(|name| (name, sea.boat.parameter(name))).into()
}

/// What is drawn besides the world itself.
struct Drawn {
    weather: Weather,
    profile: Profile,
    mishap: (f64, Mishap),
}

impl Drawn {
    fn of(chance: &mut Chance) -> Self {
        let mut drawn = |most: f64| most * chance.uniform();
        let weather = match drawn(1.0) < 0.5 {
            true => Weather::default(),
            false => Weather {
                loss: drawn(0.2),
                duplication: drawn(0.2),
                latency_s: drawn(0.1),
                jitter_s: drawn(0.1),
                garbage: drawn(0.05),
                single: None,
            },
        };
        let profiles = [Profile::Rover, Profile::Sub, Profile::Px4];
        let profile = profiles[drawn(profiles.len() as f64) as usize];
        let mishap = Mishap::ALL[drawn(Mishap::ALL.len() as f64) as usize];
        Self { weather, profile, mishap: (drawn(WITHIN_S), mishap) }
    }

    fn settings(&self, abort: Arc<AtomicBool>) -> Settings {
        Settings {
            abort,
            outputs: (self.profile == Profile::Px4)
                .then(|| SteeringOutputs { outputs: vec![1], pulses_us: [1100.0, 1500.0, 1900.0] }),
            ..settings()
        }
    }
}

/// What is asked of every vehicle.
pub fn settings() -> Settings {
    Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        trying_thrust: 0.6,
        envelope: Some("the plan's".into()),
        ..Settings::default()
    }
}

/// Plays a world on a vehicle that speaks MAVLink.
pub fn play(world: &World, ending: &mut Ending) -> Result<(), Error> {
    let mut chance = world.chance.clone();
    let mut stalls = world.stalls.clone();
    let mut drawn = Drawn::of(&mut chance);
    drawn.weather.single = Single::drawn(&mut stalls);
    let sea = Sea::new(&world.vehicle, drawn.profile, drawn.weather, Some(drawn.mishap), chance)?;
    let before = parameters(&sea);
    let settings = drawn.settings(sea.abort.clone());
    let mut autopilot = Autopilot::new(sea, settings, None);
    let mut stalled = Stalled::drawn(world, &mut stalls, WITHIN_S)?;
    let trial = conducted(&mut autopilot, world, Judging::ByTrial, &mut stalled)?;
    if let Some(campaign) = &trial.campaign {
        ending.take(campaign);
        check_noticed(autopilot.wire(), trial.ended_s, ending);
        ending.broken.extend(stalled.broken(campaign)?);
    }
    let end_s = autopilot.wire().now_s + AFTERWARDS_S;
    while autopilot.wire().pass(end_s).is_some() {}
    ending.samples = autopilot.wire().sent;
    check_rudder(autopilot.wire(), drawn.weather, drawn.mishap, ending);
    if autopilot.wire().under_way() > MOST_UNDER_WAY {
        ending.broken.push("datagrams pile up".into());
    }
    let expected = match drawn.mishap {
        // It has forgotten what was changed.
        (at_s, Mishap::Reboot) if autopilot.wire().now_s >= at_s => {
            PARAMETERS.map(|name| (name, as_new(world, drawn.profile, name))).into()
        }
        _ => before,
    };
    check_parameters(&mut autopilot, &drawn, &expected, &trial, ending);
    Ok(())
}

/// Parameters are back, or listed by the hand-back; `restore` brings back the listed ones.
fn check_parameters(
    autopilot: &mut Autopilot<Sea>,
    drawn: &Drawn,
    expected: &Parameters,
    trial: &LinkedTrial,
    ending: &mut Ending,
) {
    let (mishap, profile) = (drawn.mishap, drawn.profile);
    let left = differences(expected, &parameters(autopilot.wire()));
    let is_listed = |name: &str| {
        let done = trial.done.as_ref();
        done.is_some_and(|done| done.not_restored.iter().any(|listed| listed == name))
    };
    if let Some(name) = left.iter().find(|name| !is_listed(name)) {
        ending
            .broken
            .push(format!("{name} is neither as it was nor listed ({mishap:?}, {profile:?})"));
    }
    if let Some(backup) = trial.backup.as_ref().filter(|_| !left.is_empty()) {
        autopilot.wire().mishap = None;
        autopilot.wire().weather.single = None;
        let restored = autopilot.restore(backup);
        let left = differences(expected, &parameters(autopilot.wire()));
        if !left.is_empty() {
            ending
                .broken
                .push(format!("restore leaves {left:?} ({mishap:?}, {profile:?}): {restored:?}"));
        }
    }
}

fn as_new(world: &World, profile: Profile, name: &str) -> Option<f32> {
    boat(&world.vehicle, profile, 1).ok()?.parameter(name)
}

fn differences(before: &Parameters, now: &Parameters) -> Vec<&'static str> {
    let changed = before.iter().filter(|(name, value)| now.get(*name) != Some(value));
    changed.map(|(name, _)| *name).collect()
}

/// What came of a trial.
#[derive(Default)]
pub struct LinkedTrial {
    /// What would restore the vehicle, once something is changed.
    backup: Option<Backup>,
    /// What the hand-back reached.
    done: Option<HandBack>,
    /// Its runs, once it began.
    pub campaign: Option<Campaign>,
    /// When it ended, before the hand-back, s.
    ended_s: f64,
}

/// From the preflight to the hand-back.
pub fn conducted(
    autopilot: &mut Autopilot<Sea>,
    world: &World,
    judging: Judging,
    watch: &mut dyn Watch,
) -> Result<LinkedTrial, Error> {
    let mut trial = LinkedTrial::default();
    let preflight = autopilot.inspect();
    if preflight.checks.iter().any(|check| !check.passed) {
        return Ok(trial);
    }
    let checks = autopilot.take_control(&preflight.changes, &mut |kept| {
        trial.backup = Some(kept.clone());
        Ok(())
    });
    if checks.iter().all(|check| check.passed) {
        let about = about(world);
        let plan = TrialPlan::from(world.plan).checked();
        let plan = plan.map_err(|error| Error::Setting(error.to_string()))?;
        trial.campaign = Some(conduct_judging(autopilot, &plan, about, watch, judging).campaign);
        trial.ended_s = autopilot.wire().now_s;
    }
    trial.done = Some(autopilot.hand_back());
    Ok(trial)
}

/// Checks that a trial did not go on after the link had shown what ends it.
fn check_noticed(sea: &Sea, ended_s: f64, ending: &mut Ending) {
    let (Some(seen_s), Some((at_s, mishap))) = (sea.seen_s, sea.mishap) else {
        return;
    };
    let is_meant = ending.outcome != "finished"
        || mishap == Mishap::LinkLostForAWhile
        || sea.is_before_demand(seen_s);
    let went_on_s = ended_s - seen_s;
    // The vehicle is looked at in steps.
    if !is_meant && went_on_s > NOTICED_AFTER_S + INTERVAL_S {
        ending.broken.push(format!(
            "the trial went on for {went_on_s:.2} s after {mishap:?} at {at_s:.2} s"
        ));
    }
}

/// Checks that the rudder is released soon after the link shows what ends the trial.
fn check_rudder(sea: &Sea, weather: Weather, (at_s, mishap): (f64, Mishap), ending: &mut Ending) {
    let ends = ending.outcome != "finished" && mishap != Mishap::LinkLostForAWhile;
    let (Some(seen_s), true) = (sea.seen_s, ends) else {
        return;
    };
    // Before the rudder is asked for, mode and sticks are where their owner left them, a vehicle that started again is not yet in a trial, and
    // the vehicle itself has contradicted a stranger.
    let ends_none = matches!(
        mishap,
        Mishap::PilotMode | Mishap::PilotStick | Mishap::Reboot | Mishap::ForgedDisarm
    );
    if ends_none && sea.is_before_demand(seen_s) {
        return;
    }
    let within_s = match mishap.cuts() {
        true => NEUTRAL_AFTER_CUT_S,
        false => NEUTRAL_AFTER_SEEN_S + REPEATED_AFTER_S,
    };
    // The command is on its way, too, and the vehicle moves in steps.
    let on_its_way_s = weather.latency_s + weather.jitter_s + INTERVAL_S;
    let held_s = sea.held_s - seen_s;
    ending.neutral_after_s = Some(held_s.max(0.0));
    if held_s > within_s + on_its_way_s {
        ending
            .broken
            .push(format!("the rudder was held for {held_s:.2} s after {mishap:?} at {at_s:.2} s"));
    }
}
