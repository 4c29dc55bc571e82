//! The file that holds the result of a command, for those who read it by program.

use std::fs;
use std::path::Path;

use contract::bench::DiagnosisBench;
use contract::blind_check::{PlantedCheck, Realism};
use contract::development_set::DevelopmentSetSummary;
use contract::{
    Baselines, BlindCheck, Conformance, Document as _, EffectTwins, HeldOut, ImportReport, Meals,
    OutcomesTable, SteadyStates, Training, Trajectories, TwinsTable, WidthSearch,
};
use gap::Diagnosis;
use ode_sim::OdeParameters;

use crate::progress::{json_is_asked_for, note, print};

/// The result's file in the output folder of a command; `None` for a command whose result is no JSON.
#[must_use]
pub fn result_file(command: &str) -> Option<&'static str> {
    Some(match command {
        "baselines" => Baselines::<OdeParameters>::FILE,
        "bench" => DiagnosisBench::FILE,
        "blind-check" => BlindCheck::FILE,
        "development-set" => DevelopmentSetSummary::FILE,
        "diagnose" | "pipeline" => Diagnosis::FILE,
        "effect-twins" => EffectTwins::FILE,
        "evaluate" => OutcomesTable::FILE,
        "held-out" => HeldOut::FILE,
        "import" => ImportReport::FILE,
        "realism" => Realism::FILE,
        "reconcile" => Meals::FILE,
        "steady-state" => SteadyStates::FILE,
        "train" => Training::FILE,
        "trajectories" => Trajectories::FILE,
        "twin" => TwinsTable::FILE,
        "verify" => Conformance::FILE,
        "widths" => WidthSearch::FILE,
        _ => return None,
    })
}

/// Prints the result in a finished folder, if its JSON was asked for.
pub(crate) fn print_result(command: &str, folder: &Path) {
    if !json_is_asked_for() {
        return;
    }
    let Some(file) = result_file(command) else { return };
    // Effects planted into real records are a result of their own.
    let files = [folder.join(file), folder.join(PlantedCheck::FILE)];
    match files.iter().find_map(|path| fs::read(path).ok()) {
        Some(bytes) => print(bytes.trim_ascii_end()),
        None => note(format!("{command}: there is no {file}, so that nothing is printed")),
    }
}
