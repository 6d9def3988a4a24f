//! Doublet, 3-2-1-1 and a designed manoeuvre at equal amplitude and time.

use seatrial_core::{Excitation, List, Manoeuvre, Plan, Sample};
use serde::Serialize;

use super::expected_vehicle::ExpectedVehicle;
use super::information::{ExpectedAccuracy, relative_half_widths};
use super::{Prior, PriorSpeed, excursion_rad, range};

/// How wrong the prior may be: a22 and b2 by this factor either way.
pub(super) const PRIOR_ERROR: f64 = 0.3;

/// Jumps of a designed manoeuvre are looked for on this many parts of its duration ...
const COARSE_PARTS: u32 = 10;
/// ... then moved by ever smaller ones.
const FINE_PARTS: [f64; 2] = [20.0, 40.0];
/// Shortest deflection, as a part of the duration.
const SHORTEST_DEFLECTION: f64 = 0.05;
/// Most jumps between the first deflection and the return to neutral.
const MOST_JUMPS: u32 = 3;

/// Samples of a training stage that are enough to weigh one manoeuvre against another.
const ENOUGH_SAMPLES: f64 = 400.0;

/// Manoeuvres of equal amplitude and time side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Amplitude of all, rad.
    pub amplitude_rad: f64,
    /// Duration of all, s.
    pub duration_s: f64,
    /// Doublet, 3-2-1-1, designed within the envelope, designed within the heading excursion of the doublet.
    pub designs: Vec<Design>,
}

/// One manoeuvre at every speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Design {
    /// `doublet`, `3-2-1-1`, `designed`, `designed_calm`.
    pub name: &'static str,
    /// The manoeuvre.
    pub excitation: Excitation<f64>,
    /// One for each speed of the plan.
    pub speeds: Vec<DesignAtSpeed>,
}

/// What a manoeuvre does and determines at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DesignAtSpeed {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// What it determines. `None` where it determines nothing.
    pub expected: Option<ExpectedAccuracy>,
    /// Farthest heading from the heading held, rad.
    pub heading_excursion_rad: f64,
    /// Extent of the track along and across the heading held, training stage, m.
    pub track_m: Option<[f64; 2]>,
}

/// Compares the manoeuvres with the amplitude and duration of the plan's training.
///
/// A designed manoeuvre is a sequence of full deflections to alternating sides with at most 3 jumps between them,
/// chosen to make
///
/// ```text
/// sum over speeds and prior errors of  log max(half width of a22 / |a22|, half width of b2 / |b2|)
/// ```
///
/// least, the prior errors being none and a22 and b2 30 % too large or too small, all four ways. At none of them may
/// it leave the plan's envelope of heading and yaw rate; the calm one may at none of them turn farther than the
/// doublet. The jumps are looked for on tenths of the duration, all of them, and the best is then moved in steps of
/// a twentieth and a fortieth. Where no manoeuvre stays within its limits there is no design.
pub fn compare_designs(plan: &Plan<f64>, prior: &Prior) -> Comparison {
    let amplitude_rad = plan.training.excitation.amplitude_rad().abs();
    let duration_s = plan.training.excitation.duration_s();
    let doublet = Excitation::Doublet { amplitude_rad, period_s: duration_s };
    let three_two_one_one = Excitation::ThreeTwoOneOne { amplitude_rad, unit_s: duration_s / 7.0 };
    let thinned = thinned(prior, plan.training.duration_s());
    let search = |limits: Limits| Search {
        training: plan.training,
        amplitude_rad,
        duration_s,
        prior: &thinned,
        cases: cases(&thinned, plan, limits),
    };
    let calm = search(Limits::Of(doublet));
    let designs = [
        ("doublet", Some(doublet)),
        ("3-2-1-1", Some(three_two_one_one)),
        ("designed", search(Limits::Envelope).best()),
        ("designed_calm", calm.best()),
    ];
    let at_speeds = |excitation: Excitation<f64>| {
        let manoeuvre = Manoeuvre { excitation, ..plan.training };
        prior.speeds.iter().map(|speed| at_speed(&manoeuvre, speed, plan, prior)).collect()
    };
    Comparison {
        amplitude_rad,
        duration_s,
        designs: designs
            .into_iter()
            .filter_map(|(name, excitation)| {
                Some(Design { name, excitation: excitation?, speeds: at_speeds(excitation?) })
            })
            .collect(),
    }
}

fn at_speed(
    manoeuvre: &Manoeuvre<f64>,
    speed: &PriorSpeed,
    plan: &Plan<f64>,
    prior: &Prior,
) -> DesignAtSpeed {
    let northwards = Prior { heading_rad: 0.0, ..prior.clone() };
    let samples = ExpectedVehicle::train(&northwards, *speed, manoeuvre);
    let extent = |of: fn(&Sample<f64>) -> Option<f64>| {
        range(samples.iter().map(of)).map(|[low, high]| high - low)
    };
    DesignAtSpeed {
        thrust: speed.thrust,
        expected: ExpectedAccuracy::of(&samples, speed, plan.rudder_limit_rad),
        heading_excursion_rad: excursion_rad(&samples, 0.0),
        track_m: extent(|s| s.north_m).zip(extent(|s| s.east_m)).map(<[f64; 2]>::from),
    }
}

/// The prior with so few samples that weighing many manoeuvres is quick, and with so much less noise on each
/// that they determine the same.
pub(super) fn thinned(prior: &Prior, stage_s: f64) -> Prior {
    let thinning = (stage_s / (ENOUGH_SAMPLES * prior.sample_interval_s)).floor().max(1.0);
    let mut thinned = prior.clone();
    thinned.sample_interval_s *= thinning;
    thinned.speeds.iter_mut().for_each(|speed| speed.noise.heading_rad /= thinning.sqrt());
    thinned
}

/// How far a designed manoeuvre may go.
enum Limits {
    /// As far as the envelope allows.
    Envelope,
    /// As far as this manoeuvre.
    Of(Excitation<f64>),
}

/// A vehicle that a manoeuvre has to suit.
struct Case {
    speed: PriorSpeed,
    heading_excursion_max_rad: f64,
    yaw_rate_max_rad_s: f64,
}

fn cases(prior: &Prior, plan: &Plan<f64>, limits: Limits) -> Vec<Case> {
    let factors = [1.0 - PRIOR_ERROR, 1.0 + PRIOR_ERROR];
    let corners = factors.map(|a22| factors.map(|b2| [a22, b2]));
    let errors: Vec<[f64; 2]> = corners.into_iter().flatten().chain([[1.0; 2]]).collect();
    let case = |speed: &PriorSpeed, [a22_factor, b2_factor]: [f64; 2]| {
        let mut speed = *speed;
        speed.model.a22_per_s *= a22_factor;
        speed.model.b2_per_s2 *= b2_factor;
        let heading_excursion_max_rad = match limits {
            Limits::Envelope => plan.envelope.heading_excursion_max_rad,
            Limits::Of(excitation) => {
                let manoeuvre = Manoeuvre { excitation, ..plan.training };
                let samples = ExpectedVehicle::train(prior, speed, &manoeuvre);
                excursion_rad(&samples, prior.heading_rad)
            }
        };
        Case {
            speed,
            heading_excursion_max_rad,
            yaw_rate_max_rad_s: plan.envelope.yaw_rate_max_rad_s,
        }
    };
    prior
        .speeds
        .iter()
        .flat_map(|speed| errors.iter().map(move |error| (speed, *error)))
        .map(|(speed, error)| case(speed, error))
        .collect()
}

struct Search<'a> {
    training: Manoeuvre<f64>,
    amplitude_rad: f64,
    duration_s: f64,
    prior: &'a Prior,
    cases: Vec<Case>,
}

impl Search<'_> {
    fn best(&self) -> Option<Excitation<f64>> {
        let coarse = subsets(COARSE_PARTS, MOST_JUMPS).into_iter().map(|parts| {
            let jumps: Vec<f64> =
                parts.iter().map(|part| f64::from(*part) / f64::from(COARSE_PARTS)).collect();
            (self.cost(&jumps), jumps)
        });
        let (mut least, mut jumps) = coarse.min_by(|a, b| a.0.total_cmp(&b.0))?;
        for parts in FINE_PARTS {
            for place in 0..jumps.len() {
                for step in [-1.0 / parts, 1.0 / parts] {
                    loop {
                        let mut moved = jumps.clone();
                        moved[place] += step;
                        let cost = self.cost(&moved);
                        if cost >= least {
                            break;
                        }
                        (least, jumps) = (cost, moved);
                    }
                }
            }
        }
        least.is_finite().then(|| self.excitation(&jumps))?
    }

    /// The sum of the logarithms; infinite outside the limits.
    fn cost(&self, jumps: &[f64]) -> f64 {
        let Some(excitation) = self.excitation(jumps) else {
            return f64::INFINITY;
        };
        let manoeuvre = Manoeuvre { excitation, ..self.training };
        let mut cost = 0.0;
        for case in &self.cases {
            let samples = ExpectedVehicle::train(self.prior, case.speed, &manoeuvre);
            // The rounding of a comparison of a doublet with itself.
            let tolerance = 1.0 + 1e-9;
            if excursion_rad(&samples, self.prior.heading_rad)
                > case.heading_excursion_max_rad * tolerance
                || fastest_turn_rad_s(&samples) > case.yaw_rate_max_rad_s
            {
                return f64::INFINITY;
            }
            let [a22, b2] = relative_half_widths(&samples, &case.speed);
            cost += libm::log(a22.max(b2));
        }
        cost
    }

    /// `None` where a deflection would be too short.
    fn excitation(&self, jumps: &[f64]) -> Option<Excitation<f64>> {
        let ends = jumps.iter().copied().chain([1.0]);
        let starts = [0.0].into_iter().chain(jumps.iter().copied());
        let lengths: Vec<f64> = starts.zip(ends).map(|(start, end)| end - start).collect();
        // The rounding of sums of fortieths.
        if lengths.iter().any(|l| *l < SHORTEST_DEFLECTION - 1e-9) {
            return None;
        }
        let lengths_s: Vec<f64> = lengths.iter().map(|l| l * self.duration_s).collect();
        Some(Excitation::Switched {
            amplitude_rad: self.amplitude_rad,
            deflections_s: List::from_slice(&lengths_s)?,
        })
    }
}

pub(super) fn fastest_turn_rad_s(samples: &[Sample<f64>]) -> f64 {
    samples
        .iter()
        .filter_map(|s| s.yaw_rate_rad_s)
        .fold(0.0, |fastest, rate| f64::max(fastest, rate.abs()))
}

/// All increasing sequences of up to `most` of the numbers from 1 to below `parts`.
fn subsets(parts: u32, most: u32) -> Vec<Vec<u32>> {
    let mut all = vec![Vec::new()];
    let mut longest = all.clone();
    for _ in 0..most {
        longest = longest
            .iter()
            .flat_map(|shorter: &Vec<u32>| {
                let from = shorter.last().map_or(1, |last| last + 1);
                (from..parts).map(move |next| [shorter.as_slice(), &[next]].concat())
            })
            .collect();
        all.extend(longest.iter().cloned());
    }
    all
}
