//! What training days give: the fits before and after, and the strength of hidden effects, all people of a fold together.

use effects::Form;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::folds::FOLDS;
use super::hierarchy::{CohortAmplitudes, empirical_bayes};
use super::person_fold::{ITERATIONS, PersonFold};
use super::reconstruction::{Strength, StrengthSums, published};
use super::refit::{Equations, Fit};
use super::{NamedEffect, Subject};
use crate::filter::calibration::CalibrationRule;

/// What training days gave.
pub(super) struct FoldFits<'a> {
    /// Every person in every fold.
    pub(super) person_folds: Vec<PersonFold<'a>>,
    /// Amplitudes of the cohort in each fold.
    pub(super) hierarchies: Vec<CohortAmplitudes>,
    /// Variant of each driven effect, a list a fold.
    pub(super) variants: Vec<Vec<usize>>,
}

/// Fits before and after for every person and fold.
///
/// Variants are chosen again in each fold, on its training days and with the calibration before.
pub(super) fn fitted<'a>(
    subjects: &'a [Subject<'a>],
    driven: &[&NamedEffect<'_>],
    calibration: &CalibrationRule,
) -> FoldFits<'a> {
    let mut person_folds: Vec<PersonFold<'_>> = (0..FOLDS)
        .into_par_iter()
        .flat_map(|fold| {
            subjects.par_iter().filter_map(move |s| PersonFold::new(s, fold, calibration))
        })
        .collect();
    let mut hierarchies: Vec<CohortAmplitudes> = Vec::new();
    if driven.is_empty() {
        return FoldFits { person_folds, hierarchies, variants: Vec::new() };
    }
    let variants = (0..FOLDS)
        .map(|fold| {
            let of_fold = person_folds.iter_mut().filter(|person_fold| person_fold.fold == fold);
            let mut of_fold: Vec<&mut PersonFold<'_>> = of_fold.collect();
            (0..driven.len())
                .map(|index| choose_variant(&mut of_fold, subjects, driven, index, calibration))
                .collect()
        })
        .collect();
    let priors: Vec<_> = driven.iter().map(|found| found.effect.card().prior).collect();
    for _ in 0..ITERATIONS {
        person_folds.par_iter_mut().for_each(|person_fold| person_fold.take_equations(calibration));
        hierarchies.clear();
        for fold in 0..FOLDS {
            let mut members: Vec<&mut PersonFold<'_>> = person_folds
                .iter_mut()
                .filter(|member| member.fold == fold && member.equations().is_some())
                .collect();
            if members.is_empty() {
                continue;
            }
            let known: Vec<&Equations> = members.iter().filter_map(|m| m.equations()).collect();
            let inflation = inflation(&known, priors.len());
            let evidence: Vec<_> = known.iter().map(|e| e.evidence(&inflation)).collect();
            let hierarchy = empirical_bayes(&evidence, &priors);
            for (member, amplitudes) in members.iter_mut().zip(&hierarchy.people) {
                member.move_after(amplitudes.clone(), calibration);
            }
            hierarchies.push(hierarchy);
        }
    }
    FoldFits { person_folds, hierarchies, variants }
}

impl FoldFits<'_> {
    /// How frequent and strong each hidden effect, by its number, is in the training days of each fold, over all people:
    /// one list a fold. Who cannot be counted is left to a note.
    pub(super) fn strengths(
        &self,
        subjects: &[Subject<'_>],
        found: &[NamedEffect<'_>],
        hidden: &[usize],
        calibration: &CalibrationRule,
        notes: &mut Vec<String>,
    ) -> Vec<Vec<(usize, Strength)>> {
        let first = hidden.iter().filter_map(|index| {
            let mut forms = subjects.iter().filter_map(|s| s.forms[*index].as_ref());
            let form = forms.find(|form| **form != Form::Driven)?;
            let amplitudes = (0..subjects.len()).map(|person| found[*index].amplitude(person));
            let mean = amplitudes.sum::<f64>() / subjects.len() as f64;
            Some((*index, published(form, mean)))
        });
        let first: Vec<(usize, Strength)> = first.collect();
        let tallies: Vec<Option<Vec<StrengthSums>>> = self
            .person_folds
            .par_iter()
            .map(|person_fold| person_fold.tallies(&first, calibration).ok())
            .collect();
        let lost = tallies.iter().filter(|tally| tally.is_none()).count();
        if lost > 0 {
            notes.push(format!("hidden events of {lost} fits could not be counted"));
        }
        let mut sums = vec![vec![StrengthSums::default(); first.len()]; FOLDS];
        for (person_fold, tallies) in self.person_folds.iter().zip(&tallies) {
            for (sum, tally) in sums[person_fold.fold].iter_mut().zip(tallies.iter().flatten()) {
                *sum = sum.plus(*tally);
            }
        }
        let strength = |(sum, (index, before)): (&StrengthSums, &(usize, Strength))| {
            (*index, sum.strength(*before))
        };
        sums.iter().map(|sums| sums.iter().zip(&first).map(strength).collect()).collect()
    }
}

/// By how much the information on each amplitude is overstated because steps of a day are not independent:
/// the squared scores of days over the information, over all people together.
fn inflation(equations: &[&Equations], effects: usize) -> Vec<f64> {
    (0..effects)
        .map(|effect| {
            let by_day: f64 = equations.iter().map(|e| e.by_day[effect]).sum();
            let by_step: f64 = equations.iter().map(|e| e.information[(effect, effect)]).sum();
            if by_step > 0.0 { (by_day / by_step).max(1.0) } else { 1.0 }
        })
        .collect()
}

/// Gives an effect the variant that explains most of a fold's training days, and returns it.
///
/// The other effects keep their variants and are profiled out. The variant found on the whole record is
/// kept unless another explains more.
fn choose_variant(
    person_folds: &mut [&mut PersonFold<'_>],
    subjects: &[Subject<'_>],
    driven: &[&NamedEffect<'_>],
    index: usize,
    calibration: &CalibrationRule,
) -> usize {
    let NamedEffect { effect, variant: given, .. } = *driven[index];
    let tried = subjects.iter().map(|s| effect.variants_for(&s.course)).max().unwrap_or(1);
    if tried < 2 {
        return given;
    }
    let found: Vec<Option<(Fit, Equations)>> = person_folds
        .par_iter()
        .map(|person_fold| person_fold.equations_of_variants(index, tried, calibration))
        .collect();
    let known: Vec<&Equations> = found.iter().flatten().map(|(_, equations)| equations).collect();
    let inflation = inflation(&known, tried);
    let gain = |variant: usize| {
        let (mut information, mut weighted) = (0.0, 0.0);
        for equations in &known {
            let (own, product) = profiled(equations, variant, tried);
            information += own;
            weighted += product;
        }
        // Amplitudes are not negative.
        let gain = 0.5 * weighted.max(0.0).powi(2) / information;
        if information > 0.0 { gain / inflation[variant] } else { 0.0 }
    };
    let of_given = if given < tried { gain(given) } else { 0.0 };
    let all = (0..tried).map(|variant| (variant, gain(variant)));
    let better = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
    let (best, _) = all.fold((given, of_given), better);
    for (person_fold, about) in person_folds.iter_mut().zip(found) {
        person_fold.set_variant(index, best, tried, about);
    }
    best
}

/// Information on a variant and its product with the estimate, with the effects after the first `tried`
/// columns profiled out and the other variants left out.
fn profiled(equations: &Equations, variant: usize, tried: usize) -> (f64, f64) {
    let Equations { information, weighted, .. } = equations;
    let mut own = information[(variant, variant)];
    let mut product = weighted[variant];
    let others = weighted.len() - tried;
    if others == 0 {
        return (own, product);
    }
    let inner = Mat::from_fn(others, others, |a, b| {
        let ridge = if a == b { 1.0 } else { 0.0 };
        information[(tried + a, tried + b)] + ridge
    });
    let mixed = Mat::from_fn(others, 1, |a, _| information[(tried + a, variant)]);
    let Ok(factor) = inner.llt(Side::Lower) else { return (own, product) };
    let answer = factor.solve(&mixed);
    for a in 0..others {
        own -= answer[(a, 0)] * mixed[(a, 0)];
        product -= answer[(a, 0)] * weighted[tried + a];
    }
    (own, product)
}
