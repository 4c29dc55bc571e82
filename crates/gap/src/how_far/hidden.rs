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

/// An event or a factor that was reconstructed, in one step of the record.
pub(super) type Hidden = (usize, Field, Change);

/// Adds changes to modulations of the whole record. A factor does not turn negative.
pub(super) fn add(changes: &[Hidden], modulations: &mut [Modulation]) {
    for (step, field, change) in changes {
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
