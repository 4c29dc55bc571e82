//! Every document, once.

use crate::bench::*;
use crate::blind_check::*;
use crate::development_set::*;
use crate::document::same_again;
use crate::posterior::*;
use crate::*;

/// Lists every kind of document, and gives the types their file and schema name, but for those that state them
/// beside a check of their own.
macro_rules! document_kinds {
    ($($type:ty $(: $file:literal, $schema:literal)?;)*) => {
        $($(
            impl Document for $type {
                const FILE: &'static str = $file;
                const SCHEMA: &'static str = $schema;
            }
        )?)*

        /// Every kind of document.
        #[must_use]
        pub fn document_kinds() -> Vec<DocumentKind> {
            vec![$(DocumentKind {
                file: <$type>::FILE,
                same_again: same_again::<$type>,
                #[cfg(test)]
                schema: (<$type>::SCHEMA, || schemars::schema_for!($type).to_value()),
            }),*]
        }
    };
}

document_kinds! {
    Manifest: "manifest.json", "manifest/1";
    ImportReport: "import_report.json", "";
    DevelopmentSetSummary: "development-set.json", "development-set/1";
    ScalerSummary: "scaler.json", "scaler/1";
    WidthSearch: "widths.json", "widths/1";
    Training: "training.json", "training/1";
    RegionFile: "region.json", "";
    Conformance: "conformance.json", "conformance/2";
    Certificates: "certificates.json", "certificate/2";
    Repair: "repair.json", "repair/1";
    HeldOut: "held-out.json", "held_out/1";
    SteadyStates: "steady_state.json", "steady_state/1";
    Trajectories: "trajectories.json", "trajectories/1";
    TwinsTable: "twins.json", "twins/1";
    RunErrors: "run_errors.json", "";
    Baselines;
    OutcomesTable: "outcomes.json", "outcomes/2";
    Exclusions: "exclusions.json", "";
    GlucoseProfile;
    WhatIf;
    ExampleDay;
    Diagnosis;
    DataInUse: "data_in_use.json", "data-in-use/1";
    GlucoseByPerson;
    StatedTruth: "truth.json", "truth/1";
    EffectTwins: "effect_twins.json", "effect-twins/1";
    Meals: "meals.json", "meals/1";
    BlindCheck: "blind_check.json", "blind-check/4";
    Seal: "seal.json", "seal/1";
    Answer: "answers/ID.json", "";
    OpenedLabels: "labels.json", "";
    Label: "label.json", "";
    Labels: "labels.json", "";
    PlantedCheck: "planted.json", "planted/3";
    Realism: "realism.json", "realism/1";
    People: "people.json", "";
    StatisticNames: "names.json", "";
    PosteriorCard: "working.json", "";
    DiagnosisBench: "bench.json", "bench-diagnosis/1";
    MealsBench: "bench.json", "bench-meals/1";
    TrainingStepBench: "bench.json", "bench-training-step/1";
    TwinsBench: "bench.json", "bench-twins/1";
}
