//! Numbers that carry their derivatives (forward-mode automatic differentiation).

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the equations are written over: a plain number, or one that carries derivatives.
pub trait Scalar:
    Copy
    + From<f64>
    + PartialOrd<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

impl Scalar for f64 {}
impl<const N: usize> Scalar for Dual<N> {}

/// A value and its derivatives by `N` variables.
///
/// Comparisons look at the value alone, so that a function with a kink has the slope of the branch
/// that is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Its derivative by each variable.
    pub slopes: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The variable with this index, at a value.
    #[must_use]
    pub fn variable(value: f64, index: usize) -> Self {
        Self { value, slopes: std::array::from_fn(|k| f64::from(u8::from(k == index))) }
    }

    /// A value whose derivatives are `left` times those of `self` and `right` times those of `other`.
    fn chained(self, value: f64, left: f64, other: Self, right: f64) -> Self {
        let slopes = std::array::from_fn(|k| left * self.slopes[k] + right * other.slopes[k]);
        Self { value, slopes }
    }
}

impl<const N: usize> From<f64> for Dual<N> {
    fn from(value: f64) -> Self {
        Self { value, slopes: [0.0; N] }
    }
}

impl<const N: usize> PartialEq<f64> for Dual<N> {
    fn eq(&self, other: &f64) -> bool {
        self.value == *other
    }
}

impl<const N: usize> PartialOrd<f64> for Dual<N> {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.value.partial_cmp(other)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.chained(self.value + other.value, 1.0, other, 1.0)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.chained(self.value - other.value, 1.0, other, -1.0)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.chained(self.value * other.value, other.value, other, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        self.chained(value, 1.0 / other.value, other, -value / other.value)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, slopes: self.slopes.map(|slope| -slope) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_product_a_quotient_and_a_branch_by_hand() {
        let (x, y) = (Dual::<2>::variable(3.0, 0), Dual::<2>::variable(4.0, 1));
        let f = x * y - -x / y;
        assert_eq!(f.value, 12.75);
        assert_eq!(f.slopes, [4.25, 3.0 - 3.0 / 16.0]);
        let kinked = |g: Dual<2>| if g >= 3.0 { g * g } else { g };
        assert_eq!(kinked(x).slopes, [6.0, 0.0]);
        assert_eq!(kinked(x - Dual::from(0.5)).slopes, [1.0, 0.0]);
    }
}
