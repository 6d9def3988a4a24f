//! Pilots, failsafes, lost links, a process that is gone: at random instants of a trial.

use std::collections::BTreeMap;

use seatrial_app::conduct::conduct;
use seatrial_core::{AbortReason, Action, Outcome, Steering, Vehicle};
use seatrial_links::autopilot::{Autopilot, Backup, Profile, Stop};
use seatrial_links::link::Wire;

use super::sea::{Draw, FULL_RUDDER_RAD, INTERVAL_S, MISHAPS, Mishap, Sea, Weather, boat};
use super::{
    Witness, about, assert_as_before, assert_replays, failures, plan, run, settings, starfish,
    taken,
};

/// One mishap at one time; what the vehicle did about it.
fn suffer(mishap: Mishap, after_s: f64, seed: u64) {
    let (mut autopilot, backup) = taken(Sea::new(starfish(), Weather::default(), seed));
    let start_s = autopilot.wire().now_s;
    let at_s = start_s + after_s;
    let context = format!("{mishap:?} after {after_s:.2} s, seed {seed}");
    let mut witness = Witness::default();
    autopilot.wire().mishap = Some((at_s, mishap));
    match mishap {
        Mishap::Abort => witness.abort_from_s = Some(at_s),
        Mishap::Killed => witness.stop_from_s = Some(at_s),
        _ => {}
    }
    if mishap == Mishap::Killed {
        // Nothing of ours runs any more, not even what runs when something is dropped.
        let mut autopilot = std::mem::ManuallyDrop::new(autopilot);
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let gone = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            run(&mut autopilot, &mut witness)
        }));
        std::panic::set_hook(hook);
        assert!(gone.is_err(), "{context}");
        // Before, while and after the vehicle's own failsafe takes note.
        let end_s = autopilot.wire().now_s + 4.0 + 0.5 * (seed / 12 % 8) as f64;
        while autopilot.wire().pass(end_s).is_some() {}
        assert_held(autopilot.wire(), &context);
        let sea = std::mem::ManuallyDrop::into_inner(autopilot);
        restore_later(sea, &backup, &context);
        return;
    }
    let conducted = run(&mut autopilot, &mut witness);
    let outcome = conducted.campaign.outcome.unwrap();
    assert_ne!(outcome, Outcome::Finished, "{context}");
    let expected = match mishap {
        Mishap::PilotMode => AbortReason::ModeChanged,
        Mishap::PilotStick => AbortReason::StickMoved,
        Mishap::Battery => AbortReason::LowBattery,
        Mishap::Disarmed => AbortReason::Disarmed,
        Mishap::Reboot => AbortReason::Restarted,
        Mishap::SecondStation => AbortReason::SecondStation,
        Mishap::Deaf => AbortReason::Failsafe,
        Mishap::Abort => AbortReason::Operator,
        _ => AbortReason::LinkLost,
    };
    // A vehicle that is disarmed or does not hear may be noticed first by its rudder.
    let is_noticed_first = matches!(mishap, Mishap::Disarmed | Mishap::Deaf)
        && matches!(conducted.fault, Some(Stop::NotFollowed { .. }));
    let expected = match is_noticed_first {
        true => AbortReason::RudderNotFollowed,
        false => expected,
    };
    assert_eq!(outcome, Outcome::Aborted(expected), "{context}");
    let last_s = witness.steps.last().unwrap().sample.time_s;
    // A sample is complete with the next, and one may be under way.
    let gap_s = autopilot.wire().seen_s.map_or(0.0, |seen_s| seen_s - last_s);
    assert!(gap_s < 0.2, "{context}: {gap_s} s are missing");
    let kept = conducted.campaign.runs.iter().map(|run| run.record.samples.len()).sum::<usize>();
    assert!(kept + 3 >= witness.steps.len(), "{context}: {kept} of {}", witness.steps.len());
    assert_replays(&witness.steps);
    let done = autopilot.hand_back();
    assert_held(autopilot.wire(), &context);
    let is_cut = matches!(mishap, Mishap::LinkLost | Mishap::Deaf | Mishap::Mute);
    assert_eq!(done.not_restored.is_empty(), !is_cut, "{context}: {done:?}");
    if is_cut {
        autopilot.wire().mishap = None;
        restore_later(autopilot, &backup, &context);
    } else if mishap != Mishap::Reboot {
        assert_as_before(autopilot.wire());
    }
    // A reboot is a vehicle that has forgotten what was changed: it is as before already.
}

fn assert_held(sea: &Sea, context: &str) {
    // What is noticed by a rudder that does not follow is never told.
    let seen_s = sea.seen_s.unwrap_or(sea.now_s);
    // The second, and a step of the vehicle.
    let held_s = sea.held_s - seen_s;
    assert!(held_s <= 1.0 + INTERVAL_S, "{context}: the rudder was held for {held_s:.2} s");
}

fn restore_later(mut autopilot: Autopilot<Sea>, backup: &Backup, context: &str) {
    autopilot.wire().mishap = None;
    let done = autopilot.restore(backup);
    assert!(done.is_complete(), "{context}: {done:?}");
    assert_as_before(autopilot.wire());
    let sea = autopilot.wire();
    let end_s = sea.now_s + 3.0;
    while sea.pass(end_s).is_some() {}
    assert!(!sea.boat.is_critical(), "{context}: its failsafe stays");
    std::mem::forget(autopilot);
}

/// Mishaps at random instants of the trial; SEATRIAL_MISHAPS says how many.
#[test]
fn prop_every_mishap_ends_with_the_rudder_released() {
    let count = std::env::var("SEATRIAL_MISHAPS").ok();
    let count = count.and_then(|count| count.parse().ok()).unwrap_or(36);
    let mut draw = Draw(20);
    let mut suffered = BTreeMap::new();
    for seed in 0..count {
        let mishap = MISHAPS[seed as usize % MISHAPS.len()];
        // Settling takes 10 to 40 s, then 33 s of manoeuvres; a deaf vehicle is noticed after 7 s.
        suffer(mishap, 0.5 + 35.0 * draw.next(), seed);
        *suffered.entry(format!("{mishap:?}")).or_insert(0) += 1;
    }
    println!("{suffered:?}");
}

/// A panic on this side hands the vehicle back as it is dropped.
#[test]
fn io_a_panic_hands_the_vehicle_back() {
    struct Shared(std::rc::Rc<std::cell::RefCell<Sea>>);
    impl Wire for Shared {
        fn now_s(&self) -> f64 {
            self.0.borrow().now_s
        }
        fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
            self.0.borrow_mut().receive(bytes, until_s);
        }
        fn send(&mut self, bytes: &[u8]) {
            self.0.borrow_mut().send(bytes);
        }
    }
    let sea =
        std::rc::Rc::new(std::cell::RefCell::new(Sea::new(starfish(), Weather::default(), 1)));
    let mut autopilot = Autopilot::new(Shared(sea.clone()), settings(), None);
    let preflight = autopilot.inspect();
    let checks = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
    assert_eq!(failures(&checks), [""; 0]);
    let start_s = sea.borrow().now_s;
    let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(move || {
        let mut witness = Witness { stop_from_s: Some(start_s + 12.0), ..Witness::default() };
        conduct(&mut autopilot, plan(), about(), &mut witness)
    }));
    assert!(panicked.is_err());
    assert_as_before(&sea.borrow());
    assert_eq!(sea.borrow().boat.mode, 4);
    assert_eq!(sea.borrow().boat.steering(), 0.0);
}

/// ArduSub's other modes take the sticks too, also overrides that RC_OVERRIDE_TIME makes fresh again as it is put back: after a
/// hand-back to a pilot, or a process that is gone, nothing of ours is left in them.
#[test]
fn regress_no_stick_of_a_submarine_is_left_deflected() {
    let taken_sub = || {
        let mut sea = Sea::new(starfish(), Weather::default(), 1);
        sea.boat = boat(&starfish(), Profile::Sub);
        taken(sea)
    };
    let mut deflected = 0;
    for tenths in (120..200).step_by(7) {
        for mishap in [Mishap::PilotMode, Mishap::Disarmed, Mishap::Killed] {
            let (mut autopilot, backup) = taken_sub();
            let at_s = autopilot.wire().now_s + 0.1 * f64::from(tenths);
            autopilot.wire().mishap = Some((at_s, mishap));
            while autopilot.wire().now_s < at_s {
                let Ok(Some(_)) = autopilot.next_sample() else {
                    break;
                };
                autopilot.act(&full_rudder()).unwrap();
            }
            deflected += u32::from(autopilot.wire().boat.steering() != 0.0);
            let done = if mishap == Mishap::Killed {
                let gone = Sea::new(starfish(), Weather::default(), 1);
                let sea = std::mem::replace(autopilot.wire(), gone);
                let killed =
                    std::mem::replace(&mut autopilot, Autopilot::new(sea, settings(), None));
                std::mem::forget(killed);
                autopilot.restore(&backup)
            } else {
                while autopilot.next_sample().is_ok() {}
                autopilot.hand_back()
            };
            assert!(done.not_restored.is_empty(), "{mishap:?}: {done:?}");
            let boat = &autopilot.wire().boat;
            assert_eq!(boat.parameter("RC_OVERRIDE_TIME"), Some(3.0));
            assert_eq!(boat.steering(), 0.0, "{mishap:?} after {tenths}");
        }
    }
    assert_eq!(deflected, 36);
}

fn full_rudder() -> Action<f64> {
    Action { steering: Steering::Rudder(FULL_RUDDER_RAD), thrust: Some(0.6), outcome: None }
}
