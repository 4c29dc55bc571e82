//! The ensemble, its file, and its answers.

use std::collections::{BTreeMap, HashMap};

use candle_core::{DType, Device, Tensor};
use contract::posterior::PosteriorCard;
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};

use crate::error::PosteriorError;
use crate::network::GAP_UNIT;
use crate::network::{Constants, Network, Shape};
use crate::reading::Reading;
use crate::sets::{Lacking, Sets};
use crate::table::Table;

/// Key of the description in a file's metadata.
const DESCRIPTION: &str = "posterior";

/// Probabilities of what a cohort lacks.
#[derive(Debug, Clone)]
pub struct Posterior {
    described: Described,
    sets: Sets,
    constants: Constants,
    members: Vec<Network>,
}

/// Everything but the weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Described {
    effects: Vec<String>,
    ports: Vec<String>,
    cells: Vec<String>,
    hidden: usize,
    reading: Reading,
    card: PosteriorCard,
}

impl Described {
    fn shape(&self) -> Shape {
        Shape {
            statistics: self.reading.names.len(),
            hidden: self.hidden,
            odds: self.effects.len() + 1,
            ports: self.ports.len(),
            cells: self.cells.len(),
        }
    }
}

/// What a posterior says of a cohort.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Probability that nothing is missing.
    pub nothing: f64,
    /// Probability that something is missing that is none of the effects.
    pub unknown: f64,
    /// Probability of each effect, alone or beside another.
    pub effects: Vec<(String, f64)>,
    /// Probabilities of all sets of one or two effects, most probable first.
    pub sets: Vec<(Vec<String>, f64)>,
    /// Probability of each port, given that something is missing; most probable first.
    pub ports: Vec<(String, f64)>,
    /// What is expected of the gap, by cell.
    pub gaps: BTreeMap<String, Gap>,
}

/// The gap that is expected in a cell, mg/dL.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Its mean.
    pub mean: f64,
    /// The mean of its size.
    pub size: f64,
}

impl Answer {
    /// Probability of everything: 1 but for rounding.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.nothing + self.unknown + self.sets.iter().map(|(_, p)| p).sum::<f64>()
    }
}

impl Posterior {
    pub(crate) fn new(
        effects: Vec<String>,
        ports: Vec<String>,
        cells: Vec<String>,
        reading: Reading,
        members: Vec<Network>,
        card: PosteriorCard,
    ) -> Result<Self, PosteriorError> {
        let hidden = members.first().and_then(|m| m.weights.first()).map_or(0, |w| w.dims()[1]);
        let described = Described { effects, ports, cells, hidden, reading, card };
        Self::described(described, members)
    }

    fn described(described: Described, members: Vec<Network>) -> Result<Self, PosteriorError> {
        let sets = Sets::of(described.effects.len());
        let constants = Constants::of(&sets)?;
        Ok(Self { described, sets, constants, members })
    }

    /// What it saw.
    #[must_use]
    pub fn card(&self) -> &PosteriorCard {
        &self.described.card
    }

    /// The effects that it knows.
    #[must_use]
    pub fn effects(&self) -> &[String] {
        &self.described.effects
    }

    /// What it says of the statistics of one cohort.
    ///
    /// # Errors
    /// [`PosteriorError::Tensor`].
    pub fn answer(&self, statistics: &BTreeMap<String, f64>) -> Result<Answer, PosteriorError> {
        let read = self.described.reading.of_cohort(statistics);
        let mut answers = self.answers_to(read, 1)?;
        answers.pop().ok_or_else(|| PosteriorError::File("it has no members".to_owned()))
    }

    /// What it says of every row of a table.
    ///
    /// # Errors
    /// [`PosteriorError::Tensor`].
    pub fn answers(&self, table: &Table) -> Result<Vec<Answer>, PosteriorError> {
        self.answers_to(self.described.reading.of_table(table), table.len())
    }

    fn answers_to(&self, read: Vec<f32>, rows: usize) -> Result<Vec<Answer>, PosteriorError> {
        let Described { effects, ports, cells, .. } = &self.described;
        let read = Tensor::from_vec(read, (rows, self.described.shape().statistics), &Device::Cpu)?;
        let count = self.members.len() as f64;
        let mut sums = [
            Tensor::zeros((rows, self.sets.all().len()), DType::F32, &Device::Cpu)?,
            Tensor::zeros((rows, ports.len()), DType::F32, &Device::Cpu)?,
            Tensor::zeros((rows, 2 * cells.len()), DType::F32, &Device::Cpu)?,
        ];
        for member in &self.members {
            let found = member.answer(&read, &self.constants, None)?;
            for (sum, own) in sums.iter_mut().zip([found.sets, found.ports, found.gaps]) {
                *sum = (&*sum + (own / count)?)?;
            }
        }
        let [sets, by_port, gaps] = sums;
        // Members are joined by the mean of their logarithms.
        let sets = candle_nn::ops::softmax(&sets, 1)?.to_vec2::<f32>()?;
        let by_port = candle_nn::ops::softmax(&by_port, 1)?.to_vec2::<f32>()?;
        let gaps = gaps.to_vec2::<f32>()?;
        let answers = sets.iter().zip(&by_port).zip(&gaps);
        Ok(answers
            .map(|((sets, by_port), gaps)| self.in_words(effects, sets, by_port, gaps))
            .collect())
    }

    fn in_words(&self, effects: &[String], sets: &[f32], ports: &[f32], gaps: &[f32]) -> Answer {
        let all = || self.sets.all().iter().zip(sets.iter().map(|p| f64::from(*p)));
        let of = |wanted: &dyn Fn(Lacking) -> bool| -> f64 {
            all().filter(|(set, _)| wanted(**set)).map(|(_, p)| p).sum()
        };
        let named = |set: &Lacking| match *set {
            Lacking::Nothing | Lacking::Unknown => None,
            Lacking::One(one) => Some(vec![effects[one].clone()]),
            Lacking::Two(one, other) => Some(vec![effects[one].clone(), effects[other].clone()]),
        };
        let mut by_set: Vec<(Vec<String>, f64)> =
            all().filter_map(|(set, p)| Some((named(set)?, p))).collect();
        by_set.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut by_port: Vec<(String, f64)> = self
            .described
            .ports
            .iter()
            .zip(ports)
            .map(|(port, p)| (port.clone(), f64::from(*p)))
            .collect();
        by_port.sort_by(|a, b| b.1.total_cmp(&a.1));
        let cells = self.described.cells.iter().enumerate();
        let count = self.described.cells.len();
        Answer {
            nothing: of(&|set| set == Lacking::Nothing),
            unknown: of(&|set| set == Lacking::Unknown),
            effects: effects
                .iter()
                .enumerate()
                .map(|(index, name)| (name.clone(), of(&|set| set.has(index))))
                .collect(),
            sets: by_set,
            ports: by_port,
            gaps: cells
                .map(|(index, cell)| {
                    let mean = GAP_UNIT * f64::from(gaps[index]);
                    let size = GAP_UNIT * f64::from(gaps[count + index]);
                    (cell.clone(), Gap { mean, size: size.max(mean.abs()) })
                })
                .collect(),
        }
    }

    /// The file: weights in half precision, which rounds probabilities by less than members differ.
    ///
    /// # Errors
    /// [`PosteriorError::Tensor`] and [`PosteriorError::File`].
    pub fn bytes(&self) -> Result<Vec<u8>, PosteriorError> {
        let shape = self.described.shape().weights();
        let mut tensors: Vec<(String, Tensor)> = Vec::new();
        for (index, member) in self.members.iter().enumerate() {
            for ((name, _), weights) in shape.iter().zip(&member.weights) {
                tensors.push((format!("{index}.{name}"), weights.to_dtype(DType::F16)?));
            }
        }
        let description = serde_json::to_string(&self.described)
            .map_err(|error| PosteriorError::File(error.to_string()))?;
        let metadata = HashMap::from([(DESCRIPTION.to_owned(), description)]);
        safetensors::serialize(tensors, Some(metadata))
            .map_err(|error| PosteriorError::File(error.to_string()))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`PosteriorError::File`] for bytes that are no file of ours.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PosteriorError> {
        let wrong = |error: &dyn std::fmt::Display| PosteriorError::File(error.to_string());
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| wrong(&e))?;
        let description = metadata.metadata().as_ref().and_then(|all| all.get(DESCRIPTION));
        let description = description
            .ok_or_else(|| PosteriorError::File("its metadata describe no posterior".to_owned()))?;
        let described: Described = serde_json::from_str(description).map_err(|e| wrong(&e))?;
        let tensors = candle_core::safetensors::load_buffer(bytes, &Device::Cpu)?;
        let members = (0..described.card.members)
            .map(|index| {
                let weights = described.shape().weights().into_iter().map(|(name, shape)| {
                    let key = format!("{index}.{name}");
                    let found = tensors.get(&key).filter(|tensor| tensor.dims() == shape);
                    let found = found.ok_or_else(|| {
                        PosteriorError::File(format!("`{key}` is absent or of another shape"))
                    })?;
                    Ok(found.to_dtype(DType::F32)?)
                });
                Ok(Network { weights: weights.collect::<Result<_, PosteriorError>>()? })
            })
            .collect::<Result<Vec<Network>, PosteriorError>>()?;
        if members.is_empty() {
            return Err(PosteriorError::File("it has no members".to_owned()));
        }
        Self::described(described, members)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_are_no_posterior_are_refused_in_words() {
        for bytes in [&b""[..], b"nonsense", b"\x02\0\0\0\0\0\0\0{}"] {
            let error = Posterior::from_bytes(bytes).expect_err("no posterior").to_string();
            assert!(error.starts_with("the posterior cannot be read"), "{error}");
        }
    }
}
