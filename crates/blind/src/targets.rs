//! What the check must reach, and whether it does.

use contract::blind_check::{
    Bound, Kind, Outcome, PairScore, Reliability, Share, Target, UnknownScore, Verdict,
};

use stats::proportion;

use crate::error::BlindError;
use crate::outcome::{names_a_stranger, outcome};
use crate::scored_world::ScoredWorld;
use crate::share::among;

/// What was measured of a target.
struct Measured {
    value: Option<f64>,
    ends: Option<(f64, f64)>,
    of: usize,
    counting_sets: Option<f64>,
}

impl Measured {
    fn share(share: &Share, counting_sets: Option<f64>) -> Self {
        let ends = share.value.map(|_| (share.lower, share.upper));
        Self { value: share.value, ends, of: share.of, counting_sets }
    }
}

fn target(name: &str, says: &str, bound: Bound, target: f64, measured: Measured) -> Target {
    let Measured { value, ends, of, counting_sets } = measured;
    let met = value.map(|value| match bound {
        Bound::AtLeast => value >= target,
        Bound::AtMost => value <= target,
    });
    Target {
        name: name.to_owned(),
        says: says.to_owned(),
        bound,
        target,
        value,
        lower: ends.map(|e| e.0),
        upper: ends.map(|e| e.1),
        value_counting_sets: counting_sets,
        of,
        met,
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
    let outcome = |w: &ScoredWorld| outcome(&w.label, &w.answer);
    let of_kind = |kind| worlds.iter().filter(move |w| w.label.kind == kind);
    let mut all = Vec::new();
    for (shift, least, name) in [(5.0, 0.90, "named_at_5"), (10.0, 0.97, "named_at_10")] {
        let moved = || of_kind(Kind::Single).filter(move |w| w.label.largest_shift() >= shift);
        let named = among(moved(), |w| outcome(w) == Outcome::Correct)?;
        let in_set = among(moved(), |w| outcome(w).is_correct_or_in_set())?;
        let says = format!(
            "one effect that moves glucose by {shift} mg/dL or more is named, and no other"
        );
        all.push(target(name, &says, AtLeast, least, Measured::share(&named, in_set.value)));
    }
    let strangers = among(of_kind(Kind::Single), |w| names_a_stranger(&w.label, &w.answer))?;
    let says = "with one effect, another is named that cannot be confused with it";
    all.push(target("wrong_names", says, AtMost, 0.02, Measured::share(&strangers, None)));
    let alarms = false_alarms(worlds)?;
    let says = "nothing acts, and the answer is not \"none\"";
    all.push(target("false_alarms", says, AtMost, 0.05, Measured::share(&alarms, None)));
    let value = (alarms.of > 0)
        .then(|| proportion::exact_upper(alarms.count, alarms.of, 0.95))
        .transpose()?;
    let limit = Measured { value, ends: None, of: alarms.of, counting_sets: None };
    let says = "one-sided exact 95 % upper limit of the false alarms";
    all.push(target("false_alarms_limit", says, AtMost, 0.08, limit));
    let says = "an effect outside the library is called unknown";
    let recalled = Measured::share(&unknown.recalled, None);
    all.push(target("unknown_recalled", says, AtLeast, 0.80, recalled));
    let says = "what is rightly called unknown is placed at its port";
    let placed = Measured::share(&unknown.right_port, unknown.right_port_or_in_set.value);
    all.push(target("right_port", says, AtLeast, 0.85, placed));
    let says = "expected calibration error of the stated probabilities";
    let error = Measured {
        value: reliability.expected_calibration_error,
        ends: reliability.lower.zip(reliability.upper),
        of: reliability.probabilities,
        counting_sets: reliability.error_counting_sets,
    };
    all.push(target("calibration_error", says, AtMost, 0.05, error));
    let says = "F1 of the names in worlds with two effects";
    let f1 = Measured {
        value: pairs.f1,
        ends: pairs.f1_lower.zip(pairs.f1_upper),
        of: pairs.worlds,
        counting_sets: pairs.f1_counting_sets,
    };
    all.push(target("pairs_f1", says, AtLeast, 0.80, f1));
    let failed = among(worlds, |w| w.answer.verdict == Verdict::Failed)?;
    let says = "the diagnosis ends without an answer";
    all.push(target("failed", says, AtMost, 0.0, Measured::share(&failed, None)));
    Ok(all)
}

/// Null worlds whose answer names an effect or says "unknown".
pub(crate) fn false_alarms(worlds: &[ScoredWorld]) -> Result<Share, BlindError> {
    let nulls = worlds.iter().filter(|w| w.label.kind == Kind::Null);
    among(nulls, |w| w.answer.raises_alarm())
}
