//! Twins that the paper's authors published.

use std::sync::Arc;

use nn_statespace::PopulationModel;
use nn_statespace::import;

use crate::error::TwinError;
use crate::heart_rate::HeartRateScaler;
use crate::inputs::InputSet;
use crate::residual::ResidualNetwork;
use crate::twin::{Twin, TwinCard};

/// A twin from an `individual_model.pt` and its `scaler_robust.pkl`, on the population model of the
/// same authors.
///
/// # Errors
/// [`TwinError::Model`] with the tensor or offset at fault, and [`TwinError::Shape`] for widths
/// other than 128, 64 and 32.
pub fn published_twin(
    weights: &[u8],
    heart_rate_scaler: &[u8],
    population: Arc<PopulationModel>,
    person_id: &str,
) -> Result<Twin, TwinError> {
    let layers = import::individual_network(weights)?;
    let residual = ResidualNetwork::from_tensors(
        layers.each_ref().map(|layer| layer.weight.as_slice()),
        layers.each_ref().map(|layer| layer.bias.as_slice()),
    )?;
    let scaler = import::heart_rate_scaler(heart_rate_scaler)?;
    Ok(Twin {
        population,
        residual,
        heart_rate_scaler: Some(HeartRateScaler { center: scaler.centre, scale: scaler.scale }),
        inputs: InputSet::All,
        card: TwinCard {
            person_id: person_id.to_owned(),
            origin: "imported from a published PyTorch state dictionary".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            ..TwinCard::default()
        },
    })
}
