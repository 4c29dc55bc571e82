//! Weights, regions, certificates and documents.

use std::sync::Arc;

use certificate::{Network, check};
use conformance::{Region, Scaling, Signal};
use contract::document_kinds;
use nn_statespace::PopulationModel;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use twins::{InputSet, ResidualNetwork, Twin, TwinCard};

use crate::{pack, unpack};

/// The weights of the network in the repository.
pub(crate) const WEIGHTS: &[u8] =
    include_bytes!("../../nn-statespace/model/population.safetensors");
/// Its region.
pub(crate) const REGION: &[u8] = include_bytes!("../../nn-statespace/model/region.json");
/// One property of it, proved.
const CERTIFICATES: &[u8] = include_bytes!("../seeds/certificates.json");

/// Reads `population.safetensors`.
pub(crate) fn read_weights(bytes: &[u8]) {
    if let Ok(model) = PopulationModel::from_safetensors(bytes) {
        let written = model.to_safetensors();
        let back = PopulationModel::from_safetensors(&written).expect("was written");
        assert_eq!(back.to_safetensors(), written);
    }
}

fn population() -> Arc<PopulationModel> {
    Arc::new(PopulationModel::from_safetensors(WEIGHTS).expect("the network in the repository"))
}

/// A person's twin.
pub(crate) fn twin() -> Vec<u8> {
    let card = TwinCard {
        person_id: "a".to_owned(),
        origin: "a seed".to_owned(),
        version: "0".to_owned(),
        training_data_sha256: None,
        training: None,
    };
    let (residual, inputs) = (ResidualNetwork::untrained(1), InputSet::All);
    let twin = Twin { population: population(), residual, heart_rate_scaler: None, inputs, card };
    twin.to_bytes().expect("a small twin")
}

/// Reads a person's twin.
pub(crate) fn read_twin(bytes: &[u8]) {
    if let Ok(twin) = Twin::from_bytes(bytes, population()) {
        let written = twin.to_bytes().expect("was read");
        Twin::from_bytes(&written, population()).expect("was written");
    }
}

const SIGNALS: [&str; 12] =
    ["Q1", "Q2", "S1", "S2", "I", "X1", "X2", "X3", "C1", "C2", "u_insulin", "u_carbs"];

/// Reads `region.json`.
pub(crate) fn read_region(bytes: &[u8]) {
    let scaling = Some(Scaling { centre: 1.5, scale: 0.25 });
    let signals = SIGNALS.map(|name| Signal { name: name.to_owned(), scaling });
    if let Ok(region) = Region::from_json(bytes, &signals) {
        for (name, [lower, upper]) in region.iter() {
            assert!(lower.is_finite() && upper.is_finite() && lower <= upper, "{name}");
        }
        let _ = region.widened(0.1);
    }
}

/// Seeds of `certificates.json`, with its model and without.
pub(crate) fn certificate_seeds() -> Vec<Vec<u8>> {
    let both = [("certificates.json", CERTIFICATES), ("model", WEIGHTS)];
    vec![pack(&both), pack(&both[..1])]
}

/// Reads `certificates.json` with its model.
pub(crate) fn read_certificate(bytes: &[u8]) {
    let files = unpack(bytes);
    let of =
        |wanted: &str| files.iter().find(|(name, _)| name == wanted).map(|(_, content)| *content);
    let model = of("model").unwrap_or(WEIGHTS);
    let _ = Network::read(model, "S1");
    if let Some(certificates) = of("certificates.json") {
        let _ = check(certificates, model);
        // Behind the seals.
        if let Ok(Value::Object(mut file)) = serde_json::from_slice(certificates) {
            file.remove("sha256");
            file.insert("model_sha256".to_owned(), hash(model).into());
            let seal = hash(&serde_json::to_vec(&file).expect("was read"));
            file.insert("sha256".to_owned(), seal.into());
            let _ = check(&serde_json::to_vec(&file).expect("was read"), model);
        }
    }
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A file of each kind whose smallest form is short.
const SHORT: [&[u8]; 5] = [
    b"seal.json\n{\"schema\": \"seal/1\", \"hash\": \"\", \"worlds\": []}",
    b"run_errors.json\n{\"p1\": {\"left\": 0.5, \"added\": 0.25}}",
    b"labels.json\n[]",
    b"data_in_use.json\n{\"schema\": \"data-in-use/1\", \"people\": []}",
    b"exclusions.json\n[]",
];

/// Seeds of the JSON files of the pipeline: the name of the file in the first line, then its text.
pub(crate) fn document_seeds() -> Vec<Vec<u8>> {
    let region = [b"region.json\n", REGION].concat();
    SHORT.iter().map(|seed| seed.to_vec()).chain([region]).collect()
}

/// Reads a JSON file of the pipeline.
pub(crate) fn read_document(bytes: &[u8]) {
    let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else { return };
    let (name, text) = (&bytes[..end], &bytes[end + 1..]);
    for kind in document_kinds().iter().filter(|kind| kind.file.as_bytes() == name) {
        let _ = kind.same_again(text);
    }
}
