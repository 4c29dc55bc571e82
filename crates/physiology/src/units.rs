//! Quantities with their units, for the boundaries of the crates.
//!
//! Inside an equation values are bare `f64` with the unit on the doc line; across a public
//! boundary they wear one of these types, so that a rate cannot be handed over as an amount or
//! mmol/L as mg/dL.

/// Conversion of glucose concentration that the models of this workspace use: 1 mmol/L = 18 mg/dL.
///
/// The molar mass of glucose gives 18.016; the simulator of Resalat et al. (2019) rounds it, and
/// the published weights and traces depend on the rounded value.
pub const MG_PER_DL_PER_MMOL_PER_L: f64 = 18.0;

/// Mass of one millimole of glucose, g (Resalat et al. 2019; the molar mass is 180.16 g/mol).
pub const GRAMS_PER_MMOL_GLUCOSE: f64 = 0.18;

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident $unit:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
        pub struct $name(pub f64);

        impl $name {
            /// The unit's symbol, as it stands in tables and on axes.
            pub const UNIT: &'static str = $unit;

            /// The bare value in this unit.
            #[must_use]
            pub const fn value(self) -> f64 {
                self.0
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(&self.0, f)?;
                write!(f, " {}", $unit)
            }
        }

        impl std::ops::Add for $name {
            type Output = Self;
            #[inline]
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl std::ops::Sub for $name {
            type Output = Self;
            #[inline]
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl std::ops::Mul<f64> for $name {
            type Output = Self;
            #[inline]
            fn mul(self, factor: f64) -> Self {
                Self(self.0 * factor)
            }
        }
    )*};
}

quantities! {
    /// Glucose concentration, mg/dL.
    MgPerDl "mg/dL";
    /// Glucose concentration, mmol/L.
    MmolPerL "mmol/L";
    /// Insulin infusion rate, U/h.
    UnitsPerHour "U/h";
    /// Amount of insulin, U.
    Units "U";
    /// Amount of carbohydrate, g.
    Grams "g";
    /// Insulin-to-carbohydrate ratio (ICR), g/U.
    GramsPerUnit "g/U";
    /// Duration, min.
    Minutes "min";
    /// Body weight, kg.
    Kilograms "kg";
    /// Heart rate or a difference of heart rates, 1/min.
    BeatsPerMinute "1/min";
}

impl From<MmolPerL> for MgPerDl {
    #[inline]
    fn from(glucose: MmolPerL) -> Self {
        Self(glucose.0 * MG_PER_DL_PER_MMOL_PER_L)
    }
}

impl From<MgPerDl> for MmolPerL {
    #[inline]
    fn from(glucose: MgPerDl) -> Self {
        Self(glucose.0 / MG_PER_DL_PER_MMOL_PER_L)
    }
}

impl Units {
    /// The rate that gives this amount when held for `duration`.
    ///
    /// A bolus of `b` U within one five-minute step is `12 b` U/h in that step.
    #[inline]
    #[must_use]
    pub fn over(self, duration: Minutes) -> UnitsPerHour {
        UnitsPerHour(self.0 * 60.0 / duration.0)
    }
}

impl UnitsPerHour {
    /// The amount given when this rate is held for `duration`.
    #[inline]
    #[must_use]
    pub fn during(self, duration: Minutes) -> Units {
        Units(self.0 * duration.0 / 60.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glucose_conversion_is_the_models_own() {
        assert_eq!(MgPerDl::from(MmolPerL(10.0)).0, 180.0);
        assert_eq!(MmolPerL::from(MgPerDl(90.0)).0, 5.0);
    }

    #[test]
    fn a_bolus_of_one_unit_in_five_minutes_is_twelve_units_per_hour() {
        assert_eq!(Units(1.0).over(Minutes(5.0)), UnitsPerHour(12.0));
        assert_eq!(UnitsPerHour(12.0).during(Minutes(5.0)), Units(1.0));
    }

    #[test]
    fn display_carries_the_unit_and_honours_precision() {
        assert_eq!(format!("{:.1}", MgPerDl(120.25)), "120.2 mg/dL");
    }
}
