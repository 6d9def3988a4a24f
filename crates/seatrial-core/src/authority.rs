//! Rudder authority over speed: the least-squares fit of b2 over the square of speed.

use crate::Real;
use crate::schedule::{ScheduleError, SchedulePoint, ScheduleValue};

/// Which law b2 follows over speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum AuthorityForm {
    /// b2 = k V^2: the force of a fin.
    ThroughZero,
    /// b2 = k V^2 + c: the paper's (51).
    WithConstant,
}

/// Rudder authority over speed, fitted by least squares.
///
/// ```text
/// b2 = k V^2 + c                                  (51)
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | k | `per_speed_squared_per_m2` | 1/m^2 |
/// | c | `constant_per_s2` | 1/s^2 |
/// | V | `surge_speed_m_s` | m/s |
///
/// Source: equation (51), Fig. 9. Valid over `speed_range_m_s`; outside it the value is marked. The
/// constant of the paper's own fit is 43 % of b2 at its lowest speed, while the force of a fin goes
/// through zero: the two forms part quickly below the identified speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AuthorityFit<T> {
    /// Which law was fitted.
    pub form: AuthorityForm,
    /// k, 1/m^2.
    pub per_speed_squared_per_m2: T,
    /// c, 1/s^2; 0 for the law through zero.
    pub constant_per_s2: T,
    /// Root of the mean squared residual of b2, 1/s^2.
    pub rms_residual_per_s2: T,
    /// The least and greatest speed fitted, m/s.
    pub speed_range_m_s: [T; 2],
}

impl<T: Real> AuthorityFit<T> {
    /// The fit over the points whose speed is known: at least two different speeds.
    ///
    /// ```
    /// use seatrial_core::schedule::{ScheduleError, SchedulePoint};
    /// use seatrial_core::{AuthorityFit, AuthorityForm, YawModel};
    ///
    /// let at = |speed_m_s: f64, b2| SchedulePoint {
    ///     thrust: None,
    ///     surge_speed_m_s: Some(speed_m_s),
    ///     model: YawModel::from_theta([-1.0, b2, 0.0]),
    /// };
    /// // Twice the speed, four times the authority: a fin.
    /// let fit = AuthorityFit::new(&[at(1.0, 0.5), at(2.0, 2.0)], AuthorityForm::ThroughZero)?;
    /// assert!((fit.per_speed_squared_per_m2 - 0.5).abs() < 1e-12);
    /// // One speed tells no law.
    /// let one = AuthorityFit::new(&[at(1.0, 0.5)], AuthorityForm::ThroughZero);
    /// assert_eq!(one, Err(ScheduleError::TooFewPoints { found: 1, needed: 2 }));
    /// # Ok::<(), ScheduleError>(())
    /// ```
    pub fn new(points: &[SchedulePoint<T>], form: AuthorityForm) -> Result<Self, ScheduleError> {
        if let Some(index) = points.iter().position(|p| !p.is_finite()) {
            return Err(ScheduleError::NonFinite { index });
        }
        let known = || points.iter().filter_map(|p| Some((p.surge_speed_m_s?, p.model.b2_per_s2)));
        let count = known().count();
        let n = T::of(count as f64);
        let mean = |of: fn(T, T) -> T| known().map(|(v, b2)| of(v, b2)).sum::<T>() / n;
        let (centre_v2, centre_b2) = match form {
            AuthorityForm::ThroughZero => (T::ZERO, T::ZERO),
            AuthorityForm::WithConstant => (mean(|v, _| v * v), mean(|_, b2| b2)),
        };
        let product: T = known().map(|(v, b2)| (v * v - centre_v2) * (b2 - centre_b2)).sum();
        let square: T = known().map(|(v, _)| (v * v - centre_v2) * (v * v - centre_v2)).sum();
        let slowest = known().map(|(v, _)| v).fold(T::MAX, T::min);
        let fastest = known().map(|(v, _)| v).fold(T::ZERO, T::max);
        if count < 2 || fastest <= slowest {
            return Err(ScheduleError::TooFewPoints { found: count.min(1), needed: 2 });
        }
        let k = product / square;
        let c = centre_b2 - k * centre_v2;
        let squared_residuals: T = known().map(|(v, b2)| b2 - k * v * v - c).map(|e| e * e).sum();
        Ok(Self {
            form,
            per_speed_squared_per_m2: k,
            constant_per_s2: c,
            rms_residual_per_s2: (squared_residuals / n).sqrt(),
            speed_range_m_s: [slowest, fastest],
        })
    }

    /// b2 at a speed, 1/s^2, marked where the speed was not covered.
    ///
    /// ```
    /// use seatrial_core::{AuthorityFit, AuthorityForm};
    ///
    /// let fit = AuthorityFit {
    ///     form: AuthorityForm::WithConstant,
    ///     per_speed_squared_per_m2: 0.3,
    ///     constant_per_s2: 0.2,
    ///     rms_residual_per_s2: 0.0,
    ///     speed_range_m_s: [1.0, 2.0],
    /// };
    /// let at_3_m_s = fit.b2_per_s2(3.0);
    /// assert!((at_3_m_s.value() - 2.9_f64).abs() < 1e-12 && at_3_m_s.is_extrapolated());
    /// assert!(!fit.b2_per_s2(1.5).is_extrapolated());
    /// ```
    pub fn b2_per_s2(&self, surge_speed_m_s: T) -> ScheduleValue<T> {
        let [slowest, fastest] = self.speed_range_m_s;
        ScheduleValue::marked(
            self.per_speed_squared_per_m2 * surge_speed_m_s * surge_speed_m_s
                + self.constant_per_s2,
            slowest <= surge_speed_m_s && surge_speed_m_s <= fastest,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::tests::{TABLE_II, points};

    /// NOTES of the paper: (51) refitted from Table II is 0.311 V^2 + 0.259; printed 0.31 and 0.26.
    #[test]
    fn val_paper_equation_51_refitted_from_table_ii() {
        let fit =
            AuthorityFit::<f64>::new(&points(&TABLE_II), AuthorityForm::WithConstant).unwrap();
        // Half a unit of the last digit given.
        assert!((fit.per_speed_squared_per_m2 - 0.311).abs() < 5e-4);
        assert!((fit.constant_per_s2 - 0.259).abs() < 5e-4);
        assert!(!fit.b2_per_s2(1.5).is_extrapolated());
        assert!(fit.b2_per_s2(2.99).is_extrapolated());
    }

    /// numpy: (V2 @ b2) / (V2 @ V2) = 0.3866024872950378 for Table II.
    #[test]
    fn val_numpy_authority_through_zero() {
        let fit = AuthorityFit::<f64>::new(&points(&TABLE_II), AuthorityForm::ThroughZero).unwrap();
        assert!((fit.per_speed_squared_per_m2 - 0.386_602_487_295_037_8).abs() < 1e-14);
        assert_eq!(fit.constant_per_s2, 0.0);
        let single = AuthorityFit::new(&points::<f64>(&TABLE_II)[..1], AuthorityForm::ThroughZero);
        assert!(matches!(single, Err(ScheduleError::TooFewPoints { .. })));
    }
}
