//! The normal distribution of which what is below 0 is cut off.

use core::f64::consts::{FRAC_1_SQRT_2, TAU};

/// x ~ N(mu, 1) given x > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AboveZero {
    /// log P(x > 0).
    pub log_probability: f64,
    /// E[x | x > 0] - mu.
    pub shift: f64,
    /// 1 - var[x | x > 0].
    pub narrowing: f64,
}

/// The part above zero of a normal distribution with this mean and variance 1.
pub fn above_zero(mu: f64) -> AboveZero {
    if mu > 8.0 {
        return AboveZero { log_probability: 0.0, shift: 0.0, narrowing: 0.0 };
    }
    let log_density = -0.5 * (mu * mu + libm::log(TAU));
    // Mills' ratio; far out by its continued fraction.
    let (log_probability, shift) = if mu > -5.0 {
        let above = 0.5 * libm::erfc(-mu * FRAC_1_SQRT_2);
        (libm::log(above), libm::exp(log_density) / above)
    } else {
        let m = -mu;
        let shift = m + 1.0 / (m + 2.0 / (m + 3.0 / (m + 4.0 / m)));
        (log_density - libm::log(shift), shift)
    };
    AboveZero { log_probability, shift, narrowing: shift * (shift + mu) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_half_of_the_normal_distribution() {
        let cut = above_zero(0.0);
        // Rounding.
        assert!((cut.log_probability - 0.5_f64.ln()).abs() < 1e-15);
        assert!((cut.shift - (2.0 / core::f64::consts::PI).sqrt()).abs() < 1e-15);
        assert!((cut.narrowing - 2.0 / core::f64::consts::PI).abs() < 1e-15);
    }

    #[test]
    fn exact_both_formulas_agree_where_they_meet() {
        let (near, far) = (above_zero(-4.999_999), above_zero(-5.000_001));
        // Five terms of the fraction.
        assert!((near.log_probability - far.log_probability).abs() < 1e-3);
        assert!((near.shift - far.shift).abs() < 1e-3);
    }
}
