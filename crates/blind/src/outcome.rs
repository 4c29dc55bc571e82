//! How an answer compares with the truth.

use serde::{Deserialize, Serialize};

use crate::answer::{Answer, Found, Verdict};
use crate::label::{Kind, Label};

/// How the answer for one world compares with its label.
///
/// What is right depends on the kind of world: "none" for a null world, all effects and no other
/// for one or two effects, "unknown" for an effect outside the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Right, and nothing besides.
    Correct,
    /// Every effect is named, and one that does not act as well.
    WithExtra,
    /// One of two effects is named.
    Partial,
    /// No effect is named, but one of them stands in the set of those that an effect that is named
    /// cannot be told from.
    InSet,
    /// An effect is named that does not act, and none that does.
    Wrong,
    /// "Unknown" where that is not right.
    Unknown,
    /// "None" where something acts.
    Missed,
    /// No answer.
    Failed,
}

impl Outcome {
    /// Compares an answer with a label.
    #[must_use]
    pub fn of(label: &Label, answer: &Answer) -> Self {
        match (answer.verdict, label.kind) {
            (Verdict::Failed, _) => Self::Failed,
            (Verdict::None, Kind::Null) | (Verdict::Unknown, Kind::Outside) => Self::Correct,
            (Verdict::None, _) => Self::Missed,
            (Verdict::Unknown, _) => Self::Unknown,
            (Verdict::Effect, Kind::Null | Kind::Outside) => Self::Wrong,
            (Verdict::Effect, Kind::Single | Kind::Pair) => Self::of_names(label, &answer.found),
        }
    }

    fn of_names(label: &Label, found: &[Found]) -> Self {
        let named =
            label.effects.iter().filter(|e| found.iter().any(|f| f.effect == e.effect)).count();
        let extra = found.iter().any(|f| !label.has(&f.effect));
        if named == label.effects.len() {
            return if extra { Self::WithExtra } else { Self::Correct };
        }
        if named > 0 {
            return Self::Partial;
        }
        let in_set = found.iter().any(|f| f.set_holds(|other| label.has(other)));
        if in_set { Self::InSet } else { Self::Wrong }
    }

    /// Whether it is right, or the truth stands in the set that the answer offers.
    #[must_use]
    pub const fn is_correct_or_in_set(self) -> bool {
        matches!(self, Self::Correct | Self::InSet)
    }
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
        for (kind, truth, given, outcome, stranger) in [
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
            assert_eq!(Outcome::of(&label, given), outcome, "{truth:?} {given:?}");
            assert_eq!(names_a_stranger(&label, given), stranger, "{truth:?} {given:?}");
        }
    }
}
