//! What was typed, as the settings of a stage.

use crate::cli::*;
use pipeline::stages;

/// Options of a command become the settings of a stage, field by field under the same names.
macro_rules! settings {
    ($($typed:ident => $stage:ident { $($field:ident),* })*) => {$(
        impl From<$typed> for stages::$stage::Settings {
            fn from(typed: $typed) -> Self {
                Self { $($field: typed.$field),* }
            }
        }
    )*};
}

settings! {
    PipelineArgs => pipeline { profile, cohort, model, patients, from, out, seed }
    ImportArgs => import {
        from, source, out, parquet, map, unit, zone, utc, dates, decimal, sheet, guess
    }
    ExportArgs => export { cohort, to, out }
    SimulateArgs => simulate { patients, meals, initial, days, scenario, out }
    DevelopmentSetArgs => development_set { profile, out, seed }
    TrainArgs => train { profile, preset, patience, out, seed }
    ImportModelArgs => import_model { from, folder, model, out }
    VerifyArgs => verify { model, region, widen, delta, milp, limit, repair, out, seed }
    TwinArgs => twin {
        cohort, model, profile, variants, continue_from, training_days, epochs, out, seed
    }
    BaselinesArgs => baselines { cohort, model, patients, profile, training_days, out, seed }
    ReplayArgs => replay { cohort, model, twin, initial, out }
    ReconcileArgs => reconcile { cohort, detector, rule, out }
    EvaluateArgs => evaluate { cohort, twins, baselines, out, seed }
    DiagnoseArgs => diagnose { cohort, model, population, out, seed, posterior }
    EffectTwinsArgs => effect_twins { cohort, model, profile, out, seed }
    BlindCheckArgs => blind_check { worlds, nulls, full, model, out, seed }
    WorldsArgs => worlds {
        effect, shift, generator, regime, people, days, nuisances, count, mixture, nulls, out, seed
    }
    RealismArgs => realism { cohort, worlds, nulls, people, days, out, seed }
    EvidenceArgs => evidence { worlds, nulls, narrow, cohort, labelled, out, seed }
    TrainPosteriorArgs => train_posterior { table, out, seed }
    SteadyStateArgs => steady_state { model, compare, out }
    TrajectoriesArgs => trajectories { model, twin, out }
    WidthsArgs => widths { profile, explore, exploit, at_once, out, seed }
    HeldOutArgs => held_out { model, beside, profile, seed, out }
}
