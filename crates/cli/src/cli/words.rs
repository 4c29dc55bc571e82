//! The words that options take, each with what the help says of it and what it means to a stage.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use pipeline::Profile;
use pipeline::stages::export::ExportFormat;
use pipeline::stages::import::{DateOrder, ImportFormat};
use pipeline::stages::import_model::ModelFormat;
use pipeline::stages::pipeline::Stage;
use pipeline::stages::reconcile::{DetectorName, Rule};
use pipeline::stages::replay::Initial;
use pipeline::stages::train::TrainingPreset;
use pipeline::stages::verify::MilpForm;
use pipeline::stages::worlds::{Generator, RegimeName};

/// A word, what the help says, and what it means.
type Word<T> = (&'static str, &'static str, T);

/// One of several words.
pub(super) fn one_of<T: Clone + Send + Sync + 'static>(
    words: &'static [Word<T>],
) -> impl TypedValueParser<Value = T> {
    let named = words.iter().map(|(word, says, _)| PossibleValue::new(*word).help(*says));
    PossibleValuesParser::new(named).map(move |typed| {
        let meant = words.iter().find(|(word, ..)| *word == typed);
        meant.expect("only these words pass").2.clone()
    })
}

/// How much to compute.
pub(super) const PROFILE: &[Word<Profile>] = &[
    ("quick", "Minutes on two cores", Profile::Quick),
    (
        "paper",
        "The paper's widths, schedules and simulated days; hours, of which `train` takes a \
         quarter of one",
        Profile::Paper,
    ),
];

/// A study's format.
pub(super) fn cohort_format() -> impl TypedValueParser<Value = ImportFormat> {
    let formats = ImportFormat::ALL.iter();
    let words = formats.map(|format| PossibleValue::new(format.name()).help(format.says()));
    PossibleValuesParser::new(words)
        .map(|typed| ImportFormat::from_name(&typed).expect("only these words pass"))
}

/// The order of day and month.
pub(super) const DATE_ORDER: &[Word<DateOrder>] = &[
    ("day-first", "31/12/2024", DateOrder::DayFirst),
    ("month-first", "12/31/2024", DateOrder::MonthFirst),
];

/// A format of other programs.
pub(super) const EXPORT_FORMAT: &[Word<ExportFormat>] = &[
    ("iglu", "`id,time,gl` for the R package iglu", ExportFormat::Iglu),
    ("replaybg", "A table a person for ReplayBG", ExportFormat::Replaybg),
    ("simglucose", "A table a person like the results of simglucose", ExportFormat::Simglucose),
    ("metabonet", "A Parquet file with the columns of MetaboNet", ExportFormat::Metabonet),
];

/// How the population network is trained.
pub(super) const TRAINING_PRESET: &[Word<TrainingPreset>] = &[
    (
        "working",
        "Ours: short roll-outs come first, gradients are limited, the best epoch is kept, \
         and slopes keep the signs of physiology",
        TrainingPreset::Working,
    ),
    ("unconstrained", "Ours, with slopes as they come", TrainingPreset::Unconstrained),
    ("paper", "As the paper says", TrainingPreset::Paper),
    (
        "authors-code",
        "As the published code does: glucose is also confined to 40-400 mg/dL after every \
         step",
        TrainingPreset::AuthorsCode,
    ),
];

/// A published model's format.
pub(super) const MODEL_FORMAT: &[Word<ModelFormat>] = &[(
    "t1dsim",
    "T1DSim_AI: a folder with the population's `.pt` and scalers, or with a twin's",
    ModelFormat::T1dsim,
)];

/// Programmes of the paper's question.
pub(super) const MILP_FORM: &[Word<MilpForm>] = &[
    ("gradient", "The largest slope", MilpForm::Gradient),
    (
        "difference",
        "The largest movement over a step, in one copy of the network",
        MilpForm::Difference,
    ),
    ("two-copies", "The same in two copies, as in the paper; slow", MilpForm::TwoCopies),
    ("none", "None", MilpForm::None),
];

/// How meals are found.
pub(super) const DETECTOR: &[Word<DetectorName>] = &[
    ("grid", "The published rate-of-rise detector; it estimates no sizes", DetectorName::Grid),
    ("plant", "A matched filter behind a Kalman filter on the ODE plant", DetectorName::Plant),
];

/// How a log and the meals found become one log.
pub(super) const RULE: &[Word<Rule>] = &[
    (
        "published",
        "The paper's: reports near a detection and a bolus are replaced, unsupported ones \
         discarded",
        Rule::Published,
    ),
    (
        "additive",
        "Every report stays; meals found where nothing is logged are added",
        Rule::Additive,
    ),
];

/// How basal insulin is decided.
pub(super) const REGIME: &[Word<RegimeName>] = &[
    ("open-loop", "A pump that follows its programme", RegimeName::OpenLoop),
    ("closed-loop", "Automated insulin delivery", RegimeName::ClosedLoop),
];

/// The stages of a pipeline.
pub(super) const STAGE: &[Word<Stage>] = &[
    ("cohort", "Read and judge the cohort's records", Stage::Cohort),
    ("train", "Simulate days and train the population network", Stage::Train),
    ("verify", "Prove or refute the network's monotonicity", Stage::Verify),
    (
        "held-out",
        "Compare the network with the ODE on simulated days that trained neither",
        Stage::HeldOut,
    ),
    ("twin", "Train a twin a person, and its variants", Stage::Twin),
    ("baselines", "Fit what twins are compared with", Stage::Baselines),
    ("evaluate", "Compare with held-out days", Stage::Evaluate),
    ("diagnose", "Say where the ODE plant misses", Stage::Diagnose),
    ("report", "Write the report", Stage::Report),
];

/// A generator of worlds by its name.
pub(super) fn generator(name: &str) -> Result<Generator, String> {
    Generator::from_name(name).ok_or_else(|| {
        format!("expected one of {}", Generator::ALL.map(Generator::name).join(", "))
    })
}

/// Where a replay starts: `steady-state` or `table:FILE`.
pub(super) fn initial(text: &str) -> Result<Initial, String> {
    match text.split_once(':') {
        None if text == "steady-state" => Ok(Initial::SteadyState),
        Some(("table", file)) if !file.is_empty() => Ok(Initial::Table(file.into())),
        _ => Err("expected steady-state or table:FILE".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_is_a_word_or_a_table() {
        assert_eq!(initial("steady-state"), Ok(Initial::SteadyState));
        assert_eq!(initial("table:a:b.csv"), Ok(Initial::Table("a:b.csv".into())));
        for wrong in ["", "table", "table:", "steady", "file:x"] {
            assert!(initial(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_stage_is_called_what_messages_call_it() {
        for stage in Stage::ALL {
            let command = clap::Command::new("x");
            let typed =
                super::one_of(super::STAGE).parse_ref(&command, None, stage.name().as_ref());
            assert_eq!(typed.ok(), Some(stage), "{}", stage.name());
        }
    }
}
