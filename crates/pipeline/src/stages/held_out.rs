//! `held-out`: outcomes and errors of population networks on days that none was trained on, beside the ODE.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use contract::held_out::{HeldOutParts, ModelScores};
use contract::{Document as _, HeldOut};
use nn_statespace::PopulationModel;
use ode_sim::DevelopmentSet;
use stats::Outcome;

use crate::files::read_population;
use crate::{Manifest, OutputFolder, Profile, Progress, note};
use development::held_out::{Scored, balanced, score_all};

/// Settings of `held-out`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Population model.
    pub model: PathBuf,
    /// Another population model, on the same windows.
    pub beside: Option<PathBuf>,
    /// The development set whose test subset is used: that of `train` with this profile and seed.
    pub profile: Profile,
    /// Seed of the development set.
    pub seed: u64,
    /// Output folder.
    pub out: PathBuf,
}

/// What the paper prints for its network and the ODE on its own held-out days, mean and SD.
const PAPER: [[(f64, f64); 2]; 6] = [
    [(72.9, 35.2), (74.1, 34.1)],
    [(23.1, 36.3), (22.3, 35.3)],
    [(4.0, 8.2), (3.6, 6.8)],
    [(1.5, 1.7), (1.4, 1.5)],
    [(4.2, 6.2), (4.1, 6.0)],
    [(132.6, 48.2), (132.8, 46.8)],
];

/// The tables as text, within the output folder.
pub(crate) const TEXT: &str = "held-out.txt";

fn paths(args: &Settings) -> Vec<&Path> {
    std::iter::once(args.model.as_path()).chain(args.beside.as_deref()).collect()
}

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Result<Manifest> {
    let config = serde_json::json!({ "simulated_weeks": args.profile.plan(args.seed).weeks() });
    let manifest = Manifest::new("held-out", config, Some(args.seed));
    paths(args).into_iter().try_fold(manifest, |manifest, path| manifest.with_model(path))
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let paths = paths(args);
    let manifest = manifest(args)?;
    let models: Vec<PopulationModel> =
        paths.iter().map(|path| read_population(path)).collect::<Result<_>>()?;
    let output = OutputFolder::begin(&args.out, manifest)?;

    let set = DevelopmentSet::new(args.profile.plan(args.seed)).context("the development set")?;
    let progress = Progress::begin("held-out", set.len());
    let [all, combinations] = score_all(&set, &models, &|| progress.advance("weeks"))?;
    let mut text = String::new();
    let mut part = |title: &str, scored: &[Scored]| -> Result<Vec<ModelScores>> {
        let scores = paths.iter().zip(&scored[1..]).map(|(path, model)| {
            Ok(ModelScores { model: name(path), told: model.told(&scored[0])? })
        });
        let scores = scores.collect::<Result<Vec<_>>>()?;
        write_part(&mut text, title, &scores);
        Ok(scores)
    };
    let parts = HeldOutParts {
        all: part("All held-out weeks", &all)?,
        combinations: part("Without the additional weeks", &combinations)?,
    };
    let hashes = models.iter().map(|model| model.card().training_data_sha256.clone());
    output.write_document(&HeldOut {
        groups: ["in_range", "low", "other"].map(str::to_owned),
        parts,
        schema: HeldOut::SCHEMA.to_owned(),
        training_data_sha256: hashes.collect(),
        unit_of_equivalence: "meal week".to_owned(),
        window_minutes: 300,
    })?;
    let place = output.finish_with_table(TEXT, &text)?;
    note(format!("held-out: {}", place.join(HeldOut::FILE).display()));
    Ok(())
}

/// A file's name with its folder's, which tells models apart.
fn name(path: &Path) -> String {
    let last: Vec<_> = path.iter().rev().take(2).collect();
    last.into_iter().rev().collect::<std::path::PathBuf>().display().to_string()
}

fn write_part(text: &mut String, title: &str, scores: &[ModelScores]) {
    let Some(first) = scores.first() else { return };
    let [in_range, low, other] = first.told.errors.windows;
    let _ = writeln!(
        text,
        "{title}: {in_range} windows of 5 h in range, {low} low, {other} other\n\n\
         RMSE of glucose, mg/dL{:<24}in range       low     other  balanced   balanced, fasting starts",
        ""
    );
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    for ModelScores { model, told } in scores {
        let [in_range, low, other] = told.errors.rmse_mg_dl.map(number);
        let (all, fasting) = (balanced(&told.errors), balanced(&told.errors_fasting));
        let _ = writeln!(
            text,
            "  {:<43}{in_range:>9} {low:>9} {other:>9} {all:>9.2} {fasting:>10.2}",
            model
        );
    }
    for ModelScores { model, told } in scores {
        let _ = writeln!(
            text,
            "\nOutcomes of {}, mean (SD) over windows; equivalence over {} meal weeks\n  \
             {:<5} {:>17} {:>17}   {:>28}  {:>8}   in the paper: ODE, network",
            model,
            told.equivalence.first().map_or(0, |row| row.actual.n),
            "",
            "ODE",
            "network",
            "difference (90 % interval)",
            "p"
        );
        let both =
            |of: &contract::Summary| format!("{:.2} ({:.2})", of.mean, of.sd.unwrap_or(f64::NAN));
        for (((outcome, (ode, network)), row), [theirs, printed]) in
            Outcome::ALL.into_iter().zip(&told.windows).zip(&told.equivalence).zip(PAPER)
        {
            let _ = writeln!(
                text,
                "  {:<5} {:>17} {:>17}   {:>8.3} ({:>7.3} to {:>7.3})  {:>8.1e} {}  {} ({}), {} ({})",
                outcome.name(),
                both(ode),
                both(network),
                row.difference.value,
                row.difference.lower,
                row.difference.upper,
                row.p,
                if row.equivalent { "equivalent" } else { "NOT equiv." },
                theirs.0,
                theirs.1,
                printed.0,
                printed.1,
            );
        }
        if told.windows_broken + told.samples_below_1_mg_dl > 0 {
            let _ = writeln!(
                text,
                "  {} windows left the finite numbers and are not counted; {} samples below 1 mg/dL count as 1",
                told.windows_broken, told.samples_below_1_mg_dl
            );
        }
    }
    text.push('\n');
}
