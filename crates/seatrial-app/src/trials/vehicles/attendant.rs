//! Who attends a vehicle that moves, and what is said of it.

use seatrial_links::autopilot::HandBack;

use crate::trials::order::{Change, Check, Preflight, VehicleError};

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
    found.changes.iter().for_each(|change| attendant.change(change));
}

/// A hand-back for people. Values that are put back from a file leave the controls to who has them: of these only what was done is said.
pub fn hand_back_text(done: &HandBack) -> String {
    let is_from_file = !done.values.is_empty();
    let controls = [
        ("rudder", done.rudder_neutral, ["neutral", "NOT SEEN NEUTRAL"]),
        ("throttle", done.throttle_neutral, ["neutral", "NOT SEEN NEUTRAL"]),
        ("mode", done.mode_restored, ["restored", "NOT RESTORED"]),
    ];
    let said = |(name, known, [yes, no]): (&str, Option<bool>, [&str; 2])| match known {
        Some(true) => Some(format!("{name} {yes}")),
        Some(false) => Some(format!("{name} {no}")),
        None => (!is_from_file).then(|| format!("{name} left as it is: another has control")),
    };
    let mut parts: Vec<String> = controls.into_iter().filter_map(said).collect();
    if !done.restored.is_empty() {
        parts.push(format!("restored {}", done.restored.join(", ")));
    }
    if !done.not_restored.is_empty() {
        parts.push(format!("NOT RESTORED {}", done.not_restored.join(", ")));
    }
    format!("handed back: {}", parts.join("; "))
}

#[cfg(test)]
mod tests {
    use seatrial_links::autopilot::PutBack;

    use super::*;

    #[test]
    fn exact_values_put_back_from_a_file_say_nothing_of_controls_that_were_not_taken() {
        let after_a_takeover =
            HandBack { restored: vec!["ATC_STR_RAT_FF".into()], ..HandBack::default() };
        let from_a_file = HandBack {
            values: vec![PutBack { name: "ATC_STR_RAT_FF".into(), from: Some(6.14), to: 0.2 }],
            ..after_a_takeover.clone()
        };
        let taken = hand_back_text(&after_a_takeover);
        assert!(taken.contains("rudder left as it is: another has control"));
        assert_eq!(hand_back_text(&from_a_file), "handed back: restored ATC_STR_RAT_FF");
        let to_a_mode = HandBack { mode_restored: Some(false), ..from_a_file };
        assert_eq!(
            hand_back_text(&to_a_mode),
            "handed back: mode NOT RESTORED; restored ATC_STR_RAT_FF"
        );
    }
}
