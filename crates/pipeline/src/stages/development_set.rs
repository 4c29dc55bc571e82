//! `development-set`: the simulated weeks on which the population network is trained, as Parquet.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context as _, Result};
use cohort::{CellKind, Cells, ParquetSink};
use contract::Document as _;
use contract::development_set::{
    ColumnUnit, DevelopmentSetSummary, ScalerSummary, SignalScale, SubsetSummary,
};
use nn_statespace::training_set::{CoarseCounts, FineCounts};
use nn_statespace::{CentreAndScale, Scaler, Signal};
use ode_sim::DevelopmentSet;
use ode_sim::development_set::{Origin, STEPS_PER_WEEK, Subset};
use physiology::STEP;
use rayon::prelude::*;

use crate::progress::in_threads;
use crate::usage::peak_mib;
use crate::{Manifest, OutputFolder, Profile, Progress, note};
use development::weeks::{
    TRAINING_STRIDE, WINDOW, WeekFacts, check_split, data_hash, mean_shares, simulated,
    windows_per_week,
};

/// Settings of `development-set`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How many days: quick 420, paper 323,400 (two minutes, 3 GB).
    pub profile: Profile,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of meals, starts and doses.
    pub seed: u64,
}

/// Weeks in a file: half a million rows, 15 MB.
const WEEKS_PER_FILE: usize = 256;
/// Weeks in a row group: what a thread holds at a time.
const WEEKS_PER_GROUP: usize = 64;

/// The column of a signal and its unit.
fn column_of(signal: Signal) -> ColumnUnit {
    let (name, unit) = match signal {
        Signal::State(compartment) => (compartment.name(), compartment.unit()),
        Signal::Insulin => ("insulin_u_h", "U/h"),
        Signal::Carbs => ("carbs_g", "g in the step"),
    };
    ColumnUnit { name: name.to_owned(), unit: unit.to_owned() }
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let began = Instant::now();
    let set = DevelopmentSet::new(args.profile.plan(args.seed)).context("the development set")?;
    let manifest = Manifest::new("development-set", config(&set), Some(args.seed));
    let output = OutputFolder::begin(&args.out, manifest)?;

    let (weeks, coarse) = write_rows(&set, &output)?;
    check_split(&set, &weeks)?;
    let hash = data_hash(&weeks);
    let scaler = fit_scaler(&set, &weeks, &coarse)?;

    output.write("weeks.csv", weeks_table(&weeks).as_bytes())?;
    output.write("meal_days.csv", meal_days_table(&set).as_bytes())?;
    output.write_document(&scaler_summary(&scaler, &weeks, &hash))?;
    let summary = summary(&set, &weeks, &hash);
    output.write_document(&summary)?;
    let place = output.finish()?;

    note(scaler_text(&scaler));
    note(weeks_text(&summary));
    let seconds = began.elapsed().as_secs_f64();
    note(format!(
        "development-set: {} days, {} rows, data {}, {seconds:.1} s, peak {:.0} MiB, {}",
        set.plan().days(),
        summary.rows,
        &hash[..16],
        peak_mib().unwrap_or(f64::NAN),
        place.display()
    ));
    Ok(())
}

fn config(set: &DevelopmentSet) -> serde_json::Value {
    let plan = set.plan();
    serde_json::json!({
        "meal_days": plan.meal_days,
        "meal_weeks": plan.meal_weeks,
        "starts_per_week": plan.starts_per_week,
        "delays_min": plan.delays.iter().map(|d| *d as f64 * STEP.0).collect::<Vec<_>>(),
        "dose_factors": plan.dose_factors,
        "additional_weeks": plan.additional_weeks,
        "production": format!("{:?}", plan.egp),
        "weeks_per_file": WEEKS_PER_FILE,
        "weeks_per_row_group": WEEKS_PER_GROUP,
    })
}

fn file_name(week: usize) -> String {
    format!("rows/{:04}.parquet", week / WEEKS_PER_FILE)
}

/// Writes every row, a file on each thread at a time; what is left are facts of the weeks, in order,
/// and the first count of the training rows.
fn write_rows(
    set: &DevelopmentSet,
    output: &OutputFolder,
) -> Result<(Vec<WeekFacts>, CoarseCounts)> {
    std::fs::create_dir(output.path().join("rows")).context("cannot make the folder of rows")?;
    let progress = Progress::begin("weeks", set.len());
    let files = set.len().div_ceil(WEEKS_PER_FILE);
    let counts = Mutex::new(CoarseCounts::new());
    let weeks = in_threads(files, |file| {
        let (weeks, own) = write_file(set, output, file * WEEKS_PER_FILE, &progress)?;
        counts.lock().unwrap_or_else(PoisonError::into_inner).merge(&own);
        Ok(weeks)
    })?;
    progress.finish(&format!("{files} files of simulated weeks"));
    Ok((weeks.concat(), counts.into_inner().unwrap_or_else(PoisonError::into_inner)))
}

/// Writes the file that begins with the week `first`.
fn write_file(
    set: &DevelopmentSet,
    output: &OutputFolder,
    first: usize,
    progress: &Progress,
) -> Result<(Vec<WeekFacts>, CoarseCounts)> {
    let name = file_name(first);
    let end = set.len().min(first + WEEKS_PER_FILE);
    let problem = || format!("cannot write '{name}' (is the disk full?)");
    let file = File::create(output.path().join(&name)).with_context(problem)?;
    let mut file = BufWriter::new(file);
    let (integer, word) = (CellKind::Integer, CellKind::Word);
    let mut columns = vec![("week", integer), ("step", integer), ("subset", word)];
    let of_signals: Vec<ColumnUnit> = Signal::all().map(column_of).collect();
    columns.extend(of_signals.iter().map(|column| (column.name.as_str(), CellKind::Number)));
    let mut sink = ParquetSink::new(&name, &mut file, &columns).with_context(problem)?;

    let mut counts = CoarseCounts::new();
    let mut weeks = Vec::with_capacity(end - first);
    for first in (first..end).step_by(WEEKS_PER_GROUP) {
        let (mut week, mut step, mut subset) = (Vec::new(), Vec::new(), Vec::new());
        let mut signals = vec![Vec::new(); of_signals.len()];
        for index in first..end.min(first + WEEKS_PER_GROUP) {
            let (facts, rows) = simulated(set, index)?;
            if facts.subset == Subset::Train {
                counts.add(&rows);
            }
            // A row for every state: the last of a week has no inputs.
            week.extend(std::iter::repeat_n(i32::try_from(index)?, rows.steps() + 1));
            step.extend(0..=i32::try_from(rows.steps())?);
            subset.extend(std::iter::repeat_n(facts.subset.name(), rows.steps() + 1));
            for (signal, column) in Signal::all().zip(&mut signals) {
                column.extend(rows.values(signal).map(Some));
                column.resize(week.len(), None);
            }
            weeks.push(facts);
            progress.advance("simulated");
        }
        let mut cells = vec![Cells::Integers(week), Cells::Integers(step), Cells::Words(subset)];
        cells.extend(signals.into_iter().map(Cells::Numbers));
        sink.write(cells).with_context(problem)?;
    }
    sink.finish().with_context(problem)?;
    file.flush().and_then(|()| file.get_ref().sync_all()).with_context(problem)?;
    Ok((weeks, counts))
}

/// The second count of the training rows, which are simulated again: cheaper than to keep or to read
/// them.
fn fit_scaler(set: &DevelopmentSet, weeks: &[WeekFacts], coarse: &CoarseCounts) -> Result<Scaler> {
    let training: Vec<usize> =
        weeks.iter().filter(|week| week.subset == Subset::Train).map(|week| week.index).collect();
    let empty = coarse.narrow().context("the scaler")?;
    let progress = Progress::begin("scaler", training.len());
    let counted = training.par_chunks(WEEKS_PER_FILE).map(|indices| {
        let mut own = empty.clone();
        for index in indices {
            own.add(&simulated(set, *index)?.1);
            progress.advance("counted");
        }
        anyhow::Ok(own)
    });
    let merged = |mut counts: FineCounts, others: FineCounts| {
        counts.merge(&others);
        Ok(counts)
    };
    let counts = counted.try_reduce(|| empty.clone(), merged)?;
    progress.finish("medians and quartiles of the training rows");
    counts.scaler().context("the scaler")
}

fn weeks_table(weeks: &[WeekFacts]) -> String {
    let mut text = String::from(
        "week,subset,origin,initial_glucose_mg_dl,bolus_delay_min,dose_factor,\
         mean_basal_factor,extra_bolus_u,meal_day_1,meal_day_2,\
         meal_day_3,meal_day_4,meal_day_5,meal_day_6,meal_day_7,share_below_70,share_above_250,file\n",
    );
    for week in weeks {
        let _ = write!(
            text,
            "{},{},{},{},{},{},{},{}",
            week.index,
            week.subset.name(),
            week.origin.name(),
            week.initial_glucose.0,
            week.delay as f64 * STEP.0,
            week.dose_factor,
            week.basal_factor,
            week.extra_boluses,
        );
        for day in week.meal_days {
            let _ = write!(text, ",{day}");
        }
        let shares = week.shares;
        let _ =
            writeln!(text, ",{},{},{}", shares.below_70, shares.above_250, file_name(week.index));
    }
    text
}

fn meal_days_table(set: &DevelopmentSet) -> String {
    let mut text = String::from("meal_day,subset,minute,carbs_g\n");
    for subset in Subset::ALL {
        for place in set.pool_of(subset) {
            for meal in set.pool()[place].meals() {
                let minute = meal.step as f64 * STEP.0;
                let _ = writeln!(text, "{place},{},{minute},{}", subset.name(), meal.carbs.0);
            }
        }
    }
    text
}

fn scaler_summary(scaler: &Scaler, weeks: &[WeekFacts], hash: &str) -> ScalerSummary {
    let training = weeks.iter().filter(|week| week.subset == Subset::Train).count();
    let signals = Signal::all().map(|signal| {
        let CentreAndScale { centre, scale } = scaler.of(signal);
        let unit = column_of(signal).unit;
        (signal.name().to_owned(), SignalScale { centre, scale, unit })
    });
    ScalerSummary {
        centre_is: "median".to_owned(),
        data_sha256: hash.to_owned(),
        scale_is: "interquartile range, 1 where that is 0; C1 is not scaled".to_owned(),
        schema: ScalerSummary::SCHEMA.to_owned(),
        signals: signals.collect(),
        training_rows: training * (STEPS_PER_WEEK + 1),
    }
}

fn summary(set: &DevelopmentSet, weeks: &[WeekFacts], hash: &str) -> DevelopmentSetSummary {
    let subsets = Subset::ALL.into_iter().map(|subset| {
        let own: Vec<_> = weeks.iter().filter(|week| week.subset == subset).collect();
        let of = |origin| own.iter().filter(|week| week.origin == origin).count();
        let shares = mean_shares(&own);
        let summary = SubsetSummary {
            additional_high: of(Origin::AdditionalHigh),
            additional_low: of(Origin::AdditionalLow),
            combinations: of(Origin::Combination),
            meal_days: set.pool_of(subset).len(),
            share_above_250: shares.above_250,
            share_below_70: shares.below_70,
            weeks: own.len(),
            windows_apart: own.len() * windows_per_week(WINDOW),
            windows_overlapping: own.len() * windows_per_week(TRAINING_STRIDE),
        };
        (subset.name().to_owned(), summary)
    });
    DevelopmentSetSummary {
        columns: Signal::all().map(column_of).collect(),
        data_sha256: hash.to_owned(),
        days: set.plan().days(),
        files: set.len().div_ceil(WEEKS_PER_FILE),
        meal_days_in_two_subsets: 0,
        rows: weeks.len() * (STEPS_PER_WEEK + 1),
        schema: DevelopmentSetSummary::SCHEMA.to_owned(),
        step_minutes: STEP.0,
        subsets: subsets.collect(),
        weeks: weeks.len(),
        window_steps: WINDOW,
    }
}

fn scaler_text(scaler: &Scaler) -> String {
    let mut text = String::from("Scaler of the training rows:   centre (median)   scale (IQR)");
    for signal in Signal::all() {
        let (name, unit) = (signal.name(), column_of(signal).unit);
        let CentreAndScale { centre, scale } = scaler.of(signal);
        let _ = write!(text, "\n  {name:<10} {unit:<14} {centre:>18.6e} {scale:>13.6e}");
    }
    text
}

fn weeks_text(summary: &DevelopmentSetSummary) -> String {
    let mut text = String::from("No daily meal scenario lies in two subsets:");
    for name in Subset::ALL.map(Subset::name) {
        let own = &summary.subsets[name];
        let _ = write!(
            text,
            "\n  {name:<10} {:>6} weeks, {} of them added as low and {} as high",
            own.weeks, own.additional_low, own.additional_high
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use nn_statespace::training::Run;
    use ode_sim::DevelopmentPlan;
    use physiology::{Compartment, Plant as _, States};
    use std::path::Path;

    fn written(seed: u64, threads: usize, out: &Path) -> Manifest {
        let args = Settings { profile: Profile::Quick, seed, out: out.to_path_buf() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| run(&args)).expect("written");
        Manifest::read(out).expect("a manifest")
    }

    #[test]
    fn bytes_follow_the_seed_and_not_the_threads() {
        let folder = tempfile::tempdir().expect("a folder");
        let one = written(1, 1, &folder.path().join("one"));
        let three = written(1, 3, &folder.path().join("three"));
        assert_eq!(one.outputs, three.outputs);
        let names: Vec<_> = one.outputs.iter().map(|output| output.path.as_str()).collect();
        let expected = [
            "development-set.json",
            "meal_days.csv",
            "rows/0000.parquet",
            "scaler.json",
            "weeks.csv",
        ];
        assert_eq!(names, expected);
        let other = written(2, 2, &folder.path().join("other"));
        assert!(one.outputs.iter().zip(&other.outputs).all(|(a, b)| a.sha256 != b.sha256));
    }

    #[test]
    fn the_scaler_is_that_of_all_training_rows_at_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("set");
        written(3, 2, &out);
        let text = std::fs::read(out.join("scaler.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");

        let set = DevelopmentSet::new(DevelopmentPlan::quick(3)).expect("a plan");
        let weeks = set.simulate(0..set.len()).expect("weeks");
        let single = |x: f64| f64::from(x as f32);
        let rounded: Vec<(Vec<States>, _)> = weeks
            .iter()
            .filter(|(week, _)| week.subset == Subset::Train)
            .map(|(_, run)| {
                let mut states: Vec<States> =
                    run.states.iter().map(|x| set.plant().report(x)).collect();
                for compartment in Compartment::ALL {
                    states.iter_mut().for_each(|x| x[compartment] = single(x[compartment]));
                }
                (states, &run.inputs)
            })
            .collect();
        let runs: Vec<Run<'_>> =
            rounded.iter().map(|(states, inputs)| Run { states, inputs }).collect();
        let expected = Scaler::fit(&runs).expect("finite");
        for compartment in Compartment::ALL {
            let pair = expected.of(Signal::State(compartment));
            let found = &json["signals"][compartment.name()];
            assert_eq!(found["centre"].as_f64(), Some(pair.centre), "{compartment}");
            assert_eq!(found["scale"].as_f64(), Some(pair.scale), "{compartment}");
        }
        // The rate of the basal, which was not rounded here.
        let (basal, found) = (expected.of(Signal::Insulin), &json["signals"]["u_insulin"]);
        assert_eq!(found["centre"].as_f64(), Some(single(basal.centre)));
        assert_eq!(found["scale"].as_f64(), Some(basal.scale));
    }

    #[test]
    fn tables_name_every_week_and_its_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("set");
        written(1, 2, &out);
        let table = std::fs::read_to_string(out.join("weeks.csv")).expect("written");
        let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let header = rows.next().expect("a header");
        let set = DevelopmentSet::new(DevelopmentPlan::quick(1)).expect("a plan");
        let mut count = 0;
        for (row, index) in rows.zip(0..) {
            let week = set.week(index).expect("a week");
            let cell = |name| row[header.iter().position(|h| *h == name).expect("a column")];
            assert_eq!(cell("week"), index.to_string());
            assert_eq!(cell("subset"), week.subset.name());
            assert_eq!(cell("dose_factor").parse(), Ok(week.dose_factor));
            assert_eq!(cell("initial_glucose_mg_dl").parse(), Ok(week.initial_glucose.0));
            assert_eq!(cell("meal_day_7"), week.meal_days[6].to_string());
            let share = |name| cell(name).parse::<f64>().expect("a number");
            match week.origin {
                Origin::AdditionalLow => assert!(share("share_below_70") > 0.2),
                Origin::AdditionalHigh => assert!(share("share_above_250") > 0.4),
                Origin::Combination => assert_eq!(cell("origin"), "combination"),
            }
            assert!(out.join(cell("file")).is_file());
            count += 1;
        }
        assert_eq!(count, set.len());
    }
}
