//! How a long turn ends that ordinary steering hardly shows: hulls beyond first order, and play of the gear, compete by their evidence.
//!
//! ```text
//! r' = -(d + d2 |r|) r + k v + b delta_a + c,   v' = r - v/T_v,   |delta_a'| <= rho,   K: steady turn per rudder at the log's rudder amplitude
//! ```
//!
//! Course changes tell d and b of the first seconds of a turn. With sway a long turn ends up to several times as fast, with damping that grows
//! slower. Of 51 missions of simulated boats with growing damping, sway or play the interval of first order held the steady turn in 2; of 135 others,
//! some with a slow gear or course-unstable, this one does in 121 (`examples/missions`, mode `hulls`). Cost: a tenth of the fit of first order where
//! no step of scoring promises a hull.

use super::columns::Run;
use super::fit::{Fit, Hypothesis, Problem};
use super::information::Uncertainty;
use super::record::Legs;
use super::{uncertain, weights};
use crate::identification::{GainVehicle, Refined};
use crate::identify::heading_gain::Vehicles;
use crate::identify::robust::estimate::{LEAST_EVIDENCE, MODEL_ERROR};
use crate::likelihood::hypothesis::Scale;
use crate::likelihood::posterior::Moments;
use crate::likelihood::steering_model::log_steady_gain;
use crate::likelihood::{Structure, Vehicle};
use crate::propagation::NORMAL_95;

/// Log of how much likelier a log must be with a hull beyond first order to be surely of one: seas of eight waves made it likelier by up to 12 in 72
/// missions of vehicles of first order, and hulls by 15 to 140 where a sea hid them.
pub const SURE_HULL: f64 = 20.0;

/// The legs with the yaw rates that a fit of first order saw.
fn with_turning(legs: &Legs, fit: &Fit) -> Legs {
    let yaw_rate_rad_s = legs.yaw_rate_deviation_rad_s();
    let mut turning = legs.clone();
    for (leg, of) in turning.legs.iter_mut().zip(&legs.legs) {
        let mut run = Run::<6>::new(of, &fit.point, legs.interval_s, yaw_rate_rad_s);
        leg.turning_rad_s = (0..of.len())
            .map(|i| {
                run.measure(i, |_, _| {});
                let rate = run.yaw_rate_rad_s(&fit.linear);
                run.advance(i);
                rate.abs()
            })
            .collect();
    }
    turning
}

/// Hulls and a slow gear beyond first order, each fitted from the likeliest vehicle of first order.
pub fn hulls(legs: &Legs, scale: Scale, heaviest: &Fit) -> Vec<(Fit, Uncertainty)> {
    let legs = &with_turning(legs, heaviest);
    let problem = Problem::new(legs, scale);
    let of = |structure| Hypothesis {
        structure: heaviest.hypothesis.structure.union(structure),
        ..heaviest.hypothesis
    };
    let [slow, growth, sway] = [Structure::RATE_LIMIT, Structure::QUADRATIC, Structure::SWAY]
        .map(|structure| problem.with_hull(heaviest, of(structure)));
    let general = of(Structure::SWAY_QUADRATIC);
    let both = [
        (sway.as_ref()).and_then(|sway| problem.extended(sway, general)),
        (growth.as_ref()).and_then(|growth| problem.with_hull(growth, general)),
    ];
    let both = (both.into_iter().flatten()).min_by(|a, b| a.cost.total_cmp(&b.cost));
    let fits = [slow, growth, sway, both].into_iter().flatten().collect();
    uncertain(&problem, fits)
}

/// A vehicle beyond first order that may have made the log.
pub struct Beyond {
    log_evidence: f64,
    vehicle: Vehicle,
    offset_rad_s2: f64,
    /// ln |K|, K in 1/s, at the log's rudder amplitude.
    log_gain: Moments<1>,
    /// Log evidence from which it alone explains the log.
    sure: f64,
}

impl Beyond {
    /// The vehicle of a fit, behind play, rad; a log evidence by `sure` more than that of first order leaves no doubt.
    pub fn of(
        (fit, uncertainty): &(Fit, Uncertainty),
        play_rad: f64,
        amplitude_rad: f64,
        sure: f64,
    ) -> Self {
        let vehicle = Vehicle { play_rad, ..fit.vehicle() };
        let log_gain = log_steady_gain(&vehicle, amplitude_rad);
        let model_error: f64 = MODEL_ERROR.iter().map(|share| share * share).sum();
        Self {
            log_evidence: uncertainty.log_evidence,
            vehicle,
            offset_rad_s2: fit.linear[1],
            log_gain: Moments {
                mean: [log_gain].into(),
                covariance: [[uncertainty.log_gain_variance + model_error]].into(),
            },
            sure,
        }
    }
}

/// How a long turn ends where first order does not explain the log.
pub struct LongTurn {
    /// The likeliest vehicle.
    pub vehicle: Vehicle,
    /// Its offset, rad/s^2.
    pub offset_rad_s2: f64,
    /// Mean and variance of ln |K|, K in 1/s, at the log's rudder amplitude.
    pub log_gain: [f64; 2],
    /// That amplitude, rad.
    pub rudder_rad: f64,
    /// Is the vehicle surely not of first order?
    pub is_sure: bool,
    /// Vehicles that may have made the log, with their weights.
    vehicles: Vec<(f64, Vehicle)>,
}

impl LongTurn {
    /// Of vehicles beyond first order, where one is likelier than one of first order, whose own log evidence and ln |K| these are.
    ///
    /// Where that is not sure the variance reaches the turn of first order, too.
    pub fn of(all: &[Beyond], first_order: (f64, f64), rudder_rad: f64) -> Option<Self> {
        let (log_evidence, first_gain) = first_order;
        let likeliest = all.iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))?;
        let lead = likeliest.log_evidence - log_evidence;
        if lead.is_nan() || lead <= LEAST_EVIDENCE {
            return None;
        }
        let evidence = all.iter().map(|beyond| beyond.log_evidence);
        let weights = weights(evidence);
        let of = |(beyond, weight): (&Beyond, &f64)| (*weight, beyond.log_gain);
        let log_gain = Moments::of(&all.iter().zip(&weights).map(of).collect::<Vec<_>>())?;
        let (mean, variance) = (log_gain.mean[0], log_gain.covariance[(0, 0)]);
        let is_sure = lead >= likeliest.sure;
        let away = match is_sure {
            true => 0.0,
            false => (first_gain - mean) / NORMAL_95,
        };
        Some(Self {
            vehicle: likeliest.vehicle,
            offset_rad_s2: likeliest.offset_rad_s2,
            log_gain: [mean, variance + away * away],
            rudder_rad,
            is_sure,
            vehicles: (weights.iter().zip(all))
                .filter(|(weight, _)| **weight > 0.0)
                .map(|(weight, beyond)| (*weight, beyond.vehicle))
                .collect(),
        })
    }

    /// The vehicle that the heading gain is made for, so that it holds on all that may have made the log, behind a delay, s, in a loop as fast as
    /// the samples. `None` where none holds.
    pub fn gain_vehicle(
        &self,
        refined: &Refined,
        lag_s: f64,
        interval_s: f64,
    ) -> Option<GainVehicle> {
        let behind = |(weight, vehicle): &(f64, Vehicle)| (*weight, Vehicle { lag_s, ..*vehicle });
        let vehicles = self.vehicles.iter().map(behind).collect();
        Vehicles::new(vehicles, interval_s, self.rudder_rad).gain_vehicle(refined)
    }
}
