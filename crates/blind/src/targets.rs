//! What the check must reach, and whether it does.

use crate::outcome::outcome;
use crate::share::among;
use contract::blind_check::{
    Bound, Kind, Outcome, PairScore, Reliability, Share, Target, UnknownScore, Verdict,
};

use stats::proportion;

use crate::error::BlindError;
use crate::outcome::names_a_stranger;
use crate::scored_world::ScoredWorld;

fn promised(name: &str, says: &str, bound: Bound, target: f64) -> Target {
    Target {
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

fn measured(target: Target, value: Option<f64>, ends: Option<(f64, f64)>, of: usize) -> Target {
    let met = value.map(|value| match target.bound {
        Bound::AtLeast => value >= target.target,
        Bound::AtMost => value <= target.target,
    });
    Target { value, lower: ends.map(|e| e.0), upper: ends.map(|e| e.1), of, met, ..target }
}

fn with_share(target: Target, share: &Share) -> Target {
    let ends = share.value.map(|_| (share.lower, share.upper));
    measured(target, share.value, ends, share.of)
}

fn counting_sets(target: Target, value: Option<f64>) -> Target {
    Target { value_counting_sets: value, ..target }
}

/// Every target with what was measured.
pub(crate) fn targets(
    worlds: &[ScoredWorld],
    unknown: &UnknownScore,
    pairs: &PairScore,
    reliability: &Reliability,
) -> Result<Vec<Target>, BlindError> {
    use Bound::{AtLeast, AtMost};
    let outcome = |w: &ScoredWorld| outcome(&w.label, &w.answer);
    let of_kind = |kind| worlds.iter().filter(move |w| w.label.kind == kind);
    let mut all = Vec::new();
    for (shift, target, name, says) in [
        (
            5.0,
            0.90,
            "named_at_5",
            "one effect that moves glucose by 5 mg/dL or more is named, and no other",
        ),
        (
            10.0,
            0.97,
            "named_at_10",
            "one effect that moves glucose by 10 mg/dL or more is named, and no other",
        ),
    ] {
        let moved = || of_kind(Kind::Single).filter(move |w| w.label.largest_shift() >= shift);
        let named = among(moved(), |w| outcome(w) == Outcome::Correct)?;
        let in_set = among(moved(), |w| outcome(w).is_correct_or_in_set())?;
        let target = promised(name, says, AtLeast, target);
        all.push(counting_sets(with_share(target, &named), in_set.value));
    }
    let strangers = among(of_kind(Kind::Single), |w| names_a_stranger(&w.label, &w.answer))?;
    let says = "with one effect, another is named that cannot be confused with it";
    all.push(with_share(promised("wrong_names", says, AtMost, 0.02), &strangers));

    let alarms = false_alarms(worlds)?;
    let says = "nothing acts, and the answer is not \"none\"";
    all.push(with_share(promised("false_alarms", says, AtMost, 0.05), &alarms));
    let limit = (alarms.of > 0)
        .then(|| proportion::exact_upper(alarms.count, alarms.of, 0.95))
        .transpose()?;
    let says = "one-sided exact 95 % upper limit of the false alarms";
    let target = promised("false_alarms_limit", says, AtMost, 0.08);
    all.push(measured(target, limit, None, alarms.of));

    let says = "an effect outside the library is called unknown";
    let target = promised("unknown_recalled", says, AtLeast, 0.80);
    all.push(with_share(target, &unknown.recalled));
    let says = "what is rightly called unknown is placed at its port";
    let in_set = unknown.right_port_or_in_set.value;
    let target = promised("right_port", says, AtLeast, 0.85);
    all.push(counting_sets(with_share(target, &unknown.right_port), in_set));

    let ends = reliability.lower.zip(reliability.upper);
    let says = "expected calibration error of the stated probabilities";
    let target = promised("calibration_error", says, AtMost, 0.05);
    let error = reliability.expected_calibration_error;
    let target = measured(target, error, ends, reliability.probabilities);
    all.push(counting_sets(target, reliability.error_counting_sets));

    let says = "F1 of the names in worlds with two effects";
    let target = promised("pairs_f1", says, AtLeast, 0.80);
    let ends = pairs.f1_lower.zip(pairs.f1_upper);
    let target = measured(target, pairs.f1, ends, pairs.worlds);
    all.push(counting_sets(target, pairs.f1_counting_sets));

    let failed = among(worlds, |w| w.answer.verdict == Verdict::Failed)?;
    let says = "the diagnosis ends without an answer";
    all.push(with_share(promised("failed", says, AtMost, 0.0), &failed));
    Ok(all)
}

/// Null worlds whose answer names an effect or says "unknown".
pub(crate) fn false_alarms(worlds: &[ScoredWorld]) -> Result<Share, BlindError> {
    let nulls = worlds.iter().filter(|w| w.label.kind == Kind::Null);
    among(nulls, |w| w.answer.raises_alarm())
}
