//! From the voyage to the file.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use seatrial_core::Real;

use super::clock;
use super::draw::Draw;
use super::setup::{GyroChannel, Setup};
use super::voyage::Voyage;
use super::{LogTruth, LyingLog};

/// A reading repeats for so many rows where the compass sticks.
const STUCK_ROWS: usize = 8;

/// Writes the log.
pub fn write(setup: &Setup, voyage: &Voyage, seed: u64) -> LyingLog {
    let mut chance = Draw::new(seed ^ 0x10_6000);
    let end_s = voyage.validation_s[1];
    let rows = (end_s / setup.row_s()) as usize;
    let times_s: Vec<f64> = (0..rows).map(|row| row as f64 * setup.row_s()).collect();
    let middle_s = voyage.training_s[0] + 4.0 * setup.time_constant_s();
    let headings = headings(setup, voyage, &times_s, middle_s, &mut chance);
    let rudders = rudders(setup, voyage, &times_s);
    let rates = setup.gyro.map(|gyro| gyro_rates(setup, &gyro, voyage, &times_s, &mut chance));
    let stamped = clock::stamps(setup, &times_s, middle_s, &mut chance);
    let reach = setup.gyro.and_then(|gyro| gyro.computed);
    let rates =
        reach.map_or(rates, |reach| Some(computed_rates(setup, &headings, &stamped, reach)));
    let mut csv = header(setup);
    for &(row, stamp) in &stamped {
        let decimals = setup.clock.decimals();
        let _ = write!(csv, "{stamp:.decimals$},{:.6},{:.6}", headings[row], rudders[row]);
        if let Some(rates) = &rates {
            let _ = write!(csv, ",{:.6}", rates[row]);
        }
        if setup.has_speed {
            let speed = voyage.at(times_s[row]).speed_m_s + 0.01 * chance.normal();
            let _ = write!(csv, ",{speed:.3}");
        }
        csv.push('\n');
    }
    let by_the_clock = |window: [f64; 2]| {
        window.map(|time_s| {
            stamped
                .iter()
                .find(|(row, _)| times_s[*row] >= time_s - 1e-9)
                .or(stamped.last())
                .map_or(0.0, |(_, stamp)| *stamp)
        })
    };
    let hull = &setup.hulls[0];
    LyingLog {
        csv,
        training_s: by_the_clock(voyage.training_s),
        validation_s: by_the_clock(voyage.validation_s),
        truth: LogTruth {
            a22_per_s: hull.a22_per_s,
            b2_per_s2: hull.b2_per_s2
                * setup.rudder.sense
                * if setup.heading.mirrored { -1.0 } else { 1.0 },
            full_rudder_rad: setup.full_rudder_rad,
        },
    }
}

/// What a gyro reads, in the file's unit.
fn gyro_rates(
    setup: &Setup,
    gyro: &GyroChannel,
    voyage: &Voyage,
    times_s: &[f64],
    chance: &mut Draw,
) -> Vec<f64> {
    let read = |&t: &f64| {
        let true_rad_s = voyage.at((t - gyro.late_s).max(0.0)).yaw_rate_rad_s;
        let rate = true_rad_s + gyro.noise_rad_s * chance.normal();
        gyro.factor * setup.columns.yaw_rate.per_si * rate
    };
    times_s.iter().map(read).collect()
}

/// Mean slopes of the file's headings by its times, as a program computes them, in the file's unit.
fn computed_rates(
    setup: &Setup,
    headings: &[f64],
    stamped: &[(usize, f64)],
    reach: usize,
) -> Vec<f64> {
    let turn = TAU * setup.columns.heading.per_si;
    let last = headings.len() - 1;
    let slope = |row: usize| {
        let (before, after) = (row.saturating_sub(1), (row + 1).min(last));
        let change = headings[after] - headings[before];
        let passed = stamped[after].1 - stamped[before].1;
        (change - turn * (change / turn).round()) / passed
    };
    let mean = |row: usize| {
        let rows = row.saturating_sub(reach)..=(row + reach).min(last);
        let count = rows.clone().count() as f64;
        rows.map(slope).sum::<f64>() / count
    };
    (0..=last).map(mean).collect()
}

fn header(setup: &Setup) -> String {
    let columns = &setup.columns;
    let mut names = vec![columns.time, columns.heading.name, columns.rudder.name];
    if setup.gyro.is_some() {
        names.push(columns.yaw_rate.name);
    }
    if setup.has_speed {
        names.push("speed_m_s");
    }
    names.join(",") + "\n"
}

/// The number in the heading column of each row.
fn headings(
    setup: &Setup,
    voyage: &Voyage,
    times_s: &[f64],
    middle_s: f64,
    chance: &mut Draw,
) -> Vec<f64> {
    let channel = &setup.heading;
    let filtered = low_passed(setup, voyage);
    let seen = |time_s: f64| {
        let held_s = match channel.held_s {
            0.0 => time_s,
            held_s => libm::floor(time_s / held_s + 1e-6) * held_s,
        };
        let tick = (held_s / setup.control_s + 1e-6) as usize;
        let noise_rad = voyage.noise_rad[tick.min(voyage.noise_rad.len() - 1)];
        let at_s = (held_s - channel.late_s).max(0.0);
        let true_rad = match (&filtered, channel.course_over_ground) {
            (Some(filtered), _) => {
                let place = (at_s / voyage.step_s + 1e-6) as usize;
                return filtered[place.min(filtered.len() - 1)];
            }
            (None, Some([north, east])) => {
                let moment = voyage.at(at_s);
                let (psi, u) = (moment.heading_rad, moment.speed_m_s);
                let course = libm::atan2(u * libm::sin(psi) + east, u * libm::cos(psi) + north);
                psi + Real::wrapped(course - psi)
            }
            (None, None) => voyage.at(at_s).heading_rad,
        };
        let [size, phase] = channel.deviation_rad;
        let jump_rad = if time_s >= middle_s { channel.jump_rad } else { 0.0 };
        true_rad + size * libm::sin(true_rad + phase) + jump_rad + noise_rad
    };
    let mut stuck_for = 0;
    let mut last = f64::NAN;
    times_s
        .iter()
        .map(|&time_s| {
            if channel.constant && last.is_finite() {
                return last;
            }
            if stuck_for == 0 && chance.chance(channel.stuck_share / STUCK_ROWS as f64) {
                stuck_for = STUCK_ROWS;
            }
            stuck_for = usize::saturating_sub(stuck_for, 1);
            if stuck_for > 0 && last.is_finite() {
                return last;
            }
            last = in_the_file(setup, seen(time_s));
            last
        })
        .collect()
}

/// A heading as its column has it.
fn in_the_file(setup: &Setup, heading_rad: f64) -> f64 {
    let channel = &setup.heading;
    let column = &setup.columns.heading;
    let heading_rad = if channel.mirrored { -heading_rad } else { heading_rad };
    let wrapped_rad = match channel.modulo_rad {
        Some(modulo_rad) => heading_rad.rem_euclid(modulo_rad),
        None if channel.wraps_badly => {
            // Averaged over a wrap: between 350 and 10 deg it passes through south.
            let wrapped = heading_rad.rem_euclid(TAU);
            let from_north = Real::wrapped(wrapped);
            if from_north.abs() < 0.1 { PI - from_north * PI / 0.1 } else { wrapped }
        }
        None if setup.columns.heading.name.ends_with("rad") => Real::wrapped(heading_rad),
        None => heading_rad.rem_euclid(TAU),
    };
    let number = wrapped_rad * column.per_si + column.offset;
    match channel.resolution {
        0.0 => number,
        step => (number / step).round() * step,
    }
}

/// The heading and its noise behind a low-pass filter, at every step of the truth.
fn low_passed(setup: &Setup, voyage: &Voyage) -> Option<Vec<f64>> {
    let time_constant_s = setup.heading.low_pass_s;
    if time_constant_s == 0.0 {
        return None;
    }
    let share = -libm::expm1(-voyage.step_s / time_constant_s);
    let mut filtered = voyage.moments[0].heading_rad;
    let last = voyage.noise_rad.len() - 1;
    let follow = |(step, moment): (usize, &super::voyage::Moment)| {
        let tick = (step as f64 * voyage.step_s / setup.control_s + 1e-6) as usize;
        let measured = moment.heading_rad + voyage.noise_rad[tick.min(last)];
        filtered += share * (measured - filtered);
        filtered
    };
    Some(voyage.moments.iter().enumerate().map(follow).collect())
}

/// The number in the rudder column of each row.
fn rudders(setup: &Setup, voyage: &Voyage, times_s: &[f64]) -> Vec<f64> {
    let channel = &setup.rudder;
    let column = &setup.columns.rudder;
    (0..times_s.len())
        .map(|row| {
            let shifted = (row as i64 - channel.late_rows).clamp(0, times_s.len() as i64 - 1);
            let time_s = match (channel.constant, channel.held_s) {
                (true, _) => 0.0,
                (false, 0.0) => times_s[shifted as usize],
                (false, held_s) => libm::floor(times_s[shifted as usize] / held_s + 1e-6) * held_s,
            };
            let place = (time_s / voyage.step_s + 1e-6) as usize;
            let moment = voyage.moments[place.min(voyage.moments.len() - 1)];
            if channel.half_sum {
                let sum = 0.2 + 0.01 * libm::sin(0.3 * row as f64 / setup.time_constant_s());
                return sum * column.per_si + column.offset;
            }
            let angle_rad = if channel.measured { moment.fin_rad } else { moment.command_rad };
            channel.sense * angle_rad * column.per_si + column.offset
        })
        .collect()
}
