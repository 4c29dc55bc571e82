//! Every document, once.

use crate::bench::{DiagnosisBench, MealsBench, TrainingStepBench, TwinsBench};
use crate::blind_check::{
    Answer, BlindCheck, Label, Labels, OpenedLabels, People, PlantedCheck, Realism, Seal,
};
use crate::development_set::{DevelopmentSetSummary, ScalerSummary};
use crate::posterior::{PosteriorCard, StatisticNames};
use crate::{
    Baselines, Certificates, Conformance, DataInUse, Diagnosis, DocumentKind, EffectTwins,
    ExampleDay, Exclusions, GlucoseByPerson, GlucoseProfile, HeldOut, ImportReport, Manifest,
    Meals, OutcomesTable, RegionFile, Repair, RunErrors, StatedTruth, SteadyStates, Training,
    Trajectories, TwinsTable, WhatIf, WidthSearch,
};

/// Every kind of document.
#[must_use]
pub fn document_kinds() -> Vec<DocumentKind> {
    vec![
        DocumentKind::of::<Manifest>(),
        DocumentKind::of::<ImportReport>(),
        DocumentKind::of::<DevelopmentSetSummary>(),
        DocumentKind::of::<ScalerSummary>(),
        DocumentKind::of::<WidthSearch>(),
        DocumentKind::of::<Training>(),
        DocumentKind::of::<RegionFile>(),
        DocumentKind::of::<Conformance>(),
        DocumentKind::of::<Certificates>(),
        DocumentKind::of::<Repair>(),
        DocumentKind::of::<HeldOut>(),
        DocumentKind::of::<SteadyStates>(),
        DocumentKind::of::<Trajectories>(),
        DocumentKind::of::<TwinsTable>(),
        DocumentKind::of::<RunErrors>(),
        DocumentKind::of::<Baselines>(),
        DocumentKind::of::<OutcomesTable>(),
        DocumentKind::of::<Exclusions>(),
        DocumentKind::of::<GlucoseProfile>(),
        DocumentKind::of::<WhatIf>(),
        DocumentKind::of::<ExampleDay>(),
        DocumentKind::of::<Diagnosis>(),
        DocumentKind::of::<DataInUse>(),
        DocumentKind::of::<GlucoseByPerson>(),
        DocumentKind::of::<StatedTruth>(),
        DocumentKind::of::<EffectTwins>(),
        DocumentKind::of::<Meals>(),
        DocumentKind::of::<BlindCheck>(),
        DocumentKind::of::<Seal>(),
        DocumentKind::of::<Answer>(),
        DocumentKind::of::<OpenedLabels>(),
        DocumentKind::of::<Label>(),
        DocumentKind::of::<Labels>(),
        DocumentKind::of::<PlantedCheck>(),
        DocumentKind::of::<Realism>(),
        DocumentKind::of::<People>(),
        DocumentKind::of::<StatisticNames>(),
        DocumentKind::of::<PosteriorCard>(),
        DocumentKind::of::<DiagnosisBench>(),
        DocumentKind::of::<MealsBench>(),
        DocumentKind::of::<TrainingStepBench>(),
        DocumentKind::of::<TwinsBench>(),
    ]
}
