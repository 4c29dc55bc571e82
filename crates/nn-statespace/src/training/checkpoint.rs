//! Everything that a training run needs to go on, as the bytes of a safetensors file.
//!
//! Counters and configuration stand in the metadata as JSON, numbers of the run as tensors, so that
//! all of them read back to the last bit.

use std::collections::HashMap;
use std::fmt::Display;

use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};

use super::adam::Adam;
use super::config::TrainingConfig;
use super::report::EpochReport;
use super::validation::GroupErrors;
use crate::error::ModelError;

/// Entry of the metadata, and what it says first.
const ENTRY: &str = "training_checkpoint";
const FORMAT: &str = "training_checkpoint/1";
/// Numbers of an epoch's report in the tensor `epochs`.
const REPORT: usize = 11;

/// A training run between two updates.
#[derive(Debug, Clone)]
pub(super) struct Checkpoint {
    pub(super) header: Header,
    /// Sum over the epoch's batches so far of the loss times the windows.
    pub(super) weighted_loss: f64,
    pub(super) parameters: Vec<f32>,
    pub(super) adam: Adam,
    pub(super) epochs: Vec<EpochReport>,
    pub(super) kept: Option<Kept>,
}

/// The weights that would be returned if the run ended here.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kept {
    pub(super) epoch: usize,
    /// Its balanced error, mg/dL.
    pub(super) error: f64,
    pub(super) parameters: Vec<f32>,
}

/// What is read before the numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    pub(super) format: String,
    pub(super) config: TrainingConfig,
    /// Hidden units in the order of [`physiology::Compartment::ALL`].
    pub(super) widths: Vec<usize>,
    /// Fingerprint of training and validation windows.
    pub(super) data: String,
    /// Batches of the present epoch that are done.
    pub(super) batches: usize,
    pub(super) updates: u32,
    pub(super) kept_epoch: Option<usize>,
}

impl Header {
    /// The header of a run at its start.
    pub(super) fn new(config: &TrainingConfig, widths: Vec<usize>, data: String) -> Self {
        Self {
            format: FORMAT.to_owned(),
            config: config.clone(),
            widths,
            data,
            batches: 0,
            updates: 0,
            kept_epoch: None,
        }
    }
}

impl Checkpoint {
    /// The bytes of the file.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let singles = |all: &[f32]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let doubles = |all: &[f64]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let (kept_error, kept) =
            self.kept.as_ref().map_or((f64::NAN, [].as_slice()), |k| (k.error, &k.parameters));
        let reports: Vec<f64> = self.epochs.iter().flat_map(report_numbers).collect();
        let (m, v) = (&self.adam.first_moment, &self.adam.second_moment);
        let parts = [
            ("parameters", Dtype::F32, self.parameters.len(), singles(&self.parameters)),
            ("first_moment", Dtype::F32, m.len(), singles(m)),
            ("second_moment", Dtype::F32, v.len(), singles(v)),
            ("kept", Dtype::F32, kept.len(), singles(kept)),
            ("loss_and_kept_error", Dtype::F64, 2, doubles(&[self.weighted_loss, kept_error])),
            ("epochs", Dtype::F64, reports.len(), doubles(&reports)),
        ];
        let views = parts.iter().map(|(name, dtype, len, bytes)| {
            (*name, TensorView::new(*dtype, vec![*len], bytes).expect("as long as it says"))
        });
        let json = serde_json::to_string(&self.header).expect("plain data");
        safetensors::serialize(views, Some(HashMap::from([(ENTRY.to_owned(), json)])))
            .expect("names are different")
    }

    /// The run of a file.
    ///
    /// # Errors
    /// [`ModelError::Training`] if it is not one that [`Self::to_bytes`] wrote.
    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(damaged)?;
        let json = metadata.metadata().as_ref().and_then(|entries| entries.get(ENTRY));
        let json = json.ok_or_else(|| damaged("it is no checkpoint"))?;
        let header: Header = serde_json::from_str(json).map_err(damaged)?;
        if header.format != FORMAT {
            return Err(damaged("it has another format"));
        }
        let data = |name: &str, dtype: Dtype| {
            let tensor = tensors.tensor(name).map_err(damaged)?;
            if tensor.dtype() != dtype {
                return Err(damaged("a tensor has another type"));
            }
            Ok(tensor.data())
        };
        let singles = |name: &str| -> Result<Vec<f32>, ModelError> {
            let bytes = data(name, Dtype::F32)?;
            Ok(bytes.as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four)).collect())
        };
        let doubles = |name: &str| -> Result<Vec<f64>, ModelError> {
            let bytes = data(name, Dtype::F64)?;
            Ok(bytes.as_chunks::<8>().0.iter().map(|eight| f64::from_le_bytes(*eight)).collect())
        };
        let parameters = singles("parameters")?;
        let adam =
            Adam::resumed(singles("first_moment")?, singles("second_moment")?, header.updates);
        let [weighted_loss, error] = doubles("loss_and_kept_error")?[..] else {
            return Err(damaged("the loss is missing"));
        };
        let kept = singles("kept")?;
        let lengths = [adam.first_moment.len(), adam.second_moment.len()];
        let kept_len = header.kept_epoch.map_or(0, |_| parameters.len());
        if lengths != [parameters.len(); 2] || kept.len() != kept_len {
            return Err(damaged("tensors differ in length"));
        }
        let kept = header.kept_epoch.map(|epoch| Kept { epoch, error, parameters: kept });
        let reports = doubles("epochs")?;
        let (reports, rest) = reports.as_chunks::<REPORT>();
        if !rest.is_empty() {
            return Err(damaged("a report is incomplete"));
        }
        let epochs = reports.iter().map(report).collect();
        Ok(Self { header, weighted_loss, parameters, adam, epochs, kept })
    }
}

fn damaged(what: impl Display) -> ModelError {
    ModelError::Training(format!("the checkpoint cannot be read: {what}; delete it to begin anew"))
}

/// A report as numbers; an error is absent where its group has no windows.
fn report_numbers(report: &EpochReport) -> [f64; REPORT] {
    let [r0, r1, r2] = report.validation.rmse_mg_dl.map(|rmse| rmse.unwrap_or(0.0));
    let [w0, w1, w2] = report.validation.windows.map(|windows| windows as f64);
    let (epoch, stage, steps) = (report.epoch as f64, report.stage as f64, report.steps as f64);
    let (rate, loss) = (report.learning_rate, report.training_loss);
    [epoch, stage, steps, rate, loss, r0, r1, r2, w0, w1, w2]
}

fn report(numbers: &[f64; REPORT]) -> EpochReport {
    let [epoch, stage, steps, learning_rate, training_loss, r0, r1, r2, w0, w1, w2] = *numbers;
    let windows = [w0 as usize, w1 as usize, w2 as usize];
    let rmse = [r0, r1, r2];
    let rmse_mg_dl = std::array::from_fn(|group| (windows[group] > 0).then_some(rmse[group]));
    EpochReport {
        epoch: epoch as usize,
        stage: stage as usize,
        steps: steps as usize,
        learning_rate,
        training_loss,
        validation: GroupErrors { rmse_mg_dl, windows },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Checkpoint {
        let mut header = Header::new(&TrainingConfig::quick(1), vec![3; 10], "ab".to_owned());
        header.updates = 7;
        header.kept_epoch = Some(1);
        let validation =
            GroupErrors { rmse_mg_dl: [Some(1.5), None, Some(0.1)], windows: [3, 0, 1] };
        Checkpoint {
            header,
            weighted_loss: 0.1 + 0.2,
            parameters: vec![1.0, f32::MIN_POSITIVE, -0.0],
            adam: Adam::resumed(vec![0.1; 3], vec![0.2; 3], 7),
            epochs: vec![EpochReport {
                epoch: 0,
                stage: 0,
                steps: 6,
                learning_rate: 1e-2,
                training_loss: 0.3,
                validation,
            }],
            kept: Some(Kept { epoch: 1, error: 0.7, parameters: vec![0.5; 3] }),
        }
    }

    #[test]
    fn a_run_survives_the_file() {
        let checkpoint = example();
        let bytes = checkpoint.to_bytes();
        let back = Checkpoint::from_bytes(&bytes).expect("just written");
        assert_eq!(back.header, checkpoint.header);
        assert_eq!(back.adam, checkpoint.adam);
        assert_eq!(back.epochs, checkpoint.epochs);
        assert_eq!(back.kept, checkpoint.kept);
        assert_eq!(back.to_bytes(), bytes);
    }

    #[test]
    fn damaged_bytes_give_errors() {
        let bytes = example().to_bytes();
        for length in (0..bytes.len()).step_by(7) {
            assert!(Checkpoint::from_bytes(&bytes[..length]).is_err(), "{length}");
        }
        let mut other = example();
        other.adam.second_moment.pop();
        other.parameters.pop();
        assert!(Checkpoint::from_bytes(&other.to_bytes()).is_err());
    }
}
