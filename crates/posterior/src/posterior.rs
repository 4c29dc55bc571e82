//! The ensemble, its file, and its answers.

use std::collections::{BTreeMap, HashMap};

use candle_core::{DType, Device, Tensor};
use contract::posterior::PosteriorCard;
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};

use crate::any_number::AnyNumber;
use crate::error::PosteriorError;
use crate::joint::Joint;
use crate::network::{GAP_UNIT, Network, Shape};
use crate::reading::Reading;
use crate::regression::Regression;

/// Key of the description in a file's metadata.
const DESCRIPTION: &str = "posterior";
/// How many sets of effects an answer holds.
const SETS: usize = 5;
/// First part of the names of the regression's weights.
const REGRESSION: &str = "regression";

/// Probabilities of what a cohort lacks.
#[derive(Debug, Clone)]
pub struct Posterior {
    pub(crate) described: Described,
    pub(crate) networks: Vec<Network>,
    pub(crate) regression: Regression,
}

/// Everything but the weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Described {
    pub(crate) effects: Vec<String>,
    /// Kinds outside the library, by the names that hands give them.
    pub(crate) outside: Vec<String>,
    pub(crate) ports: Vec<String>,
    pub(crate) cells: Vec<String>,
    pub(crate) hidden: usize,
    pub(crate) reading: Reading,
    /// What the regressions read.
    pub(crate) regression: Reading,
    pub(crate) card: PosteriorCard,
}

impl Described {
    pub(crate) fn shape(&self) -> Shape {
        Shape {
            statistics: self.reading.names.len(),
            hidden: self.hidden,
            odds: self.effects.len() + self.outside.len(),
            ports: self.ports.len(),
            cells: self.cells.len(),
        }
    }

    /// Names and shapes of the weights in a file: those of each network, and then those of the regressions.
    fn weights(&self) -> impl Iterator<Item = (String, Vec<usize>)> {
        let shape = self.shape();
        let networks = (0..self.card.members).flat_map(move |member| {
            shape.weights().map(|(name, shape)| (format!("{member}.{name}"), shape))
        });
        let regression = Regression::shapes(self.regression.names.len(), shape.odds);
        networks.chain(regression.map(|(name, shape)| (format!("{REGRESSION}.{name}"), shape)))
    }
}

/// What a posterior says of a cohort.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Probability that nothing is missing.
    pub nothing: f64,
    /// Probability that something is missing that is none of the effects.
    pub unknown: f64,
    /// Probability of each effect, alone or beside others.
    pub effects: Vec<(String, f64)>,
    /// The most probable sets of effects with their probabilities, most probable first.
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

impl Posterior {
    /// What it saw.
    #[must_use]
    pub fn card(&self) -> &PosteriorCard {
        &self.described.card
    }

    /// The same, judged on hands that it never saw: the offset of the log odds of "nothing", and the probability from
    /// which on something is said to be missing. Training alone knows neither, so that what was just trained has no
    /// offset and says nothing.
    #[must_use]
    pub fn judged(mut self, offset: f64, speaks_from: f64) -> Self {
        let card = &mut self.described.card;
        (card.offset, card.speaks_from) = (offset, speaks_from);
        self
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
        let shape = self.described.shape();
        let tensor = |reading: &Reading| {
            let read = reading.of_cohort(statistics);
            Tensor::from_vec(read, (1, reading.names.len()), &Device::Cpu)
        };
        // What networks read, and what the regressions read.
        let read = tensor(&self.described.reading)?;
        let regressed = tensor(&self.described.regression)?;
        let zeros = |width: usize| Tensor::zeros((1, width), DType::F32, &Device::Cpu);
        let (mut odds, mut by_port) = (zeros(shape.odds)?, zeros(shape.ports)?);
        let mut gaps = zeros(2 * shape.cells)?;
        let mut pair = Tensor::zeros(1, DType::F32, &Device::Cpu)?;
        for network in &self.networks {
            let found = network.answer(&read, None)?;
            odds = (odds + found.odds)?;
            pair = (pair + network.pair())?;
            by_port = (by_port + found.ports)?;
            gaps = (gaps + found.gaps)?;
        }
        // Networks are joined by the mean of their logarithms, and so are networks and regressions.
        let networks = self.networks.len() as f64;
        let odds = (((odds / networks)? + self.regression.odds(&regressed)?)? / 2.0)?;
        let pair = (((pair / networks)? + self.regression.pair())? / 2.0)?;
        let pair = f64::from(pair.to_vec1::<f32>()?[0]);
        let numbers = |tensor: Tensor| tensor.flatten_all()?.to_vec1::<f32>();
        let by_port = numbers(candle_nn::ops::softmax(&(by_port / networks)?, 1)?)?;
        let gaps = numbers((gaps / networks)?)?;
        // What the offset adds to "nothing" it takes from every set alike, of one effect or of more.
        let offset = self.described.card.offset;
        let odds: Vec<f64> =
            numbers(odds)?.into_iter().map(|odds| f64::from(odds) - offset).collect();
        Ok(self.in_words(&odds, pair + offset, &by_port, &gaps))
    }

    fn in_words(&self, odds: &[f64], pair: f64, ports: &[f32], gaps: &[f32]) -> Answer {
        let Described { effects, cells, .. } = &self.described;
        let joint = Joint::of(odds, effects.len(), pair);
        let unknown = joint.unknown();
        let any = AnyNumber::of(&odds[..effects.len()], pair);
        let any_is = (1.0 - joint.nothing - unknown).max(0.0);
        let each = effects.iter().cloned().zip(any.each());
        let named = |(set, p): (Vec<usize>, f64)| {
            (set.into_iter().map(|index| effects[index].clone()).collect(), any_is * p)
        };
        let mut by_port: Vec<(String, f64)> = self
            .described
            .ports
            .iter()
            .zip(ports)
            .map(|(port, p)| (port.clone(), f64::from(*p)))
            .collect();
        by_port.sort_by(|a, b| b.1.total_cmp(&a.1));
        let (means, sizes) = gaps.split_at(cells.len());
        Answer {
            nothing: joint.nothing,
            unknown,
            effects: each.map(|(effect, p)| (effect, any_is * p)).collect(),
            sets: any.sets(SETS).into_iter().map(named).collect(),
            ports: by_port,
            gaps: cells
                .iter()
                .zip(means.iter().zip(sizes))
                .map(|(cell, (mean, size))| {
                    let (mean, size) = (GAP_UNIT * f64::from(*mean), GAP_UNIT * f64::from(*size));
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
        let networks = self.networks.iter().flat_map(|network| &network.weights);
        let weights = networks.chain(&self.regression.weights);
        let named = self.described.weights().zip(weights);
        let tensors = named
            .map(|((name, _), weights)| Ok((name, weights.to_dtype(DType::F16)?)))
            .collect::<Result<Vec<(String, Tensor)>, PosteriorError>>()?;
        let description = serde_json::to_string(&self.described).map_err(file)?;
        let metadata = HashMap::from([(DESCRIPTION.to_owned(), description)]);
        safetensors::serialize(tensors, Some(metadata)).map_err(file)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`PosteriorError::File`] for bytes that are no file of ours.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PosteriorError> {
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(file)?;
        let description = metadata.metadata().as_ref().and_then(|all| all.get(DESCRIPTION));
        let description = description.ok_or_else(|| file("its metadata describe no posterior"))?;
        let described: Described = serde_json::from_str(description).map_err(file)?;
        if !(0.0..=1.0).contains(&described.card.speaks_from) {
            return Err(file("`speaks_from` is no probability"));
        }
        if !described.card.offset.is_finite() {
            return Err(file("`offset` is not finite"));
        }
        if let Some(fault) = described.reading.fault().or(described.regression.fault()) {
            return Err(file(fault));
        }
        let tensors = candle_core::safetensors::load_buffer(bytes, &Device::Cpu)?;
        let read = |(name, shape): (String, Vec<usize>)| {
            let found = tensors.get(&name).filter(|tensor| tensor.dims() == shape);
            let found =
                found.ok_or_else(|| file(format!("`{name}` is absent or of another shape")))?;
            let found = found.to_dtype(DType::F32)?;
            if found.flatten_all()?.to_vec1::<f32>()?.iter().any(|weight| !weight.is_finite()) {
                return Err(file(format!("`{name}` holds a weight that is not finite")));
            }
            Ok(found)
        };
        let mut weights =
            described.weights().map(read).collect::<Result<Vec<Tensor>, PosteriorError>>()?;
        let of_network = described.shape().weights().len();
        let of_regression = weights.split_off(described.card.members * of_network);
        let regression = Regression { weights: of_regression };
        let networks: Vec<Network> =
            weights.chunks(of_network).map(|own| Network { weights: own.to_vec() }).collect();
        if networks.is_empty() {
            return Err(file("it has no members"));
        }
        Ok(Self { described, networks, regression })
    }
}

/// An error of a file.
fn file(why: impl std::fmt::Display) -> PosteriorError {
    PosteriorError::File(why.to_string())
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
