//! Sub-networks of a model as the verifier takes them, and their proofs.

use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use conformance::{AcceptedClaim, Direction, OneHiddenLayer, Proofs, Property, Region, Row, prove};
use nn_statespace::PopulationModel;
use physiology::Compartment;

/// A sub-network handed over as matrices.
pub(crate) fn network(model: &PopulationModel, compartment: Compartment) -> Result<OneHiddenLayer> {
    let network = model.network(compartment);
    let inputs = model.wiring().inputs(compartment);
    let names = inputs.iter().map(|signal| signal.name().to_owned()).collect();
    Ok(OneHiddenLayer::new(
        compartment.name(),
        names,
        network.w1().to_vec(),
        network.b1().to_vec(),
        network.w2().to_vec(),
        network.b2(),
    )?)
}

/// Certificates for the rows, checked against the bytes of the model file; `took` is the time of the check.
pub(crate) fn proved(
    rows: &mut [Row],
    properties: &[Property],
    model: &PopulationModel,
    bytes: &[u8],
    region: &Region,
    took: &mut Duration,
) -> Result<Proofs> {
    let networks = properties
        .iter()
        .map(|property| {
            let compartment = Compartment::from_name(&property.network)
                .with_context(|| format!("there is no network '{}'", property.network))?;
            network(model, compartment)
        })
        .collect::<Result<Vec<OneHiddenLayer>>>()?;
    let of: Vec<(&OneHiddenLayer, &Property)> = networks.iter().zip(properties).collect();
    let check = |file: &[u8]| {
        let began = Instant::now();
        let accepted = certificate::check(file, bytes).map_err(|error| error.to_string());
        *took = began.elapsed();
        let claims = accepted?.into_iter().map(|claim| {
            let property = match claim.property.as_str() {
                "decreasing" => Direction::Decreasing,
                "increasing" => Direction::Increasing,
                other => return Err(format!("no property is called '{other}'")),
            };
            Ok(AcceptedClaim {
                network: claim.network,
                input: claim.input,
                property,
                claim: claim.claim,
            })
        });
        claims.collect()
    };
    Ok(prove(rows, &of, region, bytes, check)?)
}
