//! What happened once and explains that no model holds: a heading that jumped, a rudder that stuck.
//!
//! Both are looked for without a gyro and without a measured rudder. They name the cause of a verdict; alone they reject
//! nothing.

use seatrial_core::{Sample, YawModel};

use super::compass::Jump;
use super::validation::{fit_of_what_is_measured, goodness_of_fit};
use crate::identification::LEAST_R2;
use crate::line::Line;
use crate::manoeuvre::Manoeuvre;
use crate::record::{between_gaps, turned_rad, unwrapped_rad};

/// Samples on either side that say where the heading goes, beside the nearest one, which may be an outlier.
const SIDE: usize = 10;
/// A jump is at least this, rad, and so many times what nine in ten instants show.
const LEAST_JUMP_RAD: f64 = 0.05;
const TIMES_USUAL: f64 = 4.0;
/// Share of a jump that comes within one interval.
const AT_ONCE: f64 = 0.6;

/// Instants at which a rudder may have stuck or come free.
const INSTANTS: usize = 40;
/// R^2 with the stuck rudder, and the share of what is not explained without it that may be left.
const LEAST_R2_JAMMED: f64 = 0.9;
const MOST_LEFT: f64 = 0.2;
/// Share of the rudder's amplitude that the command must move while the rudder is stuck, and that shows that it parts from the rudder.
const LEAST_MOVED: f64 = 0.5;
const ASIDE: f64 = 0.2;

/// A rudder that stayed where it was, whatever it was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jam {
    /// When its command first went elsewhere, s on the log's clock.
    pub from_s: f64,
    /// Until when, s; `None` where it did not come free.
    pub to_s: Option<f64>,
    /// Where it stayed, rad.
    pub rudder_rad: f64,
}

/// What happened once in the training or in the validation data, and in which.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mishaps {
    /// A jump of the heading.
    pub jump: Option<(Jump, &'static str)>,
    /// A stuck rudder.
    pub jam: Option<(Jam, &'static str)>,
}

impl Mishaps {
    /// Looks for a jump in both, and for a stuck rudder in each by the model of the other where the model does not hold.
    pub fn of(
        [training, validation]: [&[Sample<f64>]; 2],
        model: YawModel<f64>,
        other: Option<YawModel<f64>>,
    ) -> Self {
        let places = [(training, "in training"), (validation, "in the validation data")];
        let jumps = places.iter().filter_map(|(part, at)| Some((heading_jump(part)?, *at)));
        let largest = |a: &(Jump, _), b: &(Jump, _)| a.0.size_rad.total_cmp(&b.0.size_rad);
        let jam = |(part, at), model| Some((rudder_jam(model, part)?, at));
        let jam = match holds(model, validation) {
            true => None,
            false => jam(places[1], model).or_else(|| jam(places[0], other?)),
        };
        Self { jump: jumps.max_by(largest), jam }
    }
}

/// The largest jump of the heading that no vehicle makes.
///
/// ```text
/// d(k) = line through psi(k+2..k+11) - line through psi(k-10..k-1), both at the middle of samples k and k+1
/// ```
///
/// A vehicle turns on, so that d is noise and what little its yaw rate changes within a side. A jump stands out of the d of nine instants
/// in ten, stays, and comes within one interval: an outlier and a hard turn do not. Nor does what changes over a gap of the record.
pub fn heading_jump(samples: &[Sample<f64>]) -> Option<Jump> {
    let usable = || samples.iter().filter(|s| s.heading_rad.is_finite());
    let is_large = |(one, next): (&Sample<f64>, &Sample<f64>)| {
        turned_rad(one, next).abs() > AT_ONCE * LEAST_JUMP_RAD
    };
    if !usable().zip(usable().skip(1)).any(is_large) {
        return None;
    }
    let usable: Vec<Sample<f64>> = usable().copied().collect();
    between_gaps(&usable).filter_map(jump_of_part).max_by(|a, b| a.size_rad.total_cmp(&b.size_rad))
}

/// [`heading_jump`] of samples without a gap, whose headings are finite.
fn jump_of_part(usable: &[Sample<f64>]) -> Option<Jump> {
    if usable.len() < 4 * SIDE {
        return None;
    }
    let heading_rad = unwrapped_rad(0.0, usable.iter().map(|s| s.heading_rad));
    let times_s: Vec<f64> = usable.iter().map(|s| s.time_s).collect();
    let lines: Vec<Option<Line>> = (times_s.windows(SIDE).zip(heading_rad.windows(SIDE)))
        .map(|(times_s, heading_rad)| Line::through(times_s, heading_rad))
        .collect();
    let parts: Vec<(usize, f64)> = (SIDE..usable.len() - SIDE - 1)
        .filter_map(|k| {
            let middle_s = 0.5 * (times_s[k] + times_s[k + 1]);
            let at = |from: usize| Some(lines[from].as_ref()?.at(middle_s));
            Some((k, at(k + 2)? - at(k - SIDE)?))
        })
        .filter(|(_, parted)| parted.is_finite())
        .collect();
    let mut sizes: Vec<f64> = parts.iter().map(|(_, parted)| parted.abs()).collect();
    if sizes.is_empty() {
        return None;
    }
    let nine_in_ten = 9 * sizes.len() / 10;
    let usual = *sizes.select_nth_unstable_by(nine_in_ten, f64::total_cmp).1;
    let (k, parted) = parts.into_iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))?;
    // The sample beside each line may be on either side of the jump.
    let step = |at: &usize| (heading_rad[at + 1] - heading_rad[*at]) * parted.signum();
    let at = (k - 1..k + 2).max_by(|a, b| step(a).total_cmp(&step(b)))?;
    let stays = (middle_of(&heading_rad[k + 2..k + 5]) - middle_of(&heading_rad[k - 3..k]))
        * parted.signum();
    let is_jump = parted.abs() > LEAST_JUMP_RAD.max(TIMES_USUAL * usual)
        && step(&at).min(stays) > AT_ONCE * parted.abs();
    is_jump.then(|| Jump { size_rad: parted.abs(), time_s: times_s[at + 1] })
}

/// The middle one by size.
fn middle_of(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A stuck rudder that explains what a model does not: the heading is simulated with the rudder held from each of some instants
/// until each later one, and until the end. `None` where the model holds as it is, no such pair makes it hold, or the model is not stable:
/// that one explains any heading once the rudder is held.
///
/// Cost: some 800 simulations of the record; only where a model does not hold.
pub fn rudder_jam(model: YawModel<f64>, samples: &[Sample<f64>]) -> Option<Jam> {
    if holds(model, samples) || model.a22_per_s >= 0.0 {
        return None;
    }
    let r2 =
        |samples: &[Sample<f64>]| fit_of_what_is_measured(model, samples).r2_heading_offset_refit;
    let free = r2(samples)?;
    let manoeuvre = Manoeuvre::find(samples)?;
    let first = samples.partition_point(|s| s.time_s < manoeuvre.starts_s);
    let step = ((samples.len() - first) / INSTANTS).max(1);
    let instants: Vec<usize> = (first..samples.len()).step_by(step).collect();
    let ends =
        |from: usize| instants.iter().copied().filter(move |to| *to > from).chain([samples.len()]);
    let tried = instants.iter().flat_map(|&from| ends(from).map(move |to| (from, to)));
    let moved = |from: usize, to: usize| {
        let held = samples[from].rudder_rad;
        let apart = samples[from..to].iter().map(|s| (s.rudder_rad - held).abs());
        apart.fold(0.0, f64::max) >= LEAST_MOVED * manoeuvre.amplitude_rad
    };
    let (from, to, best) = tried
        .filter(|(from, to)| moved(*from, *to))
        .filter_map(|(from, to)| Some((from, to, r2(&held(samples, from, to))?)))
        .max_by(|(.., a), (.., b)| a.total_cmp(b))?;
    let explains = best >= LEAST_R2_JAMMED && 1.0 - best <= MOST_LEFT * (1.0 - free);
    let rudder_rad = samples[from].rudder_rad;
    let parts =
        |s: &&Sample<f64>| (s.rudder_rad - rudder_rad).abs() > ASIDE * manoeuvre.amplitude_rad;
    explains.then_some(Jam {
        from_s: samples[from..to].iter().find(parts)?.time_s,
        to_s: samples.get(to).map(|s| s.time_s),
        rudder_rad,
    })
}

/// Does the model explain the heading, at least but for an offset?
fn holds(model: YawModel<f64>, samples: &[Sample<f64>]) -> bool {
    fit_of_what_is_measured(model, samples).reaches(LEAST_R2)
        || goodness_of_fit(model, samples).reaches(LEAST_R2)
}

/// The samples with the rudder held.
fn held(samples: &[Sample<f64>], from: usize, to: usize) -> Vec<Sample<f64>> {
    let mut held = samples.to_vec();
    let rudder_rad = samples[from].rudder_rad;
    held[from..to].iter_mut().for_each(|s| s.rudder_rad = rudder_rad);
    held
}

#[cfg(test)]
mod tests {
    use seatrial_core::Real;

    use super::*;

    const MODEL: YawModel<f64> = YawModel { a22_per_s: -1.0, b2_per_s2: 1.0, c0_rad_per_s2: 0.0 };

    /// A doublet at 20 Hz, its heading through an error, its rudder through what it does of its command.
    fn doublet(
        compass: impl Fn(f64, f64) -> f64,
        rudder: impl Fn(f64, f64) -> f64,
    ) -> Vec<Sample<f64>> {
        let (mut heading, mut rate, mut noise) = (0.0, 0.0, 0.0);
        (0..400)
            .map(|k| {
                let time_s = f64::from(k) * 0.05;
                let command = match time_s {
                    t if (4.0..8.0).contains(&t) => 0.3,
                    t if (8.0..12.0).contains(&t) => -0.3,
                    _ => 0.0,
                };
                // A cheap noise of half a degree.
                noise = (noise * 7.3_f64 + 0.37).fract();
                let sample = Sample {
                    time_s,
                    heading_rad: Real::wrapped(compass(time_s, heading) + 0.02 * (noise - 0.5)),
                    rudder_rad: command,
                    ..Sample::default()
                };
                heading += 0.05 * rate;
                rate += 0.05 * (MODEL.a22_per_s * rate + MODEL.b2_per_s2 * rudder(time_s, command));
                sample
            })
            .collect()
    }

    #[test]
    fn exact_a_jump_differs_from_a_turn_and_an_outlier() {
        let followed = |_: f64, command: f64| command;
        assert_eq!(heading_jump(&doublet(|_, psi| psi, followed)), None);
        let spike = |t: f64, psi: f64| psi + if (t - 6.0).abs() < 0.02 { 0.4 } else { 0.0 };
        assert_eq!(heading_jump(&doublet(spike, followed)), None);
        for (size_rad, time_s) in [(0.35, 7.0), (-0.2, 10.0), (0.1, 2.0)] {
            let jumped = |t: f64, psi: f64| psi + if t >= time_s - 1e-9 { size_rad } else { 0.0 };
            let found = heading_jump(&doublet(jumped, followed)).unwrap();
            assert!((found.time_s - time_s).abs() < 0.06, "{found:?}");
            assert!((found.size_rad - size_rad.abs()).abs() < 0.04, "{found:?}");
        }
    }

    #[test]
    fn exact_a_stuck_rudder_is_found_with_its_time() {
        let free = |_: f64, command: f64| command;
        assert_eq!(rudder_jam(MODEL, &doublet(|_, psi| psi, free)), None);
        // Sticks at starboard and never comes back.
        let stuck = |t: f64, command: f64| if t >= 6.0 { 0.3 } else { command };
        let found = rudder_jam(MODEL, &doublet(|_, psi| psi, stuck)).unwrap();
        assert!((found.rudder_rad - 0.3).abs() < 1e-12, "{found:?}");
        assert!((8.0..8.1).contains(&found.from_s), "{found:?}");
        assert_eq!(found.to_s, None);
        // Another vehicle is none: its rudder did what it was told.
        let other = |_: f64, command: f64| 2.5 * command;
        assert_eq!(rudder_jam(MODEL, &doublet(|_, psi| psi, other)), None);
        let reversed = |_: f64, command: f64| -command;
        assert_eq!(rudder_jam(MODEL, &doublet(|_, psi| psi, reversed)), None);
        // Of a vehicle that is not stable nothing is known.
        let unstable = YawModel { a22_per_s: 0.1, ..MODEL };
        assert_eq!(rudder_jam(unstable, &doublet(|_, psi| psi, stuck)), None);
    }
}
