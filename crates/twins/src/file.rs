//! The weight file of a twin: safetensors with one metadata entry, `twin`, that says everything
//! else.
//!
//! One entry, because safetensors writes its metadata from an unordered map: with two, equal twins
//! would give different bytes.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use nn_statespace::{CentreAndScale, DoseGains, PopulationModel, Signal};
use physiology::Compartment;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};

use crate::error::TwinError;
use crate::fingerprint::population_fingerprint;
use crate::heart_rate::HeartRateScaler;
use crate::inputs::InputSet;
use crate::residual::{ResidualNetwork, SHAPES, tensor_name};
use crate::twin::{Twin, TwinCard};

/// The metadata entry that makes a file a twin's.
const ENTRY: &str = "twin";
/// The tensor that holds median and interquartile range of the heart rate. A tensor and not JSON,
/// because reading decimal text back may lose the last bit.
const HEART_RATE: &str = "heart_rate_scaler";
/// The tensor that holds the gains on insulin and carbohydrate, where they are not the population's.
const DOSE_GAINS: &str = "dose_gains";
/// Version of the layout.
const FORMAT: &str = "twin/1";
/// The network's inputs in order, for readers outside this crate.
const INPUT_ORDER: [&str; 10] = [
    "Q1",
    "Q2",
    "X1",
    "X3",
    "C2",
    "heart_rate_over_baseline",
    "weekend",
    "cos_hour",
    "sin_hour",
    "sleep_efficiency",
];

/// What the entry `twin` holds, as JSON.
#[derive(serde::Serialize, serde::Deserialize)]
struct Header {
    format: String,
    card: TwinCard,
    inputs: InputSet,
    input_order: Vec<String>,
    population_sha256: String,
    /// Centre and scale of each state by name, for readers outside this crate; decimal text, exact
    /// only to the last bit or so.
    state_scaler: BTreeMap<String, CentreAndScale>,
}

impl Twin {
    /// The twin as a safetensors file: tensors `layers.0.weight` to `layers.3.bias` in f64, weights
    /// of shape `(outputs, inputs)`; `heart_rate_scaler`, median and interquartile range, where the
    /// twin has one; `dose_gains`, on insulin and carbohydrate, where they are not the population's; and the
    /// metadata entry `twin`. Equal twins give equal bytes.
    ///
    /// # Errors
    /// [`TwinError::Header`] or [`TwinError::File`] if it cannot be put into the format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, TwinError> {
        let scaling =
            |c: Compartment| (c.name().to_owned(), self.population.scaler().of(Signal::State(c)));
        let header = Header {
            format: FORMAT.to_owned(),
            card: self.card.clone(),
            inputs: self.inputs,
            input_order: INPUT_ORDER.map(str::to_owned).to_vec(),
            population_sha256: population_fingerprint(&self.population),
            state_scaler: Compartment::ALL.into_iter().map(scaling).collect(),
        };
        let text =
            serde_json::to_string(&header).map_err(|error| TwinError::Header(error.to_string()))?;
        let mut tensors = Vec::with_capacity(10);
        for (i, (weight, bias)) in self.residual.matrices().into_iter().enumerate() {
            let (inputs, outputs) = SHAPES[i];
            tensors.push((tensor_name(i, "weight"), vec![outputs, inputs], bytes_of(&weight)));
            tensors.push((tensor_name(i, "bias"), vec![outputs], bytes_of(&bias)));
        }
        if let Some(HeartRateScaler { center, scale }) = self.heart_rate_scaler {
            tensors.push((HEART_RATE.to_owned(), vec![2], bytes_of(&[center, scale])));
        }
        let gains = self.population.scaler().dose_gains();
        if gains != DoseGains::NONE {
            let pair = bytes_of(&[gains.insulin, gains.carbs]);
            tensors.push((DOSE_GAINS.to_owned(), vec![2], pair));
        }
        let mut views = Vec::with_capacity(tensors.len());
        for (name, shape, bytes) in &tensors {
            let view = TensorView::new(Dtype::F64, shape.clone(), bytes).map_err(unreadable)?;
            views.push((name.as_str(), view));
        }
        let metadata = HashMap::from([(ENTRY.to_owned(), text)]);
        safetensors::serialize(views, Some(metadata)).map_err(unreadable)
    }

    /// A twin from a file that [`to_bytes`](Self::to_bytes) wrote, on the population model that it
    /// was trained on.
    ///
    /// # Errors
    /// [`TwinError::File`] for something that is no safetensors file or a truncated one,
    /// [`TwinError::WrongKind`] for weights that are not a twin's, [`TwinError::Header`] for a
    /// broken description, [`TwinError::OtherPopulation`] for another population model, and
    /// [`TwinError::MissingTensor`], [`TwinError::Shape`] and [`TwinError::NotFiniteWeight`].
    pub fn from_bytes(bytes: &[u8], population: Arc<PopulationModel>) -> Result<Self, TwinError> {
        let file = SafeTensors::deserialize(bytes).map_err(unreadable)?;
        let header = read_header(bytes, &file)?;
        let found = population_fingerprint(&population);
        if header.population_sha256 != found {
            return Err(TwinError::OtherPopulation { expected: header.population_sha256, found });
        }
        let (mut weights, mut biases): ([Vec<f64>; 4], [Vec<f64>; 4]) = Default::default();
        for i in 0..4 {
            weights[i] = values(&file, &tensor_name(i, "weight"))?;
            biases[i] = values(&file, &tensor_name(i, "bias"))?;
        }
        let residual = ResidualNetwork::from_tensors(
            weights.each_ref().map(Vec::as_slice),
            biases.each_ref().map(Vec::as_slice),
        )?;
        let population = match pair_of(&file, DOSE_GAINS)? {
            Some((insulin, carbs)) => {
                let gains = DoseGains { insulin, carbs };
                Arc::new(PopulationModel::clone(&population).with_dose_gains(gains)?)
            }
            None => population,
        };
        Ok(Self {
            population,
            residual,
            heart_rate_scaler: heart_rate_scaler(&file)?,
            inputs: header.inputs,
            card: header.card,
        })
    }
}

/// Whether a file says that it holds a twin. It may still be a broken one.
#[must_use]
pub fn is_twin(bytes: &[u8]) -> bool {
    SafeTensors::read_metadata(bytes).is_ok_and(|(_, metadata)| {
        metadata.metadata().as_ref().is_some_and(|entries| entries.contains_key(ENTRY))
    })
}

fn read_header(bytes: &[u8], file: &SafeTensors<'_>) -> Result<Header, TwinError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(unreadable)?;
    let entries = metadata.metadata().clone().unwrap_or_default();
    let Some(text) = entries.get(ENTRY) else {
        return Err(TwinError::WrongKind(guess(&entries, file)));
    };
    let header: Header =
        serde_json::from_str(text).map_err(|error| TwinError::Header(error.to_string()))?;
    let problem = if header.format != FORMAT {
        format!("format '{}' is not '{FORMAT}'", header.format)
    } else if header.input_order != INPUT_ORDER {
        format!("inputs in the order {}", header.input_order.join(", "))
    } else {
        return Ok(header);
    };
    Err(TwinError::Header(problem))
}

/// The tensor `heart_rate_scaler`, `None` if there is none.
fn heart_rate_scaler(file: &SafeTensors<'_>) -> Result<Option<HeartRateScaler>, TwinError> {
    match pair_of(file, HEART_RATE)? {
        None => Ok(None),
        Some((center, scale)) if center.is_finite() && scale.is_finite() && scale > 0.0 => {
            Ok(Some(HeartRateScaler { center, scale }))
        }
        Some((center, scale)) => {
            Err(TwinError::Header(format!("heart rate scaled by {scale} about {center}")))
        }
    }
}

/// A tensor of two numbers, `None` if there is none of this name.
fn pair_of(file: &SafeTensors<'_>, name: &str) -> Result<Option<(f64, f64)>, TwinError> {
    if !file.names().contains(&name) {
        return Ok(None);
    }
    match values(file, name)?.as_slice() {
        [one, other] => Ok(Some((*one, *other))),
        found => Err(TwinError::Shape { tensor: name.to_owned(), found: found.len(), expected: 2 }),
    }
}

/// What a file without the entry `twin` seems to be, for the message.
fn guess(entries: &HashMap<String, String>, file: &SafeTensors<'_>) -> String {
    let mut keys: Vec<&str> = entries.keys().map(String::as_str).collect();
    keys.sort_unstable();
    let mut names = file.names();
    names.sort_unstable();
    let list = |items: &[&str]| match items {
        [] => "none".to_owned(),
        items => items[..items.len().min(3)].join(", "),
    };
    format!("metadata {} and tensors {}", list(&keys), list(&names))
}

fn values(file: &SafeTensors<'_>, name: &str) -> Result<Vec<f64>, TwinError> {
    let tensor = file.tensor(name).map_err(|_| TwinError::MissingTensor(name.to_owned()))?;
    if tensor.dtype() != Dtype::F64 {
        let problem = format!("tensor {name} is of type {:?}, not F64", tensor.dtype());
        return Err(TwinError::File(problem));
    }
    let (eights, _) = tensor.data().as_chunks::<8>();
    Ok(eights.iter().map(|eight| f64::from_le_bytes(*eight)).collect())
}

fn bytes_of(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn unreadable(error: safetensors::SafeTensorError) -> TwinError {
    TwinError::File(error.to_string())
}
