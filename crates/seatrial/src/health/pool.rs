//! One change common to several estimates: generalised least squares and its test.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix3, Vector3};
use seatrial_core::YawModel;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

use super::{Detectable, Effect, Effects, HealthSettings, ReferencePoint, SpeedModel};

/// No estimate counts as surer than a millionth of its value.
const LEAST_VARIANCE: f64 = 1e-12;

/// The F distribution of more degrees of freedom than this is that of infinitely many.
const MOST_DEGREES_OF_FREEDOM: f64 = 1e6;

/// How surely a detectable change is detected.
const POWER: f64 = 0.9;

/// The error of one point of the reference, relative to its values.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReferenceError {
    information: Matrix3<f64>,
    degrees_of_freedom: f64,
}

impl ReferenceError {
    pub(super) fn of(point: &SpeedModel) -> Self {
        let covariance = relative(&point.covariance, &point.model);
        Self {
            information: covariance.try_inverse().unwrap_or_default(),
            degrees_of_freedom: point.degrees_of_freedom,
        }
    }
}

/// An estimate of now against what the reference expects at its speed.
#[derive(Clone, Debug)]
pub(super) struct Deviation {
    change: Vector3<f64>,
    covariance: Matrix3<f64>,
    degrees_of_freedom: f64,
    weights: Vec<(usize, f64)>,
}

impl Deviation {
    /// `None` where the numbers are too large or too small for it.
    pub(super) fn between(expected: &ReferencePoint, now: &SpeedModel) -> Option<Self> {
        let [a22, b2, c0] = expected.model.theta();
        let [a22_now, b2_now, c0_now] = now.model.theta();
        let change = Vector3::new(a22_now / a22 - 1.0, b2_now / b2 - 1.0, (c0_now - c0) / b2);
        let covariance = relative(&now.covariance, &expected.model);
        let is_finite = change.iter().chain(&covariance).all(|x| x.is_finite());
        is_finite.then(|| Self {
            change,
            covariance,
            degrees_of_freedom: now.degrees_of_freedom,
            weights: expected.weights.clone(),
        })
    }

    /// Half the 95 % interval of b2 over what is expected.
    pub(super) fn rudder_half_width(&self) -> f64 {
        2.0 * self.covariance[(1, 1)].sqrt()
    }
}

/// The covariance of x of [`super`], for errors of [a22, b2, C0].
fn relative(covariance: &[[f64; 3]; 3], model: &YawModel<f64>) -> Matrix3<f64> {
    let scale = [model.a22_per_s, model.b2_per_s2, model.b2_per_s2];
    Matrix3::from_fn(|i, j| covariance[i][j] / (scale[i] * scale[j]))
        + LEAST_VARIANCE * Matrix3::identity()
}

/// One change d common to several deviations.
///
/// ```text
/// x_w = d + G sum_j h_wj e_j + n_w,    n_w ~ N(0, N_w),  e_j ~ N(0, C_j)
/// V = V_e + max(1, J / (p (m - 1))) (1 + 4 sum_w omega_w (1 - omega_w) / nu_w) V_n,   omega_w = tr(V_n N_w^-1) / p
/// F = min over |t| <= tolerance of (d - t)^T V^-1 (d - t) / p  ~  F(p, nu)
/// 1/nu = s^2 / nu_e + (1 - s)^2 sum_w omega_w^2 / nu_w,   s = tr(V^-1 V_e) / p
/// ```
///
/// | symbol | meaning |
/// |---|---|
/// | x_w, N_w | deviation of estimate w of m, its covariance |
/// | e_j, C_j, h_wj | error of point j of the reference, its covariance, its weight at the speed of w |
/// | G | identity for the test; diag(1 + d) for the interval of a ratio |
/// | V_n, V_e | covariance of d from the estimates, from the reference |
/// | J | sum of squares of what one d leaves, with p (m - 1) degrees of freedom |
/// | p, nu | parameters tested, degrees of freedom of V; nu_w, nu_e of an estimate, of the reference |
///
/// The reference's error is shared by all estimates and does not average out. Estimates that scatter more than
/// their covariances say (Birge's ratio) widen V, and so do weights by covariances that are themselves estimates
/// (Meier 1953). Generalised likelihood ratio of a common shift; Satterthwaite's degrees of freedom.
#[derive(Clone, Debug)]
pub(super) struct PooledChange {
    pub(super) change: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) degrees_of_freedom: f64,
}

/// The equations of the common change and of the errors of the reference's points.
struct NormalEquations {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// N_w^-1
    informations: Vec<DMatrix<f64>>,
    /// sum x_w^T N_w^-1 x_w
    total: f64,
}

impl NormalEquations {
    fn of(
        deviations: &[Deviation],
        references: &[ReferenceError],
        growth: &DVector<f64>,
    ) -> Option<Self> {
        let p = growth.len();
        let size = p * (1 + references.len());
        let mut equations = Self {
            normal: DMatrix::zeros(size, size),
            right: DVector::zeros(size),
            informations: Vec::with_capacity(deviations.len()),
            total: 0.0,
        };
        for deviation in deviations {
            equations.add(deviation, growth)?;
        }
        for (point, reference) in references.iter().enumerate() {
            // Where a parameter is left out, the marginal of the Gaussian is tested, not the conditional.
            let marginal = reference.information.try_inverse()?;
            let covariance = marginal.view((0, 0), (p, p)).into_owned();
            let place = ((1 + point) * p, (1 + point) * p);
            let mut part = equations.normal.view_mut(place, (p, p));
            part += Cholesky::new(covariance)?.inverse();
        }
        Some(equations)
    }

    fn add(&mut self, deviation: &Deviation, growth: &DVector<f64>) -> Option<()> {
        let p = growth.len();
        let covariance = deviation.covariance.view((0, 0), (p, p)).into_owned();
        let information = Cholesky::new(covariance)?.inverse();
        let change = deviation.change.rows(0, p).into_owned();
        let weighted = &information * &change;
        self.total += change.dot(&weighted);
        // Where the common change and each point of the reference stand, and how they act.
        let unit = DMatrix::identity(p, p);
        let of_points = deviation
            .weights
            .iter()
            .map(|(point, weight)| ((1 + point) * p, *weight * DMatrix::from_diagonal(growth)));
        let acting: Vec<(usize, DMatrix<f64>)> =
            std::iter::once((0, unit)).chain(of_points).collect();
        for (row, left) in &acting {
            let mut part = self.right.rows_mut(*row, p);
            part += left * &weighted;
            for (column, other) in &acting {
                let mut part = self.normal.view_mut((*row, *column), (p, p));
                part += left * &information * other;
            }
        }
        self.informations.push(information);
        Some(())
    }
}

/// What part of the common change an estimate has, and how well its covariance is known.
struct Share {
    weight: f64,
    degrees_of_freedom: f64,
}

/// The degrees of freedom of a variance that is a sum of shares, one of them the reference's.
fn satterthwaite(shares: &[Share], reference_share: f64, reference_freedom: f64) -> f64 {
    let own = |share: &Share| share.weight * share.weight / share.degrees_of_freedom;
    let of_estimates: f64 = shares.iter().map(own).sum();
    let degrees_of_freedom = 1.0
        / (reference_share.powi(2) / reference_freedom
            + (1.0 - reference_share).powi(2) * of_estimates);
    degrees_of_freedom.min(MOST_DEGREES_OF_FREEDOM)
}

/// How well the least known of the reference's points that count is known.
fn reference_freedom(deviations: &[Deviation], references: &[ReferenceError]) -> f64 {
    deviations
        .iter()
        .flat_map(|deviation| &deviation.weights)
        .map(|(point, _)| references[*point].degrees_of_freedom)
        .fold(MOST_DEGREES_OF_FREEDOM, f64::min)
}

impl PooledChange {
    /// For the test: as the errors are if nothing has changed.
    pub(super) fn of(
        deviations: &[Deviation],
        references: &[ReferenceError],
        parameters: usize,
    ) -> Option<Self> {
        Self::with_growth(deviations, references, &DVector::from_element(parameters, 1.0))
    }

    /// For the intervals: as the errors are after this change.
    fn with_growth(
        deviations: &[Deviation],
        references: &[ReferenceError],
        growth: &DVector<f64>,
    ) -> Option<Self> {
        let p = growth.len();
        let equations = NormalEquations::of(deviations, references, growth)?;
        let inverse = Cholesky::new(equations.normal)?.inverse();
        let solution = &inverse * &equations.right;
        let of_all = inverse.view((0, 0), (p, p)).into_owned();
        let of_noise =
            Cholesky::new(equations.informations.iter().sum::<DMatrix<f64>>())?.inverse();
        let shares: Vec<Share> = deviations
            .iter()
            .zip(&equations.informations)
            .map(|(deviation, information)| Share {
                weight: (&of_noise * information).trace() / p as f64,
                degrees_of_freedom: deviation.degrees_of_freedom,
            })
            .collect();
        let left = (equations.total - equations.right.dot(&solution)).max(0.0);
        let spread = match deviations.len() {
            0 | 1 => 1.0,
            m => (left / (p * (m - 1)) as f64).max(1.0),
        };
        let uncertain =
            |share: &Share| share.weight * (1.0 - share.weight) / share.degrees_of_freedom;
        let uncertain_weights = 1.0 + 4.0 * shares.iter().map(uncertain).sum::<f64>();
        let covariance = &of_all + (spread * uncertain_weights - 1.0) * &of_noise;
        let of_reference = (Cholesky::new(covariance.clone())?.inverse() * (&of_all - &of_noise))
            .trace()
            / p as f64;
        Some(Self {
            change: solution.rows(0, p).into_owned(),
            covariance,
            degrees_of_freedom: satterthwaite(
                &shares,
                of_reference.clamp(0.0, 1.0),
                reference_freedom(deviations, references),
            ),
        })
    }

    pub(super) fn information(&self) -> Option<DMatrix<f64>> {
        Some(Cholesky::new(self.covariance.clone())?.inverse())
    }

    /// Probability of this change or a larger one, were nothing changed by more than is tolerated.
    pub(super) fn p_value(&self, settings: &HealthSettings) -> f64 {
        let p = self.change.len();
        let Some(information) = self.information() else {
            return 1.0;
        };
        let beyond = beyond(&self.change, &information, settings.tolerated_change);
        let statistic = (beyond.transpose() * information * &beyond)[(0, 0)];
        f_distribution(p as f64, self.degrees_of_freedom).sf(statistic / p as f64)
    }

    /// What a test of this level would find.
    pub(super) fn detectable(&self, level: f64, settings: &HealthSettings) -> Option<Detectable> {
        let information = self.information()?;
        let p = self.change.len() as f64;
        let threshold = p * f_distribution(p, self.degrees_of_freedom).inverse_cdf(1.0 - level);
        let distance = noncentrality(p, threshold).sqrt();
        let alone = |i: usize| distance / information[(i, i)].sqrt();
        Some(Detectable {
            damping: settings.tolerated_change + alone(0),
            rudder: settings.tolerated_change + alone(1),
            inertia: settings.tolerated_change
                + distance / information.view((0, 0), (2, 2)).sum().sqrt(),
            offset_rad: settings.offset_counts.then(|| alone(2)),
        })
    }

    /// The change in words' units, with intervals that hold also after a large change.
    pub(super) fn effects(
        &self,
        deviations: &[Deviation],
        references: &[ReferenceError],
    ) -> Effects {
        let growth = DVector::from_fn(self.change.len(), |i, _| match i {
            0 | 1 => 1.0 + self.change[i],
            _ => 1.0,
        });
        let after = Self::with_growth(deviations, references, &growth);
        let pooled = after.as_ref().unwrap_or(self);
        let effect = |i: usize| {
            interval(pooled.change[i], pooled.covariance[(i, i)], pooled.degrees_of_freedom)
        };
        Effects {
            damping: effect(0),
            rudder: effect(1),
            offset_rad: (self.change.len() > 2).then(|| effect(2)),
        }
    }
}

/// A value with its 95 % interval by Student's distribution.
pub(super) fn interval(change: f64, variance: f64, degrees_of_freedom: f64) -> Effect {
    let student = StudentsT::new(0.0, 1.0, degrees_of_freedom);
    let half_width = student.map_or(1.96, |student| student.inverse_cdf(0.975)) * variance.sqrt();
    Effect { change, interval_95: [change - half_width, change + half_width] }
}

pub(super) fn f_distribution(parameters: f64, degrees_of_freedom: f64) -> FisherSnedecor {
    FisherSnedecor::new(parameters, degrees_of_freedom.clamp(1.0, MOST_DEGREES_OF_FREEDOM))
        .expect("both degrees of freedom are positive")
}

/// What remains of a change beyond the nearest one that is tolerated, by coordinate descent.
fn beyond(change: &DVector<f64>, information: &DMatrix<f64>, tolerated: f64) -> DVector<f64> {
    const SWEEPS: usize = 50;
    let mut beyond = change.clone();
    if tolerated == 0.0 {
        return beyond;
    }
    for _ in 0..SWEEPS {
        for i in 0..2 {
            let pull = information.row(i).dot(&beyond.transpose()) / information[(i, i)];
            let taken = change[i] - beyond[i];
            beyond[i] = change[i] - (taken + pull).clamp(-tolerated, tolerated);
        }
    }
    beyond
}

/// The noncentrality at which chi-square exceeds a threshold with [`POWER`].
fn noncentrality(parameters: f64, threshold: f64) -> f64 {
    let missed = |lambda: f64| {
        // Poisson mixture of central distributions.
        let mut weight = libm::exp(-0.5 * lambda);
        let mut sum = 0.0;
        for j in 0..10_000 {
            let freedom = parameters + 2.0 * f64::from(j);
            let below = ChiSquared::new(freedom).map_or(0.0, |chi| chi.cdf(threshold));
            sum += weight * below;
            if f64::from(j) > 0.5 * lambda && below * weight < 1e-9 {
                break;
            }
            weight *= 0.5 * lambda / f64::from(j + 1);
        }
        sum
    };
    // exp(-lambda/2) is a number up to here; far above it the distribution is as good as normal.
    const LARGEST: f64 = 1400.0;
    let (mut low, mut high) = (0.0, LARGEST);
    if missed(high) > 1.0 - POWER {
        return threshold + 1.3 * (4.0 * threshold).sqrt();
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if missed(middle) > 1.0 - POWER {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(scale: [f64; 3], deviation: f64) -> SpeedModel {
        let variance = |x: f64| (deviation * x).powi(2);
        SpeedModel {
            thrust: None,
            surge_speed_m_s: None,
            model: YawModel::from_theta([-scale[0], 2.0 * scale[1], 0.02 * scale[2]]),
            covariance: [
                [variance(1.0), 0.0, 0.0],
                [0.0, variance(2.0), 0.0],
                [0.0, 0.0, variance(2.0)],
            ],
            degrees_of_freedom: 1e6,
            rudder_lag_s: 0.0,
        }
    }

    fn expected(reference: &SpeedModel) -> ReferencePoint {
        ReferencePoint { model: reference.model, weights: vec![(0, 1.0)] }
    }

    /// Four estimates of 2 % each and a reference of 3 %: 1 % and 3 % combine.
    #[test]
    fn exact_the_error_of_the_reference_does_not_average_out() {
        let reference = model([1.0; 3], 0.03);
        let now = model([1.0, 0.8, 1.0], 0.02);
        let deviation = Deviation::between(&expected(&reference), &now).unwrap();
        let errors = [ReferenceError::of(&reference)];
        let pooled = PooledChange::of(&vec![deviation.clone(); 4], &errors, 3).unwrap();
        // The floor of the variance, 1e-12, and rounding.
        assert!((pooled.change[1] + 0.2).abs() < 1e-9);
        assert!((pooled.covariance[(1, 1)] - (0.01_f64.powi(2) + 0.03_f64.powi(2))).abs() < 1e-9);
        // The ratio 0.8 has its reference's error times 0.8.
        let rudder = pooled.effects(&vec![deviation; 4], &errors).rudder;
        let half_width = (rudder.interval_95[1] - rudder.interval_95[0]) / 2.0;
        let deviation = (0.01_f64.powi(2) + (0.8_f64 * 0.03).powi(2)).sqrt();
        assert!((half_width / deviation - 1.96).abs() < 1e-3);
    }

    #[test]
    fn exact_scatter_beyond_the_intervals_widens_them() {
        let reference = model([1.0; 3], 0.0);
        let deviations: Vec<Deviation> = [0.9, 1.1]
            .map(|b2| {
                Deviation::between(&expected(&reference), &model([1.0, b2, 1.0], 0.01)).unwrap()
            })
            .into();
        let pooled = PooledChange::of(&deviations, &[ReferenceError::of(&reference)], 2).unwrap();
        // J = 2 (10 deviations)^2 over 2 degrees of freedom: a hundred times the variance of 1 %^2/2, within the
        // share of a millionth of the uncertain weights.
        assert!((pooled.covariance[(1, 1)] / 0.005 - 1.0).abs() < 1e-5);
    }

    /// chi-square of 3 degrees exceeds 7.815 with probability 0.9 at a noncentrality of 14.17 (tables of power).
    #[test]
    fn val_noncentrality_of_the_tables() {
        assert!((noncentrality(3.0, 7.8147) - 14.17).abs() < 0.01);
        assert!((noncentrality(1.0, 3.8415) - 10.507).abs() < 0.01);
    }

    #[test]
    fn prop_what_is_tolerated_is_no_change() {
        let reference = model([1.0; 3], 0.001);
        let now = model([1.03, 0.96, 1.0], 0.001);
        let deviations = [Deviation::between(&expected(&reference), &now).unwrap()];
        let pooled = PooledChange::of(&deviations, &[ReferenceError::of(&reference)], 3).unwrap();
        let p_value = |tolerated| {
            let settings = HealthSettings::new(0.05, tolerated, true).unwrap();
            pooled.p_value(&settings)
        };
        assert!(p_value(0.0) < 1e-12);
        assert!(p_value(0.03) < 1e-6);
        assert!(p_value(0.05) > 0.999);
    }
}
