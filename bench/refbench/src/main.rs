//! Speed beside other programs that do the same work, in turns, in one run.
//!
//! `refbench TABLE.md` prints a line of JSON for each piece of work and each ratio, and writes the table. `REFBENCH_PYTHON` names a Python with
//! `peers/requirements.txt`, `REFBENCH_CPP` the compiled `peers/peer.cpp`; `bench/run` makes both. What is missing is left out.

mod goals;
mod machine;
mod online;
mod peers;
mod signals;
mod table;
mod work;

use std::env;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use seatrial::identify::output_error::output_error;
use seatrial::identify::simplex::fit_as_paper;
use serde_json::json;

use goals::GOALS;
use peers::Peer;
use signals::Data;
use table::Rounds;
use work::{Entry, agree, entries, model_of};

type Outcome<T> = Result<T, Box<dyn Error>>;

const ROUNDS: usize = 7;
const INTERVAL_S: f64 = 0.05;
const LAMBDA_RAD_S: f64 = 1.5;
const INITIAL_COVARIANCE: f64 = 1e6;

const SHORT: usize = 330;
const LONG: usize = 1_000_000;
const ONLINE: usize = 20_000;

/// Peers with fewer samples in their loop agree with the rest to this: their estimate is another.
const AGREEMENT: f64 = 0.05;

fn main() -> Outcome<()> {
    let Some(table) = env::args().nth(1) else {
        return Err("usage: refbench TABLE.md".into());
    };
    let folder = env::temp_dir().join(format!("refbench-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let outcome = measure(&folder, Path::new(&table));
    fs::remove_dir_all(&folder)?;
    outcome
}

/// The work of other programs: by which of the three peers, and its name there.
const OF_PEERS: [(usize, &str); 8] = [
    (0, "online C++ by hand"),
    (0, "online Eigen"),
    (1, "online Octave"),
    (2, "online padasip"),
    (2, "online filterpy"),
    (2, "batch scipy"),
    (2, "refined scipy least_squares"),
    (2, "refined scipy simplex, Python RK4"),
];

/// C++, Octave and Python, each where it is installed.
fn started_peers(folder: &Path) -> [Option<Peer>; 3] {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers");
    let python = env::var("REFBENCH_PYTHON").unwrap_or("python3".into());
    let python = Peer::start(
        Command::new(python)
            .arg(here.join("peer.py"))
            // One core for everybody.
            .env("OPENBLAS_NUM_THREADS", "1"),
        folder,
    );
    let cpp = env::var_os("REFBENCH_CPP")
        .and_then(|program| Peer::start(&mut Command::new(program), folder));
    let octave = Peer::start(Command::new("octave-cli").arg("-q").arg(here.join("peer.m")), folder);
    [cpp, octave, python]
}

/// Root mean squares of the heading error, rad, by the name of the work.
type Costs = Vec<(&'static str, f64)>;

/// Everybody in turn, round by round.
fn rounds(
    entries: &mut [Entry<'_>],
    peers: &mut [Option<Peer>; 3],
    expected: [f64; 3],
) -> Outcome<(Rounds, Costs)> {
    let mut rounds = Rounds::default();
    let mut costs = Vec::new();
    for round in 0..=ROUNDS {
        // The first one warms caches and compiles what is compiled late.
        let counts = round > 0;
        for Entry { name, run } in &mut *entries {
            let seconds = run()?;
            if counts {
                rounds.add(name, seconds);
            }
        }
        for (which, name) in OF_PEERS {
            let Some(peer) = &mut peers[which] else {
                continue;
            };
            let (seconds, numbers) = peer.run(name)?;
            agree(name, &numbers, expected)?;
            if counts {
                rounds.add(name, seconds);
            } else if name.starts_with("refined") {
                costs.push((name, numbers[3]));
            }
        }
        eprintln!("refbench: round {round} of {ROUNDS}");
    }
    Ok((rounds, costs))
}

fn measure(folder: &Path, table: &Path) -> Outcome<()> {
    let data = Data::new();
    data.write(folder)?;
    let (head, helm) = data.online();
    let expected = model_of(head, helm)?.theta();
    let (rounds, mut costs) = rounds(&mut entries(&data)?, &mut started_peers(folder), expected)?;
    for line in rounds.json_lines() {
        println!("{line}");
    }
    let (goals, lines) = rounds.goals(&GOALS);
    for line in lines {
        println!("{line}");
    }
    let found = output_error(&data.samples, Some(data.start))?;
    let own_simplex = fit_as_paper(&data.samples).ok_or("no sample")?;
    costs.push(("refined", found.residual_rms_rad));
    costs.push(("refined, own simplex + RK4", own_simplex.cost));
    let mut text = format!("{goals}\n{}\n", rounds.times());
    text.push('\n');
    text += "| refined estimate | root mean square of the heading error, mrad |\n|---|---|\n";
    for (name, cost) in costs {
        println!("{}", json!({"work": name, "cost_rad": cost}));
        text += &format!("| {name} | {:.6} |\n", cost * 1e3);
    }
    fs::write(table, text)?;
    Ok(())
}
