//! What the contest of hypotheses hands over: the nearest first-order model with its interval, and the model beyond first order.

use nalgebra::Vector3;
use seatrial_core::{Sample, YawModel};

use super::excited_segment::most_excited;
use super::intervals::{normal_intervals, widened};
use super::robust::estimate::MODEL_ERROR;
use crate::identification::{EstimateMethod, HigherOrder, Refined, WIDEST_A22, WIDEST_B2};
use crate::likelihood::hypothesis::Vehicle;
use crate::likelihood::steering_model::{first_order_at, log_steady_gain};
use crate::likelihood::{Candidate, Contest, Disturbance, contest_of_hulls};
use crate::manoeuvre::Manoeuvre;
use crate::propagation::NORMAL_95;

/// The first-order model that has the vehicle's steady turn at the record's rudder amplitude, `None` where no hypothesis has one near it, and the
/// model that predicts.
pub fn beyond_first_order(
    contest: &Contest,
    rudder_amplitude_rad: f64,
) -> (Option<Refined>, HigherOrder) {
    let predictor = contest.predictor();
    let beyond = HigherOrder {
        structure: predictor.hypothesis.problem.structure,
        model: predictor.hypothesis.steering_model(),
        least_r2_left_out: Some(predictor.least_r2),
        lag_interval_s: None,
        steady_log_gain: steady_log_gain(contest, rudder_amplitude_rad),
        steady_rudder_rad: Some(rudder_amplitude_rad),
        hypotheses: contest.weighed(),
        gain_vehicle: None,
        validation: None,
    };
    (same_steady_turn(contest, rudder_amplitude_rad), beyond)
}

/// The hull that predicts a record whose first-order model may not be used, where a time constant of its a22, 1/s, holds a comparison at least.
pub fn hull_of(samples: &[Sample<f64>], a22_per_s: f64) -> Option<HigherOrder> {
    let mut legs = Vec::new();
    let amplitude_rad = Manoeuvre::find(samples)?.amplitude_rad;
    let contest = contest_of_hulls(most_excited(samples), &mut legs)?;
    let leg = contest.heaviest().hypothesis.problem.legs.first()?;
    let apart_s = leg.duration_s() / leg.len() as f64;
    (apart_s * a22_per_s.abs() < 1.0).then(|| beyond_first_order(&contest, amplitude_rad).1)
}

/// The first-order model that has the steady turn of the hypotheses.
fn same_steady_turn(contest: &Contest, rudder_amplitude_rad: f64) -> Option<Refined> {
    let moments = contest.moments(&|v, c| first_order_at(v, c, rudder_amplitude_rad))?;
    let mut covariance = moments.covariance;
    for (i, share) in MODEL_ERROR.iter().enumerate() {
        covariance[(i, i)] += (share * moments.mean[i]).powi(2);
    }
    let model = YawModel::from_theta(moments.mean.into());
    let fit = contest.heaviest().hypothesis.best();
    let noise_rad = fit.variance_rad2.sqrt();
    let refined = Refined {
        method: EstimateMethod::WeighedHypotheses,
        model,
        delta0_rad: model.delta0_rad(),
        interval_95: normal_intervals(&model, &covariance),
        covariance: covariance.into(),
        heading_noise_rad: noise_rad,
        disturbance_rad_s2: fit.noise.sea[0] * noise_rad,
    };
    let is_finite =
        model.theta().iter().chain(refined.covariance.as_flattened()).all(|x| x.is_finite());
    is_finite.then(|| reaching_small_angles(refined, contest, rudder_amplitude_rad))
}

/// With intervals that hold the model behind the play of the gear, too: at larger angles more of the rudder reaches the blade; and the offset at
/// rest, of which damping that grows takes less than in a turn.
fn reaching_small_angles(refined: Refined, contest: &Contest, amplitude_rad: f64) -> Refined {
    let small = contest.moments(&|vehicle, c| {
        let [a22, b2, _] = first_order_at(&Vehicle { play_rad: 0.0, ..*vehicle }, c, amplitude_rad);
        let at_rest = Vehicle { quadratic_per_rad: 0.0, ..*vehicle };
        let [.., c0] = first_order_at(&at_rest, c, amplitude_rad);
        [a22, b2, c0]
    });
    let model = Vector3::from(refined.model.theta());
    match small.map(|small| (small.mean - model) / NORMAL_95) {
        Some(away) if away != Vector3::zeros() => {
            let [behind, at_rest] = [Vector3::new(away.x, away.y, 0.0), away.z * Vector3::z()];
            let apart = behind * behind.transpose() + at_rest * at_rest.transpose();
            widened(&refined, &apart)
        }
        _ => refined,
    }
}

/// Mean and variance of the log of the gain K, 1/s, that the hypotheses' steady turns have at a rudder amplitude, rad.
fn steady_log_gain(contest: &Contest, amplitude_rad: f64) -> Option<[f64; 2]> {
    let log_gain = |vehicle: &Vehicle, _: f64| [log_steady_gain(vehicle, amplitude_rad), 0.0, 0.0];
    let moments = contest.moments(&log_gain)?;
    let (mean, variance) = (moments.mean[0], moments.covariance[(0, 0)]);
    (mean.is_finite() && variance.is_finite()).then_some([mean, variance])
}

/// Half widths of the 95 % intervals of a22 and b2 over them, beyond which the contest tells no first-order model.
const WIDEST: [f64; 2] = [1.5 * WIDEST_A22, 1.5 * WIDEST_B2];

/// Does this estimate tell a stable first-order model?
pub fn is_telling(refined: &Refined) -> bool {
    let theta = refined.model.theta();
    let half = |i: usize| NORMAL_95 * refined.covariance[i][i].sqrt();
    theta[0] < 0.0
        && refined.interval_95.a22_per_s[1] < 0.0
        && (0..2).all(|i| half(i) < WIDEST[i] * theta[i].abs())
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
        all.map(|c| c.hypothesis.log_evidence()).fold(f64::NEG_INFINITY, f64::max)
    };
    let other = best(&|c| {
        let is_calm = c.hypothesis.disturbance != Disturbance::Sea;
        c.is_of_another_structure() && (is_calm || in_doubt && c.passes_as_a_sea())
    });
    let sea = best(&|c| c.is_of_first_order_in_a_sea() && !c.predicts_badly());
    let margin = if in_doubt { MARGIN_IN_DOUBT } else { MARGIN };
    sea > other - margin
}
