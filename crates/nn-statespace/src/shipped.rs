//! The population model that comes with the crate.

use crate::error::ModelError;
use crate::population::PopulationModel;

/// Its weight file; the range of its training data, as `cargo xtask verify` reads it, and its card lie beside it.
const FILE: &[u8] = include_bytes!("../model/population.safetensors");

impl PopulationModel {
    /// The population model that this project trained at the paper's scale, in the paper's widths: on 323,400 simulated
    /// days of the nominal ODE, with slopes kept as physiology has them. `model/README.md` in the crate is its card.
    ///
    /// ```
    /// use nn_statespace::PopulationModel;
    ///
    /// let model = PopulationModel::shipped()?;
    /// assert_eq!(model.widths().total(), 1467); // 6,782 weights and biases
    /// # Ok::<(), nn_statespace::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`PopulationModel::from_safetensors`], if the crate was changed.
    pub fn shipped() -> Result<Self, ModelError> {
        Self::from_safetensors(FILE)
    }
}
