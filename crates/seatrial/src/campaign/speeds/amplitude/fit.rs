//! Generalised least squares over the models.

use core::f64::consts::PI;

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

use super::{Finding, LEAST_SPREAD, OverAmplitude, SeenModel, ValueInterval};
use crate::propagation::NORMAL_95;

impl OverAmplitude {
    /// Fits [a22_0, a_rr, b2] to two or more models of one speed. `None` of fewer, and where a number is not finite or a covariance not
    /// positive.
    pub fn of(models: &[SeenModel]) -> Option<Self> {
        let amplitudes = models.iter().map(|model| model.yaw_rate_amplitude_rad_s);
        let seen_rad_s = amplitudes
            .map(|amplitude| [amplitude; 2])
            .reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])?;
        if models.len() < 2 {
            return None;
        }
        let has_quadratic = seen_rad_s[1] > LEAST_SPREAD * seen_rad_s[0];
        let degrees_of_freedom = 2 * models.len() - if has_quadratic { 3 } else { 2 };
        let LawFit { values, covariance, chi_squared } = LawFit::of(models, has_quadratic)?;
        let freedom = degrees_of_freedom as f64;
        let chi_squared_95 = bounds(freedom)?;
        let is_explained = chi_squared <= chi_squared_95[1];
        let (widened, deviations) = match is_explained {
            true => (1.0, NORMAL_95),
            false => (chi_squared / freedom, student_95(freedom)?),
        };
        let mut fit = Self {
            finding: Finding::Agree,
            models: models.len(),
            seen_rad_s,
            a22_at_rest_per_s: ValueInterval::default(),
            quadratic_per_rad: None,
            b2_per_s2: ValueInterval::default(),
            a22_at_seen_per_s: [ValueInterval::default(); 2],
            chi_squared,
            chi_squared_95,
            degrees_of_freedom,
            covariance: covariance.map(|row| row.map(|element| widened * element)),
            deviations,
        };
        fit.a22_at_rest_per_s = fit.combination(values, [1.0, 0.0, 0.0]);
        fit.b2_per_s2 = fit.combination(values, [0.0, 0.0, 1.0]);
        fit.quadratic_per_rad = has_quadratic.then(|| fit.combination(values, [0.0, 1.0, 0.0]));
        fit.a22_at_seen_per_s = seen_rad_s.map(|amplitude| fit.a22_at(amplitude));
        fit.finding = fit.found();
        Some(fit)
    }

    /// The quasi-linear a22 at an amplitude of the yaw rate, 1/s. It is known within [`seen_rad_s`](Self::seen_rad_s).
    pub fn a22_at(&self, yaw_rate_amplitude_rad_s: f64) -> ValueInterval {
        let quadratic = self.quadratic_per_rad.map_or(0.0, |bounded| bounded.value);
        let values = [self.a22_at_rest_per_s.value, quadratic, 0.0];
        self.combination(values, [1.0, share(yaw_rate_amplitude_rad_s), 0.0])
    }

    /// Do the models differ by no more than amplitude and their own uncertainty explain?
    pub fn is_explained(&self) -> bool {
        self.chi_squared <= self.chi_squared_95[1]
    }

    fn found(&self) -> Finding {
        match self.quadratic_per_rad.filter(ValueInterval::excludes_zero) {
            Some(quadratic) if quadratic.value < 0.0 => Finding::Grows,
            Some(_) => Finding::Falls,
            None if self.is_explained() => Finding::Agree,
            None => Finding::Differ,
        }
    }

    /// A linear combination of the parameters.
    fn combination(&self, values: [f64; 3], weights: [f64; 3]) -> ValueInterval {
        let mut variance = 0.0;
        for (row, a) in self.covariance.iter().zip(weights) {
            for (element, b) in row.iter().zip(weights) {
                variance += a * element * b;
            }
        }
        let value = values.iter().zip(weights).map(|(v, w)| v * w).sum();
        let half_width = self.deviations * variance.max(0.0).sqrt();
        ValueInterval { value, interval_95: [value - half_width, value + half_width] }
    }
}

/// What a_rr is multiplied with in a22.
fn share(yaw_rate_amplitude_rad_s: f64) -> f64 {
    8.0 / (3.0 * PI) * yaw_rate_amplitude_rad_s
}

/// Within which chi^2 of so many degrees of freedom is 95 times in 100.
fn bounds(degrees_of_freedom: f64) -> Option<[f64; 2]> {
    let distribution = ChiSquared::new(degrees_of_freedom).ok()?;
    Some([0.025, 0.975].map(|share| distribution.inverse_cdf(share)))
}

fn student_95(degrees_of_freedom: f64) -> Option<f64> {
    let distribution = StudentsT::new(0.0, 1.0, degrees_of_freedom).ok()?;
    Some(distribution.inverse_cdf(0.975))
}

/// [a22_0, a_rr, b2]; a_rr is 0 and sure where it is not fitted.
struct LawFit {
    values: [f64; 3],
    covariance: [[f64; 3]; 3],
    chi_squared: f64,
}

impl LawFit {
    fn of(models: &[SeenModel], has_quadratic: bool) -> Option<Self> {
        let fitted: &[usize] = if has_quadratic { &[0, 1, 2] } else { &[0, 2] };
        let size = fitted.len();
        let mut information = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        let mut weighed = Vec::with_capacity(models.len());
        for model in models {
            let [[aa, ab], [_, bb]] = model.covariance;
            let weight = Matrix2::new(aa, ab, ab, bb).cholesky()?.inverse();
            let of_all = [[1.0, share(model.yaw_rate_amplitude_rad_s), 0.0], [0.0, 0.0, 1.0]];
            let design = DMatrix::from_fn(2, size, |row, column| of_all[row][fitted[column]]);
            let observed = Vector2::new(model.a22_per_s, model.b2_per_s2);
            information += design.transpose() * weight * &design;
            right += design.transpose() * (weight * observed);
            weighed.push((weight, design, observed));
        }
        let inverse = information.cholesky()?.inverse();
        let solution = &inverse * right;
        let chi_squared = weighed
            .iter()
            .map(|(weight, design, observed)| {
                let missed = observed - design * &solution;
                missed.dot(&(weight * missed))
            })
            .sum();
        let mut values = [0.0; 3];
        let mut covariance = [[0.0; 3]; 3];
        for (i, &row) in fitted.iter().enumerate() {
            values[row] = solution[i];
            for (j, &column) in fitted.iter().enumerate() {
                covariance[row][column] = inverse[(i, j)];
            }
        }
        values.iter().all(|value| value.is_finite()).then_some(Self {
            values,
            covariance,
            chi_squared,
        })
    }
}
