//! Speed beside other programs that do the same work, in turns, in one run.
//!
//! `refbench TABLE.md` prints a line of JSON for each piece of work and each ratio, and writes the table. `REFBENCH_PYTHON` names a Python with
//! `peers/requirements.txt`, `REFBENCH_CPP` the compiled `peers/peer.cpp`; `bench/run` makes both. What is missing is left out.

mod machine;
mod online;
mod peers;
mod table;

use std::env;
use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use seatrial::identify::batch::BatchLeastSquares;
use seatrial::identify::output_error::nearest_simulation;
use seatrial::identify::simplex::fit_as_paper;
use seatrial_core::model::{YawModel, YawState};
use seatrial_core::state_variable_filter::{FilterStep, Hold, StateVariableFilter};
use seatrial_core::{FixedRateSettings, Sample};
use seatrial_kernels::{
    Accumulator, NoisyRuns, every_theta, monte_carlo, normals_of_run, of_records,
};
use serde_json::json;

use peers::Peer;
use table::{Goal, Rounds};

type Outcome<T> = Result<T, Box<dyn Error>>;

const ROUNDS: usize = 7;
/// The one of so many repetitions that took least processor time is a round's: others share the machine.
const REPEATS: usize = 3;

const INTERVAL_S: f64 = 0.05;
const LAMBDA_RAD_S: f64 = 1.5;
const INITIAL_COVARIANCE: f64 = 1e6;
const NOISE_RAD: f64 = 0.02;

const SHORT: usize = 330;
const LONG: usize = 1_000_000;
const ONLINE: usize = 20_000;
const RECORDS: usize = 8192;
const RUNS: u64 = 2000;

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

/// A vehicle that steers to both hands all the time; heading without and with noise, and rudder.
struct Signals {
    truth: Vec<f64>,
    heading: Vec<f64>,
    rudder: Vec<f64>,
}

impl Signals {
    fn new(samples: usize, run: u64) -> Self {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let mut state = YawState::default();
        let (truth, rudder): (Vec<f64>, Vec<f64>) = (0..samples)
            .map(|k| {
                let rudder = match k % 210 {
                    40..80 => 0.26,
                    80..120 => -0.26,
                    _ => -0.011,
                };
                let heading = state.heading_rad;
                state = model.advance(state, rudder, INTERVAL_S);
                (heading, rudder)
            })
            .unzip();
        let noise = normals_of_run(7, run, samples);
        let heading = truth
            .iter()
            .zip(noise)
            .map(|(psi, z)| psi + 0.1 * NOISE_RAD * z)
            .collect();
        Self {
            truth,
            heading,
            rudder,
        }
    }
}

/// The least processor time of some repetitions, s, and what the work gave.
fn timed<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut least = f64::INFINITY;
    let mut result = None;
    for _ in 0..REPEATS {
        let begin = machine::processor_s();
        result = Some(black_box(work()));
        least = least.min(machine::processor_s() - begin);
    }
    (least, result.expect("repeated at least once"))
}

/// The same by the clock on the wall, for what runs on two cores.
fn timed_by_the_clock<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut least = f64::INFINITY;
    let mut result = None;
    for _ in 0..REPEATS {
        let begin = Instant::now();
        result = Some(black_box(work()));
        least = least.min(begin.elapsed().as_secs_f64());
    }
    (least, result.expect("repeated at least once"))
}

struct Entry<'a> {
    name: &'static str,
    run: Box<dyn FnMut() -> Outcome<f64> + 'a>,
}

fn entry<'a>(name: &'static str, run: impl FnMut() -> Outcome<f64> + 'a) -> Entry<'a> {
    Entry {
        name,
        run: Box::new(run),
    }
}

fn agree(name: &str, found: &[f64], expected: [f64; 3]) -> Outcome<()> {
    let scale = expected[0].abs().max(expected[1].abs());
    let is_close = found.len() >= 3
        && found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < AGREEMENT * scale);
    match is_close {
        true => Ok(()),
        false => Err(format!("{name} gives {found:?}, expected {expected:?}").into()),
    }
}

fn measure(folder: &Path, table: &Path) -> Outcome<()> {
    let (short, long) = (Signals::new(SHORT, 0), Signals::new(LONG, 1));
    let fleet: Vec<Signals> = (0..RECORDS as u64)
        .map(|r| Signals::new(SHORT, r))
        .collect();
    let fleet_heading: Vec<f64> = fleet.iter().flat_map(|s| s.heading.clone()).collect();
    let fleet_rudder: Vec<f64> = fleet.iter().flat_map(|s| s.rudder.clone()).collect();
    drop(fleet);
    let settings = FixedRateSettings {
        lambda_rad_s: LAMBDA_RAD_S,
        initial_covariance: INITIAL_COVARIANCE,
        ..FixedRateSettings::paper(INTERVAL_S)
    };
    let model_of = |heading: &[f64], rudder: &[f64]| -> Outcome<YawModel<f64>> {
        let mut accumulator = Accumulator::new(&settings)?;
        accumulator.extend(heading, rudder);
        let model = accumulator.sums().model(INITIAL_COVARIANCE);
        Ok(model.ok_or("not excited")?)
    };
    let start = YawModel::from_theta([-1.0, 1.0, 0.01]);
    for (name, signal) in [
        ("heading_short", &short.heading[..]),
        ("rudder_short", &short.rudder),
        ("truth_short", &short.truth),
        ("heading_long", &long.heading),
        ("rudder_long", &long.rudder),
        ("heading_fleet", &fleet_heading),
        ("rudder_fleet", &fleet_rudder),
        ("start", &start.theta()),
    ] {
        let bytes: Vec<u8> = signal.iter().flat_map(|w| w.to_le_bytes()).collect();
        fs::write(folder.join(name), bytes)?;
    }

    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers");
    let python = env::var("REFBENCH_PYTHON").unwrap_or("python3".into());
    let mut python = Peer::start(
        Command::new(python)
            .arg(here.join("peer.py"))
            // One core for everybody.
            .env("OPENBLAS_NUM_THREADS", "1"),
        folder,
    );
    let mut cpp = env::var_os("REFBENCH_CPP")
        .and_then(|program| Peer::start(&mut Command::new(program), folder));
    let mut octave = Peer::start(
        Command::new("octave-cli")
            .arg("-q")
            .arg(here.join("peer.m")),
        folder,
    );

    let (head, helm) = (&long.heading[..ONLINE], &long.rudder[..ONLINE]);
    let (head32, helm32): (Vec<f32>, Vec<f32>) = head
        .iter()
        .zip(helm)
        .map(|(w, d)| (*w as f32, *d as f32))
        .unzip();
    let samples: Vec<Sample<f64>> = short
        .heading
        .iter()
        .zip(&short.rudder)
        .enumerate()
        .map(|(k, (heading_rad, rudder_rad))| Sample {
            time_s: k as f64 * INTERVAL_S,
            heading_rad: *heading_rad,
            rudder_rad: *rudder_rad,
            ..Sample::default()
        })
        .collect();
    let noisy = NoisyRuns {
        heading_rad: &short.truth,
        rudder_rad: &short.rudder,
        heading_noise_rad: NOISE_RAD,
        seed: 1,
        runs: RUNS,
    };
    let expected = model_of(head, helm)?.theta();
    let per =
        |count: usize, (seconds, _): (f64, f64)| -> Outcome<f64> { Ok(seconds / count as f64) };
    let step = |name: &'static str, work: &mut dyn FnMut() -> [f64; 3]| -> Outcome<f64> {
        let (seconds, theta) = timed(work);
        agree(name, &theta, expected)?;
        Ok(seconds / ONLINE as f64)
    };
    let sum_of = |heading: &[f64], rudder: &[f64]| -> (f64, f64) {
        timed(|| machine::read(black_box(heading), black_box(rudder)))
    };
    let mut thetas = Vec::new();
    let mut entries = vec![
        entry("chain of multiplications", || Ok(machine::multiply_s())),
        entry("chain of additions", || Ok(machine::add_s())),
        entry("chain of divisions", || Ok(machine::divide_s())),
        entry("chain of fused multiply-adds", || {
            machine::fused_s().ok_or_else(|| "no fused multiply-add".into())
        }),
        entry("bound of the online step", || {
            Ok(2.0 * machine::multiply_s() + 4.0 * machine::add_s() + machine::divide_s())
        }),
        entry("online", || {
            step("online", &mut || {
                online::ours(&settings, black_box(head), black_box(helm))
            })
        }),
        entry("online f32", || {
            step("online f32", &mut || {
                online::ours_f32(&settings, black_box(&head32), black_box(&helm32))
            })
        }),
        entry("online, a trial's estimator", || {
            step("trial", &mut || {
                online::of_a_trial(black_box(head), black_box(helm))
            })
        }),
        entry("online nalgebra", || {
            step("nalgebra", &mut || {
                online::nalgebra(black_box(head), black_box(helm))
            })
        }),
        entry("online ndarray", || {
            step("ndarray", &mut || {
                online::ndarray(black_box(head), black_box(helm))
            })
        }),
        entry("short", || {
            per(
                SHORT * 100,
                timed(|| {
                    let one = || model_of(black_box(&short.heading), black_box(&short.rudder));
                    (0..100)
                        .filter_map(|_| one().ok())
                        .map(|m| m.a22_per_s)
                        .sum()
                }),
            )
        }),
        entry("long", || {
            let (seconds, found) =
                timed(|| model_of(black_box(&long.heading), black_box(&long.rudder)));
            agree("long", &found?.theta(), expected)?;
            Ok(seconds / LONG as f64)
        }),
        entry("reading long", || {
            per(LONG, sum_of(&long.heading, &long.rudder))
        }),
        entry("every Theta", || {
            let (seconds, done) = timed(|| {
                every_theta(
                    &settings,
                    &long.heading,
                    &long.rudder,
                    black_box(&mut thetas),
                )
            });
            done?;
            agree("every Theta", &thetas[LONG - 1], expected)?;
            Ok(seconds / LONG as f64)
        }),
        entry("every Theta, new memory", || {
            per(
                LONG,
                timed(|| {
                    let mut thetas = Vec::new();
                    let _ = every_theta(&settings, &long.heading, &long.rudder, &mut thetas);
                    thetas[LONG - 1][0]
                }),
            )
        }),
        entry("fleet", || {
            per(
                SHORT * RECORDS,
                timed(|| {
                    let sums = of_records(&settings, SHORT, &fleet_heading, &fleet_rudder);
                    let models = sums
                        .into_iter()
                        .flatten()
                        .filter_map(|s| s.model(INITIAL_COVARIANCE));
                    models.map(|m| m.a22_per_s).sum()
                }),
            )
        }),
        entry("fleet, two cores", || {
            per(
                SHORT * RECORDS,
                timed_by_the_clock(|| {
                    let half = SHORT * RECORDS / 2;
                    let part = |heading: &[f64], rudder: &[f64]| -> f64 {
                        let sums = of_records(&settings, SHORT, heading, rudder);
                        let models = sums.into_iter().flatten();
                        models
                            .filter_map(|s| s.model(INITIAL_COVARIANCE))
                            .map(|m| m.a22_per_s)
                            .sum()
                    };
                    std::thread::scope(|scope| {
                        let other =
                            scope.spawn(|| part(&fleet_heading[..half], &fleet_rudder[..half]));
                        let own = part(&fleet_heading[half..], &fleet_rudder[half..]);
                        own + other.join().unwrap_or(f64::NAN)
                    })
                }),
            )
        }),
        entry("fleet, one core by the clock", || {
            per(
                SHORT * RECORDS,
                timed_by_the_clock(|| {
                    let sums = of_records(&settings, SHORT, &fleet_heading, &fleet_rudder);
                    let models = sums.into_iter().flatten();
                    models
                        .filter_map(|s| s.model(INITIAL_COVARIANCE))
                        .map(|m| m.a22_per_s)
                        .sum()
                }),
            )
        }),
        entry("reading fleet", || {
            per(SHORT * RECORDS, sum_of(&fleet_heading, &fleet_rudder))
        }),
        entry("refined", || {
            per(
                100,
                timed(|| {
                    let one = || nearest_simulation(black_box(&samples), Some(start));
                    (0..100)
                        .filter_map(|_| one().ok())
                        .map(|f| f.residual_rms_rad())
                        .sum()
                }),
            )
        }),
        entry("refined, own simplex + RK4", || {
            per(
                1,
                timed(|| fit_as_paper(black_box(&samples)).map_or(f64::NAN, |m| m.cost)),
            )
        }),
        entry("monte carlo", || {
            per(
                SHORT * RUNS as usize,
                timed(|| {
                    let sums = monte_carlo(&settings, black_box(&noisy));
                    let models = sums
                        .into_iter()
                        .flatten()
                        .filter_map(|s| s.model(INITIAL_COVARIANCE));
                    models.map(|m| m.a22_per_s).sum()
                }),
            )
        }),
        entry("drawing its numbers", || {
            per(
                SHORT * RUNS as usize,
                timed(|| {
                    (0..RUNS)
                        .map(|run| normals_of_run(1, black_box(run), SHORT)[SHORT - 1])
                        .sum()
                }),
            )
        }),
    ];
    let of_peers: [(usize, &'static str); 12] = [
        (0, "online C++ by hand"),
        (0, "online Eigen"),
        (1, "online Octave"),
        (2, "online padasip"),
        (2, "online filterpy"),
        (2, "short scipy"),
        (2, "long scipy"),
        (2, "fleet numba"),
        (2, "fleet numpy"),
        (2, "refined scipy least_squares"),
        (2, "refined scipy simplex, Python RK4"),
        (2, "monte carlo numpy"),
    ];
    let mut peers = [cpp.as_mut(), octave.as_mut(), python.as_mut()];
    let mut rounds = Rounds::default();
    let mut costs = Vec::new();
    for round in 0..=ROUNDS {
        // The first one warms caches and compiles what is compiled late.
        let counts = round > 0;
        for Entry { name, run } in &mut entries {
            let seconds = run()?;
            if counts {
                rounds.add(name, seconds);
            }
        }
        for (which, name) in of_peers {
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
    drop(entries);

    for line in rounds.json_lines() {
        println!("{line}");
    }
    let (goals, lines) = rounds.goals(&GOALS);
    for line in lines {
        println!("{line}");
    }
    let found = nearest_simulation(&samples, Some(start))?;
    let own_simplex = fit_as_paper(&samples).ok_or("no sample")?;
    costs.push(("refined", found.residual_rms_rad()));
    costs.push(("refined, own simplex + RK4", own_simplex.cost));
    let mut text = format!("{goals}\n{}\n", rounds.times());
    text += &format!("Passes of the refined estimate: {}.\n\n", found.passes());
    text += "| refined estimate | root mean square of the heading error, mrad |\n|---|---|\n";
    for (name, cost) in costs {
        println!("{}", json!({"work": name, "cost_rad": cost}));
        text += &format!("| {name} | {:.6} |\n", cost * 1e3);
    }
    text += &growth(&settings, &long)?;
    text += &drift(&settings, &long)?;
    fs::write(table, text)?;
    Ok(())
}

const GOALS: [Goal; 21] = {
    const fn goal(work: &'static str, beside: &'static str, most: f64, text: &'static str) -> Goal {
        Goal {
            work,
            beside,
            most,
            text,
        }
    }
    [
        goal("online", "online C++ by hand", 0.9, "0.9"),
        goal("online", "online nalgebra", 0.65, "0.65"),
        goal("online", "online Eigen", 0.4, "0.4"),
        goal("online", "online padasip", 1.0 / 700.0, "1/700"),
        goal("online", "online Octave", 1.0 / 1500.0, "1/1500"),
        goal("online", "bound of the online step", 1.35, "1.35"),
        goal("short", "online", 0.4, "0.4"),
        goal("short", "short scipy", 1.0 / 7.0, "1/7"),
        goal("long", "long scipy", 1.0 / 45.0, "1/45"),
        goal("long", "reading long", 1.5, "1.5"),
        goal("every Theta", "online", 0.3, "0.3"),
        goal("fleet", "reading fleet", 1.3, "1.3"),
        goal("fleet", "fleet numba", 1.0 / 18.0, "1/18"),
        goal("fleet", "fleet numpy", 1.0 / 30.0, "1/30"),
        goal("refined", "refined, own simplex + RK4", 1.0 / 50.0, "1/50"),
        goal(
            "refined",
            "refined scipy least_squares",
            1.0 / 120.0,
            "1/120",
        ),
        goal(
            "refined",
            "refined scipy simplex, Python RK4",
            1.0 / 5000.0,
            "1/5000",
        ),
        goal("monte carlo", "drawing its numbers", 2.3, "2.3"),
        goal("monte carlo", "monte carlo numpy", 1.0 / 25.0, "1/25"),
        // Two cores at least 1.85 of one.
        goal(
            "fleet, two cores",
            "fleet, one core by the clock",
            1.0 / 1.85,
            "0.54",
        ),
        // No goal: what the recursion with two divisions more and all its care costs.
        goal(
            "online, a trial's estimator",
            "online",
            f64::INFINITY,
            "none",
        ),
    ]
};

/// The recursion is that slow that its longest stream ends here.
const MOST_ONLINE_MILLIONS: i32 = 100;

/// Streams of growing length, of which nothing is kept.
fn growth(settings: &FixedRateSettings<f64>, signals: &Signals) -> Outcome<String> {
    let mut text = String::from(
        "\n| samples, streamed | batch, ns a sample | online (to 100e6), ns a sample | peak memory, MB |\n|---|---|---|---|\n",
    );
    for millions in [1, 10, 100, 1000] {
        let begin = machine::processor_s();
        let mut accumulator = Accumulator::new(settings)?;
        for _ in 0..millions {
            accumulator.extend(&signals.heading, &signals.rudder);
        }
        black_box(accumulator.sums());
        let count = f64::from(millions) * LONG as f64;
        let batch_ns = (machine::processor_s() - begin) * 1e9 / count;
        let begin = machine::processor_s();
        let online_millions = millions.min(MOST_ONLINE_MILLIONS);
        for _ in 0..online_millions {
            black_box(online::ours(settings, &signals.heading, &signals.rudder));
        }
        let online_count = f64::from(online_millions) * LONG as f64;
        let online_ns = (machine::processor_s() - begin) * 1e9 / online_count;
        let peak_mb = machine::peak_mb();
        println!(
            "{}",
            json!({"samples": count, "batch_ns": batch_ns, "online_ns": online_ns, "peak_mb": peak_mb})
        );
        text += &format!(
            "| {millions}e6 | {batch_ns:.2} | {online_ns:.2} | {:.0} |\n",
            peak_mb.unwrap_or(f64::NAN)
        );
    }
    Ok(text)
}

/// How far sums are from Givens rotations after a million samples.
fn drift(settings: &FixedRateSettings<f64>, signals: &Signals) -> Outcome<String> {
    fn sums<T: seatrial_kernels::Lane>(
        settings: &FixedRateSettings<f64>,
        heading: &[T],
        rudder: &[T],
    ) -> Outcome<[f64; 3]> {
        let mut accumulator = Accumulator::<T>::new(settings)?;
        accumulator.extend(heading, rudder);
        let model = accumulator.sums().model(f64::INFINITY);
        Ok(model.ok_or("not excited")?.theta())
    }
    let reference = |heading: &[f64], rudder: &[f64]| -> Outcome<[f64; 3]> {
        let mut step = FilterStep::new(settings.lambda_rad_s);
        step.set_interval(settings.sample_interval_s);
        let mut yaw = StateVariableFilter::new(heading[0], settings.filter_start);
        let mut helm = StateVariableFilter::new(rudder[0], settings.filter_start);
        let mut batch = BatchLeastSquares::default();
        for (k, (heading, rudder)) in heading.iter().zip(rudder).enumerate() {
            if k > 0 {
                yaw.advance(*heading, Hold::ZeroOrder, &step);
                helm.advance(*rudder, Hold::ZeroOrder, &step);
            }
            let regressor = [yaw.first_derivative(&step), helm.smoothed(), 1.0];
            batch.add(regressor, yaw.second_derivative(&step));
        }
        Ok(batch.solve().ok_or("not excited")?.theta())
    };
    let apart = |a: [f64; 3], b: [f64; 3]| {
        let scale = b.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        a.iter()
            .zip(b)
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
            / scale
    };
    let (heading, rudder) = (&signals.heading, &signals.rudder);
    let double = apart(
        sums(settings, heading, rudder)?,
        reference(heading, rudder)?,
    );
    let heading32: Vec<f32> = heading.iter().map(|w| *w as f32).collect();
    let rudder32: Vec<f32> = rudder.iter().map(|d| *d as f32).collect();
    let heading: Vec<f64> = heading32.iter().map(|w| f64::from(*w)).collect();
    let rudder: Vec<f64> = rudder32.iter().map(|d| f64::from(*d)).collect();
    let single = apart(
        sums(settings, &heading32, &rudder32)?,
        reference(&heading, &rudder)?,
    );
    println!("{}", json!({"drift_f64": double, "drift_f32": single}));
    Ok(format!(
        "\nDrift of Theta from Givens rotations in f64 at 1e6 samples: f64 {double:.1e} (goal 1e-11), f32 {single:.1e} (goal 1e-4).\n"
    ))
}
