//! What a world needs from a body beyond the plant.

use ode_sim::OdeError;
use physiology::{MgPerDl, Plant, UnitsPerHour};

/// A body that has steady states: the start of a life, and of the trials that find its settings.
pub trait VirtualBody: Plant {
    /// The state that a constant basal rate holds at a glucose concentration, and that rate.
    ///
    /// # Errors
    /// [`OdeError::NoBasal`] where glucose stays below the target even without insulin, and the
    /// other errors of [`ode_sim::steady_state::at_glucose`].
    fn at_rest(&self, glucose: MgPerDl) -> Result<(Self::State, UnitsPerHour), OdeError>;
}
