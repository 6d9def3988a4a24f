//! Pilots, failsafes, lost links, reboots, a process that is gone: in every stage of a commission.

use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};

use seatrial_app::commission::Ending;

use crate::sea::{INTERVAL_S, MISHAPS, Mishap};
use crate::{OnSea, sea, truth};

/// From the first course to the last step of a commission of this boat, s.
const LIFE_S: f64 = 170.0;
/// Where nobody says how many: each mishap at five instants.
const COMMISSIONS: u32 = 60;
/// Neutral after a mishap that is seen, or after the last heading that was heard: the autopilot's own timeout and a step.
const LONGEST_HELD_S: f64 = 0.5 + INTERVAL_S;

#[derive(Debug, Default)]
struct Tally {
    kept: u32,
    old_at_once: u32,
    old_by_restore: u32,
    longest_held_s: f64,
}

fn suffer(mishap: Mishap, after_s: f64, seed: u64, tally: &mut Tally) {
    let told = format!("{mishap:?} after {after_s:.2} s, seed {seed}");
    let mut vehicle = OnSea::take(sea(seed));
    let before = vehicle.gains();
    let at_s = vehicle.autopilot.wire().now_s + after_s;
    vehicle.autopilot.wire().mishap = Some((at_s, mishap));
    let is_ours = matches!(mishap, Mishap::Killed | Mishap::Abort);
    if is_ours {
        vehicle.killed_s = Some(at_s);
    }
    // An operator's abort is the process stopping by itself; here it is the harsher one that is played.
    let mut vehicle = ManuallyDrop::new(vehicle);
    let ended = catch_unwind(AssertUnwindSafe(|| vehicle.commission(&truth())));
    let end_s = vehicle.autopilot.wire().now_s + 3.0;
    while vehicle.autopilot.wire().pass(end_s).is_some() {}
    let sea = vehicle.autopilot.wire();
    let seen_s = sea.seen_s.unwrap_or(at_s);
    if sea.now_s > at_s && !is_undisturbed(&ended) {
        let held_s = sea.held_s - seen_s;
        tally.longest_held_s = tally.longest_held_s.max(held_s);
        assert!(
            held_s <= LONGEST_HELD_S,
            "{told}: steered for {held_s:.2} s"
        );
    }
    if let Ok(found) = &ended
        && matches!(found.ending, Ending::Kept { .. })
    {
        tally.kept += 1;
        assert!(vehicle.undo.is_some(), "{told}");
        return;
    }
    if vehicle.gains() == before {
        tally.old_at_once += 1;
    } else {
        let restore = vehicle.restore.clone();
        let restore = restore.unwrap_or_else(|| panic!("{told}: nothing tells the old gains"));
        vehicle.autopilot.wire().mishap = None;
        let done = vehicle.autopilot.restore(&restore);
        assert!(done.not_restored.is_empty(), "{told}: {done:?}");
        assert_eq!(vehicle.gains(), before, "{told}");
        tally.old_by_restore += 1;
    }
}

/// It ended before the mishap could do anything.
fn is_undisturbed(ended: &std::thread::Result<seatrial_app::commission::Commissioned>) -> bool {
    ended
        .as_ref()
        .is_ok_and(|found| !matches!(found.ending, Ending::Aborted { .. }))
}

#[test]
fn prop_whatever_happens_the_gains_are_no_worse_than_found() {
    let count = std::env::var("SEATRIAL_COMMISSIONS").ok();
    let count: u32 = count.map_or(COMMISSIONS, |count| count.parse().unwrap());
    let hook = take_hook();
    set_hook(Box::new(|_| {}));
    let mut failed = Vec::new();
    let mut tallies: Vec<(Mishap, Tally)> = MISHAPS.map(|m| (m, Tally::default())).into();
    for number in 0..count {
        let (mishap, tally) = &mut tallies[number as usize % MISHAPS.len()];
        // Spread evenly: the golden ratio's multiples.
        let place = (f64::from(number) * 0.618_033_988_749_894_9).fract();
        let suffered = catch_unwind(AssertUnwindSafe(|| {
            suffer(*mishap, LIFE_S * place, u64::from(number) + 1, tally);
        }));
        if let Err(why) = suffered {
            let why = why.downcast_ref::<String>().cloned();
            failed.push(why.unwrap_or_else(|| format!("{mishap:?}, {number}")));
        }
    }
    set_hook(hook);
    for (mishap, tally) in &tallies {
        eprintln!("{mishap:?}: {tally:?}");
    }
    assert!(failed.is_empty(), "{failed:#?}");
    let restored: u32 = tallies.iter().map(|(_, t)| t.old_by_restore).sum();
    let at_once: u32 = tallies.iter().map(|(_, t)| t.old_at_once).sum();
    assert!(
        restored > 0 && at_once > restored,
        "{restored} and {at_once}"
    );
}
