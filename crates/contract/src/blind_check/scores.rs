//! Figures of a check and the limits that they are held against.

/// How many of how many, with two-sided 95 % intervals.
#[apply(strict!)]
#[derive(Copy)]
pub struct Share {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// Their ratio; `None` where nothing was counted.
    pub value: Option<f64>,
    /// Lower end of the Clopper-Pearson interval.
    pub lower: f64,
    /// Upper end of the Clopper-Pearson interval.
    pub upper: f64,
    /// Lower end of the Wilson interval.
    pub wilson_lower: f64,
    /// Upper end of the Wilson interval.
    pub wilson_upper: f64,
}

/// On which side of a limit a figure must lie.
#[apply(word!)]
pub enum Bound {
    /// At the limit or above.
    AtLeast,
    /// At the limit or below.
    AtMost,
}

/// One figure that was promised. A figure that falls short is printed as such.
#[apply(strict!)]
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

/// Rank correlation of true and estimated amplitude over the worlds that were answered correctly.
///
/// The world and the library write an effect in different forms, so that amplitudes can be ranked
/// within an effect and not compared.
#[apply(strict!)]
pub struct AmplitudeRecovery {
    /// Worlds of effects with at least three correct answers.
    pub worlds: usize,
    /// Spearman's correlation of ranks within each effect, the effects pooled; `None` where the ranks
    /// do not vary.
    pub rank_correlation: Option<f64>,
}

/// The figures of the worlds of one hand.
#[apply(strict!)]
pub struct HandRow {
    /// The generator; `None` for all hands together.
    pub hand: Option<String>,
    /// Worlds.
    pub worlds: usize,
    /// Single effects that are named first.
    pub named: Share,
    /// The same of effects that move glucose by 5 mg/dL or more.
    pub named_from_5: Share,
    /// The same from 10 mg/dL.
    pub named_from_10: Share,
    /// Worlds with one effect in which another one is named, first or later.
    pub another_named: Share,
    /// Nulls in which the answer names an effect or says "unknown".
    pub nulls_with_alarm: Share,
    /// Nulls in which an effect is named.
    pub nulls_with_name: Share,
    /// Effects outside the library that are called unknown.
    pub unknown: Share,
    /// Of these, those at the right port.
    pub right_port: Share,
    /// Effects outside the library that are given a name.
    pub outside_named: Share,
    /// F1 of the names in pairs; `None` without a pair.
    pub pairs_f1: Option<f64>,
    /// Expected calibration error of the stated probabilities; `None` without one.
    pub calibration_error: Option<f64>,
    /// Comparable worlds in which one of the three largest cells of "where" is truly hot after 60 min.
    pub where_hit: Share,
    /// The same share for three random cells; `None` without a comparable world.
    pub where_by_chance: Option<f64>,
}

/// Counts of worlds by truth and by the first effect of the answer. Worlds with two effects are
/// left out; [`PairScore`] counts them.
#[apply(strict!)]
#[derive(Eq)]
pub struct Confusion {
    /// Names of the columns: effects, then `none`, `unknown` and `failed`.
    pub answers: Vec<String>,
    /// One row a truth: effects, then `none`, then the effects outside the library.
    pub rows: Vec<ConfusionRow>,
}

/// The answers to one truth.
#[apply(strict!)]
#[derive(Eq)]
pub struct ConfusionRow {
    /// Name of the effect, `none`, or `outside:` with the name of the effect.
    pub truth: String,
    /// Worlds, one count a column.
    pub counts: Vec<usize>,
}

/// Names given in worlds with two effects against the names that act, over all such worlds.
#[apply(strict!)]
pub struct PairScore {
    /// Worlds with two effects.
    pub worlds: usize,
    /// Of the names given, those that act.
    pub precision: Share,
    /// Of the effects that act, those that were named.
    pub recall: Share,
    /// Worlds in which both, and nothing else, were named.
    pub both: Share,
    /// Harmonic mean of precision and recall; `None` without a world.
    pub f1: Option<f64>,
    /// Lower end of its 95 % bootstrap interval over worlds.
    pub f1_lower: Option<f64>,
    /// Upper end of its 95 % bootstrap interval over worlds.
    pub f1_upper: Option<f64>,
    /// F1 if a name whose set of confusable effects holds one that acts, and is not named itself,
    /// counts as that one.
    pub f1_counting_sets: Option<f64>,
    /// Worlds in which both effects move glucose by 5 mg/dL or more.
    pub worlds_at_5: usize,
    /// F1 over those worlds alone.
    pub f1_at_5: Option<f64>,
}

/// The worlds with one effect whose shift lies in one bin.
#[apply(strict!)]
pub struct PowerRow {
    /// The effect; `None` for all effects together.
    pub effect: Option<String>,
    /// Lower end of the bin, mg/dL.
    pub from_mg_dl: f64,
    /// Upper end of the bin, mg/dL, itself not in it; `None` where there is none.
    pub to_mg_dl: Option<f64>,
    /// Mean achieved shift of the worlds, mg/dL.
    pub mean_shift_mg_dl: f64,
    /// Worlds in which the effect, and nothing else, was named.
    pub named: Share,
    /// As `named`, or the effect stands in the set that the answer offers.
    pub named_or_in_set: Share,
    /// Worlds in which the answer named an effect or said "unknown".
    pub detected: Share,
    /// Worlds in which the exact course of the effect would be above the bar
    /// (the ceiling); `None` where that was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<Share>,
}

/// Stated probability against the share that came true.
///
/// A world contributes the probability of each effect that it names, which comes true if the effect
/// acts; and of "none" and "unknown" where that is the answer and the diagnosis states a probability
/// for it, which come true if nothing acts, or an effect outside the library.
#[apply(strict!)]
pub struct Reliability {
    /// Ten bins of equal width; those without a probability are left out.
    pub bins: Vec<ReliabilityBin>,
    /// Probabilities that were counted.
    pub probabilities: usize,
    /// Expected calibration error: the mean over probabilities of the distance between their bin's mean
    /// and its share (Naeini et al., AAAI 2015). `None` without a probability.
    pub expected_calibration_error: Option<f64>,
    /// Lower end of its 95 % bootstrap interval over worlds.
    pub lower: Option<f64>,
    /// Upper end of its 95 % bootstrap interval over worlds.
    pub upper: Option<f64>,
    /// The mean error of as many probabilities that each come true as often as they say, independently of each other:
    /// few probabilities are off by chance (Bröcker and Smith, Weather Forecast 2007;22:651).
    pub error_if_calibrated: Option<f64>,
    /// The error if a name counts as true when its set of confusable effects holds one that acts.
    pub error_counting_sets: Option<f64>,
}

/// Probabilities of about one size.
#[apply(strict!)]
pub struct ReliabilityBin {
    /// Lower end of the bin.
    pub from: f64,
    /// Upper end of the bin.
    pub to: f64,
    /// Mean of the probabilities.
    pub mean_probability: f64,
    /// How many came true.
    pub came_true: Share,
}
