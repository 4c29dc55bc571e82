//! Changes of single steps that no driver explains.

use effects::{Field, Modulation};

/// What happens to a field in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Change {
    /// Is added.
    Added(f64),
    /// Is multiplied.
    Factor(f64),
}

/// Events and factors that were reconstructed, by step of the record.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Hidden(Vec<(usize, Field, Change)>);

impl Hidden {
    pub(super) fn push(&mut self, step: usize, field: Field, change: Change) {
        self.0.push((step, field, change));
    }

    pub(super) fn extend(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Adds the changes to modulations of the whole record. A factor does not turn negative.
    pub(super) fn add_to(&self, modulations: &mut [Modulation]) {
        for (step, field, change) in &self.0 {
            let Some(modulation) = modulations.get_mut(*step) else { continue };
            match change {
                Change::Added(value) => modulation[*field] += value,
                Change::Factor(value) => modulation[*field] *= value,
            }
            if field.neutral() > 0.0 {
                modulation[*field] = modulation[*field].max(0.0);
            }
        }
    }
}
