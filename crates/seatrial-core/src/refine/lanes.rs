//! Numbers that are computed side by side, so that the processor's vector unit can take them together.

use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Sub, SubAssign};

/// One number for each of several dampings that are tried at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    pub const ZERO: Self = Self([0.0; N]);

    /// `value` in every lane.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; N])
    }

    pub fn map(self, function: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(function))
    }
}

impl<const N: usize> From<f64> for Lanes<N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::all(value)
    }
}

/// An operation lane by lane, in place and by value. Loops, because closures over arrays are not always inlined.
macro_rules! lane_by_lane {
    ($($by_value:ident $method:ident $in_place:ident $assign:ident $operator:tt),*) => {$(
        impl<const N: usize> $in_place for Lanes<N> {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                for (own, other) in self.0.iter_mut().zip(other.0) {
                    *own $operator other;
                }
            }
        }

        impl<const N: usize> $by_value for Lanes<N> {
            type Output = Self;

            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for (own, other) in self.0.iter_mut().zip(other.0) {
                    *own $operator other;
                }
                self
            }
        }
    )*};
}

lane_by_lane!(
    Add add AddAssign add_assign +=,
    Sub sub SubAssign sub_assign -=,
    Mul mul MulAssign mul_assign *=,
    Div div DivAssign div_assign /=
);

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Self::all(factor)
    }
}
