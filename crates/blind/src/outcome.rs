//! How an answer compares with the truth.

use contract::blind_check::{Answer, Kind, Label, Outcome, Verdict};
use contract::diagnosis::FoundEffect;

/// Compares an answer with a label.
#[must_use]
pub fn outcome(label: &Label, answer: &Answer) -> Outcome {
    match (answer.verdict, label.kind) {
        (Verdict::Failed, _) => Outcome::Failed,
        (Verdict::None, Kind::Null) | (Verdict::Unknown, Kind::Outside) => Outcome::Correct,
        (Verdict::None, _) => Outcome::Missed,
        (Verdict::Unknown, _) => Outcome::Unknown,
        (Verdict::Effect, Kind::Null | Kind::Outside) => Outcome::Wrong,
        (Verdict::Effect, Kind::Single | Kind::Pair) => of_names(label, &answer.found),
    }
}

fn of_names(label: &Label, found: &[FoundEffect]) -> Outcome {
    let named = label.effects.iter().filter(|e| found.iter().any(|f| f.effect == e.effect)).count();
    let extra = found.iter().any(|f| !label.has(&f.effect));
    if named == label.effects.len() {
        return if extra { Outcome::WithExtra } else { Outcome::Correct };
    }
    if named > 0 {
        return Outcome::Partial;
    }
    let in_set = found.iter().any(|f| f.set_holds(|other| label.has(other)));
    if in_set { Outcome::InSet } else { Outcome::Wrong }
}

/// Whether an effect is named that does not act and cannot be confused with one that does.
pub(crate) fn names_a_stranger(label: &Label, answer: &Answer) -> bool {
    answer.verdict == Verdict::Effect
        && answer
            .found
            .iter()
            .any(|f| !label.has(&f.effect) && !f.set_holds(|other| label.has(other)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planted::{answer, label};

    #[test]
    fn every_pair_of_truth_and_answer_has_its_outcome() {
        use Outcome::{Correct, Failed, InSet, Missed, Partial, Unknown, WithExtra, Wrong};
        let alcohol_or_dawn = {
            let mut planted = answer(&["alcohol"]);
            planted.found[0].confusable_with.push("dawn".to_owned());
            planted
        };
        let unknown = Answer { verdict: Verdict::Unknown, ..Answer::none() };
        let failed = Answer::failed("killed", 1.0);
        for (kind, truth, given, expected, stranger) in [
            (Kind::Null, &[][..], &Answer::none(), Correct, false),
            (Kind::Null, &[], &unknown, Unknown, false),
            (Kind::Null, &[], &answer(&["dawn"]), Wrong, true),
            (Kind::Null, &[], &failed, Failed, false),
            (Kind::Single, &["dawn"], &answer(&["dawn"]), Correct, false),
            (Kind::Single, &["dawn"], &answer(&["dawn", "alcohol"]), WithExtra, true),
            (Kind::Single, &["dawn"], &answer(&["alcohol"]), Wrong, true),
            (Kind::Single, &["dawn"], &alcohol_or_dawn, InSet, false),
            (Kind::Single, &["dawn"], &unknown, Unknown, false),
            (Kind::Single, &["dawn"], &Answer::none(), Missed, false),
            (Kind::Single, &["dawn"], &failed, Failed, false),
            (Kind::Pair, &["dawn", "exercise"], &answer(&["exercise", "dawn"]), Correct, false),
            (Kind::Pair, &["dawn", "exercise"], &answer(&["dawn"]), Partial, false),
            (Kind::Pair, &["dawn", "exercise"], &answer(&["dawn", "alcohol"]), Partial, true),
            (Kind::Pair, &["dawn", "exercise"], &answer(&["alcohol"]), Wrong, true),
            (Kind::Pair, &["dawn", "exercise"], &alcohol_or_dawn, InSet, false),
            (Kind::Outside, &["pump_occlusion"], &unknown, Correct, false),
            (Kind::Outside, &["pump_occlusion"], &answer(&["dawn"]), Wrong, true),
            (Kind::Outside, &["pump_occlusion"], &Answer::none(), Missed, false),
        ] {
            let label = label("w", kind, truth, 5.0);
            assert_eq!(outcome(&label, given), expected, "{truth:?} {given:?}");
            assert_eq!(names_a_stranger(&label, given), stranger, "{truth:?} {given:?}");
        }
    }
}
