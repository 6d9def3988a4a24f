//! What to type next.

use std::path::Path;

use seatrial::identification::{Outcome, ReasonCode};
use seatrial_core::Axis;
use seatrial_logs::Format;

use crate::identify_log::IdentifiedLog;

/// The option that makes `seatrial gains` write parameters of ArduSub, and of Rover.
const SUB: &str = "--export ardupilot --vehicle-type underwater --out gains.param";
const ROVER: &str = "--export ardupilot --out gains.param";
pub(crate) const PX4: &str = "--export px4 --out gains.params";

/// Options of one verb on a log that the others have not, alone and with a value.
const OWN: [&str; 4] = ["--verbose", "--trace", "--accept-unvalidated", "--json"];
const OWN_WITH_VALUE: [&str; 3] = ["--schedule", "--report", "--out"];

/// Another verb on the same log, with the columns, units and windows that were typed: of `seatrial identify run.csv --time t`
/// the command `seatrial report run.csv --time t`.
pub fn with_verb(call: &str, verb: &str) -> String {
    let mut words = call.split(' ');
    let mut kept: Vec<&str> = words.next().into_iter().collect();
    words.next();
    kept.push(verb);
    while let Some(word) = words.next() {
        let name = word.split('=').next().unwrap_or(word);
        if OWN_WITH_VALUE.contains(&name) {
            if name == word {
                words.next();
            }
        } else if !OWN.contains(&word) {
            kept.push(word);
        }
    }
    kept.join(" ")
}

/// The command that goes on from an identified log. `call` is the command that identified it, `seatrial identify run.csv`; `schedule`
/// the file that it wrote its models to. Of an autopilot's log the command writes that autopilot's file of parameters.
pub fn after_log(found: &IdentifiedLog, call: &str, schedule: Option<&Path>) -> String {
    let log = &found.logs.log;
    let is_one_log = found.logs.parts.is_empty();
    let look = || match is_one_log {
        true => with_verb(call, "report"),
        false => format!("{call} --verbose"),
    };
    match found.verdict().outcome() {
        Outcome::Use | Outcome::UseWithCare if found.axis == Axis::Pitch => {
            format!("{call} --json > model.json")
        }
        Outcome::Use | Outcome::UseWithCare if has_no_gain(found) => look(),
        Outcome::Use | Outcome::UseWithCare => {
            let gains = match schedule {
                Some(written) => format!("seatrial gains --schedule {}", written.display()),
                None => format!("{call} --json > model.json && seatrial gains --model model.json"),
            };
            let is_submarine = is_ardusub(log.description.firmware.as_deref());
            let export = match log.description.format {
                Format::DataFlash if is_submarine => format!(" {SUB}"),
                Format::DataFlash => format!(" {ROVER}"),
                Format::Ulog => format!(" {PX4}"),
                _ => String::new(),
            };
            format!("{gains}{export}")
        }
        Outcome::NotValidated if is_one_log => format!("{call} --validate-on SECOND_LOG"),
        Outcome::NotValidated => format!("{call} ONE_MORE_LOG"),
        Outcome::DoNotUse => look(),
    }
}

/// Is it one model, for which `gains` has no gain?
fn has_no_gain(found: &IdentifiedLog) -> bool {
    let is_one = found.models.as_ref().is_none_or(|models| models.len() < 2);
    let model = found.identification().filter(|_| is_one);
    model.is_some_and(|model| model.verdict.has(&ReasonCode::Unstable))
}

fn is_ardusub(firmware: Option<&str>) -> bool {
    firmware.is_some_and(|name| name.starts_with("ArduSub"))
}

#[cfg(test)]
mod tests {
    use super::with_verb;

    #[test]
    fn exact_another_verb_keeps_what_was_typed_of_the_log() {
        for (call, expected) in [
            ("seatrial identify run.csv --time n --verbose", "seatrial report run.csv --time n"),
            (
                "seatrial identify --schedule a.toml 'my run.csv' --unit rudder=deg",
                "seatrial report 'my run.csv' --unit rudder=deg",
            ),
            (
                "seatrial inspect --report=a.html run.csv --from 3",
                "seatrial report run.csv --from 3",
            ),
        ] {
            assert_eq!(with_verb(call, "report"), expected);
        }
    }
}
