//! How often chance alone exceeds a sum of squares of independent standard normal deviates.

/// Most terms; the series needs a few times the root of its argument.
const MOST_TERMS: usize = 10_000;

/// The chance of a sum of squares above this one, where there are so many independent squares:
///
/// Q(a, x) = Gamma(a, x) / Gamma(a), a = freedom / 2, x = sum / 2
///
/// the regularised incomplete gamma function: below x = a + 1 by the series of its complement, above by the continued fraction, both as in
/// Abramowitz and Stegun 6.5.29 and 6.5.31. The relative error is below 1e-10 up to 100 degrees of freedom. `None` where the freedom is
/// not positive.
pub(crate) fn chance_beyond(degrees_of_freedom: f64, sum_of_squares: f64) -> Option<f64> {
    let (a, x) = (0.5 * degrees_of_freedom, 0.5 * sum_of_squares);
    if a.is_nan() || a <= 0.0 || x.is_nan() {
        return None;
    }
    if x <= 0.0 {
        return Some(1.0);
    }
    if x == f64::INFINITY {
        return Some(0.0);
    }
    // x^a e^-x / Gamma(a)
    let scale = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    Some(match x < a + 1.0 {
        true => 1.0 - scale * series(a, x),
        false => scale * continued_fraction(a, x),
    })
}

/// 1/a + x/(a (a + 1)) + x^2/(a (a + 1) (a + 2)) + ...
fn series(a: f64, x: f64) -> f64 {
    let mut term = 1.0 / a;
    let mut sum = term;
    for k in 1..MOST_TERMS {
        term *= x / (a + k as f64);
        sum += term;
        if term < sum * f64::EPSILON {
            break;
        }
    }
    sum
}

/// 1/(x + 1 - a - 1 (1 - a)/(x + 3 - a - 2 (2 - a)/(x + 5 - a - ...))), by the recursion of Lentz.
fn continued_fraction(a: f64, x: f64) -> f64 {
    let mut b = x + 1.0 - a;
    let mut c = f64::MAX;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for k in 1..MOST_TERMS {
        let k = k as f64;
        let numerator = -k * (k - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        let change = c * d;
        fraction *= change;
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    /// Another implementation, and the closed form of two degrees of freedom, e^-x.
    #[test]
    fn exact_the_chance_is_that_of_other_implementations() {
        for freedom in [1.0, 2.0, 3.0, 6.0, 20.0, 100.0] {
            let other = ChiSquared::new(freedom).unwrap();
            for share in [0.01, 0.3, 0.9, 1.0, 1.1, 2.0, 5.0] {
                let ours = chance_beyond(freedom, share * freedom).unwrap();
                let expected = other.sf(share * freedom);
                assert!(
                    (ours / expected - 1.0).abs() < 1e-10,
                    "{freedom} {share}: {ours} {expected}"
                );
            }
        }
        let far = chance_beyond(2.0, 200.0).unwrap();
        assert!((libm::log(far) + 100.0).abs() < 1e-12);
        assert_eq!(chance_beyond(2.0, 0.0), Some(1.0));
        assert_eq!(chance_beyond(0.0, 1.0), None);
        assert_eq!(chance_beyond(2.0, f64::INFINITY), Some(0.0));
    }
}
