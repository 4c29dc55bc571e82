//! `train-posterior`: the posterior in use, and one for each hand that has not seen it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use candle_core::Device;
use contract::blind_check::{Label, Labels};
use contract::posterior::StatisticNames;
use posterior::{Posterior, Table, Training, Truth, train};
use rayon::prelude::*;

use crate::files::read_document;
use crate::{Manifest, OutputFolder, Progress, note};

/// Settings of `train-posterior`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Tables of `evidence`.
    pub table: Vec<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the networks.
    pub seed: u64,
}

/// Statistics that follow how a calibration states its uncertainty, not what a record holds.
const NOT_READ: &str = "calibration/SD of ";
/// Largest offset of the log odds that nothing is missing: posteriors that are further off have learned nothing.
const LARGEST_OFFSET: f64 = 10.0;
/// Share of the cohorts in which nothing is missing of which a diagnosis may say that something is.
const FALSE_ALARMS: f64 = 0.05;
/// Factor of the cells that belong to one cohort alone.
const PERSON: &str = "person";

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let manifest = Manifest::new("train-posterior", serde_json::json!({}), Some(args.seed))
        .with_inputs(&args.table)?;
    let read = |folder: &PathBuf| read(folder).with_context(|| format!("'{}'", folder.display()));
    let tables = args.table.iter().map(read).collect::<Result<Vec<Table>>>()?;
    let table = Table::joined(&tables)?;
    drop(tables);
    let hands: BTreeSet<String> = table.truths.iter().map(|truth| truth.hand.clone()).collect();
    ensure!(
        hands.len() > 2,
        "worlds of too few hands ({}); give tables of three: each file leaves one out, and another judges it",
        hands.len()
    );
    let output = OutputFolder::begin(&args.out, manifest)?;
    let pairs: Vec<[&String; 2]> = hands
        .iter()
        .enumerate()
        .flat_map(|(index, first)| hands.iter().skip(index + 1).map(move |second| [first, second]))
        .collect();
    let progress = Progress::begin("posteriors", pairs.len() + hands.len() + 1);
    // What is said of the worlds of each hand, by posteriors that saw neither this hand nor the one that the file leaves
    // out.
    let mut judges: BTreeMap<Option<&String>, Vec<Vec<Said>>> = BTreeMap::new();
    for [first, second] in pairs {
        let seen = table.rows_where(|truth| truth.hand != *first && truth.hand != *second);
        let trained = trained(&seen, args.seed)?;
        for (file, asked) in [(first, second), (second, first)] {
            judges.entry(Some(file)).or_default().push(said(&trained, &table, asked)?);
        }
        progress.advance(&format!("neither {first} nor {second}, to judge by"));
    }
    for left_out in hands.iter().map(Some).chain([None]) {
        let seen = table.rows_where(|truth| Some(&truth.hand) != left_out);
        let mut trained = trained(&seen, args.seed)?;
        if let Some(hand) = left_out {
            judges.entry(None).or_default().push(said(&trained, &table, hand)?);
        }
        let asked = &judges[&left_out];
        let offset = offset(asked);
        trained = trained.judged(offset, bar(asked, offset));
        let name = left_out.map_or("working".to_owned(), |hand| format!("without-{hand}"));
        output.write(&format!("{name}.safetensors"), &trained.bytes()?)?;
        output.write_document_as(&format!("{name}.json"), trained.card())?;
        progress.advance(&name);
    }
    progress.finish(&format!("trained on {} worlds", table.len()));
    let place = output.finish()?;
    note(format!("train-posterior: {}", place.display()));
    Ok(())
}

/// What a posterior says of a world.
struct Said {
    /// Its probability that nothing is missing.
    nothing: f64,
    /// Whether nothing is.
    is_so: bool,
}

/// What a posterior says of each world of a hand.
fn said(posterior: &Posterior, table: &Table, hand: &str) -> Result<Vec<Said>> {
    let rows = (0..table.len()).into_par_iter().filter(|row| table.truths[*row].hand == hand);
    rows.map(|row| {
        let Truth { effects, outside, .. } = &table.truths[row];
        let nothing = posterior.answer(&table.row(row))?.nothing;
        Ok(Said { nothing, is_so: effects.is_empty() && outside.is_none() })
    })
    .collect()
}

/// The offset, to a hundredth, of the log odds that nothing is missing with which "nothing" is stated as often as it is
/// true, in the mean of the hands: the intercept of a logistic recalibration (Van Calster et al., J Clin Epidemiol
/// 2016;74:167). Hands whose worlds are all of one kind tell none; 0 where no other is there.
fn offset(said: &[Vec<Said>]) -> f64 {
    let both = |of: &&Vec<Said>| of.iter().any(|one| one.is_so) && of.iter().any(|one| !one.is_so);
    let asked: Vec<&Vec<Said>> = said.iter().filter(both).collect();
    let excess = |offset: f64| -> f64 {
        let of_world = |one: &Said| shifted(one.nothing, offset) - f64::from(u8::from(one.is_so));
        asked.iter().map(|of| of.iter().map(of_world).sum::<f64>() / of.len() as f64).sum()
    };
    if asked.is_empty() {
        return 0.0;
    }
    let (mut low, mut high) = (-LARGEST_OFFSET, LARGEST_OFFSET);
    while high - low > 1e-4 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    (50.0 * (low + high)).round() / 100.0
}

/// A probability whose log odds are moved by `offset`.
fn shifted(probability: f64, offset: f64) -> f64 {
    let moved = probability * offset.exp();
    moved / (moved + 1.0 - probability)
}

/// The lowest hundredth that at most [`FALSE_ALARMS`] of the worlds in which nothing is missing reach with the
/// probability of something, in the mean of the hands; 1 where there is none.
fn bar(said: &[Vec<Said>], offset: f64) -> f64 {
    let something = |of: &Vec<Said>| -> Vec<f64> {
        let idle = of.iter().filter(|one| one.is_so);
        idle.map(|one| 1.0 - shifted(one.nothing, offset)).collect()
    };
    let asked: Vec<Vec<f64>> = said.iter().map(something).filter(|of| !of.is_empty()).collect();
    let share = |of: &Vec<f64>, bar: f64| {
        of.iter().filter(|said| **said >= bar).count() as f64 / of.len() as f64
    };
    let mean = |bar: f64| asked.iter().map(|of| share(of, bar)).sum::<f64>() / asked.len() as f64;
    let mut hundredths = (1..100).map(|hundredth| f64::from(hundredth) / 100.0);
    hundredths.find(|bar| mean(*bar) <= FALSE_ALARMS).unwrap_or(1.0)
}

/// A posterior over the effects of the library.
fn trained(table: &Table, seed: u64) -> Result<Posterior> {
    let library = effects::library();
    let cards = || library.iter().map(|effect| effect.card());
    let names: Vec<String> = cards().map(|card| card.id.name().to_owned()).collect();
    let ports: BTreeSet<String> = cards().map(|card| card.port.name().to_owned()).collect();
    let ports: Vec<String> = ports.into_iter().collect();
    let source = format!("train-posterior --seed {seed}");
    Ok(train(table, &names, &ports, &Training::working(seed), &source)?)
}

/// Reads a table of `evidence`.
fn read(folder: &Path) -> Result<Table> {
    let StatisticNames(names) = read_document(folder)?;
    let Labels(labels) = read_document(folder)?;
    let file = folder.join("statistics.safetensors");
    let tensors = candle_core::safetensors::load(&file, &Device::Cpu)
        .with_context(|| format!("cannot read '{}'", file.display()))?;
    let statistics = tensors.get("statistics").context("it holds no `statistics`")?;
    ensure!(
        statistics.dims() == [labels.len(), names.len()],
        "statistics of shape {:?} beside {} labels and {} names",
        statistics.dims(),
        labels.len(),
        names.len()
    );
    let values = statistics.flatten_all()?.to_vec1::<f32>()?;
    let kept: Vec<usize> =
        (0..names.len()).filter(|index| !names[*index].starts_with(NOT_READ)).collect();
    let values = values
        .chunks(names.len().max(1))
        .flat_map(|row| kept.iter().map(|index| row[*index]).collect::<Vec<f32>>())
        .collect();
    let names = kept.into_iter().map(|index| names[index].clone()).collect();
    let truths = labels.iter().map(truth).collect::<Result<_>>()?;
    Ok(Table { names, values, truths })
}

/// What is true of a world, in the words of a posterior.
fn truth(label: &Label) -> Result<Truth> {
    let mut truth = Truth { hand: label.generator.clone(), ..Truth::default() };
    for effect in &label.effects {
        match &effect.port {
            Some(port) => truth.ports.push(port.clone()),
            None => {
                let known = effects::find(&effect.effect).with_context(|| {
                    format!(
                        "world {} has `{}`, which is not in the library and states no port; make the table \
                         again with this version",
                        label.id, effect.effect
                    )
                })?;
                truth.ports.push(known.card().port.name().to_owned());
                truth.effects.push(effect.effect.clone());
            }
        }
        if !effect.in_library {
            truth.outside = Some(effect.effect.clone());
        }
    }
    if let Some(gap) = &label.gap {
        for cell in gap.cells.iter().filter(|cell| cell.factor != PERSON) {
            for (minutes, mean) in blind::HORIZONS.iter().zip(cell.mean_mg_dl) {
                if let Some(mean) = mean {
                    truth.gaps.insert(format!("{minutes}/{}/{}", cell.factor, cell.level), mean);
                }
            }
        }
    }
    Ok(truth)
}

#[cfg(test)]
mod tests {
    use contract::blind_check::TrueEffect;

    use super::*;

    /// Worlds in which nothing is missing, with evenly spread probabilities of something from 0 to this one.
    fn up_to(largest: f64) -> Vec<Said> {
        idle((0..1000).map(|k| largest * (f64::from(k) + 0.5) / 1000.0))
    }

    fn idle(something: impl IntoIterator<Item = f64>) -> Vec<Said> {
        something.into_iter().map(|p| Said { nothing: 1.0 - p, is_so: true }).collect()
    }

    /// So many worlds of whose hundred so many lack nothing, each with this probability of nothing.
    fn worlds(count: u32, idle_of_hundred: u32, nothing: f64) -> Vec<Said> {
        (0..count).map(|k| Said { nothing, is_so: k % 100 < idle_of_hundred }).collect()
    }

    #[test]
    fn one_in_twenty_reaches_the_bar_where_hands_agree() {
        assert_eq!(bar(&[up_to(1.0), up_to(1.0)], 0.0), 0.95);
        assert_eq!(bar(&[idle([0.2, 0.3]), idle([0.2, 0.3])], 0.0), 0.31);
        assert_eq!(bar(&[idle([0.999; 30]), idle([0.999; 30])], 0.0), 1.0);
        assert_eq!(bar(&[], 0.0), 1.0);
    }

    #[test]
    fn the_bar_is_that_of_the_probabilities_as_they_are_stated() {
        // Odds of something of 19 to 1 become, by an offset of log 19, even.
        assert_eq!(bar(&[up_to(1.0), worlds(50, 0, 0.0)], 19f64.ln()), 0.5);
    }

    #[test]
    fn the_bar_weighs_hands_alike() {
        // .90 leaves none of the first and one in ten of the second, however many worlds either has.
        let few: Vec<Said> = up_to(0.9).into_iter().step_by(100).collect();
        assert_eq!(bar(&[few, up_to(1.0)], 0.0), 0.9);
    }

    #[test]
    fn nothing_is_stated_as_often_as_it_is_true() {
        assert_eq!(offset(&[worlds(100, 50, 0.5)]), 0.0);
        // Stated one in two, true three in four: odds of three to one.
        assert_eq!(offset(&[worlds(100, 75, 0.5)]), 1.1);
        assert_eq!(offset(&[worlds(100, 25, 0.5)]), -1.1);
        // In the mean of hands, however many worlds each has.
        assert_eq!(offset(&[worlds(1000, 75, 0.5), worlds(100, 25, 0.5)]), 0.0);
        // Hands that hold one kind alone tell nothing of how often.
        assert_eq!(offset(&[worlds(100, 75, 0.5), worlds(100, 100, 0.1)]), 1.1);
        assert_eq!(offset(&[worlds(100, 0, 0.5)]), 0.0);
    }

    #[test]
    fn an_effect_that_nothing_places_is_refused_with_a_remedy() {
        let mut label = Label::null("w1", "hovorka", "aid", 1, 14);
        label.effects.push(TrueEffect {
            effect: "magic".to_owned(),
            port: None,
            in_library: true,
            amplitude: 1.0,
            target_mg_dl: 5.0,
            achieved_mg_dl: 5.0,
            at_limit: false,
            form: None,
        });
        let error = truth(&label).expect_err("unknown").to_string();
        assert!(error.starts_with("world w1 has `magic`, which is not in the library"), "{error}");
        assert!(error.ends_with("make the table again with this version"), "{error}");
    }
}
