//! What a report is made from: any subset of the pipeline's JSON outputs.

use std::io::Read;

use contract::blind_check::Seal;
use contract::{
    BlindCheck, Conformance, DataInUse, Diagnosis, ExampleDay, GlucoseByPerson, GlucoseProfile,
    ImportReport, Manifest, OutcomesTable, StatedTruth, Training, TwinsTable, WhatIf,
};

use crate::ReportError;

/// One JSON output of the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// How a stage was run.
    Manifest,
    /// Glucose outcomes and forecast errors of every method.
    Outcomes,
    /// Proofs of the network's monotonicity properties.
    Conformance,
    /// Where the gap lies, which effect explains it, and how far it shrinks.
    Diagnosis,
    /// Training of the population network.
    Training,
    /// Training of the twins, by person.
    Twins,
    /// What was found and done on import.
    ImportReport,
    /// Days of one person, measured and simulated.
    ExampleDay,
    /// What twins predict for meals under other doses.
    WhatIf,
    /// The same for twins whose networks keep physiology's signs.
    WhatIfConstrained,
    /// Ambulatory glucose profile, measured and simulated.
    Agp,
    /// Answers of the diagnosis, scored against labels that it could not see.
    BlindCheck,
    /// Hashes of those labels.
    Seal,
    /// The people, days and channels in use, and what the checks of the data said.
    DataInUse,
    /// Each person's measured glucose.
    GlucoseByPerson,
    /// What the makers of the cohort state.
    Truth,
}

impl Part {
    /// Every part.
    pub const ALL: [Self; 16] = [
        Self::Manifest,
        Self::Outcomes,
        Self::Conformance,
        Self::Diagnosis,
        Self::Training,
        Self::Twins,
        Self::ImportReport,
        Self::ExampleDay,
        Self::WhatIf,
        Self::WhatIfConstrained,
        Self::Agp,
        Self::BlindCheck,
        Self::Seal,
        Self::DataInUse,
        Self::GlucoseByPerson,
        Self::Truth,
    ];

    /// Name of the file that holds the part in an output folder.
    #[must_use]
    pub const fn file_name(self) -> &'static str {
        match self {
            Self::Manifest => "manifest.json",
            Self::Outcomes => "outcomes.json",
            Self::Conformance => "conformance.json",
            Self::Diagnosis => "diagnosis.json",
            Self::Training => "training.json",
            Self::Twins => "twins.json",
            Self::ImportReport => "import_report.json",
            Self::ExampleDay => "example_day.json",
            Self::WhatIf => "what_if.json",
            Self::WhatIfConstrained => "what_if_constrained.json",
            Self::Agp => "agp.json",
            Self::BlindCheck => "blind_check.json",
            Self::Seal => "seal.json",
            Self::DataInUse => "data_in_use.json",
            Self::GlucoseByPerson => "glucose_by_person.json",
            Self::Truth => "truth.json",
        }
    }
}

/// The available parts. A missing part becomes a section that says so.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    /// Manifests of the stages, in the order in which they were read.
    pub manifests: Vec<Manifest>,
    /// From `outcomes.json`.
    pub outcomes: Option<OutcomesTable>,
    /// From `conformance.json`.
    pub conformance: Option<Conformance>,
    /// From `diagnosis.json`.
    pub diagnosis: Option<Diagnosis>,
    /// From `training.json`.
    pub training: Option<Training>,
    /// From `twins.json`.
    pub twins: Option<TwinsTable>,
    /// From `import_report.json`.
    pub import_report: Option<ImportReport>,
    /// From `example_day.json`.
    pub example_day: Option<ExampleDay>,
    /// From `what_if.json`.
    pub what_if: Option<WhatIf>,
    /// From `what_if_constrained.json`.
    pub what_if_constrained: Option<WhatIf>,
    /// From `agp.json`.
    pub agp: Option<GlucoseProfile>,
    /// From `blind_check.json`.
    pub blind_check: Option<BlindCheck>,
    /// From `seal.json`.
    pub seal: Option<Seal>,
    /// From `data_in_use.json`.
    pub data_in_use: Option<DataInUse>,
    /// From `glucose_by_person.json`.
    pub glucose_by_person: Option<GlucoseByPerson>,
    /// From `truth.json`.
    pub truth: Option<StatedTruth>,
}

impl Inputs {
    /// Whether there is nothing that a report shows; a manifest, a seal or the truth alone is nothing.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.outcomes.is_none()
            && self.conformance.is_none()
            && self.diagnosis.is_none()
            && self.training.is_none()
            && self.twins.is_none()
            && self.import_report.is_none()
            && self.example_day.is_none()
            && self.what_if.is_none()
            && self.what_if_constrained.is_none()
            && self.agp.is_none()
            && self.blind_check.is_none()
            && self.data_in_use.is_none()
            && self.glucose_by_person.is_none()
    }

    /// Reads one part, strictly. A manifest is added to those already read; any other part replaces
    /// one read before.
    ///
    /// # Errors
    ///
    /// [`ReportError::Unreadable`], and [`ReportError::Contract`] with line and column where the
    /// part does not match its schema.
    pub fn read(&mut self, part: Part, mut reader: impl Read) -> Result<(), ReportError> {
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .map_err(|source| ReportError::Unreadable { file: part.file_name(), source })?;
        match part {
            Part::Manifest => self.manifests.push(contract::read(&bytes)?),
            Part::Outcomes => self.outcomes = Some(contract::read(&bytes)?),
            Part::Conformance => self.conformance = Some(contract::read(&bytes)?),
            Part::Diagnosis => self.diagnosis = Some(contract::read(&bytes)?),
            Part::Training => self.training = Some(contract::read(&bytes)?),
            Part::Twins => self.twins = Some(contract::read(&bytes)?),
            Part::ImportReport => self.import_report = Some(contract::read(&bytes)?),
            Part::ExampleDay => self.example_day = Some(contract::read(&bytes)?),
            Part::WhatIf => self.what_if = Some(contract::read(&bytes)?),
            Part::WhatIfConstrained => self.what_if_constrained = Some(contract::read(&bytes)?),
            Part::Agp => self.agp = Some(contract::read(&bytes)?),
            Part::BlindCheck => self.blind_check = Some(contract::read(&bytes)?),
            Part::Seal => self.seal = Some(contract::read(&bytes)?),
            Part::DataInUse => self.data_in_use = Some(contract::read(&bytes)?),
            Part::GlucoseByPerson => self.glucose_by_person = Some(contract::read(&bytes)?),
            Part::Truth => self.truth = Some(contract::read(&bytes)?),
        }
        Ok(())
    }
}
