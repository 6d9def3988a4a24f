//! How often the verdict accepts what it must not, and sound experiments beside it, in every sea of the accuracy study:
//! `cargo run --release -p seatrial-app --example false_acceptance -- 63`, behind which only some may be named: `Saturated`.

#[path = "../tests/false_acceptance/cases.rs"]
mod cases;

use std::thread;

use cases::{Kind, Sea, verdict};
use seatrial::identification::{Reason, ReasonCode, Subject};

const KINDS: [Kind; 6] = [
    Kind::SoundRun,
    Kind::TrueModel,
    Kind::Unexcited,
    Kind::Reversed,
    Kind::Saturated,
    Kind::ThirtyPercentWrong,
];
const DISTURBANCES: [(f64, f64); 4] = [(0.0, 1.0), (0.005, 2.0), (0.005, 0.5), (0.02, 2.0)];
const NOISES_DEG: [f64; 4] = [0.2, 0.5, 1.0, 2.0];

fn main() {
    let cases: u64 =
        std::env::args().nth(1).map_or(100, |text| text.parse().expect("a number of cases"));
    let named: Vec<String> = std::env::args().skip(2).collect();
    println!(
        "accepted of {cases} cases each, and without the note that the validation data could not tell; compass noise, deg: {NOISES_DEG:?}\n"
    );
    println!("| case | disturbance, rad/s^2, s | 0.2 | 0.5 | 1 | 2 |\n|---|---|---|---|---|---|");
    let is_wanted = |kind: &Kind| named.is_empty() || named.contains(&format!("{kind:?}"));
    for kind in KINDS.into_iter().filter(is_wanted) {
        for disturbance in DISTURBANCES {
            let cells = thread::scope(|scope| {
                NOISES_DEG
                    .map(|noise_deg| {
                        let sea = Sea { noise_deg, disturbance };
                        scope.spawn(move || {
                            let judged = (1..=cases).filter_map(|seed| verdict(kind, sea, seed));
                            let (mut accepted, mut sure) = (0, 0);
                            for verdict in judged.filter(|verdict| verdict.accepted) {
                                accepted += 1;
                                let is_weak = |r: &Reason| {
                                    r.kind() == ReasonCode::UnderExcited.of(Subject::Validation)
                                };
                                sure += usize::from(!verdict.reasons.iter().any(is_weak));
                            }
                            format!("{accepted} {sure}")
                        })
                    })
                    .map(|worker| worker.join().expect("no case panics"))
            });
            println!("| {kind:?} | {disturbance:?} | {} |", cells.join(" | "));
        }
    }
}
