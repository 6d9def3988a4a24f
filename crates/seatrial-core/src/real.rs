//! The number type: `f32` or `f64`.

use core::fmt::{Debug, Display};
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A floating-point number whose elementary functions are `libm`'s on every platform.
///
/// The standard library's functions differ in the last bit between platforms; results that are
/// compared bit for bit between host, log replay and microcontroller cannot use them.
pub trait Real:
    Copy
    + PartialEq
    + PartialOrd
    + Debug
    + Display
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Sum
    + 'static
{
    /// 0
    const ZERO: Self;
    /// 1
    const ONE: Self;
    /// The circle constant.
    const PI: Self;
    /// The difference between 1 and the next larger number.
    const EPSILON: Self;
    /// Largest finite value.
    const MAX: Self;

    /// The nearest number of this type.
    fn of(value: f64) -> Self;
    /// This value in double precision.
    fn to_f64(self) -> f64;
    /// e^x
    fn exp(self) -> Self;
    /// e^x - 1, accurate near 0
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Angle of the point (`x`, `self`), rad, in (-pi, pi].
    fn atan2(self, x: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Nearest integer, halves away from zero.
    fn round(self) -> Self;
    /// Is it neither infinite nor NaN?
    fn is_finite(self) -> bool;

    /// The larger of two numbers; the other one where one is NaN.
    ///
    /// ```
    /// use seatrial_core::Real;
    ///
    /// assert_eq!(Real::max(f64::NAN, 1.0), 1.0);
    /// ```
    fn max(self, other: Self) -> Self;
    /// The smaller of two numbers; the other one where one is NaN.
    fn min(self, other: Self) -> Self;

    /// The value limited to `-limit ..= limit`.
    ///
    /// ```
    /// use seatrial_core::Real;
    ///
    /// assert_eq!([0.1, 0.4, -0.4].map(|rudder_rad: f64| rudder_rad.limited_to(0.26)), [0.1, 0.26, -0.26]);
    /// ```
    fn limited_to(self, limit: Self) -> Self {
        self.max(-limit).min(limit)
    }

    /// An angle taken to (-pi, pi].
    ///
    /// ```
    /// use seatrial_core::Real;
    ///
    /// assert!((350_f64.to_radians().wrapped() + 10_f64.to_radians()).abs() < 1e-12);
    /// // The interval is half-open.
    /// assert_eq!((-core::f64::consts::PI).wrapped(), core::f64::consts::PI);
    /// ```
    fn wrapped(self) -> Self {
        if self.abs() < Self::PI {
            return self;
        }
        let turn = Self::PI + Self::PI;
        let remainder = self - turn * (self / turn).round();
        if remainder <= -Self::PI { remainder + turn } else { remainder }
    }
}

macro_rules! real {
    ($type:ident, $exp:ident, $expm1:ident, $log:ident, $sqrt:ident, $sin:ident, $cos:ident, $atan2:ident, $round:ident) => {
        impl Real for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const PI: Self = core::$type::consts::PI;
            const EPSILON: Self = <$type>::EPSILON;
            const MAX: Self = <$type>::MAX;

            #[inline]
            fn of(value: f64) -> Self {
                value as Self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            #[inline]
            fn exp_m1(self) -> Self {
                libm::$expm1(self)
            }
            #[inline]
            fn ln(self) -> Self {
                libm::$log(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                libm::$sqrt(self)
            }
            #[inline]
            fn sin(self) -> Self {
                libm::$sin(self)
            }
            #[inline]
            fn cos(self) -> Self {
                libm::$cos(self)
            }
            #[inline]
            fn atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            #[inline]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline]
            fn round(self) -> Self {
                libm::$round(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                self.is_finite()
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                if self.is_nan() || self < other { other } else { self }
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                if other.is_nan() || self < other { self } else { other }
            }
        }
    };
}

real!(f32, expf, expm1f, logf, sqrtf, sinf, cosf, atan2f, roundf);
real!(f64, exp, expm1, log, sqrt, sin, cos, atan2, round);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_max_min_and_abs_are_those_of_libm() {
        let numbers = [0.0, -0.0, 1.0, -1.5, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        for a in numbers {
            assert_eq!(Real::abs(a).to_bits(), libm::fabs(a).to_bits());
            for b in numbers {
                assert_eq!(Real::max(a, b).to_bits(), libm::fmax(a, b).to_bits(), "{a}, {b}");
                assert_eq!(Real::min(a, b).to_bits(), libm::fmin(a, b).to_bits(), "{a}, {b}");
                let (a, b) = (a as f32, b as f32);
                assert_eq!(Real::max(a, b).to_bits(), libm::fmaxf(a, b).to_bits(), "{a}, {b}");
                assert_eq!(Real::min(a, b).to_bits(), libm::fminf(a, b).to_bits(), "{a}, {b}");
            }
        }
    }
}
