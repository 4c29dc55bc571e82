//! A log of carbohydrate, mended with the meals that a detector found.
//!
//! [`Rule::Published`] is the procedure of Roquemen-Echeverri et al. (section "Development dataset
//! preprocessing" of the individual-level model): three passes over what has not been used, and
//! nothing is used twice.
//!
//! 1. A detection within 90 min of a bolus is a meal at the *bolus's* time and of the *estimated*
//!    size. A report within 90 min of that bolus or detection tells of the same meal and is
//!    replaced: it may not come back in a later pass.
//! 2. A detection within 90 min of a report is a meal at the *detection's* time and of the
//!    *reported* size.
//! 3. A report within 90 min of a bolus stays as it is.
//!
//! What is left is discarded as unreliable: detections that nothing supports, reports that nothing
//! supports, boluses without a meal (corrections are no meals).
//!
//! The paper leaves open what is near what if several are. Here, in each pass, the nearest pair
//! comes first; of equally near ones that with the stronger evidence, then the earlier detection or
//! report, then the earlier partner. A bolus is what was given in successive steps, at the first
//! of them, if it is at least [`ReconcileSettings::smallest_bolus`]; a report is what was logged in
//! one step. A detector without sizes ([`Detector::Grid`]) takes, in the first pass, the size of
//! the report that would be replaced, and without such a report nothing.
//!
//! [`Rule::Additive`] is ours, for logs that are kept well: every report stays, and a detection is
//! added where nothing is logged within 90 min. Estimated sizes lean on the plant's nominal
//! parameters and are wrong by a factor of the person's own; those that are added are brought to
//! the person's own measure, the sum of reports over the sum of estimates where both tell of a
//! meal ([`Reconciled::size_scale`]).

mod desk;

use chrono::NaiveDateTime;
use cohort::{Cohort, Person};
use contract::meals::MealEvent;
use physiology::Grams;
use rayon::prelude::*;

use self::desk::Desk;
use crate::detect::{Detected, Detector};
use crate::error::{MealError, require};

pub use contract::meals::{EventKind, Fate, Rule};

/// Settings of a reconciliation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReconcileSettings {
    /// The rule.
    pub rule: Rule,
    /// Steps within which two events belong together.
    pub window: usize,
    /// Smallest bolus that counts as one, U.
    pub smallest_bolus: f64,
}

impl ReconcileSettings {
    /// The paper's window; 0.5 U, since automated delivery gives less of its own accord and a meal
    /// of 10 g asks for about as much.
    #[must_use]
    pub const fn new(rule: Rule) -> Self {
        Self { rule, window: 18, smallest_bolus: 0.5 }
    }
}

/// A person with the reconciled log, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Reconciled {
    /// The person; only the carbohydrate differs.
    pub person: Person,
    /// Every event, ordered by time and kind.
    pub events: Vec<EventRow>,
    /// Insulin sensitivity over the nominal one that the detector found, if it did.
    pub sensitivity: Option<f64>,
    /// By what estimated sizes were multiplied before they were added to the log.
    pub size_scale: f64,
}

/// One event and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct EventRow {
    /// The person's identifier.
    pub person_id: String,
    /// Start of the event's step, local wall clock.
    pub time: NaiveDateTime,
    /// What it is.
    pub kind: EventKind,
    /// g of carbohydrate or U of insulin; `None` for a detection without a size.
    pub size: Option<f64>,
    /// Strength of a detection's evidence, nats or standard deviations; `None` for other events.
    pub evidence: Option<f64>,
    /// What became of it.
    pub fate: Fate,
    /// Time of the event that decided its fate.
    pub partner: Option<NaiveDateTime>,
}

impl From<&EventRow> for MealEvent {
    fn from(row: &EventRow) -> Self {
        // As cohort folders write local times.
        let iso = |time: NaiveDateTime| time.format("%Y-%m-%dT%H:%M:%S").to_string();
        Self {
            person_id: row.person_id.clone(),
            time: iso(row.time),
            kind: row.kind,
            size: row.size,
            evidence: row.evidence,
            fate: row.fate,
            partner: row.partner.map(iso),
        }
    }
}

/// How often each fate befell an event; fates that befell none are left out.
#[must_use]
pub fn count_fates<'a>(events: impl IntoIterator<Item = &'a EventRow>) -> Vec<(Fate, usize)> {
    let mut counts = [0_usize; Fate::ALL.len()];
    for event in events {
        counts[event.fate as usize] += 1;
    }
    Fate::ALL.into_iter().zip(counts).filter(|(_, count)| *count > 0).collect()
}

/// Finds the meals of every person and reconciles their logs; in the order of the cohort, whatever
/// the number of threads. `done` is told of each person that is finished.
///
/// # Errors
/// Those of [`Detector::detect`] and [`reconcile`].
pub fn reconcile_cohort(
    cohort: &Cohort,
    detector: &Detector,
    settings: &ReconcileSettings,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Reconciled>, MealError> {
    cohort
        .people
        .par_iter()
        .map(|person| {
            let reconciled = reconcile(person, &detector.detect(person)?, settings);
            done(&person.id);
            reconciled
        })
        .collect()
}

/// Reconciles one person's log with the meals that were detected.
///
/// A step of the new log is empty where the old one was and no meal was put there, 0 where the old
/// one had a number that is no longer believed.
///
/// # Errors
/// [`MealError::Value`] for carbohydrate or insulin that is negative or not finite,
/// [`MealError::Setting`] for settings that cannot be and [`MealError::Outside`] for a detection
/// beyond the record.
pub fn reconcile(
    person: &Person,
    detected: &Detected,
    settings: &ReconcileSettings,
) -> Result<Reconciled, MealError> {
    let smallest = settings.smallest_bolus;
    let fits = smallest.is_finite() && smallest >= 0.0;
    require(fits, "smallest_bolus", smallest, "finite and not negative")?;
    let mut desk = Desk::new(person, detected, settings)?;
    match settings.rule {
        Rule::Published => desk.published(),
        Rule::Additive => desk.additive(),
    }
    Ok(desk.close(person, detected.sensitivity))
}

/// Sum of the carbohydrate of a person's log, g.
#[must_use]
pub fn logged(person: &Person) -> Grams {
    Grams(person.record.carbs().iter().flatten().sum())
}

#[cfg(test)]
mod tests {
    use cohort::{Channel, Record, Therapy};

    use super::*;
    use crate::detect::Detection;

    const STEPS: usize = 288;

    /// Events by step: detections (step, g, nats; 0 g is a size not known), reports (step, g) and
    /// boluses (step, U).
    struct Day {
        detections: &'static [(usize, f64, f64)],
        reports: &'static [(usize, f64)],
        boluses: &'static [(usize, f64)],
    }

    fn person(day: &Day) -> Person {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, STEPS).expect("on the grid");
        for (channel, events) in [(Channel::Carbs, day.reports), (Channel::Bolus, day.boluses)] {
            let column = record.channel_mut(channel);
            column.fill(Some(0.0));
            for (step, size) in events {
                column[*step] = Some(*size);
            }
        }
        record.channel_mut(Channel::Cgm).fill(Some(120.0));
        Person {
            id: "a".into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        }
    }

    fn detected(day: &Day) -> Detected {
        let meals = day.detections.iter().map(|(step, grams, nats)| Detection {
            step: *step,
            carbs: (*grams > 0.0).then_some(Grams(*grams)),
            evidence: *nats,
        });
        Detected { meals: meals.collect(), sensitivity: None }
    }

    /// The fates of detections, reports and boluses, each in order, and the new log.
    fn check(rule: Rule, day: &Day, fates: [&[Fate]; 3], log: &[(usize, f64)]) {
        let before = person(day);
        let after = reconcile(&before, &detected(day), &ReconcileSettings::new(rule))
            .expect("values that can be");
        for (kind, expected) in
            [EventKind::Detection, EventKind::Report, EventKind::Bolus].into_iter().zip(fates)
        {
            let found: Vec<Fate> =
                after.events.iter().filter(|e| e.kind == kind).map(|e| e.fate).collect();
            assert_eq!(found, expected, "{kind:?}");
        }
        let carbs = after.person.record.carbs();
        let found: Vec<(usize, f64)> = carbs
            .iter()
            .enumerate()
            .filter_map(|(step, grams)| grams.filter(|g| *g > 0.0).map(|g| (step, g)))
            .collect();
        assert_eq!(found, log);
        // Whoever is somebody's partner has that somebody as partner, or was replaced by them.
        for event in after.events.iter().filter(|e| e.fate == Fate::GivesTime) {
            let back = after
                .events
                .iter()
                .find(|e| e.kind == EventKind::Detection && Some(e.time) == event.partner);
            assert_eq!(back.and_then(|e| e.partner), Some(event.time));
        }
        let mut restored = after.person.clone();
        restored.record.channel_mut(Channel::Carbs).copy_from_slice(before.record.carbs());
        assert_eq!(restored, before, "only carbohydrate may differ");
    }

    use Fate::*;

    #[test]
    fn a_detection_by_a_bolus_takes_its_time_and_its_own_size_and_replaces_the_report() {
        check(
            Rule::Published,
            &Day {
                detections: &[(100, 55.0, 9.0)],
                reports: &[(104, 40.0)],
                boluses: &[(97, 4.0)],
            },
            [&[MealAtBolus], &[ReplacedByDetection], &[GivesTime]],
            &[(97, 55.0)],
        );
    }

    #[test]
    fn a_detection_by_a_report_alone_takes_its_size_and_its_own_time() {
        check(
            Rule::Published,
            &Day { detections: &[(100, 55.0, 9.0)], reports: &[(118, 40.0)], boluses: &[] },
            [&[MealOfReportedSize], &[MovedToDetection], &[]],
            &[(100, 40.0)],
        );
        // One step beyond 90 min.
        check(
            Rule::Published,
            &Day { detections: &[(100, 55.0, 9.0)], reports: &[(119, 40.0)], boluses: &[] },
            [&[UnsupportedDetection], &[UnsupportedReport], &[]],
            &[],
        );
    }

    #[test]
    fn a_report_by_a_bolus_stays_and_what_is_alone_goes() {
        check(
            Rule::Published,
            &Day {
                detections: &[(250, 30.0, 5.0)],
                reports: &[(50, 40.0), (150, 16.0)],
                boluses: &[(60, 4.0), (200, 2.0)],
            },
            [
                &[UnsupportedDetection],
                &[KeptWithBolus, UnsupportedReport],
                &[SupportsReport, NoMeal],
            ],
            &[(50, 40.0)],
        );
    }

    #[test]
    fn nothing_is_used_twice() {
        // One bolus, two detections: the nearer takes it, the other a report.
        check(
            Rule::Published,
            &Day {
                detections: &[(100, 55.0, 9.0), (112, 20.0, 4.0)],
                reports: &[(98, 50.0), (114, 18.0)],
                boluses: &[(102, 4.0)],
            },
            [
                &[MealAtBolus, MealOfReportedSize],
                &[ReplacedByDetection, MovedToDetection],
                &[GivesTime],
            ],
            &[(102, 55.0), (112, 18.0)],
        );
        // The report of the meal does not come back with the correction that follows.
        check(
            Rule::Published,
            &Day {
                detections: &[(100, 55.0, 9.0)],
                reports: &[(101, 50.0)],
                boluses: &[(101, 4.0), (110, 1.0)],
            },
            [&[MealAtBolus], &[ReplacedByDetection], &[GivesTime, NoMeal]],
            &[(101, 55.0)],
        );
    }

    #[test]
    fn equally_near_goes_to_the_stronger_evidence() {
        check(
            Rule::Published,
            &Day {
                detections: &[(95, 30.0, 4.0), (105, 60.0, 9.0)],
                reports: &[],
                boluses: &[(100, 5.0)],
            },
            [&[UnsupportedDetection, MealAtBolus], &[], &[GivesTime]],
            &[(100, 60.0)],
        );
    }

    #[test]
    fn a_bolus_is_successive_steps_and_not_a_trace() {
        check(
            Rule::Published,
            &Day {
                detections: &[(100, 30.0, 4.0), (200, 30.0, 4.0)],
                reports: &[],
                boluses: &[(100, 0.3), (101, 0.3), (200, 0.4)],
            },
            [&[MealAtBolus, UnsupportedDetection], &[], &[GivesTime]],
            &[(100, 30.0)],
        );
    }

    #[test]
    fn a_detector_without_sizes_takes_the_reported_one_or_none() {
        check(
            Rule::Published,
            &Day {
                detections: &[(100, 0.0, 3.0), (200, 0.0, 3.0)],
                reports: &[(98, 44.0)],
                boluses: &[(97, 4.0), (200, 2.0)],
            },
            [&[MealAtBolus, UnknownSize], &[ReplacedByDetection], &[GivesTime, NoMeal]],
            &[(97, 44.0)],
        );
    }

    #[test]
    fn the_additive_rule_keeps_reports_and_fills_holes() {
        check(
            Rule::Additive,
            &Day {
                detections: &[(100, 55.0, 9.0), (160, 25.0, 5.0), (220, 35.0, 6.0)],
                reports: &[(104, 40.0), (280, 15.0)],
                boluses: &[(97, 4.0), (223, 3.0)],
            },
            [
                &[AlreadyReported, MealAdded, MealAtBolus],
                &[KeptAsLogged, KeptAsLogged],
                &[NoMeal, GivesTime],
            ],
            &[(104, 40.0), (160, 25.0), (223, 35.0), (280, 15.0)],
        );
    }

    #[test]
    fn a_report_s_bolus_gives_no_other_meal_its_time() {
        check(
            Rule::Additive,
            &Day { detections: &[(100, 30.0, 6.0)], reports: &[(80, 40.0)], boluses: &[(85, 4.0)] },
            [&[MealAdded], &[KeptAsLogged], &[NoMeal]],
            &[(80, 40.0), (100, 30.0)],
        );
    }

    #[test]
    fn added_meals_are_of_the_persons_own_measure() {
        // Five estimates, each a fifth below its report, and one without a report.
        let day = Day {
            detections: &[
                (10, 40.0, 9.0),
                (50, 40.0, 9.0),
                (90, 40.0, 9.0),
                (130, 40.0, 9.0),
                (170, 40.0, 9.0),
                (210, 20.0, 5.0),
            ],
            reports: &[(10, 50.0), (51, 50.0), (90, 50.0), (128, 50.0), (170, 50.0)],
            boluses: &[],
        };
        let after =
            reconcile(&person(&day), &detected(&day), &ReconcileSettings::new(Rule::Additive))
                .expect("values that can be");
        assert_eq!(after.size_scale, 1.25);
        assert_eq!(after.person.record.carbs()[210], Some(25.0));
        // The published rule takes estimates as they are.
        let after =
            reconcile(&person(&day), &detected(&day), &ReconcileSettings::new(Rule::Published))
                .expect("values that can be");
        assert_eq!(after.size_scale, 1.0);
    }

    #[test]
    fn not_recorded_stays_not_recorded() {
        let day = Day { detections: &[(100, 55.0, 9.0)], reports: &[], boluses: &[(100, 5.0)] };
        let mut before = person(&day);
        before.record.channel_mut(Channel::Carbs).fill(None);
        before.record.channel_mut(Channel::Carbs)[7] = Some(12.0);
        let after = reconcile(&before, &detected(&day), &ReconcileSettings::new(Rule::Published))
            .expect("values that can be");
        let carbs = after.person.record.carbs();
        assert_eq!((carbs[7], carbs[100]), (Some(0.0), Some(55.0)));
        assert_eq!(carbs.iter().flatten().count(), 2);
    }

    #[test]
    fn what_cannot_be_is_said_in_words() {
        let day = Day { detections: &[(STEPS, 55.0, 9.0)], reports: &[], boluses: &[] };
        let settings = ReconcileSettings::new(Rule::Published);
        let message = |person: &Person, found: &Detected, settings: &ReconcileSettings| {
            reconcile(person, found, settings).expect_err("refused").to_string()
        };
        let said = message(&person(&day), &detected(&day), &settings);
        assert!(said.contains("at step 288, the record has 288 steps"), "{said}");
        let mut broken = person(&day);
        broken.record.channel_mut(Channel::Carbs)[3] = Some(-1.0);
        let said = message(&broken, &Detected::default(), &settings);
        assert!(said.contains("step 3, column carbs_g: -1 is not"), "{said}");
        let settings = ReconcileSettings { smallest_bolus: f64::NAN, ..settings };
        let said = message(&person(&day), &Detected::default(), &settings);
        assert!(said.contains("setting smallest_bolus is NaN"), "{said}");
    }
}
