//! The work of seatrial and of its kernels that is timed.

use std::hint::black_box;
use std::time::Instant;

use seatrial::identify::evenly_sampled::EvenlySampled;
use seatrial::identify::output_error::nearest_simulation;
use seatrial::identify::simplex::fit_as_paper;
use seatrial_core::{FixedRateSettings, YawModel};
use seatrial_kernels::{Accumulator, every_theta, monte_carlo, normals_of_run, of_records};

use crate::signals::{Data, RUNS};
use crate::{AGREEMENT, INITIAL_COVARIANCE, LAMBDA_RAD_S, LONG, ONLINE, Outcome, RECORDS, SHORT};
use crate::{INTERVAL_S, machine, online};

/// Of this many repetitions the one that took least processor time is a round's: others share the machine.
const REPEATS: usize = 3;

/// Runs of a work that is too short to be timed alone.
const TOGETHER: usize = 100;

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

/// The least time of some repetitions by the clock on the wall, s, and what the work gave: for what runs on two cores.
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

pub struct Entry<'a> {
    pub name: &'static str,
    /// Seconds for one of what is counted.
    pub run: Box<dyn FnMut() -> Outcome<f64> + 'a>,
}

fn entry<'a>(name: &'static str, run: impl FnMut() -> Outcome<f64> + 'a) -> Entry<'a> {
    Entry {
        name,
        run: Box::new(run),
    }
}

pub fn agree(name: &str, found: &[f64], expected: [f64; 3]) -> Outcome<()> {
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

/// All that is timed here; the peers come besides.
pub fn entries(data: &Data) -> Outcome<Vec<Entry<'_>>> {
    let mut entries = chains();
    entries.extend(of_online(data)?);
    entries.extend(of_one_record(data)?);
    entries.extend(of_a_fleet(data));
    entries.extend(of_the_refined_estimate(data));
    entries.extend(of_monte_carlo(data));
    Ok(entries)
}

/// Theta of a record by the kernel of one long record.
pub fn model_of(
    settings: &FixedRateSettings<f64>,
    heading: &[f64],
    rudder: &[f64],
) -> Outcome<YawModel<f64>> {
    let mut accumulator = Accumulator::new(settings)?;
    accumulator.extend(heading, rudder);
    let model = accumulator.sums().model(INITIAL_COVARIANCE);
    Ok(model.ok_or("not excited")?)
}

fn per(count: usize, (seconds, _): (f64, f64)) -> Outcome<f64> {
    Ok(seconds / count as f64)
}

fn chains<'a>() -> Vec<Entry<'a>> {
    vec![
        entry("chain of multiplications", || Ok(machine::multiply_s())),
        entry("chain of additions", || Ok(machine::add_s())),
        entry("chain of divisions", || Ok(machine::divide_s())),
        entry("chain of fused multiply-adds", || {
            machine::fused_s().ok_or_else(|| "no fused multiply-add".into())
        }),
        entry("bound of the online step", || {
            Ok(2.0 * machine::multiply_s() + 4.0 * machine::add_s() + machine::divide_s())
        }),
    ]
}

/// A recursion over the online part of the record; an error where it finds another model than `expected`.
fn online_step<'a>(
    expected: [f64; 3],
    name: &'static str,
    mut work: impl FnMut() -> [f64; 3] + 'a,
) -> Entry<'a> {
    entry(name, move || {
        let (seconds, theta) = timed(&mut work);
        agree(name, &theta, expected)?;
        Ok(seconds / ONLINE as f64)
    })
}

fn of_online(data: &Data) -> Outcome<Vec<Entry<'_>>> {
    let settings = &data.settings;
    let (head, helm) = data.online();
    let single = |signal: &[f64]| -> Vec<f32> { signal.iter().map(|w| *w as f32).collect() };
    let (head32, helm32) = (single(head), single(helm));
    let expected = model_of(settings, head, helm)?.theta();
    Ok(vec![
        online_step(expected, "online", move || {
            online::ours(settings, black_box(head), black_box(helm))
        }),
        online_step(expected, "online f32", move || {
            online::ours_f32(settings, black_box(&head32), black_box(&helm32))
        }),
        online_step(expected, "online, a trial's estimator", move || {
            online::of_a_trial(black_box(head), black_box(helm))
        }),
        entry("online, a trial's instrument", move || {
            let work = || online::with_the_instrument(black_box(head), black_box(helm));
            per(ONLINE, timed(|| work()[0]))
        }),
        online_step(expected, "online nalgebra", move || {
            online::nalgebra(black_box(head), black_box(helm))
        }),
        online_step(expected, "online ndarray", move || {
            online::ndarray(black_box(head), black_box(helm))
        }),
    ])
}

fn of_one_record(data: &Data) -> Outcome<Vec<Entry<'_>>> {
    let Data {
        settings,
        short,
        long,
        ..
    } = data;
    let (head, helm) = data.online();
    let expected = model_of(settings, head, helm)?.theta();
    let times: Vec<f64> = (0..LONG).map(|k| k as f64 * INTERVAL_S).collect();
    let mut thetas = Vec::new();
    Ok(vec![
        entry("short", move || {
            let one = || {
                model_of(
                    settings,
                    black_box(&short.heading),
                    black_box(&short.rudder),
                )
            };
            let models = || (0..TOGETHER).filter_map(|_| one().ok());
            per(
                SHORT * TOGETHER,
                timed(|| models().map(|model| model.a22_per_s).sum()),
            )
        }),
        entry("long", move || {
            let (seconds, found) =
                timed(|| model_of(settings, black_box(&long.heading), black_box(&long.rudder)));
            agree("long", &found?.theta(), expected)?;
            Ok(seconds / LONG as f64)
        }),
        entry("estimate=\"batch\"", move || {
            let record = EvenlySampled {
                time_s: &times,
                heading_rad: &long.heading,
                rudder_rad: &long.rudder,
            };
            let (seconds, found) = timed(|| black_box(record).least_squares(LAMBDA_RAD_S));
            agree("batch", &found?.model.theta(), expected)?;
            Ok(seconds / LONG as f64)
        }),
        entry("reading long", move || {
            per(
                LONG,
                timed(|| machine::read(black_box(&long.heading), black_box(&long.rudder))),
            )
        }),
        entry("every Theta", move || {
            let (seconds, done) = timed(|| {
                every_theta(
                    settings,
                    &long.heading,
                    &long.rudder,
                    black_box(&mut thetas),
                )
            });
            done?;
            agree("every Theta", &thetas[LONG - 1], expected)?;
            Ok(seconds / LONG as f64)
        }),
        entry("every Theta, new memory", move || {
            per(
                LONG,
                timed(|| {
                    let mut thetas = Vec::new();
                    let _ = every_theta(settings, &long.heading, &long.rudder, &mut thetas);
                    thetas[LONG - 1][0]
                }),
            )
        }),
    ])
}

fn of_a_fleet(data: &Data) -> Vec<Entry<'_>> {
    let (heading, rudder) = (&data.fleet_heading[..], &data.fleet_rudder[..]);
    let all = SHORT * RECORDS;
    let models = move |heading: &[f64], rudder: &[f64]| -> f64 {
        let sums = of_records(&data.settings, SHORT, heading, rudder);
        let models = sums.into_iter().flatten();
        models
            .filter_map(|sums| sums.model(INITIAL_COVARIANCE))
            .map(|model| model.a22_per_s)
            .sum()
    };
    vec![
        entry("fleet", move || per(all, timed(|| models(heading, rudder)))),
        entry("fleet, two cores", move || {
            let half = all / 2;
            let on_two = || {
                std::thread::scope(|scope| {
                    let other = scope.spawn(|| models(&heading[..half], &rudder[..half]));
                    let own = models(&heading[half..], &rudder[half..]);
                    own + other.join().unwrap_or(f64::NAN)
                })
            };
            per(all, timed_by_the_clock(on_two))
        }),
        entry("fleet, one core by the clock", move || {
            per(all, timed_by_the_clock(|| models(heading, rudder)))
        }),
        entry("reading fleet", move || {
            per(
                all,
                timed(|| machine::read(black_box(heading), black_box(rudder))),
            )
        }),
    ]
}

fn of_the_refined_estimate(data: &Data) -> Vec<Entry<'_>> {
    vec![
        entry("refined", || {
            let one = || nearest_simulation(black_box(&data.samples), Some(data.start));
            let found = || (0..TOGETHER).filter_map(|_| one().ok());
            per(
                TOGETHER,
                timed(|| found().map(|found| found.residual_rms_rad()).sum()),
            )
        }),
        entry("refined, own simplex + RK4", || {
            let one = || fit_as_paper(black_box(&data.samples));
            per(1, timed(|| one().map_or(f64::NAN, |found| found.cost)))
        }),
    ]
}

fn of_monte_carlo(data: &Data) -> Vec<Entry<'_>> {
    let all = SHORT * RUNS as usize;
    let noisy = data.noisy_runs();
    vec![
        entry("monte carlo", move || {
            per(
                all,
                timed(|| {
                    let sums = monte_carlo(&data.settings, black_box(&noisy));
                    let models = sums.into_iter().flatten();
                    models
                        .filter_map(|sums| sums.model(INITIAL_COVARIANCE))
                        .map(|model| model.a22_per_s)
                        .sum()
                }),
            )
        }),
        entry("drawing its numbers", move || {
            let last = |run| normals_of_run(1, black_box(run), SHORT)[SHORT - 1];
            per(all, timed(|| (0..RUNS).map(last).sum()))
        }),
    ]
}
