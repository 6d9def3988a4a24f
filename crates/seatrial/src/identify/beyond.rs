//! What the contest of hypotheses hands over: the nearest first-order model with its interval, and the model beyond first order.

use nalgebra::Vector3;
use seatrial_core::YawModel;

use super::intervals::{normal_intervals, widened};
use super::robust::estimate::MODEL_ERROR;
use crate::gain_allowance::{DAMPING_RATIO, GainAllowance, sampled};
use crate::identification::{EstimateMethod, HigherOrder, Refined, WIDEST_A22, WIDEST_B2};
use crate::likelihood::filter::{Noise, heading_step};
use crate::likelihood::hypothesis::Vehicle;
use crate::likelihood::steering_model::{first_order_at, steady_gain};
use crate::likelihood::{Candidate, Contest, Disturbance, SteeringModel};
use crate::propagation::NORMAL_95;

/// The first-order model that has the vehicle's steady turn at the record's rudder amplitude, and the heaviest hypothesis.
/// `None` where no hypothesis has a first-order model near it.
pub fn beyond_first_order(
    contest: &Contest,
    rudder_amplitude_rad: f64,
) -> Option<(Refined, HigherOrder)> {
    let moments = contest.moments(&|v, c| first_order_at(v, c, rudder_amplitude_rad))?;
    let mut covariance = moments.covariance;
    for (i, share) in MODEL_ERROR.iter().enumerate() {
        covariance[(i, i)] += (share * moments.mean[i]).powi(2);
    }
    let model = YawModel::from_theta(moments.mean.into());
    let heaviest = contest.heaviest();
    let (problem, fit) = (&heaviest.hypothesis.problem, heaviest.hypothesis.best());
    let noise_rad = fit.variance_rad2.sqrt();
    let vehicle = problem.vehicle(&fit.x);
    let found = HigherOrder {
        structure: problem.structure,
        model: SteeringModel::new(&vehicle, problem.start_of(&fit.x, 0).offset_rad_s2),
        lag_interval_s: None,
        steady_log_gain: steady_log_gain(contest, rudder_amplitude_rad),
        hypotheses: contest.weighed(),
        validation: None,
    };
    let refined = Refined {
        method: EstimateMethod::WeighedHypotheses,
        model,
        delta0_rad: model.delta0_rad(),
        interval_95: normal_intervals(&model, &covariance),
        covariance: covariance.into(),
        heading_noise_rad: noise_rad,
        disturbance_rad_s2: match fit.noise {
            Noise::Sea { per_s2, .. } => per_s2 * noise_rad,
            Noise::None | Noise::Drift { .. } => 0.0,
        },
    };
    let is_finite = model
        .theta()
        .iter()
        .chain(refined.covariance.as_flattened())
        .all(|x| x.is_finite());
    is_finite.then(|| {
        (
            reaching_behind_play(refined, contest, rudder_amplitude_rad),
            found,
        )
    })
}

/// With intervals that hold the model behind the play of the gear, too: at larger angles more of the rudder reaches the blade.
fn reaching_behind_play(refined: Refined, contest: &Contest, amplitude_rad: f64) -> Refined {
    let behind = contest.moments(&|vehicle, offset_rad_s2| {
        let without = Vehicle {
            play_rad: 0.0,
            ..*vehicle
        };
        first_order_at(&without, offset_rad_s2, amplitude_rad)
    });
    let model = Vector3::from(refined.model.theta());
    match behind.map(|behind| (behind.mean - model) / NORMAL_95) {
        Some(away) if away != Vector3::zeros() => widened(&refined, &(away * away.transpose())),
        _ => refined,
    }
}

/// Mean and variance of the log of the gain K, 1/s, that the hypotheses' steady turns have at a rudder amplitude, rad.
fn steady_log_gain(contest: &Contest, amplitude_rad: f64) -> Option<[f64; 2]> {
    let log_gain = |vehicle: &Vehicle, _: f64| {
        let gain = steady_gain(vehicle, amplitude_rad);
        [libm::log(gain.abs()), 0.0, 0.0]
    };
    let moments = contest.moments(&log_gain)?;
    let (mean, variance) = (moments.mean[0], moments.covariance[(0, 0)]);
    (mean.is_finite() && variance.is_finite()).then_some([mean, variance])
}

/// Half widths of the 95 % intervals of a22 and b2 over them, beyond which the contest tells no first-order model.
const WIDEST: [f64; 2] = [1.5 * WIDEST_A22, 1.5 * WIDEST_B2];

/// Does this estimate tell a stable first-order model?
pub fn is_telling(refined: &Refined) -> bool {
    let theta = refined.model.theta();
    let narrow =
        |i: usize, share: f64| NORMAL_95 * refined.covariance[i][i].sqrt() < share * theta[i].abs();
    theta[0] < 0.0
        && refined.interval_95.a22_per_s[1] < 0.0
        && narrow(0, WIDEST[0])
        && narrow(1, WIDEST[1])
}

/// Overshoot, and error and swing that stay, of a heading step that no vehicle of the record may exceed under the gain of its model.
const MOST_OVERSHOOT: f64 = 0.2;
const MOST_LEFT: f64 = 0.1;

/// The course change whose overshoot is looked at: 40 deg, the boatbuilders' measure.
const COURSE_CHANGE_RAD: f64 = 0.698;

/// Gains that are tried: from the one for the nearest first-order vehicle down, each this share of the one before.
const NEXT_GAIN: f64 = 0.85;
const GAINS: usize = 20;

/// By how much less may hold under the gain that is taken than under the one under which most do.
const NEARLY: f64 = 0.05;

/// The largest proportional gain, not beyond the one for the nearest first-order vehicle, that holds on nearly as many vehicles as any
/// does, and the share of the weight of these vehicles. `None` where that vehicle has no gain.
pub fn most_gain(
    contest: &Contest,
    nearest: &Refined,
    interval_s: f64,
    amplitude_rad: f64,
) -> Option<[f64; 2]> {
    const LEAST_WEIGHT: f64 = 0.1;
    let vehicles: Vec<_> = (contest.candidates.iter())
        .filter(|c| c.weight >= LEAST_WEIGHT)
        .flat_map(|c| {
            let vehicles = c.vehicles();
            let share = c.weight / vehicles.len() as f64;
            vehicles.into_iter().map(move |vehicle| (share, vehicle))
        })
        .collect();
    let total: f64 = vehicles.iter().map(|(share, _)| share).sum();
    let holding = |gain: f64| {
        let holds = |vehicle: &Vehicle| {
            let [over, left, swing] =
                heading_step(vehicle, gain, COURSE_CHANGE_RAD, amplitude_rad, interval_s);
            // In its play the rudder does not act.
            let of_play = 0.5 * vehicle.play_rad / (gain * COURSE_CHANGE_RAD).abs();
            over < MOST_OVERSHOOT
                && swing < MOST_LEFT
                && left < MOST_LEFT.max(1.5 * of_play).min(0.5)
        };
        let weights = vehicles.iter().filter(|(_, vehicle)| holds(vehicle));
        weights.map(|(share, _)| share).sum::<f64>() / total
    };
    let largest = designed(nearest, 0.0, interval_s)?;
    let mut gains: Vec<[f64; 2]> = Vec::new();
    // Nothing holds on more than all.
    while gains.len() < GAINS && gains.last().is_none_or(|[_, weight]| *weight < 1.0) {
        let gain = largest * NEXT_GAIN.powi(gains.len() as i32);
        gains.push([gain, holding(gain)]);
    }
    let most = gains.iter().map(|[_, weight]| *weight).fold(0.0, f64::max);
    gains
        .into_iter()
        .find(|[_, weight]| *weight > most - NEARLY)
}

/// The estimate with an interval of a22 whose less damped end asks for no larger gain.
pub fn holding(refined: &Refined, most_gain: f64, interval_s: f64) -> Refined {
    let asks_for_more = |damping_per_s: f64| {
        designed(refined, damping_per_s, interval_s)
            .is_some_and(|gain| gain.abs() > most_gain.abs())
    };
    let [mut low, mut high] = [0.0, refined.model.a22_per_s.abs()];
    if refined.model.a22_per_s >= 0.0 || !asks_for_more(low) {
        return refined.clone();
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match asks_for_more(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    let mut holding = refined.clone();
    let [_, least_damped] = &mut holding.interval_95.a22_per_s;
    *least_damped = least_damped.max(refined.model.a22_per_s + high);
    holding
}

/// Of an interval, to single precision.
const HALVINGS: u32 = 24;

/// The gain for a vehicle less damped than the estimate by so much, 1/s. `None` where there is none.
fn designed(refined: &Refined, damping_per_s: f64, interval_s: f64) -> Option<f64> {
    let allowance = GainAllowance {
        damping_per_s,
        timing: sampled(interval_s, 0.0),
    };
    let gain = allowance.design(&refined.model, DAMPING_RATIO);
    Some(gain.ok()?.proportional_gain)
}

/// A hull is believed where its log evidence leads that of a sea by more than chance does in simulated seas, and by less where the first-order
/// estimate is doubtful by itself.
const MARGIN: f64 = 5.0;
const MARGIN_IN_DOUBT: f64 = 3.0;

/// Does a first-order vehicle in a sea, whose gear lags at most, explain the record as well as any other structure does without a sea?
///
/// Its own draws must explain the sea. In doubt other structures are held against it in a sea, too.
pub fn is_a_sea(contest: &Contest, in_doubt: bool) -> bool {
    let best = |is_of: &dyn Fn(&Candidate) -> bool| {
        let all = contest.candidates.iter().filter(|c| is_of(c));
        all.map(|c| c.hypothesis.log_evidence())
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let other = best(&|c| {
        let is_calm = c.hypothesis.disturbance != Disturbance::Sea;
        c.is_of_another_structure() && (is_calm || in_doubt && c.passes_as_a_sea())
    });
    let sea = best(&|c| c.is_of_first_order_in_a_sea());
    let margin = if in_doubt { MARGIN_IN_DOUBT } else { MARGIN };
    sea > other - margin
}
