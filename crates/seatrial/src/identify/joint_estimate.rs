//! Several manoeuvres of one speed in one model.

use nalgebra::{Matrix2, Matrix3, Vector2};
use seatrial_core::YawModel;
use serde::{Deserialize, Serialize};

use super::intervals::around;
use crate::chi_squared::chance_beyond;
use crate::identification::Refined;
use crate::record::Window;

/// What several manoeuvres say each, and together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointEstimate {
    /// Each manoeuvre by itself, the first first.
    pub manoeuvres: Vec<JoinedManoeuvre>,
    /// Probability that manoeuvres of one a22 and one b2 differ by this much.
    pub consistency: f64,
    /// By how much their scatter widened the interval, at least 1.
    pub birge_ratio: f64,
}

/// The model of one manoeuvre by itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JoinedManoeuvre {
    /// Its training window, half open.
    #[serde(flatten)]
    pub training: Window,
    /// a22 and b2 by itself, and its own offset.
    #[serde(flatten)]
    pub model: YawModel<f64>,
}

/// The common estimate of a manoeuvre and others by the same method. `None` where there is no other.
///
/// ```text
/// theta = W^-1 sum_j V_j^-1 theta_j,   W = sum_j V_j^-1,   theta = [a22, b2]
/// J = sum_j (theta_j - theta)^T V_j^-1 (theta_j - theta)  ~  chi^2(2 (m - 1))
/// V = max(1, J / (2 (m - 1))) W^-1
/// C0 = mean of c_j, with the variance of one c_j more:  mean of V_c,j + the sample variance of the c_j
/// ```
///
/// | symbol | meaning |
/// |---|---|
/// | theta_j, V_j | refined estimate of manoeuvre j of m, its covariance |
/// | c_j | the offset of manoeuvre j: wind, current and trim are its own |
/// | J | what one a22 and b2 leave of the estimates |
///
/// Each manoeuvre is refined by itself, with its own offset, heading and yaw rate at the start; the common estimate is the one
/// of least variance (Gauss, Markov), its interval widened by Birge's ratio where the manoeuvres scatter more than they
/// should. Manoeuvres for which another method was chosen than for the first, because a rudder lag or sway showed in one
/// and not in the other, and such as give no model, are left out.
pub(super) fn join(
    training: Window,
    first: &Refined,
    others: &[(Window, Refined)],
) -> Option<(Refined, JointEstimate)> {
    let alike = others.iter().filter(|(_, other)| other.method == first.method);
    let all: Vec<(Window, &Refined)> = std::iter::once((training, first))
        .chain(alike.map(|(window, refined)| (*window, refined)))
        .collect();
    if all.len() < 2 {
        return None;
    }
    let estimates: Vec<&Refined> = all.iter().map(|(_, refined)| *refined).collect();
    let common = Common::of(&estimates)?;
    let degrees_of_freedom = 2.0 * (all.len() - 1) as f64;
    let spread = (common.scatter / degrees_of_freedom).max(1.0);
    let (c0, c0_variance) = mean_offset(&estimates);
    let covariance = Matrix3::from_fn(|i, j| match (i, j) {
        (2, 2) => c0_variance,
        (2, _) | (_, 2) => 0.0,
        _ => spread * common.covariance[(i, j)],
    });
    let model = YawModel::from_theta([common.theta[0], common.theta[1], c0]);
    let joined = JointEstimate {
        manoeuvres: all
            .iter()
            .map(|(training, refined)| JoinedManoeuvre {
                training: *training,
                model: refined.model,
            })
            .collect(),
        consistency: chance_beyond(degrees_of_freedom, common.scatter)?,
        birge_ratio: spread.sqrt(),
    };
    let numbers = model.theta();
    let is_finite = numbers.iter().chain(&covariance).all(|x| x.is_finite());
    is_finite.then(|| {
        let together = around(first, model, covariance, first.method.clone());
        (together, joined)
    })
}

/// One a22 and b2 for all manoeuvres.
struct Common {
    theta: Vector2<f64>,
    /// W^-1
    covariance: Matrix2<f64>,
    /// J
    scatter: f64,
}

impl Common {
    /// `None` where a covariance has no inverse.
    fn of(estimates: &[&Refined]) -> Option<Self> {
        let theta =
            |refined: &Refined| Vector2::new(refined.model.a22_per_s, refined.model.b2_per_s2);
        let mut information = Matrix2::zeros();
        let mut weighted = Vector2::zeros();
        let mut informations = Vec::with_capacity(estimates.len());
        for refined in estimates {
            let own = Matrix2::from_fn(|i, j| refined.covariance[i][j]).try_inverse()?;
            information += own;
            weighted += own * theta(refined);
            informations.push(own);
        }
        let covariance = information.try_inverse()?;
        let mean = covariance * weighted;
        let off_the_mean = |(refined, own): (&&Refined, &Matrix2<f64>)| {
            let off = theta(refined) - mean;
            (off.transpose() * own * off)[(0, 0)]
        };
        Some(Self {
            theta: mean,
            covariance,
            scatter: estimates.iter().zip(&informations).map(off_the_mean).sum(),
        })
    }
}

/// The mean of the offsets, and the variance of one of them.
fn mean_offset(estimates: &[&Refined]) -> (f64, f64) {
    let count = estimates.len() as f64;
    let offsets = || estimates.iter().map(|refined| refined.model.c0_rad_per_s2);
    let c0 = offsets().sum::<f64>() / count;
    let between = offsets().map(|c| (c - c0).powi(2)).sum::<f64>() / (count - 1.0);
    let within = estimates.iter().map(|r| r.covariance[2][2]).sum::<f64>() / count;
    (c0, within + between)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::{EstimateMethod, Intervals};

    fn refined(theta: [f64; 3], variances: [f64; 3]) -> Refined {
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| if i == j { variances[i] } else { 0.0 })
        });
        Refined {
            method: EstimateMethod::AveragedRestrictedLikelihood,
            model: YawModel::from_theta(theta),
            delta0_rad: None,
            interval_95: Intervals {
                a22_per_s: [0.0; 2],
                b2_per_s2: [0.0; 2],
                c0_rad_per_s2: [0.0; 2],
                delta0_rad: None,
            },
            covariance,
            heading_noise_rad: 0.0,
            disturbance_rad_s2: 0.0,
        }
    }

    #[test]
    fn exact_weights_are_informations_and_offsets_stay_apart() {
        let first = refined([-1.0, 2.0, 0.01], [0.01, 0.04, 1e-6]);
        let others = [(Window::ALL, refined([-1.1, 2.3, -0.01], [0.03, 0.04, 1e-6]))];
        let (together, joined) = join(Window::ALL, &first, &others).unwrap();
        // Weights 3 : 1 and 1 : 1; V = 1 / (100 + 33.3) and 1 / (25 + 25); J = 1.4 of 2. Rounding only.
        assert!((together.model.a22_per_s + 1.025).abs() < 1e-12);
        assert!((together.model.b2_per_s2 - 2.15).abs() < 1e-12);
        assert!((together.covariance[0][0] - 0.0075).abs() < 1e-12);
        assert!((together.covariance[1][1] - 0.02).abs() < 1e-12);
        assert!(together.model.c0_rad_per_s2.abs() < 1e-15);
        assert!((together.covariance[2][2] - 201e-6).abs() < 1e-12);
        assert_eq!(joined.birge_ratio, 1.0);
        assert_eq!(joined.manoeuvres[1].model.c0_rad_per_s2, -0.01);
    }

    #[test]
    fn exact_manoeuvres_that_differ_widen_the_interval_and_are_noticed() {
        let first = refined([-1.0, 2.0, 0.0], [1e-4, 1e-4, 1e-6]);
        let others = [(Window::ALL, refined([-1.2, 2.0, 0.0], [1e-4, 1e-4, 1e-6]))];
        let (together, joined) = join(Window::ALL, &first, &others).unwrap();
        // J = 2 (0.1 / 0.01)^2 = 200 with 2 degrees of freedom: exp(-100), and V is 100 times 1e-4 / 2.
        assert!((joined.birge_ratio - 10.0).abs() < 1e-9);
        assert!((joined.consistency.ln() + 100.0).abs() < 1e-6);
        assert!((together.covariance[0][0] - 0.005).abs() < 1e-12);
    }

    #[test]
    fn prop_another_method_is_not_joined() {
        let first = refined([-1.0, 2.0, 0.0], [1e-4; 3]);
        let other = Refined { method: EstimateMethod::RudderLag, ..first.clone() };
        assert!(join(Window::ALL, &first, &[(Window::ALL, other)]).is_none());
    }
}
