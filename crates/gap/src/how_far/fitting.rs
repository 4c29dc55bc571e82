//! The fits before and after, all people of a fold together.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::NamedEffect;
use super::folds::FOLDS;
use super::hierarchy::{CohortAmplitudes, empirical_bayes};
use super::person_fold::PersonFold;
use super::refit::{Equations, Fit};
use super::subject::Subject;
use crate::filter::calibration::CalibrationRule;

/// Most Gauss-Newton iterations of the fits before and after alike; a fit ends earlier where the next step is
/// expected to be within the tolerance of the calibration.
const ITERATIONS: usize = 3;

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
        .flat_map(|fold| subjects.iter().enumerate().map(move |(index, s)| (fold, index, s)))
        .filter(|(fold, _, subject)| subject.folds.held_out(*fold).is_some())
        .map(|(fold, index, subject)| PersonFold::new(index, fold, subject))
        .collect();
    let priors: Vec<_> = driven.iter().map(|found| found.effect.card().prior).collect();
    person_folds
        .par_iter_mut()
        .for_each(|person_fold| person_fold.fit_before(ITERATIONS, calibration));
    let mut hierarchies: Vec<CohortAmplitudes> = Vec::new();
    if driven.is_empty() {
        return FoldFits { person_folds, hierarchies, variants: Vec::new() };
    }
    let variants = (0..FOLDS)
        .map(|fold| {
            let mut of_fold: Vec<&mut PersonFold<'_>> =
                person_folds.iter_mut().filter(|person_fold| person_fold.fold == fold).collect();
            (0..driven.len())
                .map(|index| choose_variant(&mut of_fold, subjects, driven, index, calibration))
                .collect()
        })
        .collect();
    for _ in 0..ITERATIONS {
        person_folds.par_iter_mut().for_each(|person_fold| person_fold.take_equations(calibration));
        hierarchies.clear();
        for fold in 0..FOLDS {
            let members: Vec<usize> = (0..person_folds.len())
                .filter(|k| person_folds[*k].fold == fold && person_folds[*k].equations().is_some())
                .collect();
            let known: Vec<&Equations> =
                members.iter().filter_map(|k| person_folds[*k].equations()).collect();
            if known.is_empty() {
                continue;
            }
            let inflation = inflation(&known, priors.len());
            let evidence: Vec<_> = known.iter().map(|e| e.evidence(&inflation)).collect();
            let hierarchy = empirical_bayes(&evidence, &priors);
            for (member, amplitudes) in members.iter().zip(&hierarchy.people) {
                person_folds[*member].move_after(amplitudes.clone(), calibration);
            }
            hierarchies.push(hierarchy);
        }
    }
    FoldFits { person_folds, hierarchies, variants }
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
    let effect = driven[index].effect;
    let given = driven[index].variant;
    let tried = subjects.iter().map(|s| effect.variants_for(&s.course)).max().unwrap_or(1);
    if tried < 2 {
        return given;
    }
    let found: Vec<Option<(Fit, Equations)>> = person_folds
        .par_iter_mut()
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
    let mut best = (given, if given < tried { gain(given) } else { 0.0 });
    for variant in 0..tried {
        let gain = gain(variant);
        if gain > best.1 {
            best = (variant, gain);
        }
    }
    for (person_fold, about) in person_folds.iter_mut().zip(found) {
        person_fold.set_variant(index, best.0, tried, about);
    }
    best.0
}

/// Information on a variant and its product with the estimate, with the effects after the first `tried`
/// columns profiled out and the other variants left out.
fn profiled(equations: &Equations, variant: usize, tried: usize) -> (f64, f64) {
    let all = equations.weighted.len();
    let mut own = equations.information[(variant, variant)];
    let mut product = equations.weighted[variant];
    if all == tried {
        return (own, product);
    }
    let others = all - tried;
    let inner = Mat::from_fn(others, others, |a, b| {
        let ridge = if a == b { 1.0 } else { 0.0 };
        equations.information[(tried + a, tried + b)] + ridge
    });
    let mixed = Mat::from_fn(others, 1, |a, _| equations.information[(tried + a, variant)]);
    let Ok(factor) = inner.llt(Side::Lower) else { return (own, product) };
    let answer = factor.solve(&mixed);
    for a in 0..others {
        own -= answer[(a, 0)] * mixed[(a, 0)];
        product -= answer[(a, 0)] * equations.weighted[tried + a];
    }
    (own, product)
}
