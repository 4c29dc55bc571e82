//! Effects planted into real people's records, scored beside the record as it is.
//!
//! Nobody knows what is missing in a real person. So an answer is compared with the answer for the
//! unchanged record: the planted effect has to be named, or its evidence to rise; no other name may be new.
//! Where what signals an effect was struck or moved, its evidence has to go.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::answer::{Answer, Verdict};
use crate::error::BlindError;
use crate::share::Share;

/// Value of [`PlantedCheck::schema`].
pub const PLANTED_SCHEMA: &str = "planted/1";
/// Nats by which evidence must rise to count as risen: odds of 20 to 1.
pub const RISEN_NATS: f64 = 3.0;

/// Nats that undoing a change exactly must gain for the change to count as one that can be told.
pub const TELLABLE_NATS: f64 = 6.0;

/// The label of a cohort of real people: what is sealed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantedLabel {
    /// Name of the cohort and of its folder.
    pub id: String,
    /// What was planted; `none` for the record as it is.
    pub planting: String,
    /// The effect that has to be named; `None` where nothing was planted that the library holds.
    pub effect: Option<String>,
    /// Effects whose evidence has to go.
    #[serde(default)]
    pub evidence_lost: Vec<String>,
    /// Size, in `unit`.
    pub size: f64,
    /// Unit of the size.
    pub unit: String,
    /// How the planting differs from the effect's definition; empty where it does not.
    #[serde(default)]
    pub inexact: String,
    /// Entries of the records that were changed.
    pub changed: usize,
}

/// How the plant was calibrated to the people of one cohort.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CalibratedPeople {
    /// People who were diagnosed.
    pub people: usize,
    /// Of these, those with a factor at its bound.
    pub at_bound: usize,
    /// Of these, those whose calibration did not converge.
    pub not_converged: usize,
    /// Of these, those with either.
    pub ill: usize,
    /// People who were left out.
    pub excluded: usize,
}

impl CalibratedPeople {
    /// Counts the people of a `diagnosis.json`.
    ///
    /// # Errors
    /// [`BlindError::Diagnosis`] if the text is none.
    pub fn of_diagnosis(text: &[u8]) -> Result<Self, BlindError> {
        let diagnosis: DiagnosedPeople = serde_json::from_slice(text)
            .map_err(|error| BlindError::Diagnosis { problem: error.to_string() })?;
        let mut counted = Self::default();
        for person in diagnosis.people {
            let Some(calibration) = person.calibration else {
                counted.excluded += 1;
                continue;
            };
            let at_bound = calibration.factors.iter().any(|factor| factor.at_bound);
            counted.people += 1;
            counted.at_bound += usize::from(at_bound);
            counted.not_converged += usize::from(!calibration.converged);
            counted.ill += usize::from(at_bound || !calibration.converged);
        }
        Ok(counted)
    }
}

/// The part of `diagnosis.json` that tells of people.
#[derive(Deserialize)]
struct DiagnosedPeople {
    people: Vec<DiagnosedPerson>,
}

#[derive(Deserialize)]
struct DiagnosedPerson {
    calibration: Option<PersonCalibration>,
}

#[derive(Deserialize)]
struct PersonCalibration {
    converged: bool,
    factors: Vec<CalibratedFactor>,
}

#[derive(Deserialize)]
struct CalibratedFactor {
    at_bound: bool,
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
    /// What undoing the change exactly would gain in likelihood, nats; `None` where the readings were changed.
    pub undone_nats: Option<f64>,
}

/// Evidence for one effect before and after, nats; `None` where the effect could not be tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvidencePair {
    /// The effect.
    pub effect: String,
    /// For the record as it is.
    pub before: Option<f64>,
    /// For the changed record.
    pub after: Option<f64>,
    /// Whether it is named for the record as it is.
    pub named_before: bool,
    /// Whether it is named for the changed record.
    pub named_after: bool,
}

impl EvidencePair {
    fn of(effect: &str, before: &Answer, after: &Answer) -> Self {
        let nats = |answer: &Answer| {
            answer.candidates.iter().find(|c| c.effect == effect).map(|c| c.gain_nats)
        };
        Self {
            effect: effect.to_owned(),
            before: nats(before),
            after: nats(after),
            named_before: names(before).contains(effect),
            named_after: names(after).contains(effect),
        }
    }

    /// Whether it rose by [`RISEN_NATS`]; evidence below zero speaks for no size and counts as zero, so that
    /// less against an effect is not more for it.
    fn risen(&self) -> bool {
        let (before, after) = (self.before.unwrap_or(0.0), self.after.unwrap_or(0.0));
        after.max(0.0) - before.max(0.0) >= RISEN_NATS
    }

    /// Whether what was named is named no more.
    fn gone(&self) -> bool {
        !self.named_after
    }
}

/// One planted cohort, scored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantedRow {
    /// The label.
    pub label: PlantedLabel,
    /// The answer in one word.
    pub verdict: Verdict,
    /// What was named, in its order.
    pub named: Vec<String>,
    /// Evidence for the planted effect, or for those that had to lose it.
    pub evidence: Vec<EvidencePair>,
    /// Whether the planted effect is named.
    pub named_rightly: bool,
    /// Whether it is named and was not before.
    pub named_anew: bool,
    /// Whether the planted effect is named or stands in the set of one that is.
    pub named_or_in_set: bool,
    /// Whether its evidence rose by [`RISEN_NATS`].
    pub risen: bool,
    /// Names that the record as it is does not have, the planted one aside.
    pub strangers: Vec<String>,
    /// How the people were calibrated.
    pub calibrated: CalibratedPeople,
    /// What undoing the change exactly would gain, nats: what an oracle would win that judges glucose through this plant.
    #[serde(default)]
    pub undone_nats: Option<f64>,
    /// Time of the diagnosis, s.
    pub seconds: f64,
}

impl PlantedRow {
    fn of(cohort: &AnsweredCohort, before: &Answer) -> Self {
        let AnsweredCohort { label, answer, calibrated, undone_nats } = cohort;
        let (old, new) = (names(before), names(answer));
        let planted = label.effect.as_deref();
        let asked = planted.into_iter().chain(label.evidence_lost.iter().map(String::as_str));
        let evidence: Vec<EvidencePair> =
            asked.map(|effect| EvidencePair::of(effect, before, answer)).collect();
        let is_named = planted.is_some_and(|effect| new.contains(effect));
        let in_set = planted.is_some_and(|effect| {
            answer.found.iter().any(|found| found.set_holds(|other| other == effect))
        });
        Self {
            verdict: answer.verdict,
            named: answer.found.iter().map(|found| found.effect.clone()).collect(),
            named_rightly: is_named,
            named_anew: is_named && planted.is_some_and(|effect| !old.contains(effect)),
            named_or_in_set: is_named || in_set,
            risen: planted.is_some() && evidence.iter().any(EvidencePair::risen),
            strangers: new
                .iter()
                .filter(|name| !old.contains(*name) && planted != Some(**name))
                .map(|name| (*name).to_owned())
                .collect(),
            evidence,
            calibrated: *calibrated,
            undone_nats: *undone_nats,
            seconds: answer.seconds,
            label: label.clone(),
        }
    }
}

fn names(answer: &Answer) -> BTreeSet<&str> {
    answer.found.iter().map(|found| found.effect.as_str()).collect()
}

/// Counts over some of the planted cohorts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantedTotals {
    /// What is counted: an effect, a multiple of the usual size, or everything.
    pub what: String,
    /// Cohorts in which the planted effect is named.
    pub named: Share,
    /// Of those in which it was not named before: those in which it is now.
    pub named_anew: Share,
    /// Cohorts in which it is named or in the set of one that is.
    pub named_or_in_set: Share,
    /// Cohorts in which its evidence rose by [`RISEN_NATS`].
    pub risen: Share,
    /// Cohorts in which another effect is named that was not before.
    pub strangers: Share,
    /// Of the cohorts for which it is known: those in which undoing the change exactly gains [`TELLABLE_NATS`].
    pub tellable: Share,
}

impl PlantedTotals {
    fn of(what: &str, rows: &[&PlantedRow]) -> Result<Self, BlindError> {
        let rows = || rows.iter().copied().filter(|row| row.label.effect.is_some());
        let fresh = |row: &&PlantedRow| row.named_anew || !row.named_rightly;
        Ok(Self {
            what: what.to_owned(),
            named: Share::among(rows(), |row| row.named_rightly)?,
            named_anew: Share::among(rows().filter(fresh), |row| row.named_anew)?,
            named_or_in_set: Share::among(rows(), |row| row.named_or_in_set)?,
            risen: Share::among(rows(), |row| row.risen)?,
            strangers: Share::among(rows(), |row| !row.strangers.is_empty())?,
            tellable: Share::among(rows().filter(|row| row.undone_nats.is_some()), |row| {
                row.undone_nats.is_some_and(|nats| nats >= TELLABLE_NATS)
            })?,
        })
    }
}

/// A check of one cohort of real people: `planted.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantedCheck {
    /// [`PLANTED_SCHEMA`].
    pub schema: String,
    /// Seed of what was drawn.
    pub seed: u64,
    /// What the diagnosis says of the record as it is.
    pub as_it_is: Answer,
    /// How its people were calibrated there.
    pub calibrated_as_it_is: CalibratedPeople,
    /// Every planted cohort, by what was planted and by size.
    pub cohorts: Vec<PlantedRow>,
    /// Counts over all cohorts with an effect of the library.
    pub all: PlantedTotals,
    /// Counts by effect.
    pub by_effect: Vec<PlantedTotals>,
    /// Counts by size: the smallest of each effect, then the next.
    pub by_size: Vec<PlantedTotals>,
    /// Cohorts in which another effect is named that was not before, whatever was planted or struck.
    pub strangers: Share,
    /// Effects that were named and have lost what signals them: those that are named no more.
    pub evidence_gone: Share,
    /// People over all changed cohorts whose calibration ends at a bound or does not converge.
    pub ill_calibrated: Share,
    /// Cohorts whose diagnosis ended without an answer.
    pub failed: Share,
}

impl PlantedCheck {
    /// Scores the answers; one of `cohorts` must be the record as it is.
    ///
    /// # Errors
    /// [`BlindError::Unmatched`] without a record as it is.
    pub fn score(seed: u64, cohorts: &[AnsweredCohort]) -> Result<Self, BlindError> {
        let is_changed = |cohort: &&AnsweredCohort| cohort.label.planting != NOTHING;
        let as_it_is = cohorts.iter().find(|cohort| !is_changed(cohort)).ok_or_else(|| {
            let problem = "no cohort holds the record as it is";
            BlindError::Unmatched { id: NOTHING.to_owned(), problem }
        })?;
        let changed = cohorts.iter().filter(is_changed);
        let mut rows: Vec<PlantedRow> =
            changed.map(|cohort| PlantedRow::of(cohort, &as_it_is.answer)).collect();
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
            effects.iter().map(|effect| PlantedTotals::of(effect, &of_effect(effect))).collect();
        let sizes = effects.iter().map(|effect| of_effect(effect).len()).max().unwrap_or(0);
        let by_size: Result<Vec<_>, _> = (0..sizes)
            .map(|rank| {
                let of_rank: Vec<&PlantedRow> = effects
                    .iter()
                    .filter_map(|effect| of_effect(effect).get(rank).copied())
                    .collect();
                PlantedTotals::of(&format!("size {}", rank + 1), &of_rank)
            })
            .collect();
        let lost = rows.iter().filter(|row| row.label.effect.is_none());
        let lost = lost.flat_map(|row| &row.evidence).filter(|evidence| evidence.named_before);
        let people = |count: fn(&CalibratedPeople) -> usize| -> usize {
            rows.iter().map(|row| count(&row.calibrated)).sum()
        };
        Ok(Self {
            schema: PLANTED_SCHEMA.to_owned(),
            seed,
            as_it_is: as_it_is.answer.clone(),
            calibrated_as_it_is: as_it_is.calibrated,
            all: PlantedTotals::of("all", &all)?,
            by_effect: by_effect?,
            by_size: by_size?,
            strangers: Share::among(&rows, |row| !row.strangers.is_empty())?,
            evidence_gone: Share::among(lost, |evidence| evidence.gone())?,
            ill_calibrated: Share::of(people(|c| c.ill), people(|c| c.people))?,
            failed: Share::among(&rows, |row| row.verdict == Verdict::Failed)?,
            cohorts: rows,
        })
    }
}

/// [`PlantedLabel::planting`] of the record as it is.
pub const NOTHING: &str = "none";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Candidate;
    use crate::planted::answer;

    fn cohort(planting: &str, size: f64, named: &[&str], nats: &[(&str, f64)]) -> AnsweredCohort {
        let candidates = nats
            .iter()
            .map(|(effect, gain_nats)| Candidate {
                effect: (*effect).to_owned(),
                gain_nats: *gain_nats,
                probability: 0.5,
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
        }
    }

    #[test]
    fn names_and_evidence_are_compared_with_the_record_as_it_is() {
        let before = [("sensor_lag", 1.0), ("dawn", 9.0), ("missed_meals", -8.0)];
        let check = PlantedCheck::score(
            1,
            &[
                cohort("sensor_lag", 12.0, &["sensor_lag", "dawn"], &[("sensor_lag", 14.0)]),
                cohort(NOTHING, 0.0, &["dawn", "sleep_loss"], &before),
                cohort("sensor_lag", 6.0, &["dawn", "exercise"], &[("sensor_lag", 3.9)]),
                // Less against it is not more for it.
                cohort("missed_meals", 0.5, &["dawn"], &[("missed_meals", -1.0)]),
                cohort("dawn", 1.0, &["dawn"], &[("dawn", 12.5)]),
                cohort("sleep_struck", 1.0, &["dawn"], &[]),
            ],
        )
        .expect("countable");
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
        let error = PlantedCheck::score(1, &[cohort("dawn", 1.0, &[], &[])]).expect_err("no other");
        assert!(error.to_string().contains("record as it is"), "{error}");
    }

    #[test]
    fn people_at_bounds_are_counted() {
        let text = br#"{"verdict": "none", "people": [
            {"person_id": "a", "excluded": null,
             "calibration": {"converged": true, "factors": [{"factor": "egp_0", "at_bound": true}]}},
            {"person_id": "b", "excluded": null,
             "calibration": {"converged": false, "factors": [{"factor": "egp_0", "at_bound": false}]}},
            {"person_id": "c", "excluded": "too short", "calibration": null}]}"#;
        let counted = CalibratedPeople::of_diagnosis(text).expect("a diagnosis");
        let expected =
            CalibratedPeople { people: 2, at_bound: 1, not_converged: 1, ill: 2, excluded: 1 };
        assert_eq!(counted, expected);
        assert!(CalibratedPeople::of_diagnosis(b"{}").is_err());
    }
}
