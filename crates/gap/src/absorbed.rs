//! What a person's residual network has already absorbed: the same evidence on the same days, with the
//! plant without the residual and with it.

use contract::diagnosis::{Absorbed, AbsorbedEffect, AbsorbedError};

use crate::Diagnosis;

/// Least evidence before of which a share is given, nats. Less is as likely to be chance.
const LEAST: f64 = 4.0;

/// Compares a diagnosis with the residual to one without.
///
/// `None` where they are not of the same people, whose evidence could not be compared.
#[must_use]
pub fn absorbed(without: &Diagnosis, with: &Diagnosis) -> Option<Absorbed> {
    let included = |diagnosis: &Diagnosis| -> Vec<String> {
        let people = diagnosis.people.iter().filter(|person| person.excluded.is_none());
        people.map(|person| person.person_id.clone()).collect()
    };
    if included(without) != included(with) {
        return None;
    }
    let mut effects: Vec<AbsorbedEffect> = effects::names()
        .into_iter()
        .filter_map(|name| {
            let evidence_before = *without.evidence.gains.get(name)?;
            let evidence_after = *with.evidence.gains.get(name)?;
            // Evidence against an effect is no evidence that is left.
            let share =
                (evidence_before >= LEAST).then(|| 1.0 - evidence_after.max(0.0) / evidence_before);
            let effect = name.to_owned();
            Some(AbsorbedEffect { effect, evidence_before, evidence_after, share })
        })
        .collect();
    effects.sort_by(|a, b| b.evidence_before.total_cmp(&a.evidence_before));
    let baseline = without
        .baseline
        .iter()
        .filter_map(|before| {
            let after = with.baseline.iter().find(|after| after.minutes == before.minutes)?;
            Some(AbsorbedError {
                minutes: before.minutes,
                mae_before: before.mae.value,
                mae_after: after.mae.value,
            })
        })
        .collect();
    Some(Absorbed {
        without: without.plant.clone(),
        verdict_without: without.verdict,
        found_without: without.effects.iter().map(|found| found.effect.clone()).collect(),
        effects,
        baseline,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagnosis(gains: &[(&str, f64)], mae: f64, excluded: Option<&str>) -> Diagnosis {
        let error =
            |value: f64| serde_json::json!({"value": value, "lower": value, "upper": value});
        let gains: serde_json::Map<String, serde_json::Value> =
            gains.iter().map(|(name, gain)| ((*name).to_owned(), (*gain).into())).collect();
        let diagnosis = serde_json::json!({
            "schema": "diagnosis/3", "verdict": "none", "effects": [],
            "candidates": [], "untried": [], "ports": [], "where": [],
            "evidence": {"person_days": 7.0, "gains": gains},
            "posterior": {"something": 0.1, "sets": [], "speaks_from": 0.75, "names_from": 0.5, "source": "made up"},
            "how_far": contract::diagnosis::HowFar::default(),
            "baseline": [{"minutes": 60, "mae": error(mae), "rmse": error(mae),
                "bias": error(0.0), "people": 1, "runs": 10}],
            "data_quality": [],
            "people": [{"person_id": "p", "days": 7, "excluded": excluded, "calibration": null}],
            "plant": "network", "seed": 1, "config": crate::DiagnosisConfig::working()});
        serde_json::from_value(diagnosis).expect("the layout of diagnosis.json")
    }

    #[test]
    fn the_share_is_of_the_evidence_before_and_only_where_there_was_some() {
        let before = [("dawn", 40.0), ("exercise", 10.0), ("slow_meals", 5.0), ("alcohol", 3.0)];
        let after = [("dawn", 10.0), ("exercise", 12.0), ("slow_meals", -3.0), ("alcohol", 0.0)];
        let (without, with) = (diagnosis(&before, 20.0, None), diagnosis(&after, 18.0, None));
        let found = absorbed(&without, &with).expect("the same people");
        let shares: Vec<(&str, Option<f64>)> =
            found.effects.iter().map(|e| (e.effect.as_str(), e.share)).collect();
        let expected = [
            ("dawn", Some(0.75)),
            ("exercise", Some(1.0 - 12.0 / 10.0)),
            ("slow_meals", Some(1.0)),
            ("alcohol", None),
        ];
        assert_eq!(shares, expected);
        let errors = AbsorbedError { minutes: 60, mae_before: 20.0, mae_after: 18.0 };
        assert_eq!(found.baseline, [errors]);
    }

    #[test]
    fn evidence_of_different_people_is_not_compared() {
        let (without, with) = (diagnosis(&[], 20.0, None), diagnosis(&[], 20.0, Some("no twin")));
        assert_eq!(absorbed(&without, &with), None);
    }
}
