//! The ten compartments of the glucoregulatory model and a physical state over them.

use std::ops::{Index, IndexMut};

named::named! {
    /// A compartment of the model (paper, Eqs. 1 and 2), by the name that tables, files and the paper use.
    ///
    /// The discriminants follow the paper's enumeration x1..x10; nothing outside this file may rely on
    /// them. Files with another order (the published weights) map names in their importer.
    Compartment {
        /// Subcutaneous insulin depot, mU/kg.
        S1: "S1",
        /// Second subcutaneous insulin depot, mU/kg.
        S2: "S2",
        /// Plasma insulin, mU/L.
        I: "I",
        /// Insulin effect on glucose distribution, 1/min.
        X1: "X1",
        /// Insulin effect on glucose disposal, 1/min.
        X2: "X2",
        /// Insulin effect on endogenous glucose production, unitless.
        X3: "X3",
        /// Accessible glucose, reported as a concentration in mg/dL.
        Q1: "Q1",
        /// Non-accessible glucose, mmol/kg.
        Q2: "Q2",
        /// First carbohydrate compartment; latent (mmol/kg in the ODE plant, unitless in the network).
        C1: "C1",
        /// Appearance rate of meal glucose U_G, mmol/kg/min.
        C2: "C2",
    }
}

impl Compartment {
    /// The unit in which [`States`] reports this compartment.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::S1 | Self::S2 => "mU/kg",
            Self::I => "mU/L",
            Self::X1 | Self::X2 => "1/min",
            Self::X3 => "",
            Self::Q1 => "mg/dL",
            Self::Q2 => "mmol/kg",
            Self::C1 => "latent",
            Self::C2 => "mmol/kg/min",
        }
    }
}

/// The ten states in the physical units of [`Compartment::unit`], whatever plant they came from.
///
/// This is the reporting convention shared by all plants: Q1 is a concentration in mg/dL and C2 is
/// the appearance rate U_G. A plant that keeps other units inside converts in
/// [`Plant::report`](crate::Plant::report).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct States([f64; 10]);

impl States {
    /// The compartments with their values, in the paper's order.
    pub fn iter(&self) -> impl Iterator<Item = (Compartment, f64)> + '_ {
        Compartment::ALL.into_iter().zip(self.0)
    }
}

impl Index<Compartment> for States {
    type Output = f64;
    fn index(&self, compartment: Compartment) -> &f64 {
        &self.0[compartment as usize]
    }
}

impl IndexMut<Compartment> for States {
    fn index_mut(&mut self, compartment: Compartment) -> &mut f64 {
        &mut self.0[compartment as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_compartment() {
        for compartment in Compartment::ALL {
            assert_eq!(Compartment::from_name(compartment.name()), Some(compartment));
        }
        assert_eq!(Compartment::from_name("q1"), None);
    }

    #[test]
    fn each_compartment_has_its_own_place() {
        let mut states = States::default();
        for (i, compartment) in Compartment::ALL.into_iter().enumerate() {
            states[compartment] = i as f64;
        }
        let values: Vec<f64> = states.iter().map(|(_, v)| v).collect();
        assert_eq!(values, (0..10).map(f64::from).collect::<Vec<_>>());
    }
}
