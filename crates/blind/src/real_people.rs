//! Effects planted into real people's records, scored relative to the unchanged record.
//!
//! Nobody knows what is missing in a real person. So an answer is compared with the answer for the
//! unchanged record: the planted effect must be named, or its evidence must rise; no other name may
//! be new. Where the signal of an effect was removed or moved, its evidence must disappear.

use crate::share::{among, share};
use contract::Document as _;
use contract::blind_check::{
    Answer, CalibratedPeople, EvidencePair, PlantedCheck, PlantedLabel, PlantedRow, PlantedTotals,
    Verdict,
};
use contract::diagnosis::PersonSummary;

use std::collections::BTreeSet;

use crate::error::BlindError;

/// Nats by which evidence must rise to count as risen: odds of 20 to 1.
pub const RISEN_NATS: f64 = 3.0;

/// Nats that are expected of a reader who does not know where it happened for a change to count as visible in the record.
pub const TELLABLE_NATS: f64 = 6.0;

/// Counts the people of a diagnosis by their calibration.
#[must_use]
pub fn calibrated_people(people: &[PersonSummary]) -> CalibratedPeople {
    let mut counted = CalibratedPeople::default();
    for person in people {
        let Some(calibration) = &person.calibration else {
            counted.excluded += 1;
            continue;
        };
        let at_bound = calibration.factors.iter().any(|factor| factor.at_bound);
        counted.people += 1;
        counted.at_bound += usize::from(at_bound);
        counted.not_converged += usize::from(!calibration.converged);
        counted.ill += usize::from(at_bound || !calibration.converged);
    }
    counted
}

/// A cohort of real people with its label and its answer.
#[derive(Debug, Clone, PartialEq)]
pub struct AnsweredCohort {
    /// What was planted.
    pub label: PlantedLabel,
    /// What the diagnosis said.
    pub answer: Answer,
    /// How its people were calibrated; zeros where the diagnosis failed.
    pub calibrated: CalibratedPeople,
    /// What undoing the change exactly would gain in likelihood, nats; `None` where the readings
    /// were changed.
    pub undone_nats: Option<f64>,
    /// The evidence that is expected of a reader who knows everything but where it happened, nats.
    pub at_best_nats: Option<f64>,
}

fn evidence_pair(effect: &str, before: &Answer, after: &Answer) -> EvidencePair {
    let nats = |answer: &Answer| {
        answer.candidates.iter().find(|c| c.effect == effect).map(|c| c.gain_nats)
    };
    EvidencePair {
        effect: effect.to_owned(),
        before: nats(before),
        after: nats(after),
        named_before: names(before).contains(effect),
        named_after: names(after).contains(effect),
    }
}

/// Whether it rose by [`RISEN_NATS`]. Evidence below zero counts as zero, because it supports no
/// size: less evidence against an effect is not more for it.
fn risen(pair: &EvidencePair) -> bool {
    let (before, after) = (pair.before.unwrap_or(0.0), pair.after.unwrap_or(0.0));
    after.max(0.0) - before.max(0.0) >= RISEN_NATS
}

fn planted_row(cohort: &AnsweredCohort, before: &Answer) -> PlantedRow {
    let AnsweredCohort { label, answer, calibrated, undone_nats, at_best_nats } = cohort;
    let (old, new) = (names(before), names(answer));
    let planted = label.effect.as_deref();
    let asked = planted.into_iter().chain(label.evidence_lost.iter().map(String::as_str));
    let evidence: Vec<EvidencePair> =
        asked.map(|effect| evidence_pair(effect, before, answer)).collect();
    let is_named = planted.is_some_and(|effect| new.contains(effect));
    let in_set = planted.is_some_and(|effect| {
        answer.found.iter().any(|found| found.set_holds(|other| other == effect))
    });
    PlantedRow {
        verdict: answer.verdict,
        named: answer.found.iter().map(|found| found.effect.clone()).collect(),
        named_rightly: is_named,
        named_anew: is_named && planted.is_some_and(|effect| !old.contains(effect)),
        named_or_in_set: is_named || in_set,
        risen: planted.is_some() && evidence.iter().any(risen),
        strangers: new
            .iter()
            .filter(|name| !old.contains(*name) && planted != Some(**name))
            .map(|name| (*name).to_owned())
            .collect(),
        evidence,
        calibrated: *calibrated,
        undone_nats: *undone_nats,
        at_best_nats: *at_best_nats,
        seconds: answer.seconds,
        label: label.clone(),
    }
}

fn names(answer: &Answer) -> BTreeSet<&str> {
    answer.found.iter().map(|found| found.effect.as_str()).collect()
}

fn planted_totals(what: &str, rows: &[&PlantedRow]) -> Result<PlantedTotals, BlindError> {
    let rows = || rows.iter().copied().filter(|row| row.label.effect.is_some());
    let fresh = |row: &&PlantedRow| row.named_anew || !row.named_rightly;
    Ok(PlantedTotals {
        what: what.to_owned(),
        named: among(rows(), |row| row.named_rightly)?,
        named_anew: among(rows().filter(fresh), |row| row.named_anew)?,
        named_or_in_set: among(rows(), |row| row.named_or_in_set)?,
        risen: among(rows(), |row| row.risen)?,
        strangers: among(rows(), |row| !row.strangers.is_empty())?,
        tellable: among(rows().filter_map(|row| row.at_best_nats), |nats| *nats >= TELLABLE_NATS)?,
    })
}

/// Scores the answers; one of `cohorts` must be the unchanged record.
///
/// # Errors
/// [`BlindError::Unmatched`] without an unchanged record that was diagnosed.
pub fn planted_check(seed: u64, cohorts: &[AnsweredCohort]) -> Result<PlantedCheck, BlindError> {
    let is_changed = |cohort: &&AnsweredCohort| cohort.label.planting != NOTHING;
    let unmatched = |problem| BlindError::Unmatched { id: NOTHING.to_owned(), problem };
    let as_it_is = cohorts.iter().find(|cohort| !is_changed(cohort));
    let as_it_is = as_it_is.ok_or_else(|| unmatched("no cohort holds the record as it is"))?;
    if as_it_is.answer.verdict == Verdict::Failed {
        return Err(unmatched(
            "the record as it is could not be diagnosed, so that nothing can be held against it",
        ));
    }
    let changed = cohorts.iter().filter(is_changed);
    let mut rows: Vec<PlantedRow> =
        changed.map(|cohort| planted_row(cohort, &as_it_is.answer)).collect();
    rows.sort_by(|a, b| {
        let name = |row: &PlantedRow| (row.label.effect.is_none(), row.label.planting.clone());
        name(a).cmp(&name(b)).then(a.label.size.total_cmp(&b.label.size))
    });
    let all: Vec<&PlantedRow> = rows.iter().collect();
    let effects: BTreeSet<&str> =
        rows.iter().filter_map(|row| row.label.effect.as_deref()).collect();
    let of_effect = |effect: &str| -> Vec<&PlantedRow> {
        rows.iter().filter(|row| row.label.effect.as_deref() == Some(effect)).collect()
    };
    let by_effect: Result<Vec<_>, _> =
        effects.iter().map(|effect| planted_totals(effect, &of_effect(effect))).collect();
    let sizes = effects.iter().map(|effect| of_effect(effect).len()).max().unwrap_or(0);
    let by_size: Result<Vec<_>, _> = (0..sizes)
        .map(|rank| {
            let of_rank: Vec<&PlantedRow> =
                effects.iter().filter_map(|effect| of_effect(effect).get(rank).copied()).collect();
            planted_totals(&format!("size {}", rank + 1), &of_rank)
        })
        .collect();
    let answered = rows.iter().filter(|row| row.verdict != Verdict::Failed);
    let lost = answered.filter(|row| row.label.effect.is_none());
    let lost = lost.flat_map(|row| &row.evidence).filter(|evidence| evidence.named_before);
    let people = |count: fn(&CalibratedPeople) -> usize| -> usize {
        rows.iter().map(|row| count(&row.calibrated)).sum()
    };
    Ok(PlantedCheck {
        schema: PlantedCheck::SCHEMA.to_owned(),
        seed,
        as_it_is: as_it_is.answer.clone(),
        calibrated_as_it_is: as_it_is.calibrated,
        all: planted_totals("all", &all)?,
        by_effect: by_effect?,
        by_size: by_size?,
        strangers: among(&rows, |row| !row.strangers.is_empty())?,
        evidence_gone: among(lost, |evidence| !evidence.named_after)?,
        ill_calibrated: share(people(|c| c.ill), people(|c| c.people))?,
        failed: among(&rows, |row| row.verdict == Verdict::Failed)?,
        cohorts: rows,
    })
}

/// [`PlantedLabel::planting`] of the unchanged record.
pub const NOTHING: &str = "none";

#[cfg(test)]
mod tests {
    use super::*;

    use crate::planted::answer;
    use contract::blind_check::Share;
    use contract::diagnosis::{CalibrationSummary, CandidateEffect, FactorEstimate};

    fn cohort(planting: &str, size: f64, named: &[&str], nats: &[(&str, f64)]) -> AnsweredCohort {
        let candidates = nats
            .iter()
            .map(|(effect, gain_nats)| CandidateEffect {
                effect: (*effect).to_owned(),
                gain_nats: *gain_nats,
                probability: 0.5,
                not_named: None,
            })
            .collect();
        let lost = planting == "sleep_struck";
        AnsweredCohort {
            label: PlantedLabel {
                id: "c".to_owned(),
                planting: planting.to_owned(),
                effect: (planting != NOTHING && !lost).then(|| planting.to_owned()),
                evidence_lost: if lost { vec!["sleep_loss".to_owned()] } else { Vec::new() },
                size,
                unit: "min".to_owned(),
                inexact: String::new(),
                changed: 1,
            },
            answer: Answer { candidates, ..answer(named) },
            calibrated: CalibratedPeople { people: 4, at_bound: 1, ill: 1, ..Default::default() },
            undone_nats: None,
            at_best_nats: None,
        }
    }

    #[test]
    fn a_diagnosis_that_failed_is_no_evidence_that_is_gone() {
        let failed = |cohort: AnsweredCohort| AnsweredCohort {
            answer: Answer::failed("killed".to_owned(), 1.0),
            ..cohort
        };
        let as_it_is = || cohort(NOTHING, 0.0, &["sleep_loss"], &[("sleep_loss", 9.0)]);
        let struck = || cohort("sleep_struck", 1.0, &[], &[]);
        let check = |cohorts: &[AnsweredCohort]| planted_check(1, cohorts);
        let gone = |check: PlantedCheck| (check.evidence_gone.count, check.evidence_gone.of);
        assert_eq!(gone(check(&[as_it_is(), struck()]).expect("countable")), (1, 1));
        assert_eq!(gone(check(&[as_it_is(), failed(struck())]).expect("countable")), (0, 0));
        let error = check(&[failed(as_it_is()), struck()]).expect_err("nothing to compare with");
        assert!(error.to_string().contains("as it is"), "{error}");
    }

    #[test]
    fn names_and_evidence_are_compared_with_the_record_as_it_is() {
        let before = [("sensor_lag", 1.0), ("dawn", 9.0), ("missed_meals", -8.0)];
        let check = planted_check(
            1,
            &[
                cohort("sensor_lag", 12.0, &["sensor_lag", "dawn"], &[("sensor_lag", 14.0)]),
                cohort(NOTHING, 0.0, &["dawn", "sleep_loss"], &before),
                cohort("sensor_lag", 6.0, &["dawn", "exercise"], &[("sensor_lag", 3.9)]),
                // Less evidence against it is not more for it.
                cohort("missed_meals", 0.5, &["dawn"], &[("missed_meals", -1.0)]),
                AnsweredCohort {
                    undone_nats: Some(20.0),
                    at_best_nats: Some(5.9),
                    ..cohort("dawn", 1.0, &["dawn"], &[("dawn", 12.5)])
                },
                cohort("sleep_struck", 1.0, &["dawn"], &[]),
            ],
        )
        .expect("countable");
        // What an oracle gains does not count where a reader cannot expect it.
        assert_eq!((check.all.tellable.count, check.all.tellable.of), (0, 1));
        let sizes: Vec<(&str, f64)> =
            check.cohorts.iter().map(|row| (row.label.planting.as_str(), row.label.size)).collect();
        let expected = [
            ("dawn", 1.0),
            ("missed_meals", 0.5),
            ("sensor_lag", 6.0),
            ("sensor_lag", 12.0),
            ("sleep_struck", 1.0),
        ];
        assert_eq!(sizes, expected);
        let counted = |share: &Share| (share.count, share.of);
        assert_eq!(counted(&check.all.named), (2, 4));
        // The dawn was named before.
        assert_eq!(counted(&check.all.named_anew), (1, 3));
        assert_eq!(counted(&check.all.risen), (2, 4));
        assert_eq!(counted(&check.all.strangers), (1, 4));
        assert_eq!(check.cohorts[2].strangers, ["exercise"]);
        assert_eq!(counted(&check.evidence_gone), (1, 1));
        assert_eq!(counted(&check.ill_calibrated), (5, 20));
        assert_eq!(counted(&check.by_size[1].named), (1, 1));
        let lag = check.by_effect.iter().find(|totals| totals.what == "sensor_lag");
        assert_eq!(lag.map(|totals| counted(&totals.named)), Some((1, 2)));
    }

    #[test]
    fn a_check_without_the_record_as_it_is_cannot_be_scored() {
        let error = planted_check(1, &[cohort("dawn", 1.0, &[], &[])]).expect_err("no other");
        assert!(error.to_string().contains("record as it is"), "{error}");
    }

    #[test]
    fn people_at_bounds_are_counted() {
        let calibrated = |converged: bool, at_bound: bool| CalibrationSummary {
            factors: vec![FactorEstimate {
                factor: "egp0".to_owned(),
                value: 1.0,
                log_sd: 0.1,
                at_bound,
            }],
            converged,
            iterations: 3,
            log_covariance: Vec::new(),
            dependence: 1.0,
            innovation_sd: 1.0,
            autoregression: [0.0; 2],
            runs: 1,
            censored_readings: 0,
            unrecorded_doses: 0,
            weight_kg: 70.0,
            weight_assumed: true,
        };
        let person = |calibration: Option<CalibrationSummary>| PersonSummary {
            person_id: "p".to_owned(),
            days: 7,
            excluded: calibration.is_none().then(|| "too short".to_owned()),
            calibration,
        };
        let people =
            [Some(calibrated(true, true)), Some(calibrated(false, false)), None].map(person);
        let counted = calibrated_people(&people);
        let expected =
            CalibratedPeople { people: 2, at_bound: 1, not_converged: 1, ill: 2, excluded: 1 };
        assert_eq!(counted, expected);
    }
}
