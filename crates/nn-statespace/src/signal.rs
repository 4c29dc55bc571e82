//! What a network can take as an input.

use physiology::Compartment;

/// A signal that a network can take as an input, always in scaled units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Signal {
    /// A state of the model.
    State(Compartment),
    /// The insulin infusion rate u_I; before scaling U/h, boluses included.
    Insulin,
    /// The carbohydrate intake u_carb; before scaling g within a sample of 5 min.
    Carbs,
}

impl Signal {
    /// Every signal, by [`row`](Self::row): the states in the paper's order, insulin, carbohydrate.
    pub fn all() -> impl Iterator<Item = Self> {
        Compartment::ALL.into_iter().map(Self::State).chain([Self::Insulin, Self::Carbs])
    }

    /// The place of the signal among [`all`](Self::all).
    #[must_use]
    pub const fn row(self) -> usize {
        match self {
            Self::State(compartment) => compartment as usize,
            Self::Insulin => Compartment::ALL.len(),
            Self::Carbs => Compartment::ALL.len() + 1,
        }
    }

    /// The name that weight files and `region.json` use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::State(compartment) => compartment.name(),
            Self::Insulin => "u_insulin",
            Self::Carbs => "u_carbs",
        }
    }

    /// The signal with this name, or `None`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|signal| signal.name() == name)
    }
}

impl std::fmt::Display for Signal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_the_order_of_all_and_names_lead_back() {
        for (row, signal) in Signal::all().enumerate() {
            assert_eq!(signal.row(), row);
            assert_eq!(Signal::from_name(signal.name()), Some(signal));
        }
        assert_eq!(Signal::from_name("u"), None);
    }
}
