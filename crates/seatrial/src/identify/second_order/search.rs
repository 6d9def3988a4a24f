//! The largest likelihood of every structure, without a disturbance and with the likeliest.

use super::comparisons::Comparisons;
use super::likelihood::Summit;
use super::theta::{A11, A21, A22, B2, C0, CROSS_FLOW, LAG, Theta};
use super::{Candidate, Structure, free_parameters};
use seatrial_core::refine::{DISTURBANCE_TIME_CONSTANTS, Disturbance};

/// Where searches start, over the first-order rate: a11, a21, and the rudder lag times it.
const DECAYS: [f64; 3] = [-0.15, -0.5, -1.0];
const COUPLINGS: [f64; 2] = [-0.1, 0.1];
const LAGS: [f64; 2] = [0.05, 0.2];

/// Ratios of neighbouring strengths of the disturbance: on the way to the first order's likeliest, and from there.
const STRIDE: f64 = 8.0;
const OCTAVE: f64 = 2.0;
const MOST_OCTAVES: u32 = 16;

/// Steps of a climb from afar, and from a neighbouring disturbance.
pub(super) const CLIMB: u32 = 60;
const FOLLOW: u32 = 2;

/// Steps of a climb from each of several starts, after which only the highest goes on.
const APPROACH: u32 = 15;

/// Time constants of the disturbance that are tried, s.
pub(super) fn disturbance_time_constants_s(scale_per_s: f64) -> [f64; 4] {
    DISTURBANCE_TIME_CONSTANTS.map(|ratio| ratio / scale_per_s)
}

/// All structures, from the first-order output error estimate `first` of a vehicle of this rate, 1/s.
pub(super) fn candidates(record: &Comparisons, first: &Theta, scale_per_s: f64) -> Vec<Candidate> {
    let mut search = Search {
        record,
        scale_per_s,
        disturbances: disturbance_time_constants_s(scale_per_s)
            .map(|time_constant_s| usual_disturbance(scale_per_s, time_constant_s))
            .into(),
    };
    let first_order = search.first_order(first);
    let with = |sway_coupling, cross_flow| Structure {
        sway_coupling,
        cross_flow,
        rudder_lag: false,
    };
    let coupled = search.highest(with(true, false), &search.couplings(first));
    let cross_flow = search.highest(with(false, true), &search.cross_flows(first));
    let mut from_both = search.cross_flows(first);
    from_both.extend(
        [&coupled, &cross_flow]
            .into_iter()
            .flatten()
            .map(|candidate| candidate.calm.theta),
    );
    let rigid = [
        first_order,
        coupled,
        cross_flow,
        search.highest(with(true, true), &from_both),
    ];
    rigid
        .into_iter()
        .flatten()
        .flat_map(|rigid| {
            let lagging = search.lagging(&rigid);
            [Some(rigid), lagging]
        })
        .flatten()
        .collect()
}

struct Search<'a> {
    record: &'a Comparisons,
    scale_per_s: f64,
    /// The likeliest of each time constant, as far as is known.
    disturbances: Vec<Disturbance>,
}

/// A disturbance that moves the heading as much as the noise does over a time constant of the vehicle.
fn usual_disturbance(scale_per_s: f64, time_constant_s: f64) -> Disturbance {
    Disturbance {
        relative: 0.1 * scale_per_s.powi(2),
        time_constant_s,
    }
}

impl Search<'_> {
    /// The first order's summits, whose disturbances are where the searches of the other structures begin.
    fn first_order(&mut self, start: &Theta) -> Option<Candidate> {
        let structure = Structure::FIRST_ORDER;
        let calm = self.calm(structure, &[*start])?;
        let likeliest = self.likeliest(structure, &calm);
        self.disturbances = likeliest.iter().map(|summit| summit.disturbance).collect();
        Some(Candidate {
            structure,
            disturbed: self.highest_of(structure, likeliest),
            calm,
        })
    }

    /// The highest summits from any of the starts, without a disturbance and with the likeliest.
    fn highest(&self, structure: Structure, starts: &[Theta]) -> Option<Candidate> {
        let calm = self.calm(structure, starts)?;
        Some(Candidate {
            structure,
            disturbed: self.disturbed(structure, &calm),
            calm,
        })
    }

    fn calm(&self, structure: Structure, starts: &[Theta]) -> Option<Summit> {
        let free = free_parameters(&structure);
        let climb =
            |start: &Theta, steps| self.record.climb(start, &free, Disturbance::NONE, steps);
        let best = starts
            .iter()
            .filter_map(|start| climb(start, APPROACH))
            .max_by(|a, b| a.likelihood.log.total_cmp(&b.likelihood.log))?;
        climb(&best.theta, CLIMB)
    }

    /// The structure with a lag besides, from its own summits.
    fn lagging(&self, rigid: &Candidate) -> Option<Candidate> {
        let structure = Structure {
            rudder_lag: true,
            ..rigid.structure
        };
        let with_lag = |theta: &Theta, lag: f64| {
            let mut theta = *theta;
            theta[LAG] = lag / self.scale_per_s;
            theta
        };
        let starts = LAGS.map(|lag| with_lag(&rigid.calm.theta, lag));
        let disturbed = rigid.disturbed.as_ref().and_then(|summit| {
            let start = with_lag(&summit.theta, LAGS[0]);
            self.record.climb(
                &start,
                &free_parameters(&structure),
                summit.disturbance,
                CLIMB,
            )
        });
        let calm = self.calm(structure, &starts)?;
        if structure.has_sway() {
            return Some(Candidate {
                structure,
                calm,
                disturbed,
            });
        }
        let calm = self.slower_than_the_servo(calm)?;
        // Edges that come late where messages are lost are another disturbance than the one that stands for the lag.
        let own = self
            .record
            .has_gaps
            .then(|| self.disturbed(structure, &calm));
        let disturbed = disturbed
            .into_iter()
            .chain(own.flatten())
            .max_by(|a, b| a.likelihood.log.total_cmp(&b.likelihood.log));
        Some(Candidate {
            structure,
            calm,
            disturbed: disturbed.and_then(|summit| self.slower_than_the_servo(summit)),
        })
    }

    /// The rudder's response hardly shows which of the two poles is the vehicle's and which is the lag's: the
    /// slower one is the vehicle's.
    fn slower_than_the_servo(&self, summit: Summit) -> Option<Summit> {
        let is_slower = |theta: &Theta| theta[LAG] * theta[A22].abs() <= 1.0;
        if is_slower(&summit.theta) {
            return Some(summit);
        }
        let mut swapped = summit.theta;
        let ratio = 1.0 / (summit.theta[A22].abs() * summit.theta[LAG]);
        for parameter in [A22, B2, C0, LAG] {
            swapped[parameter] *= ratio;
        }
        let free = free_parameters(&Structure::LAGGING_RUDDER);
        self.record
            .climb(&swapped, &free, summit.disturbance, CLIMB)
            .filter(|summit| is_slower(&summit.theta))
    }

    fn couplings(&self, first: &Theta) -> Vec<Theta> {
        let start = |decay: f64, coupling: f64| {
            let mut theta = *first;
            theta[A11] = decay * self.scale_per_s;
            theta[A21] = coupling * self.scale_per_s.powi(2);
            theta
        };
        COUPLINGS
            .into_iter()
            .flat_map(|coupling| DECAYS.map(|decay| start(decay, coupling)))
            .collect()
    }

    /// Half of the damping by a drift of a quarter of the heading's range.
    fn cross_flows(&self, first: &Theta) -> Vec<Theta> {
        let start = |decay: f64| {
            let mut theta = *first;
            theta[A11] = decay * self.scale_per_s;
            theta[A22] *= 0.5;
            theta[CROSS_FLOW] = -2.0 * self.scale_per_s / self.record.range_rad();
            theta
        };
        DECAYS.map(start).into()
    }

    /// The summit at the likeliest disturbance.
    fn disturbed(&self, structure: Structure, calm: &Summit) -> Option<Summit> {
        self.highest_of(structure, self.likeliest(structure, calm))
    }

    fn highest_of(&self, structure: Structure, near: Vec<Summit>) -> Option<Summit> {
        let best = near
            .into_iter()
            .max_by(|a, b| a.likelihood.log.total_cmp(&b.likelihood.log))?;
        let free = free_parameters(&structure);
        self.record
            .climb(&best.theta, &free, best.disturbance, CLIMB)
    }

    /// The likeliest strength of the disturbance at each of its time constants, found by climbing in octaves.
    fn likeliest(&self, structure: Structure, calm: &Summit) -> Vec<Summit> {
        let free = free_parameters(&structure);
        let follow = |from: &Summit, disturbance: Disturbance| {
            self.record.climb(&from.theta, &free, disturbance, FOLLOW)
        };
        let stronger = |than: &Summit, ratio: f64| Disturbance {
            relative: than.disturbance.relative * ratio,
            ..than.disturbance
        };
        let climbed = |mut best: Summit, ratio: f64| {
            for _ in 0..MOST_OCTAVES {
                match follow(&best, stronger(&best, ratio)) {
                    Some(next) if next.likelihood.log > best.likelihood.log + 1e-2 => best = next,
                    _ => break,
                }
            }
            best
        };
        let likeliest = |known: &Disturbance| {
            let usual = usual_disturbance(self.scale_per_s, known.time_constant_s);
            let mut best = follow(calm, usual)?;
            while best.disturbance.relative * STRIDE < known.relative {
                best = follow(&best, stronger(&best, STRIDE))?;
            }
            Some(climbed(climbed(best, OCTAVE), 1.0 / OCTAVE))
        };
        self.disturbances.iter().filter_map(likeliest).collect()
    }
}
