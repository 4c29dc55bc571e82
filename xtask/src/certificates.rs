//! Certificates of the proved rows of `verify`, and their check by the other crate.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use conformance::{Certificate, Property, Region, Row, Verdict, certify};
use nn_statespace::PopulationModel;
use physiology::Compartment;
use sha2::{Digest as _, Sha256};

use crate::manifest::hexadecimal;
use crate::stages::verify::network;

/// Boxes of a certificate after which a row counts as undecided; three hundred bytes each.
const MOST_NODES: usize = 1_000_000;

/// The file, and what the checker said.
pub(crate) struct Certified {
    pub(crate) file: Vec<u8>,
    pub(crate) accepted: usize,
    pub(crate) took: Duration,
}

/// Writes a certificate for each proved row and has them checked against the model file's bytes. A row that comes out
/// without one is no longer proved.
pub(crate) fn certified(
    rows: &mut [Row],
    properties: &[Property],
    model: &PopulationModel,
    bytes: &[u8],
    region: &Region,
) -> Result<Certified> {
    let mut found: Vec<Certificate> = Vec::new();
    for (row, property) in rows.iter_mut().zip(properties) {
        if row.verdict != Verdict::Proved {
            continue;
        }
        let compartment = Compartment::from_name(&property.network)
            .with_context(|| format!("there is no network '{}'", property.network))?;
        let network = network(model, compartment)?;
        row.certified = Some(false);
        match certify(&network, property, region, row.m_upper, MOST_NODES)? {
            Some(certificate) => found.push(certificate),
            None => row.verdict = Verdict::Undecided,
        }
    }
    let file = sealed(&found, bytes, region)?;
    let began = Instant::now();
    let accepted = certificate::check(&file, bytes).context(
        "the checker rejects what the verifier wrote; this is a defect of one of the two",
    )?;
    for row in rows.iter_mut().filter(|row| row.verdict == Verdict::Proved) {
        row.certified =
            Some(accepted.iter().any(|a| {
                a.network == row.network && a.input == row.input && a.claim == row.m_upper
            }));
    }
    Ok(Certified { file, accepted: accepted.len(), took: began.elapsed() })
}

/// The file `certificates.json`, described in `certificate`.
fn sealed(certificates: &[Certificate], model: &[u8], region: &Region) -> Result<Vec<u8>> {
    let mut file = serde_json::json!({
        "schema": "certificate/1",
        "model_sha256": hexadecimal(&Sha256::digest(model)),
        "half_spaces": region.half_spaces(),
        "bounds": region.iter().collect::<BTreeMap<_, _>>(),
        "certificates": certificates,
    });
    let seal = hexadecimal(&Sha256::digest(serde_json::to_vec(&file)?));
    file["sha256"] = seal.into();
    Ok(serde_json::to_vec(&file)?)
}
