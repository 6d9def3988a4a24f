//! How often the verdict accepts what it must not, and sound experiments beside it, in every sea of the accuracy study:
//! `cargo run --release -p seatrial --example false_acceptance -- 1000`.

#[path = "../tests/false_acceptance/cases.rs"]
mod cases;

use std::thread;

use cases::{Kind, Sea, is_accepted};

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
    let cases: u64 = std::env::args()
        .nth(1)
        .map_or(100, |text| text.parse().expect("a number of cases"));
    println!("accepted of {cases} cases each; compass noise, deg: {NOISES_DEG:?}\n");
    println!("| case | disturbance, rad/s^2, s | 0.2 | 0.5 | 1 | 2 |\n|---|---|---|---|---|---|");
    for kind in KINDS {
        for disturbance in DISTURBANCES {
            let cells = thread::scope(|scope| {
                NOISES_DEG
                    .map(|noise_deg| {
                        let sea = Sea {
                            noise_deg,
                            disturbance,
                        };
                        scope.spawn(move || {
                            (1..=cases)
                                .filter(|seed| is_accepted(kind, sea, *seed))
                                .count()
                        })
                    })
                    .map(|worker| worker.join().expect("no case panics"))
            });
            println!(
                "| {kind:?} | {disturbance:?} | {} |",
                cells.map(|count| count.to_string()).join(" | ")
            );
        }
    }
}
