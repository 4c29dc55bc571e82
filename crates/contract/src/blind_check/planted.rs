//! `planted.json`: effects planted into real records.

use super::{Answer, Share, Verdict};

/// The label of a cohort of real people: what is sealed.
#[apply(strict!)]
pub struct PlantedLabel {
    /// Name of the cohort and of its folder.
    pub id: String,
    /// What was planted; `none` for the record as it is.
    pub planting: String,
    /// The effect that has to be named; `None` where nothing was planted that the library holds.
    pub effect: Option<String>,
    /// Effects whose evidence has to go.
    pub evidence_lost: Vec<String>,
    /// Size, in `unit`.
    pub size: f64,
    /// Unit of the size.
    pub unit: String,
    /// How the planting differs from the effect's definition; empty where it does not.
    pub inexact: String,
    /// Entries of the records that were changed.
    pub changed: usize,
}

/// How the plant was calibrated to the people of one cohort.
#[apply(strict!)]
#[derive(Copy, Eq, Default)]
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

/// Evidence for one effect before and after, nats; `None` where the effect could not be tried.
#[apply(strict!)]
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

/// One planted cohort, scored.
#[apply(strict!)]
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
    /// Whether its evidence rose by 3 nats.
    pub risen: bool,
    /// Names that the record as it is does not have, the planted one aside.
    pub strangers: Vec<String>,
    /// How the people were calibrated.
    pub calibrated: CalibratedPeople,
    /// What undoing the change exactly would gain, nats: what an oracle would win that judges glucose through this plant.
    pub undone_nats: Option<f64>,
    /// The evidence that is expected of a reader who knows how it looks, how often it happens and where it could have, but
    /// not where it did, nats; what undoing it gains where it acts all the time or at every meal.
    pub at_best_nats: Option<f64>,
    /// Time of the diagnosis, s.
    pub seconds: f64,
}

/// Counts over some of the planted cohorts.
#[apply(strict!)]
pub struct PlantedTotals {
    /// What is counted: an effect, a multiple of the usual size, or everything.
    pub what: String,
    /// Cohorts in which the planted effect is named.
    pub named: Share,
    /// Of those in which it was not named before: those in which it is now.
    pub named_anew: Share,
    /// Cohorts in which it is named or in the set of one that is.
    pub named_or_in_set: Share,
    /// Cohorts in which its evidence rose by 3 nats.
    pub risen: Share,
    /// Cohorts in which another effect is named that was not before.
    pub strangers: Share,
    /// Of the cohorts for which it is known: those in which 6 nats are expected at best.
    pub tellable: Share,
}

/// A check of one cohort of real people: `planted.json`.
#[apply(strict!)]
pub struct PlantedCheck {
    /// `planted/3`.
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
