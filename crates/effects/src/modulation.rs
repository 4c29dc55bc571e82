//! What effects do to a model in one step.

use std::ops::{Index, IndexMut};

named::named! {
    /// A quantity that effects can change in one five-minute step.
    Field {
        /// Factor on the insulin that enters the depot.
        InsulinInput: "insulin_input",
        /// Factor on the time of insulin absorption.
        InsulinTime: "insulin_time",
        /// Factor on insulin action on transport and disposal (X1, X2).
        Action: "action",
        /// Factor on insulin action on the liver (X3).
        LiverAction: "liver_action",
        /// Factor on endogenous glucose production.
        Production: "production",
        /// Factor on the time of meal absorption.
        GutTime: "gut_time",
        /// Factor on the carbohydrate eaten in the step over that logged.
        CarbAmount: "carb_amount",
        /// Carbohydrate eaten in the step beside that logged, g.
        ExtraCarbs: "extra_carbs",
        /// Glucose flux into Q1, mmol/kg/min.
        Flux: "flux",
        /// Production added while interstitial glucose is low, as a share of the basal production for each full
        /// depth below 70 mg/dL (20 mg/dL).
        LowGlucoseProduction: "low_glucose_production",
        /// Factor on the rate of renal clearance.
        RenalRate: "renal_rate",
        /// Shift of the renal threshold, mg/dL.
        RenalThreshold: "renal_threshold",
        /// Factor on what the sensor shows.
        SensorGain: "sensor_gain",
        /// Added to what the sensor shows, mg/dL.
        SensorOffset: "sensor_offset",
        /// Factor on the time constant between plasma and interstitial glucose.
        SensorLag: "sensor_lag",
    }
}

/// Number of fields.
pub const FIELDS: usize = Field::ALL.len();

impl Field {
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
