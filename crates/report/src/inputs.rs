//! What a report is made from: any subset of the pipeline's JSON outputs.

use std::io::Read;

use contract::blind_check::Seal;
use contract::{
    BlindCheck, Conformance, DataInUse, Diagnosis, ExampleDay, Exclusions, GlucoseByPerson,
    GlucoseProfile, ImportReport, Manifest, OutcomesTable, StatedTruth, Training, TwinsTable,
    WhatIf,
};

use crate::ReportError;

/// Makes [`Part`] and [`Inputs`] from the parts in their order: what a part is, its variant, its field
/// and its file. Manifests stand apart, since there is one a stage.
macro_rules! parts {
    ($($(#[$doc:meta])* $part:ident, $field:ident: $type:ty, $file:literal;)*) => {
        /// One JSON output of the pipeline.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Part {
            /// How a stage was run.
            Manifest,
            $($(#[$doc])* $part,)*
        }

        impl Part {
            /// Every part.
            pub const ALL: [Self; 17] = [Self::Manifest, $(Self::$part),*];

            /// Name of the file that holds the part in an output folder.
            #[must_use]
            pub const fn file_name(self) -> &'static str {
                match self {
                    Self::Manifest => "manifest.json",
                    $(Self::$part => $file,)*
                }
            }
        }

        /// The available parts. A missing part becomes a section that says so.
        #[derive(Debug, Clone, Default)]
        pub struct Inputs {
            /// Manifests of the stages, in the order in which they were read.
            pub manifests: Vec<Manifest>,
            $(#[doc = concat!("From `", $file, "`.")] pub $field: Option<$type>,)*
        }

        impl Inputs {
            /// Reads one part, strictly. A manifest is added to those already read; any other part
            /// replaces one read before.
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
                    $(Part::$part => self.$field = Some(contract::read(&bytes)?),)*
                }
                Ok(())
            }

            /// Whether there is nothing that a report shows; a manifest, a seal or the truth alone is
            /// nothing.
            #[must_use]
            pub fn is_empty(&self) -> bool {
                let held = [$((Part::$part, self.$field.is_some())),*];
                held.into_iter()
                    .all(|(part, held)| !held || matches!(part, Part::Seal | Part::Truth))
            }
        }
    };
}

parts! {
    /// Glucose outcomes and forecast errors of every method.
    Outcomes, outcomes: OutcomesTable, "outcomes.json";
    /// Who was left out of an evaluation that judged fewer than two people.
    Exclusions, exclusions: Exclusions, "exclusions.json";
    /// Proofs of the network's monotonicity properties.
    Conformance, conformance: Conformance, "conformance.json";
    /// Where the gap lies, which effect explains it, and how far it shrinks.
    Diagnosis, diagnosis: Diagnosis, "diagnosis.json";
    /// Training of the population network.
    Training, training: Training, "training.json";
    /// Training of the twins, by person.
    Twins, twins: TwinsTable, "twins.json";
    /// What was found and done on import.
    ImportReport, import_report: ImportReport, "import_report.json";
    /// Days of one person, measured and simulated.
    ExampleDay, example_day: ExampleDay, "example_day.json";
    /// What twins predict for meals under other doses.
    WhatIf, what_if: WhatIf, "what_if.json";
    /// The same for twins whose networks keep physiology's signs.
    WhatIfConstrained, what_if_constrained: WhatIf, "what_if_constrained.json";
    /// Ambulatory glucose profile, measured and simulated.
    Agp, agp: GlucoseProfile, "agp.json";
    /// Answers of the diagnosis, scored against labels that it could not see.
    BlindCheck, blind_check: BlindCheck, "blind_check.json";
    /// Hashes of those labels.
    Seal, seal: Seal, "seal.json";
    /// The people, days and channels in use, and what the checks of the data said.
    DataInUse, data_in_use: DataInUse, "data_in_use.json";
    /// Each person's measured glucose.
    GlucoseByPerson, glucose_by_person: GlucoseByPerson, "glucose_by_person.json";
    /// What the makers of the cohort state.
    Truth, truth: StatedTruth, "truth.json";
}
