//! Which plant is diagnosed.

use std::sync::Arc;

use cohort::Person;

use crate::filter::body::Body;

/// The plant that is diagnosed, person by person: the same for everybody, or everybody's own.
pub trait Plants: Sync {
    /// Its name in the output.
    fn name(&self) -> &str;

    /// A person's body; `None` stands for the ODE.
    ///
    /// # Errors
    /// Why the person cannot be diagnosed with this plant; she is excluded for that reason.
    fn body_of(&self, person: &Person) -> Result<Option<Arc<dyn Body>>, String>;
}

/// The ODE plant for everybody.
#[derive(Debug, Clone, Copy)]
pub struct Ode;

impl Plants for Ode {
    fn name(&self) -> &str {
        "ode"
    }

    fn body_of(&self, _: &Person) -> Result<Option<Arc<dyn Body>>, String> {
        Ok(None)
    }
}
