//! Pilots, failsafes, lost links, reboots, a process that is gone: in every stage of a commission.

use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::atomic::Ordering;

use seatrial_app::trials::commission::{Ending, Proposal};

use super::{OnSea, Stage, sea, truth, under_water};
use crate::autopilot::sea::{INTERVAL_S, Mishap, Sea};

/// What happens.
const FAULTS: [Mishap; 20] = [
    Mishap::PilotMode,
    Mishap::PilotManual,
    Mishap::PilotStick,
    Mishap::SteeringStick,
    Mishap::ThrottleStick,
    Mishap::Battery,
    Mishap::Disarmed,
    Mishap::Reboot,
    Mishap::SecondStation,
    Mishap::LinkLost,
    Mishap::LinkLostForAWhile,
    Mishap::LinkGap,
    Mishap::Deaf,
    Mishap::DeafForAWhile,
    Mishap::Mute,
    Mishap::MuteForAWhile,
    Mishap::ParametersLost,
    Mishap::Abort,
    Mishap::Killed,
    Mishap::KilledAndRebooted,
];
/// Commissions with each fault where SEATRIAL_COMMISSIONS does not say how many: one in each stage.
const COMMISSIONS: usize = Stage::ALL.len();
/// Neutral after a mishap that is seen, or after the last heartbeat that was heard: the autopilot's own timeout and a step.
const LONGEST_HELD_S: f64 = 0.5 + INTERVAL_S;

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    kept: u32,
    old_at_once: u32,
    old_by_restore: u32,
    longest_held_s: f64,
}

/// A commission that keeps its gains, and one whose gains are so quick that the old ones are put back.
struct Voyage {
    proposal: Proposal,
    /// When each stage begins, from the taking of the vehicle, s, and the end.
    stages: Vec<(Stage, f64)>,
    end_s: f64,
}

impl Voyage {
    fn new(speed_up: f64, sea: fn(u64) -> Sea) -> Self {
        let mut vehicle = OnSea::take(sea(1));
        let mut proposal = vehicle.proposal(&truth());
        let settings = &mut proposal.settings;
        settings.angle_gain_per_s *= speed_up;
        settings.acceleration_limit_rad_s2 *= speed_up;
        if settings.shaping.is_some() {
            settings.rate_gain_s *= speed_up;
        }
        let start_s = vehicle.autopilot.wire().now_s;
        vehicle.carry_out(&proposal);
        let end_s = vehicle.autopilot.wire().now_s - start_s;
        let begun = vehicle.begun.iter();
        Self {
            proposal,
            stages: begun.map(|(stage, at_s)| (*stage, at_s - start_s)).collect(),
            end_s,
        }
    }

    /// An instant in a stage, s; `None` where it has no such stage.
    fn within(&self, wanted: Stage, share: f64) -> Option<f64> {
        let place = self.stages.iter().position(|(stage, _)| *stage == wanted)?;
        let (_, from_s) = self.stages[place];
        let to_s = self.stages.get(place + 1).map_or(self.end_s, |(_, at_s)| *at_s);
        Some(from_s + share * (to_s - from_s))
    }
}

fn suffer(mishap: Mishap, after_s: f64, proposal: &Proposal, sea: Sea) -> Tally {
    let context = format!("{mishap:?} after {after_s:.2} s");
    let mut tally = Tally::default();
    let mut vehicle = OnSea::take(sea);
    let before = vehicle.gains();
    let at_s = vehicle.autopilot.wire().now_s + after_s;
    vehicle.autopilot.wire().mishap = Some((at_s, mishap));
    match mishap {
        Mishap::Killed | Mishap::KilledAndRebooted => vehicle.killed_s = Some(at_s),
        Mishap::Abort => vehicle.abort_s = Some(at_s),
        _ => {}
    }
    // A process that is gone hands nothing back.
    let mut vehicle = ManuallyDrop::new(vehicle);
    let ended = catch_unwind(AssertUnwindSafe(|| vehicle.carry_out(proposal)));
    let end_s = vehicle.autopilot.wire().now_s + 3.0;
    while vehicle.autopilot.wire().pass(end_s).is_some() {}
    let sea = vehicle.autopilot.wire();
    let seen_s = sea.seen_s.unwrap_or(at_s);
    let is_disturbed =
        !matches!(&ended, Ok(found) if !matches!(found.ending, Ending::Aborted { .. }));
    if sea.now_s > at_s && is_disturbed && mishap != Mishap::ParametersLost {
        tally.longest_held_s = sea.held_s - seen_s;
        let held_s = tally.longest_held_s;
        assert!(held_s <= LONGEST_HELD_S, "{context}: steered for {held_s:.2} s");
    }
    if vehicle.undo.is_some() {
        // They were proven before it happened.
        tally.kept += 1;
        return tally;
    }
    if vehicle.gains() == before {
        tally.old_at_once += 1;
        return tally;
    }
    let restore = vehicle.restore.clone();
    let restore = restore.unwrap_or_else(|| panic!("{context}: nothing tells the old gains"));
    vehicle.autopilot.wire().mishap = None;
    vehicle.abort.store(false, Ordering::Relaxed);
    let done = vehicle.autopilot.restore(&restore);
    assert!(done.not_restored.is_empty(), "{context}: {done:?}");
    assert_eq!(vehicle.gains(), before, "{context}");
    tally.old_by_restore += 1;
    tally
}

/// Twenty mishaps in every stage of a commission. `SEATRIAL_COMMISSIONS=60 cargo nextest run -p seatrial-links -E
/// 'test(/^commission::/)' --no-capture` plays sixty of each and prints the table of `validation`.
#[test]
fn prop_whatever_happens_the_gains_are_no_worse_than_found() {
    let count = std::env::var("SEATRIAL_COMMISSIONS").ok();
    let count: usize = count.map_or(COMMISSIONS, |count| count.parse().unwrap());
    suffer_all(sea, count);
}

/// Twenty mishaps in every stage of a commission under ArduSub, a tenth as often as on Rover.
#[test]
fn prop_whatever_happens_under_water_the_gains_are_no_worse_than_found() {
    let count = std::env::var("SEATRIAL_COMMISSIONS").ok();
    let count = count.map_or(COMMISSIONS, |count| count.parse().unwrap());
    suffer_all(under_water, (count / 10).max(COMMISSIONS));
}

fn suffer_all(sea: fn(u64) -> Sea, count: usize) {
    let (good, bad) = (Voyage::new(1.0, sea), Voyage::new(8.0, sea));
    let hook = take_hook();
    set_hook(Box::new(|_| {}));
    let mut failed = Vec::new();
    let mut rows = Vec::new();
    for mishap in FAULTS {
        let mut tallies = [Tally::default(); Stage::ALL.len()];
        for number in 0..count {
            let stage = number % Stage::ALL.len();
            // Spread evenly: the golden ratio's multiples.
            let share = (number as f64 * 0.618_033_988_749_894_9).fract();
            let wanted = Stage::ALL[stage];
            let voyage = [&good, &bad].into_iter();
            let timed = voyage.map(|voyage| (voyage, voyage.within(wanted, share)));
            let (voyage, after_s) = timed
                .filter_map(|(voyage, at_s)| Some((voyage, at_s?)))
                .next()
                .unwrap_or_else(|| panic!("no commission has the stage {wanted:?}"));
            let suffered = catch_unwind(AssertUnwindSafe(|| {
                suffer(mishap, after_s, &voyage.proposal, sea(number as u64 + 1))
            }));
            match suffered {
                Ok(found) => tallies[stage].add(found),
                Err(why) => {
                    let why = why.downcast_ref::<String>().cloned();
                    failed.push(why.unwrap_or_else(|| format!("{mishap:?}, {number}")));
                }
            }
        }
        rows.push((mishap, tallies));
    }
    set_hook(hook);
    eprintln!("{}", table(&rows));
    assert!(failed.is_empty(), "{failed:#?}");
    let all = || rows.iter().flat_map(|(_, tallies)| tallies);
    let restored: u32 = all().map(|t| t.old_by_restore).sum();
    let at_once: u32 = all().map(|t| t.old_at_once).sum();
    assert!(restored > 0 && at_once > restored, "{restored} and {at_once}");
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.kept += other.kept;
        self.old_at_once += other.old_at_once;
        self.old_by_restore += other.old_by_restore;
        self.longest_held_s = self.longest_held_s.max(other.longest_held_s);
    }
}

/// A row for each mishap, a column for each stage: new gains kept / old ones back at once / old ones back by `vehicle restore`.
fn table(rows: &[(Mishap, [Tally; Stage::ALL.len()])]) -> String {
    let names = Stage::ALL.map(|stage| format!("{stage:?}")).join(" | ");
    let mut text = format!("| mishap | {names} | steered after, s |\n");
    text += &format!("|{}\n", "---|".repeat(Stage::ALL.len() + 2));
    for (mishap, tallies) in rows {
        let cell = |t: &Tally| format!("{}/{}/{}", t.kept, t.old_at_once, t.old_by_restore);
        let cells: Vec<String> = tallies.iter().map(cell).collect();
        let held_s = tallies.iter().map(|t| t.longest_held_s).fold(0.0, f64::max);
        let name = format!("{mishap:?}");
        text += &format!("| {name} | {} | {held_s:.2} |\n", cells.join(" | "));
    }
    text
}
