//! The largest likelihood of every structure, without a disturbance and with the likeliest.

use super::likelihood::{A11, A21, A22, B2, C0, CROSS_FLOW, Comparisons, LAG, Summit, Theta};
use super::{Candidate, Structure, free_parameters};
use seatrial_core::refine::{DISTURBANCE_TIME_CONSTANTS, Disturbance};

/// Where searches start, over the first-order rate: a11, a21, and the rudder lag times it.
const DECAYS: [f64; 3] = [-0.15, -0.5, -1.0];
const COUPLINGS: [f64; 2] = [-0.1, 0.1];
const LAGS: [f64; 2] = [0.05, 0.2];

/// Ratio of neighbouring strengths of the disturbance.
const STRENGTH_RATIO: f64 = 2.0;
const MOST_OCTAVES: u32 = 16;

/// Steps of a climb from afar, and from a neighbouring disturbance.
pub(super) const CLIMB: u32 = 60;
const FOLLOW: u32 = 2;

/// Time constants of the disturbance that are tried, s.
pub(super) fn disturbance_time_constants_s(scale_per_s: f64) -> [f64; 4] {
    DISTURBANCE_TIME_CONSTANTS.map(|ratio| ratio / scale_per_s)
}

/// All structures, from the first-order output error estimate `first` of a vehicle of this rate, 1/s.
pub(super) fn candidates(record: &Comparisons, first: &Theta, scale_per_s: f64) -> Vec<Candidate> {
    let search = Search {
        record,
        scale_per_s,
    };
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
        search.highest(Structure::FIRST_ORDER, &[*first]),
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
}

impl Search<'_> {
    /// The highest summits from any of the starts, without a disturbance and with the likeliest.
    fn highest(&self, structure: Structure, starts: &[Theta]) -> Option<Candidate> {
        let calm = self.calm(structure, starts)?;
        let disturbed = self.disturbed(structure, &calm);
        Some(Candidate {
            structure,
            calm,
            disturbed,
        })
    }

    fn calm(&self, structure: Structure, starts: &[Theta]) -> Option<Summit> {
        let free = free_parameters(&structure);
        starts
            .iter()
            .filter_map(|start| self.record.climb(start, &free, Disturbance::NONE, CLIMB))
            .max_by(|a, b| a.likelihood.log.total_cmp(&b.likelihood.log))
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

    /// The likeliest disturbance, found by climbing in octaves of its strength from where disturbance and noise
    /// move the heading alike over a time constant of the vehicle.
    fn disturbed(&self, structure: Structure, calm: &Summit) -> Option<Summit> {
        let free = free_parameters(&structure);
        let follow = |from: &Summit, relative: f64, time_constant_s: f64| {
            let disturbance = Disturbance {
                relative,
                time_constant_s,
            };
            self.record.climb(&from.theta, &free, disturbance, FOLLOW)
        };
        let strongest = |time_constant_s: f64| {
            let usual = 0.1 * self.scale_per_s.powi(2);
            let mut best = follow(calm, usual, time_constant_s)?;
            for step in [STRENGTH_RATIO, 1.0 / STRENGTH_RATIO] {
                for _ in 0..MOST_OCTAVES {
                    let relative = best.disturbance.relative * step;
                    match follow(&best, relative, time_constant_s) {
                        Some(next) if next.likelihood.log > best.likelihood.log + 1e-2 => {
                            best = next;
                        }
                        _ => break,
                    }
                }
            }
            Some(best)
        };
        let best = disturbance_time_constants_s(self.scale_per_s)
            .into_iter()
            .filter_map(strongest)
            .max_by(|a, b| a.likelihood.log.total_cmp(&b.likelihood.log))?;
        self.record
            .climb(&best.theta, &free, best.disturbance, CLIMB)
    }
}
