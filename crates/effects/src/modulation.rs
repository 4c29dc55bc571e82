//! What effects do to a model in one step.

use std::ops::{Index, IndexMut};

/// A quantity that effects can change in one five-minute step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Field {
    /// Factor on the insulin that enters the depot.
    InsulinInput,
    /// Factor on the time of insulin absorption.
    InsulinTime,
    /// Factor on insulin action on transport and disposal (X1, X2).
    Action,
    /// Factor on insulin action on the liver (X3).
    LiverAction,
    /// Factor on endogenous glucose production.
    Production,
    /// Factor on the time of meal absorption.
    GutTime,
    /// Factor on the carbohydrate eaten in the step over that logged.
    CarbAmount,
    /// Carbohydrate eaten in the step beside that logged, g.
    ExtraCarbs,
    /// Glucose flux into Q1, mmol/kg/min.
    Flux,
    /// Production added while interstitial glucose is low, as a share of the basal production for each full
    /// depth below 70 mg/dL (20 mg/dL).
    LowGlucoseProduction,
    /// Factor on the rate of renal clearance.
    RenalRate,
    /// Shift of the renal threshold, mg/dL.
    RenalThreshold,
    /// Factor on what the sensor shows.
    SensorGain,
    /// Added to what the sensor shows, mg/dL.
    SensorOffset,
    /// Factor on the time constant between plasma and interstitial glucose.
    SensorLag,
}

/// Number of fields.
pub const FIELDS: usize = 15;

impl Field {
    /// Every field, in the order of [`Modulation`].
    pub const ALL: [Self; FIELDS] = [
        Self::InsulinInput,
        Self::InsulinTime,
        Self::Action,
        Self::LiverAction,
        Self::Production,
        Self::GutTime,
        Self::CarbAmount,
        Self::ExtraCarbs,
        Self::Flux,
        Self::LowGlucoseProduction,
        Self::RenalRate,
        Self::RenalThreshold,
        Self::SensorGain,
        Self::SensorOffset,
        Self::SensorLag,
    ];

    /// The value at which the field changes nothing: 1 for factors, 0 for what is added.
    #[inline]
    #[must_use]
    pub const fn neutral(self) -> f64 {
        match self {
            Self::ExtraCarbs
            | Self::Flux
            | Self::LowGlucoseProduction
            | Self::RenalThreshold
            | Self::SensorOffset => 0.0,
            _ => 1.0,
        }
    }
}

/// Everything that effects change in one step. Index it by [`Field`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulation([f64; FIELDS]);

static UNCHANGED: Modulation = Modulation::NEUTRAL;

impl Modulation {
    /// Nothing is changed.
    pub const NEUTRAL: Self = {
        let mut values = [0.0; FIELDS];
        let mut k = 0;
        while k < FIELDS {
            values[k] = Field::ALL[k].neutral();
            k += 1;
        }
        Self(values)
    };

    /// The fields in which any pair of modulations differs, in the order of [`Field::ALL`].
    pub fn differing<'a>(pairs: impl Iterator<Item = (&'a Self, &'a Self)>) -> Vec<Field> {
        let mut differs = [false; FIELDS];
        for (one, other) in pairs {
            for (differs, (a, b)) in differs.iter_mut().zip(one.0.iter().zip(&other.0)) {
                *differs |= a != b;
            }
        }
        Field::ALL.into_iter().filter(|field| differs[*field as usize]).collect()
    }

    /// The neutral one that steps share in which nothing acts: it is known for neutral by its place.
    #[inline]
    #[must_use]
    pub fn unchanged() -> &'static Self {
        &UNCHANGED
    }

    /// Whether nothing is changed.
    #[inline]
    #[must_use]
    pub fn is_neutral(&self) -> bool {
        std::ptr::eq(self, &raw const UNCHANGED) || *self == Self::NEUTRAL
    }
}

impl Default for Modulation {
    fn default() -> Self {
        Self::NEUTRAL
    }
}

impl Index<Field> for Modulation {
    type Output = f64;

    #[inline]
    fn index(&self, field: Field) -> &f64 {
        &self.0[field as usize]
    }
}

impl IndexMut<Field> for Modulation {
    #[inline]
    fn index_mut(&mut self, field: Field) -> &mut f64 {
        &mut self.0[field as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_kept_apart_and_start_neutral() {
        for (index, field) in Field::ALL.into_iter().enumerate() {
            assert_eq!(field as usize, index);
            assert_eq!(Modulation::NEUTRAL[field], field.neutral());
            let mut one = Modulation::NEUTRAL;
            one[field] += 0.5;
            assert!(!one.is_neutral());
        }
    }
}
