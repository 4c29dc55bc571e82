//! Weight files: a population model as `population.safetensors`.
//!
//! Tensors, all F64 and row-major: for each compartment `NAME.hidden.weight` (hidden, inputs),
//! `NAME.hidden.bias` (hidden), `NAME.output.weight` (hidden), `NAME.output.bias` (1), and
//! `scaler.centre`, `scaler.scale` (12) in the order of the header's `signals`. The header's
//! metadata has one entry, `population`, whose JSON gives the format's version, the order of
//! states, the wiring, the widths, the clamp and the card. One entry, because the header's entries
//! have no order of their own: equal models give equal bytes.

use std::collections::{BTreeMap, HashMap};

use physiology::Compartment;
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};

use crate::error::ModelError;
use crate::import::floats;
use crate::network::{HiddenLayerNetwork, shaped};
use crate::per_compartment::PerCompartment;
use crate::population::{GlucoseClamp, ModelCard, PopulationModel};
use crate::scaler::{CentreAndScale, Scaler};
use crate::signal::Signal;
use crate::wiring::Wiring;

/// The weight file that comes with the crate; the range of its training data, as
/// `cargo xtask verify` reads it, and its card lie beside it.
const SHIPPED: &[u8] = include_bytes!("../model/population.safetensors");
const FORMAT: &str = "population/1";
const ENTRY: &str = "population";

/// The metadata that goes with the tensors.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    format: String,
    states: Vec<String>,
    signals: Vec<String>,
    wiring: BTreeMap<String, Vec<String>>,
    widths: BTreeMap<String, usize>,
    glucose_clamp: GlucoseClamp,
    card: ModelCard,
}

impl PopulationModel {
    /// The population model that this project trained at the paper's scale, in the paper's widths:
    /// on 323,400 simulated days of the nominal ODE, with slopes kept as physiology has them.
    /// `model/README.md` in the crate is its card.
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
        Self::from_safetensors(SHIPPED)
    }

    /// The model as the bytes of a safetensors file; equal models give equal bytes.
    #[must_use]
    pub fn to_safetensors(&self) -> Vec<u8> {
        let names = |signals: &[Signal]| signals.iter().map(Signal::to_string).collect();
        let each = || Compartment::ALL.into_iter();
        let header = Header {
            format: FORMAT.to_owned(),
            states: each().map(|c| c.to_string()).collect(),
            signals: Signal::all().map(|s| s.to_string()).collect(),
            wiring: each().map(|c| (c.to_string(), names(self.wiring().inputs(c)))).collect(),
            widths: each().map(|c| (c.to_string(), self.network(c).hidden())).collect(),
            glucose_clamp: self.clamp(),
            card: self.card().clone(),
        };
        let json = serde_json::to_string(&header).expect("a header is plain text and numbers");
        let mut tensors: Vec<(String, Vec<usize>, Vec<u8>)> = Vec::new();
        let mut put = |name: String, shape: Vec<usize>, values: &[f64]| {
            tensors.push((name, shape, values.iter().flat_map(|v| v.to_le_bytes()).collect()));
        };
        for compartment in Compartment::ALL {
            let network = self.network(compartment);
            let (hidden, inputs) = (network.hidden(), network.inputs());
            put(format!("{compartment}.hidden.weight"), vec![hidden, inputs], network.w1());
            put(format!("{compartment}.hidden.bias"), vec![hidden], network.b1());
            put(format!("{compartment}.output.weight"), vec![hidden], network.w2());
            put(format!("{compartment}.output.bias"), vec![1], &[network.b2()]);
        }
        let column = |value: fn(CentreAndScale) -> f64| -> Vec<f64> {
            Signal::all().map(|signal| value(self.scaler().of(signal))).collect()
        };
        put("scaler.centre".to_owned(), vec![12], &column(|pair| pair.centre));
        put("scaler.scale".to_owned(), vec![12], &column(|pair| pair.scale));
        let views = tensors.iter().map(|(name, shape, bytes)| {
            let view = TensorView::new(Dtype::F64, shape.clone(), bytes)
                .expect("the bytes were made for this shape");
            (name.as_str(), view)
        });
        safetensors::serialize(views, Some(HashMap::from([(ENTRY.to_owned(), json)])))
            .expect("names are distinct and shapes fit their bytes")
    }

    /// The model in the bytes of a safetensors file.
    ///
    /// # Errors
    /// [`ModelError::WeightFile`] if the container or its header is not readable, otherwise the
    /// error that names the tensor: missing, of another shape or type, not finite, or unknown.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, ModelError> {
        let file = ModelError::WeightFile;
        let unreadable = |error: SafeTensorError| file(error.to_string());
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(unreadable)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(unreadable)?;
        let json = metadata
            .metadata()
            .as_ref()
            .and_then(|entries| entries.get(ENTRY))
            .ok_or_else(|| file(format!("no '{ENTRY}' in the metadata")))?;
        let header: Header =
            serde_json::from_str(json).map_err(|error| file(format!("metadata: {error}")))?;
        if header.format != FORMAT {
            return Err(file(format!("format '{}', expected '{FORMAT}'", header.format)));
        }
        if header.states != Compartment::ALL.map(Compartment::name) {
            return Err(file(format!("order of states {:?}", header.states)));
        }
        let wiring = read_wiring(&header)?;
        let networks = PerCompartment::try_from_fn(|compartment| {
            let hidden = header.widths.get(compartment.name());
            let hidden = *hidden.ok_or_else(|| file(format!("no width of {compartment}")))?;
            let inputs = wiring.inputs(compartment).len();
            let take = |part: &str, shape: &[usize]| {
                take(&tensors, &format!("{compartment}.{part}"), shape)
            };
            HiddenLayerNetwork::new(
                inputs,
                take("hidden.weight", &[hidden, inputs])?,
                take("hidden.bias", &[hidden])?,
                take("output.weight", &[hidden])?,
                take("output.bias", &[1])?[0],
            )
        })?;
        let scaler = read_scaler(&tensors, &header)?;
        // Four of each network and two of the scaler.
        let expected_tensors = 4 * Compartment::ALL.len() + 2;
        if tensors.len() != expected_tensors {
            let problem = format!("{} tensors, expected {expected_tensors}", tensors.len());
            return Err(file(problem));
        }
        Self::new(wiring, networks, scaler, header.glucose_clamp, header.card)
    }
}

fn signal_named(name: &str) -> Result<Signal, ModelError> {
    let unknown = || ModelError::WeightFile(format!("unknown signal '{name}'"));
    Signal::from_name(name).ok_or_else(unknown)
}

fn read_wiring(header: &Header) -> Result<Wiring, ModelError> {
    Wiring::new(PerCompartment::try_from_fn(|compartment| {
        let missing = || ModelError::WeightFile(format!("no wiring of {compartment}"));
        let names = header.wiring.get(compartment.name()).ok_or_else(missing)?;
        names.iter().map(|name| signal_named(name)).collect::<Result<Vec<_>, _>>()
    })?)
}

fn read_scaler(tensors: &SafeTensors<'_>, header: &Header) -> Result<Scaler, ModelError> {
    let count = header.signals.len();
    let centres = take(tensors, "scaler.centre", &[count])?;
    let scales = take(tensors, "scaler.scale", &[count])?;
    let mut pairs = HashMap::new();
    for ((name, centre), scale) in header.signals.iter().zip(centres).zip(scales) {
        pairs.insert(signal_named(name)?, CentreAndScale { centre, scale });
    }
    Scaler::try_from_fn(|signal| {
        let missing = || ModelError::WeightFile(format!("no scaler of {signal}"));
        pairs.get(&signal).copied().ok_or_else(missing)
    })
}

/// The values of a tensor after checking its type, shape and finiteness.
fn take(tensors: &SafeTensors<'_>, name: &str, shape: &[usize]) -> Result<Vec<f64>, ModelError> {
    let tensor = tensors.tensor(name).map_err(|_| ModelError::MissingTensor(name.to_owned()))?;
    if tensor.dtype() != Dtype::F64 {
        let problem = "its numbers are not 64-bit floating point";
        return Err(ModelError::BadTensor { tensor: name.to_owned(), problem });
    }
    shaped(name, shape, tensor.shape())?;
    floats(name, tensor.data(), 8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::initial_networks;
    use crate::widths::Widths;

    /// Name, shape and bytes of a tensor.
    type Part = (String, Vec<usize>, Vec<u8>);
    type Parts = Vec<Part>;

    fn example() -> PopulationModel {
        let wiring = Wiring::paper();
        let networks = initial_networks(&wiring, &Widths::quick(), 1.0, 5);
        let pair = |i: usize| CentreAndScale { centre: 0.1 * i as f64, scale: 1.0 + i as f64 };
        let states = PerCompartment::from_fn(|c| pair(c as usize));
        let scaler = Scaler::new(states, pair(10), pair(11)).expect("positive");
        let card = ModelCard {
            origin: "a test \"with\" quotes".to_owned(),
            version: "0".to_owned(),
            training_data_sha256: Some("ab".repeat(32)),
            training: Some(serde_json::json!({"seed": 5})),
        };
        PopulationModel::new(wiring, networks, scaler, GlucoseClamp::Off, card).expect("fits")
    }

    /// The example's bytes with `edit` applied to tensors and header before writing.
    fn edited(edit: impl Fn(&mut Parts, &mut String)) -> Vec<u8> {
        let bytes = example().to_safetensors();
        let (_, metadata) = SafeTensors::read_metadata(&bytes).expect("ours");
        let mut json = metadata.metadata().as_ref().expect("present")[ENTRY].clone();
        let mut tensors: Vec<_> = SafeTensors::deserialize(&bytes)
            .expect("ours")
            .iter()
            .map(|(name, view)| (name.to_owned(), view.shape().to_vec(), view.data().to_vec()))
            .collect();
        edit(&mut tensors, &mut json);
        let views = tensors.iter().map(|(name, shape, data)| {
            (name.as_str(), TensorView::new(Dtype::F64, shape.clone(), data).expect("fits"))
        });
        safetensors::serialize(views, Some(HashMap::from([(ENTRY.to_owned(), json)])))
            .expect("well formed")
    }

    #[test]
    fn a_model_survives_the_file_and_gives_the_same_bytes_again() {
        let model = example();
        let bytes = model.to_safetensors();
        let back = PopulationModel::from_safetensors(&bytes).expect("just written");
        assert_eq!(back, model);
        for _ in 0..8 {
            assert_eq!(back.to_safetensors(), bytes);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        type Edit = fn(&mut Parts, &mut String);
        fn tensor<'a>(tensors: &'a mut [Part], name: &str) -> &'a mut Part {
            tensors.iter_mut().find(|(n, _, _)| n == name).expect("present")
        }
        let cases: [(Edit, &str); 9] = [
            (
                |t, _| tensor(t, "X2.hidden.weight").1.reverse(),
                "tensor X2.hidden.weight: expected shape [12, 2], found [2, 12]",
            ),
            (
                |t, _| {
                    let (_, shape, data) = tensor(t, "I.output.weight");
                    shape[0] -= 1;
                    data.truncate(shape[0] * 8);
                },
                "tensor I.output.weight: expected shape [12], found [11]",
            ),
            (
                |t, _| {
                    tensor(t, "S1.hidden.bias").2[16..24].copy_from_slice(&f64::NAN.to_le_bytes())
                },
                "tensor S1.hidden.bias: entry 2 is not a finite number",
            ),
            (|t, _| t.retain(|(n, _, _)| n != "C1.output.bias"), "tensor C1.output.bias: not in"),
            (|t, _| t.push(("extra".to_owned(), vec![1], vec![0; 8])), "43 tensors, expected 42"),
            (
                |t, _| tensor(t, "scaler.scale").2[72..80].fill(0),
                "scaler of C2: centre 0.9, scale 0",
            ),
            (|_, json| *json = json.replace("population/1", "population/9"), "population/9"),
            (|_, json| *json = json.replace("u_insulin", "u_insulinn"), "u_insulinn"),
            (|_, json| *json = json.replace("\"widths\"", "\"width\""), "widths"),
        ];
        for (edit, expected) in cases {
            let error = PopulationModel::from_safetensors(&edited(edit)).expect_err(expected);
            assert!(error.to_string().contains(expected), "{error} lacks {expected}");
        }
    }

    #[test]
    fn damaged_bytes_give_errors() {
        let bytes = example().to_safetensors();
        for length in (0..bytes.len()).step_by(37) {
            assert!(PopulationModel::from_safetensors(&bytes[..length]).is_err(), "{length}");
        }
        for position in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[position] ^= 0x55;
            // Most are errors; a weight may also come out as another number. None may panic.
            if let Ok(model) = PopulationModel::from_safetensors(&damaged) {
                assert!(model != example(), "byte {position} has no meaning");
            }
        }
    }
}
