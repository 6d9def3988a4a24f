//! Intervals of an estimate: normal ones, and wider ones for causes that the estimate does not know of.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::YawModel;

use crate::identification::{EstimateMethod, Intervals, Refined};
use crate::propagation::NORMAL_95;

/// The estimate with intervals and covariance that hold for another cause of uncertainty as well.
pub(super) fn widened(refined: &Refined, more: &Matrix3<f64>) -> Refined {
    let interval = |[low, high]: [f64; 2], variance: f64| {
        let (middle, half_width) = (0.5 * (low + high), 0.5 * (high - low));
        let half_width = libm::hypot(half_width, NORMAL_95 * variance.sqrt());
        [middle - half_width, middle + half_width]
    };
    let Intervals { a22_per_s, b2_per_s2, c0_rad_per_s2, delta0_rad } = refined.interval_95;
    let (_, of_delta0) = offset_angle(&refined.model.theta().into(), more);
    Refined {
        interval_95: Intervals {
            a22_per_s: interval(a22_per_s, more[(0, 0)]),
            b2_per_s2: interval(b2_per_s2, more[(1, 1)]),
            c0_rad_per_s2: interval(c0_rad_per_s2, more[(2, 2)]),
            delta0_rad: delta0_rad.map(|delta0| interval(delta0, of_delta0)),
        },
        covariance: (Matrix3::from(refined.covariance) + more).into(),
        ..refined.clone()
    }
}

/// Chance explains a difference of C0 up to so many standard deviations (95 %), of a22 and b2 up to so many (99.9 %).
const CHANCE: [f64; 3] = [3.29, 3.29, NORMAL_95];

/// Validation data of at least this part of the training's length count for what the disturbance does to C0.
const LONG_ENOUGH: f64 = 0.5;

/// The estimate with intervals that reach that of validation data, `length` times as long, where chance does not explain
/// the difference: wind, current, trim or something of the vehicle changed, and may again.
///
/// How far a disturbance turns the vehicle in the mean of a run is little known from that run alone: the interval of C0 is no
/// narrower than the same disturbance makes it in the validation data, with a variance that falls with the length.
pub(super) fn reaching_validation(refined: &Refined, other: &Refined, length: f64) -> Refined {
    let are_nearest = [refined, other].map(|estimate| {
        matches!(
            estimate.method,
            EstimateMethod::OutputError | EstimateMethod::InstrumentalVariable
        )
    });
    let are_comparable = refined.method == other.method || are_nearest == [true; 2];
    let reach = |k: usize| {
        let away = other.model.theta()[k] - refined.model.theta()[k];
        let variance = refined.covariance[k][k] + other.covariance[k][k];
        match away.abs() > CHANCE[k] * variance.sqrt() {
            true => (away / NORMAL_95).powi(2),
            false => 0.0,
        }
    };
    let [of_a22, of_b2] = [0, 1].map(|k| if are_comparable { reach(k) } else { 0.0 });
    let of_the_sea = match length >= LONG_ENOUGH {
        true => length * other.covariance[2][2] - refined.covariance[2][2],
        false => 0.0,
    };
    let more = Vector3::new(of_a22, of_b2, reach(2).max(of_the_sea));
    widened(refined, &Matrix3::from_diagonal(&more))
}

/// Another model with normal intervals in place of the refined one.
pub(super) fn around(
    refined: &Refined,
    model: YawModel<f64>,
    covariance: Matrix3<f64>,
    method: EstimateMethod,
) -> Refined {
    Refined {
        method,
        model,
        delta0_rad: model.delta0_rad(),
        interval_95: normal_intervals(&model, &covariance),
        covariance: covariance.into(),
        ..refined.clone()
    }
}

/// 1.96 standard deviations either side.
pub(crate) fn normal_intervals(model: &YawModel<f64>, covariance: &Matrix3<f64>) -> Intervals {
    let interval = |value: f64, variance: f64| {
        let half_width = NORMAL_95 * variance.sqrt();
        [value - half_width, value + half_width]
    };
    let [a22_per_s, b2_per_s2, c0_rad_per_s2] =
        core::array::from_fn(|i| interval(model.theta()[i], covariance[(i, i)]));
    let has_authority = b2_per_s2[0] * b2_per_s2[1] > 0.0;
    let (delta0, delta0_variance) = offset_angle(&Vector3::from(model.theta()), covariance);
    Intervals {
        a22_per_s,
        b2_per_s2,
        c0_rad_per_s2,
        delta0_rad: has_authority.then(|| interval(delta0, delta0_variance)),
    }
}

/// Mean and variance of delta0 = C0/b2 by the delta method.
fn offset_angle(mean: &Vector3<f64>, covariance: &Matrix3<f64>) -> (f64, f64) {
    let gradient = Vector3::new(0.0, -mean[2] / (mean[1] * mean[1]), 1.0 / mean[1]);
    (mean[2] / mean[1], (gradient.transpose() * covariance * gradient)[(0, 0)])
}

#[cfg(test)]
mod tests {
    use seatrial_core::model::YawState;
    use seatrial_core::refine::{StageRecord, refine as refine_stage};
    use seatrial_core::{Real, Sample};

    use super::*;
    use crate::identify::refined::refined_estimate;

    /// A doublet of 16 s, sampled every 0.15 s, in which two rows are lost.
    fn doublet() -> Vec<Sample<f64>> {
        let model = YawModel::from_theta([-0.9, 0.7, 0.01]);
        let mut state = YawState::default();
        (0..110_u32)
            .map(|k| {
                let sample = Sample {
                    time_s: 0.15 * f64::from(k),
                    heading_rad: (3.0 + f64::round(state.heading_rad * 100.0) / 100.0).wrapped(),
                    rudder_rad: [0.0, 0.2, -0.2, 0.0][(k / 28) as usize],
                    ..Sample::default()
                };
                state = model.advance(state, sample.rudder_rad, 0.15);
                sample
            })
            .enumerate()
            .filter_map(|(k, sample)| (!(60..62).contains(&k)).then_some(sample))
            .collect()
    }

    /// A vehicle keeps its stage as it comes; a log is looked at as a whole.
    #[test]
    fn parity_a_stage_kept_as_it_comes_refines_alike() {
        let samples = doublet();
        let mut record = StageRecord::<110>::new(0.15);
        for sample in &samples {
            record.push(sample).unwrap();
        }
        let (stage, log) = (
            refine_stage(record.series(), None).unwrap(),
            refined_estimate(&samples, None).unwrap(),
        );
        // The log's headings count from its first; differences of likelihoods magnify the rounding.
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-5 * b.abs(), "{a} {b}");
        for (a, b) in stage.model.theta().into_iter().zip(log.model.theta()) {
            close(a, b);
        }
        close(stage.covariance[0][0], log.covariance[0][0]);
    }

    #[test]
    fn exact_the_intervals_reach_validation_data_beyond_chance() {
        let refined = around(
            &refined_estimate(&doublet(), None).unwrap(),
            YawModel::from_theta([-1.0, 1.0, 0.01]),
            Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.001).map(|s: f64| s * s)),
            EstimateMethod::AveragedRestrictedLikelihood,
        );
        let half_widths = |found: &Refined| {
            let Intervals { a22_per_s, b2_per_s2, c0_rad_per_s2, .. } = found.interval_95;
            [a22_per_s, b2_per_s2, c0_rad_per_s2].map(|[low, high]| 0.5 * (high - low))
        };
        let own = half_widths(&refined);
        let other = |theta, of_c0: f64, method: &EstimateMethod| {
            let deviations = Vector3::new(0.02, 0.02, of_c0);
            let covariance = Matrix3::from_diagonal(&deviations.map(|s| s * s));
            around(&refined, YawModel::from_theta(theta), covariance, method.clone())
        };
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        let reached =
            |other: &Refined, length| half_widths(&reaching_validation(&refined, other, length));

        // 3.5 standard deviations of 0.02 sqrt 2 from a22, 3.2 from b2; the same C0.
        let away = 3.5 * 0.02 * 2_f64.sqrt();
        let theta = [-1.0 - away, 1.0 + 3.2 / 3.5 * away, 0.01];
        let same = other(theta, 0.001, &refined.method);
        let [a22, b2, c0] = reached(&same, 1.0);
        close(a22, own[0].hypot(away));
        close(b2, own[1]);
        close(c0, own[2]);
        // A model behind a lag has another a22 by nature, but no other C0.
        let lagging = other([theta[0], theta[1], 0.02], 0.001, &EstimateMethod::RudderLag);
        let [a22, _, c0] = reached(&lagging, 1.0);
        close(a22, own[0]);
        close(c0, own[2].hypot(0.01));
        // A disturbance that the training knew nothing of: its variance falls with the length, and a short run says nothing.
        let rough = other([-1.0, 1.0, 0.01], 0.01, &refined.method);
        for (length, times) in [(1.0, 10.0), (0.5, 10.0 * 0.5_f64.sqrt()), (0.49, 1.0)] {
            let [.., c0] = reached(&rough, length);
            close(c0, times * own[2]);
        }
        // A calm one narrows nothing.
        let [.., c0] = reached(&other([-1.0, 1.0, 0.01], 0.0001, &refined.method), 1.0);
        close(c0, own[2]);
    }
}
