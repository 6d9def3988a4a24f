//! The work of seatrial that is timed.

use std::hint::black_box;

use seatrial::identify::evenly_sampled::EvenlySampled;
use seatrial::identify::output_error::output_error;
use seatrial::identify::simplex::fit_as_paper;
use seatrial_core::YawModel;

use crate::signals::Data;
use crate::{AGREEMENT, INTERVAL_S, LAMBDA_RAD_S, LONG, ONLINE, Outcome, machine, online};

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

pub struct Entry<'a> {
    pub name: &'static str,
    /// Seconds for one of what is counted.
    pub run: Box<dyn FnMut() -> Outcome<f64> + 'a>,
}

fn entry<'a>(name: &'static str, run: impl FnMut() -> Outcome<f64> + 'a) -> Entry<'a> {
    Entry { name, run: Box::new(run) }
}

pub fn agree(name: &str, found: &[f64], expected: [f64; 3]) -> Outcome<()> {
    let scale = expected[0].abs().max(expected[1].abs());
    let is_close = found.len() >= 3
        && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < AGREEMENT * scale);
    match is_close {
        true => Ok(()),
        false => Err(format!("{name} gives {found:?}, expected {expected:?}").into()),
    }
}

/// All that is timed here; the peers come besides.
pub fn entries(data: &Data) -> Outcome<Vec<Entry<'_>>> {
    let mut entries = chains();
    entries.extend(of_online(data)?);
    entries.extend(of_the_long_record(data)?);
    entries.extend(of_the_refined_estimate(data));
    Ok(entries)
}

/// Theta of an evenly sampled record from its sums.
pub fn model_of(heading: &[f64], rudder: &[f64]) -> Outcome<YawModel<f64>> {
    let times: Vec<f64> = (0..heading.len()).map(|k| k as f64 * INTERVAL_S).collect();
    least_squares(&times, heading, rudder)
}

fn least_squares(times: &[f64], heading: &[f64], rudder: &[f64]) -> Outcome<YawModel<f64>> {
    let record = EvenlySampled { time_s: times, heading_rad: heading, rudder_rad: rudder };
    Ok(record.least_squares(LAMBDA_RAD_S)?.model)
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
    let expected = model_of(head, helm)?.theta();
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

fn of_the_long_record(data: &Data) -> Outcome<Vec<Entry<'_>>> {
    let (head, helm) = data.online();
    let expected = model_of(head, helm)?.theta();
    let (heading, rudder) = (&data.long.heading[..], &data.long.rudder[..]);
    let times: Vec<f64> = (0..LONG).map(|k| k as f64 * INTERVAL_S).collect();
    Ok(vec![
        entry("batch", move || {
            let (seconds, found) =
                timed(|| least_squares(&times, black_box(heading), black_box(rudder)));
            agree("batch", &found?.theta(), expected)?;
            Ok(seconds / LONG as f64)
        }),
        entry("reading long", move || {
            per(LONG, timed(|| machine::read(black_box(heading), black_box(rudder))))
        }),
    ])
}

fn of_the_refined_estimate(data: &Data) -> Vec<Entry<'_>> {
    vec![
        entry("refined", || {
            let one = || output_error(black_box(&data.samples), Some(data.start));
            let found = || (0..TOGETHER).filter_map(|_| one().ok());
            per(TOGETHER, timed(|| found().map(|found| found.residual_rms_rad).sum()))
        }),
        entry("refined, own simplex + RK4", || {
            let one = || fit_as_paper(black_box(&data.samples));
            per(1, timed(|| one().map_or(f64::NAN, |found| found.cost)))
        }),
    ]
}
