//! Who attends a vehicle that moves, and what is said of it.

use seatrial_links::autopilot::HandBack;

use crate::trial_run::{Change, Check, Preflight, VehicleError};

/// The person or program that attends a vehicle: is told what is found and done, and agrees to it.
pub trait Attendant: Send + Sync {
    /// A sentence of what was found or done.
    fn tell(&self, text: &str);

    /// What was looked at, and whether it passed.
    fn check(&self, check: &Check);

    /// What is changed until the hand-back.
    fn change(&self, change: &Change);

    /// Is the vehicle to be taken, changed and moved?
    fn agrees(&self) -> Result<bool, VehicleError>;
}

/// Tells everything that a preflight found.
pub(super) fn tell_all(attendant: &dyn Attendant, found: &Preflight) {
    found.checks.iter().for_each(|check| attendant.check(check));
    found
        .changes
        .iter()
        .for_each(|change| attendant.change(change));
}

/// A hand-back for people.
pub fn hand_back_text(done: &HandBack) -> String {
    let known = |name: &str, known: Option<bool>, yes: &str, no: &str| match known {
        Some(true) => format!("{name} {yes}"),
        Some(false) => format!("{name} {no}"),
        None => format!("{name} left as it is: another has control"),
    };
    let mut parts = vec![
        known("rudder", done.rudder_neutral, "neutral", "NOT SEEN NEUTRAL"),
        known(
            "throttle",
            done.throttle_neutral,
            "neutral",
            "NOT SEEN NEUTRAL",
        ),
        known("mode", done.mode_restored, "restored", "NOT RESTORED"),
    ];
    if !done.restored.is_empty() {
        parts.push(format!("restored {}", done.restored.join(", ")));
    }
    if !done.not_restored.is_empty() {
        parts.push(format!("NOT RESTORED {}", done.not_restored.join(", ")));
    }
    format!("handed back: {}", parts.join("; "))
}
