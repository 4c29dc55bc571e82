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

/// The sub-network that a property is about, and whose rate it gives.
pub(crate) fn network_of(
    model: &PopulationModel,
    property: &Property,
) -> Result<(Compartment, OneHiddenLayer)> {
    let compartment = Compartment::from_name(&property.network)
        .with_context(|| format!("there is no network '{}'", property.network))?;
    Ok((compartment, network(model, compartment)?))
}

/// Certificates for the rows, checked against the bytes of the model file, and the time of the check.
pub(crate) fn proved(
    rows: &mut [Row],
    properties: &[Property],
    model: &PopulationModel,
    bytes: &[u8],
    region: &Region,
) -> Result<(Proofs, Duration)> {
    let mut took = Duration::ZERO;
    let networks = properties.iter().map(|property| Ok(network_of(model, property)?.1));
    let networks = networks.collect::<Result<Vec<OneHiddenLayer>>>()?;
    let of: Vec<(&OneHiddenLayer, &Property)> = networks.iter().zip(properties).collect();
    let check = |file: &[u8]| {
        let began = Instant::now();
        let accepted = certificate::check(file, bytes).map_err(|error| error.to_string());
        took = began.elapsed();
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
    let proofs = prove(rows, &of, region, bytes, check)?;
    Ok((proofs, took))
}
