//! State of the ODE plant, and the ten-entry vectors and matrices over its compartments.

use std::ops::{Index, IndexMut};

use physiology::Compartment;

use crate::exercise::ExerciseMemory;
use crate::gut::GutPair;

/// Full state of the plant, in its own units.
///
/// Differs from [`physiology::States`] in Q1 (an amount, mmol/kg) and C2 (an amount, mmol/kg; the
/// appearance rate is `c2 / t_max_g`), and carries what the reporting state has no place for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OdeState {
    /// Subcutaneous insulin depot S1, mU/kg.
    pub s1: f64,
    /// Second insulin depot S2, mU/kg.
    pub s2: f64,
    /// Plasma insulin I, mU/L.
    pub i: f64,
    /// Insulin effect on distribution X1, 1/min.
    pub x1: f64,
    /// Insulin effect on disposal X2, 1/min.
    pub x2: f64,
    /// Insulin effect on endogenous production X3, unitless.
    pub x3: f64,
    /// Accessible glucose Q1, mmol/kg.
    pub q1: f64,
    /// Non-accessible glucose Q2, mmol/kg.
    pub q2: f64,
    /// Carbohydrate of meals in the gut (C1, C2), mmol/kg.
    pub meals: GutPair,
    /// Carbohydrate of rescue snacks in the gut, mmol/kg.
    pub rescue: GutPair,
    /// What past exercise has left behind.
    pub exercise: ExerciseMemory,
}

impl OdeState {
    /// The ten compartments as a vector, for linear algebra and filters.
    ///
    /// Rescue carbohydrate and the exercise memory are not part of it.
    #[inline]
    #[must_use]
    pub fn vector(&self) -> OdeVector {
        OdeVector([
            self.s1,
            self.s2,
            self.i,
            self.x1,
            self.x2,
            self.x3,
            self.q1,
            self.q2,
            self.meals.c1,
            self.meals.c2,
        ])
    }

    /// The same state with its ten compartments replaced by `x`.
    #[inline]
    #[must_use]
    pub fn with_vector(self, x: &OdeVector) -> Self {
        let [s1, s2, i, x1, x2, x3, q1, q2, c1, c2] = x.0;
        Self { s1, s2, i, x1, x2, x3, q1, q2, meals: GutPair { c1, c2 }, ..self }
    }
}

/// Position of a compartment in [`OdeVector`] and [`OdeMatrix`]: the order of [`Compartment::ALL`].
#[inline]
#[must_use]
pub const fn slot(compartment: Compartment) -> usize {
    compartment as usize
}

/// Ten values over S1 .. C2 in the units of [`OdeState`] (or those per minute, for derivatives).
///
/// Index by name, `x[Compartment::Q1]`; the array inside follows [`Compartment::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OdeVector<T = f64>(pub [T; 10]);

impl OdeVector {
    /// The first compartment whose value is not finite, or `None`.
    #[inline]
    #[must_use]
    pub fn first_non_finite(&self) -> Option<Compartment> {
        // Zero times what is not finite is not a number: one test for the common case.
        if self.0.iter().map(|value| 0.0 * value).sum::<f64>() == 0.0 {
            return None;
        }
        Compartment::ALL.into_iter().find(|c| !self[*c].is_finite())
    }
}

impl<T> Index<Compartment> for OdeVector<T> {
    type Output = T;
    #[inline]
    fn index(&self, compartment: Compartment) -> &T {
        &self.0[slot(compartment)]
    }
}

impl<T> IndexMut<Compartment> for OdeVector<T> {
    #[inline]
    fn index_mut(&mut self, compartment: Compartment) -> &mut T {
        &mut self.0[slot(compartment)]
    }
}

/// A ten-by-ten matrix over the compartments, row first: `m[(Q1, X1)]` is the effect on Q1 of X1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdeMatrix(pub [[f64; 10]; 10]);

impl OdeMatrix {
    /// The zero matrix.
    pub const ZERO: Self = Self([[0.0; 10]; 10]);

    /// The unit matrix.
    #[inline]
    #[must_use]
    pub fn identity() -> Self {
        let mut m = Self::ZERO;
        for c in Compartment::ALL {
            m[(c, c)] = 1.0;
        }
        m
    }

    /// The product `self * right`.
    #[must_use]
    pub fn times(&self, right: &Self) -> Self {
        let mut product = Self::ZERO;
        for (row, out) in self.0.iter().zip(&mut product.0) {
            for (factor, right_row) in row.iter().zip(&right.0) {
                for (cell, value) in out.iter_mut().zip(right_row) {
                    *cell += factor * value;
                }
            }
        }
        product
    }

    /// The sum `self + factor * other`.
    #[inline]
    #[must_use]
    pub fn plus_scaled(&self, factor: f64, other: &Self) -> Self {
        let mut sum = *self;
        for (row, other_row) in sum.0.iter_mut().zip(&other.0) {
            for (cell, value) in row.iter_mut().zip(other_row) {
                *cell += factor * value;
            }
        }
        sum
    }
}

impl Index<(Compartment, Compartment)> for OdeMatrix {
    type Output = f64;
    #[inline]
    fn index(&self, (row, column): (Compartment, Compartment)) -> &f64 {
        &self.0[slot(row)][slot(column)]
    }
}

impl IndexMut<(Compartment, Compartment)> for OdeMatrix {
    #[inline]
    fn index_mut(&mut self, (row, column): (Compartment, Compartment)) -> &mut f64 {
        &mut self.0[slot(row)][slot(column)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_follow_the_order_of_all_compartments() {
        for (position, compartment) in Compartment::ALL.into_iter().enumerate() {
            assert_eq!(slot(compartment), position);
        }
    }

    #[test]
    fn a_vector_goes_back_into_the_state_it_came_from() {
        let x = OdeVector(std::array::from_fn(|k| k as f64 + 1.0));
        let state = OdeState::default().with_vector(&x);
        assert_eq!(state.vector(), x);
        assert_eq!(state.q1, x[Compartment::Q1]);
        assert_eq!(state.meals.c2, x[Compartment::C2]);
    }

    #[test]
    fn matrix_products_act_from_the_left() {
        let mut shift = OdeMatrix::ZERO;
        shift[(Compartment::S2, Compartment::S1)] = 2.0;
        let mut second = OdeMatrix::ZERO;
        second[(Compartment::I, Compartment::S2)] = 3.0;
        let product = second.times(&shift);
        assert_eq!(product[(Compartment::I, Compartment::S1)], 6.0);
        assert_eq!(shift.times(&OdeMatrix::identity()), shift);
    }
}
