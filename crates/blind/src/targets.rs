//! What the check must reach, and whether it does.

use serde::{Deserialize, Serialize};
use stats::proportion;

use crate::answer::Verdict;
use crate::check::{ScoredWorld, UnknownScore};
use crate::error::BlindError;
use crate::label::Kind;
use crate::outcome::{Outcome, names_a_stranger};
use crate::pairs::PairScore;
use crate::reliability::Reliability;
use crate::share::Share;

/// On which side of a limit a figure must lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// At the limit or above.
    AtLeast,
    /// At the limit or below.
    AtMost,
}

/// One figure that was promised. A figure that falls short is printed as such.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Short name.
    pub name: String,
    /// What is counted, in words.
    pub says: String,
    /// On which side of `target` the value must lie.
    pub bound: Bound,
    /// The limit.
    pub target: f64,
    /// What was measured; `None` if no world tests it.
    pub value: Option<f64>,
    /// Lower end of its 95 % interval.
    pub lower: Option<f64>,
    /// Upper end of its 95 % interval.
    pub upper: Option<f64>,
    /// The value if a truth within the set of effects that the answer cannot tell apart counts as
    /// named; `None` where sets play no part.
    pub value_counting_sets: Option<f64>,
    /// Worlds (or names, or probabilities) behind the value.
    pub of: usize,
    /// Whether the value meets the limit; `None` if no world tests it.
    pub met: Option<bool>,
}

impl Target {
    fn new(name: &str, says: &str, bound: Bound, target: f64) -> Self {
        Self {
            name: name.to_owned(),
            says: says.to_owned(),
            bound,
            target,
            value: None,
            lower: None,
            upper: None,
            value_counting_sets: None,
            of: 0,
            met: None,
        }
    }

    fn measured(self, value: Option<f64>, ends: Option<(f64, f64)>, of: usize) -> Self {
        let met = value.map(|value| match self.bound {
            Bound::AtLeast => value >= self.target,
            Bound::AtMost => value <= self.target,
        });
        Self { value, lower: ends.map(|e| e.0), upper: ends.map(|e| e.1), of, met, ..self }
    }

    fn share(self, share: &Share) -> Self {
        let ends = share.value.map(|_| (share.lower, share.upper));
        self.measured(share.value, ends, share.of)
    }

    fn counting_sets(self, value: Option<f64>) -> Self {
        Self { value_counting_sets: value, ..self }
    }
}

/// Every target with what was measured.
pub(crate) fn targets(
    worlds: &[ScoredWorld],
    unknown: &UnknownScore,
    pairs: &PairScore,
    reliability: &Reliability,
) -> Result<Vec<Target>, BlindError> {
    use Bound::{AtLeast, AtMost};
    let outcome = |w: &ScoredWorld| Outcome::of(&w.label, &w.answer);
    let of_kind = |kind| worlds.iter().filter(move |w| w.label.kind == kind);
    let mut all = Vec::new();
    for (shift, target, name, says) in [
        (5.0, 0.90, "named_at_5", "one effect that moves glucose by 5 mg/dL or more is named"),
        (10.0, 0.97, "named_at_10", "one effect that moves glucose by 10 mg/dL or more is named"),
    ] {
        let moved = || of_kind(Kind::Single).filter(move |w| w.label.largest_shift() >= shift);
        let named = Share::among(moved(), |w| outcome(w) == Outcome::Correct)?;
        let in_set = Share::among(moved(), |w| outcome(w).is_correct_or_in_set())?;
        let target = Target::new(name, says, AtLeast, target);
        all.push(target.share(&named).counting_sets(in_set.value));
    }
    let strangers = Share::among(of_kind(Kind::Single), |w| names_a_stranger(&w.label, &w.answer))?;
    let says = "with one effect, another is named that cannot be confused with it";
    all.push(Target::new("wrong_names", says, AtMost, 0.02).share(&strangers));

    let alarms = false_alarms(worlds)?;
    let says = "nothing acts, and the answer is not \"none\"";
    all.push(Target::new("false_alarms", says, AtMost, 0.05).share(&alarms));
    let limit = (alarms.of > 0)
        .then(|| proportion::exact_upper(alarms.count, alarms.of, 0.95))
        .transpose()?;
    let says = "one-sided exact 95 % upper limit of the false alarms";
    let target = Target::new("false_alarms_limit", says, AtMost, 0.08);
    all.push(target.measured(limit, None, alarms.of));

    let says = "an effect outside the library is called unknown";
    all.push(Target::new("unknown_recalled", says, AtLeast, 0.80).share(&unknown.recalled));
    let says = "what is rightly called unknown is placed at its port";
    let in_set = unknown.right_port_or_in_set.value;
    let target = Target::new("right_port", says, AtLeast, 0.85).share(&unknown.right_port);
    all.push(target.counting_sets(in_set));

    let ends = reliability.lower.zip(reliability.upper);
    let says = "expected calibration error of the stated probabilities";
    let target = Target::new("calibration_error", says, AtMost, 0.05);
    all.push(
        target
            .measured(reliability.expected_calibration_error, ends, reliability.probabilities)
            .counting_sets(reliability.error_counting_sets),
    );

    let says = "F1 of the names in worlds with two effects";
    let target = Target::new("pairs_f1", says, AtLeast, 0.80);
    let ends = pairs.f1_lower.zip(pairs.f1_upper);
    all.push(target.measured(pairs.f1, ends, pairs.worlds).counting_sets(pairs.f1_counting_sets));

    let failed = Share::among(worlds, |w| w.answer.verdict == Verdict::Failed)?;
    let says = "the diagnosis ends without an answer";
    all.push(Target::new("failed", says, AtMost, 0.0).share(&failed));
    Ok(all)
}

/// Null worlds whose answer names an effect or says "unknown".
pub(crate) fn false_alarms(worlds: &[ScoredWorld]) -> Result<Share, BlindError> {
    let nulls = worlds.iter().filter(|w| w.label.kind == Kind::Null);
    Share::among(nulls, |w| matches!(w.answer.verdict, Verdict::Effect | Verdict::Unknown))
}
