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

use chrono::NaiveDateTime;
use cohort::{Channel, Cohort, Person};
use physiology::Grams;
use rayon::prelude::*;
use serde::{Serialize, Serializer};

use crate::detect::{Detected, Detection, Detector};
use crate::error::MealError;

/// How a log and detections become one log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// The paper's three passes.
    Published,
    /// Every report stays; detections far from any report are added.
    Additive,
}

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

/// What kind of event a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A meal that the detector claims; its size is in g.
    Detection,
    /// Carbohydrate that was logged; its size is in g.
    Report,
    /// A bolus; its size is in U.
    Bolus,
}

/// What became of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// A detection is a meal at the time of its partner, a bolus.
    MealAtBolus,
    /// A detection is a meal of the size of its partner, a report.
    MealOfReportedSize,
    /// A detection is a meal by itself ([`Rule::Additive`] only).
    MealAdded,
    /// A detection tells what its partner, a report, tells ([`Rule::Additive`] only).
    AlreadyReported,
    /// A detection that neither bolus nor report supports is discarded.
    UnsupportedDetection,
    /// A detection by a bolus is discarded because nobody knows its size.
    UnknownSize,
    /// A report is replaced by the meal of its partner, a detection.
    ReplacedByDetection,
    /// A report is moved to the time of its partner, a detection.
    MovedToDetection,
    /// A report stays, supported by its partner, a bolus.
    KeptWithBolus,
    /// A report stays ([`Rule::Additive`] only).
    KeptAsLogged,
    /// A report that neither detection nor bolus supports is discarded.
    UnsupportedReport,
    /// A bolus tells when its partner, a detection, was eaten.
    GivesTime,
    /// A bolus supports its partner, a report.
    SupportsReport,
    /// A bolus without a meal, such as a correction.
    NoMeal,
}

impl Fate {
    /// Every fate, in the order in which counts are listed.
    pub const ALL: [Self; 14] = [
        Self::MealAtBolus,
        Self::MealOfReportedSize,
        Self::MealAdded,
        Self::AlreadyReported,
        Self::UnsupportedDetection,
        Self::UnknownSize,
        Self::ReplacedByDetection,
        Self::MovedToDetection,
        Self::KeptWithBolus,
        Self::KeptAsLogged,
        Self::UnsupportedReport,
        Self::GivesTime,
        Self::SupportsReport,
        Self::NoMeal,
    ];

    /// The name that files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::MealAtBolus => "meal_at_bolus",
            Self::MealOfReportedSize => "meal_of_reported_size",
            Self::MealAdded => "meal_added",
            Self::AlreadyReported => "already_reported",
            Self::UnsupportedDetection => "unsupported_detection",
            Self::UnknownSize => "unknown_size",
            Self::ReplacedByDetection => "replaced_by_detection",
            Self::MovedToDetection => "moved_to_detection",
            Self::KeptWithBolus => "kept_with_bolus",
            Self::KeptAsLogged => "kept_as_logged",
            Self::UnsupportedReport => "unsupported_report",
            Self::GivesTime => "gives_time",
            Self::SupportsReport => "supports_report",
            Self::NoMeal => "no_meal",
        }
    }
}

/// One event and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventRow {
    /// The person's identifier.
    pub person_id: String,
    /// Start of the event's step, local wall clock.
    #[serde(serialize_with = "as_iso")]
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
    #[serde(serialize_with = "as_iso_if_any")]
    pub partner: Option<NaiveDateTime>,
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

/// Fewest pairs of a report and an estimate from which a person's own measure is taken.
const FEWEST_PAIRS: usize = 5;
/// Range of that measure.
const SIZE_SCALES: (f64, f64) = (0.5, 2.0);

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
    if !(settings.smallest_bolus.is_finite() && settings.smallest_bolus >= 0.0) {
        return Err(MealError::Setting {
            name: "smallest_bolus",
            value: settings.smallest_bolus,
            requirement: "finite and not negative",
        });
    }
    let mut desk = Desk::new(person, detected, settings)?;
    match settings.rule {
        Rule::Published => desk.published(),
        Rule::Additive => desk.additive(),
    }
    Ok(desk.close(person, detected.sensitivity))
}

/// An event on the desk.
#[derive(Debug, Clone, Copy)]
struct Entry {
    step: usize,
    size: Option<f64>,
    evidence: Option<f64>,
    fate: Option<(Fate, Option<usize>)>,
}

/// Everything that is to be reconciled, and the meals decided on so far.
struct Desk {
    detections: Vec<Entry>,
    reports: Vec<Entry>,
    boluses: Vec<Entry>,
    meals: Vec<(usize, f64)>,
    window: usize,
    size_scale: f64,
}

/// Two lists whose entries are paired.
fn nearest_pairs(left: &[Entry], right: &[Entry], window: usize) -> Vec<(usize, usize)> {
    let mut near: Vec<(usize, f64, usize, usize)> = Vec::new();
    for (l, a) in left.iter().enumerate().filter(|(_, a)| a.fate.is_none()) {
        for (r, b) in right.iter().enumerate().filter(|(_, b)| b.fate.is_none()) {
            let distance = a.step.abs_diff(b.step);
            if distance <= window {
                near.push((distance, -a.evidence.unwrap_or(0.0), l, r));
            }
        }
    }
    near.sort_by(|a, b| {
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
    });
    let (mut of_left, mut of_right) = (vec![false; left.len()], vec![false; right.len()]);
    near.retain(|(_, _, l, r)| {
        let fresh = !of_left[*l] && !of_right[*r];
        if fresh {
            (of_left[*l], of_right[*r]) = (true, true);
        }
        fresh
    });
    near.into_iter().map(|(_, _, l, r)| (l, r)).collect()
}

impl Desk {
    fn new(
        person: &Person,
        detected: &Detected,
        settings: &ReconcileSettings,
    ) -> Result<Self, MealError> {
        let steps = person.record.len();
        let entry = |meal: &Detection| {
            if meal.step >= steps {
                let person = person.id.clone();
                return Err(MealError::Outside { person, step: meal.step, steps });
            }
            let evidence = Some(meal.evidence.strength());
            Ok(Entry { step: meal.step, size: meal.carbs.map(|g| g.0), evidence, fate: None })
        };
        let mut detections = detected.meals.iter().map(entry).collect::<Result<Vec<_>, _>>()?;
        detections.sort_by_key(|detection| detection.step);
        let logged = |step, size| Entry { step, size: Some(size), evidence: None, fate: None };
        let carbs = checked(person, Channel::Carbs)?;
        let reports = carbs.filter(|(_, g)| *g > 0.0).map(|(step, g)| logged(step, g)).collect();
        let mut boluses: Vec<Entry> = Vec::new();
        let mut last = None;
        for (step, units) in checked(person, Channel::Bolus)?.filter(|(_, units)| *units > 0.0) {
            match boluses.last_mut().and_then(|bolus| bolus.size.as_mut()) {
                Some(size) if last.is_some_and(|last| last + 1 == step) => *size += units,
                _ => boluses.push(logged(step, units)),
            }
            last = Some(step);
        }
        boluses.retain(|bolus| bolus.size.is_some_and(|u| u >= settings.smallest_bolus));
        let (meals, window) = (Vec::new(), settings.window);
        Ok(Self { detections, reports, boluses, meals, window, size_scale: 1.0 })
    }

    fn published(&mut self) {
        self.detections_by_boluses();
        for (d, r) in nearest_pairs(&self.detections, &self.reports, self.window) {
            let (detection, report) = (&mut self.detections[d], &mut self.reports[r]);
            detection.fate = Some((Fate::MealOfReportedSize, Some(report.step)));
            report.fate = Some((Fate::MovedToDetection, Some(detection.step)));
            self.meals.extend(report.size.map(|grams| (detection.step, grams)));
        }
        for (r, b) in nearest_pairs(&self.reports, &self.boluses, self.window) {
            let (report, bolus) = (&mut self.reports[r], &mut self.boluses[b]);
            report.fate = Some((Fate::KeptWithBolus, Some(bolus.step)));
            bolus.fate = Some((Fate::SupportsReport, Some(report.step)));
            self.meals.extend(report.size.map(|grams| (report.step, grams)));
        }
        leave(&mut self.detections, Fate::UnsupportedDetection);
        leave(&mut self.reports, Fate::UnsupportedReport);
        leave(&mut self.boluses, Fate::NoMeal);
    }

    /// The first pass: detections take the time of boluses, and the reports of the same meals go.
    fn detections_by_boluses(&mut self) {
        let pairs = nearest_pairs(&self.detections, &self.boluses, self.window);
        // A report may lie near the bolus or near the detection: both stand for the meal, so that
        // each is asked, and the nearer of the two counts.
        let mut same: Vec<(usize, f64, usize, usize)> = Vec::new();
        for (place, (d, b)) in pairs.iter().enumerate() {
            let (detection, bolus) = (&self.detections[*d], &self.boluses[*b]);
            for (r, report) in self.reports.iter().enumerate() {
                let distance =
                    report.step.abs_diff(bolus.step).min(report.step.abs_diff(detection.step));
                if distance <= self.window {
                    same.push((distance, -detection.evidence.unwrap_or(0.0), place, r));
                }
            }
        }
        same.sort_by(|a, b| {
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
        });
        let mut report_of: Vec<Option<usize>> = vec![None; pairs.len()];
        for (_, _, place, r) in same {
            if report_of[place].is_none() && self.reports[r].fate.is_none() {
                report_of[place] = Some(r);
                let detection = self.detections[pairs[place].0].step;
                self.reports[r].fate = Some((Fate::ReplacedByDetection, Some(detection)));
            }
        }
        for ((d, b), report) in pairs.into_iter().zip(report_of) {
            let (detection, bolus) = (&mut self.detections[d], &mut self.boluses[b]);
            let reported = report.and_then(|r| self.reports[r].size);
            match detection.size.or(reported) {
                Some(grams) => {
                    detection.fate = Some((Fate::MealAtBolus, Some(bolus.step)));
                    bolus.fate = Some((Fate::GivesTime, Some(detection.step)));
                    self.meals.push((bolus.step, grams));
                }
                None => detection.fate = Some((Fate::UnknownSize, Some(bolus.step))),
            }
        }
    }

    /// Sum of reports over sum of estimates, where both tell of a meal; 1 if they seldom do.
    fn own_measure(&self) -> f64 {
        let pairs = nearest_pairs(&self.detections, &self.reports, self.window);
        let both = pairs
            .iter()
            .filter_map(|(d, r)| Some((self.detections[*d].size?, self.reports[*r].size?)));
        let (n, estimated, reported) =
            both.fold((0, 0.0, 0.0), |(n, e, r), (size, report)| (n + 1, e + size, r + report));
        if n < FEWEST_PAIRS {
            return 1.0;
        }
        (reported / estimated).clamp(SIZE_SCALES.0, SIZE_SCALES.1)
    }

    fn additive(&mut self) {
        self.size_scale = self.own_measure();
        let scale = self.size_scale;
        for report in &mut self.reports {
            report.fate = Some((Fate::KeptAsLogged, None));
            self.meals.extend(report.size.map(|grams| (report.step, grams)));
        }
        for detection in &mut self.detections {
            let nearest = self.reports.iter().min_by_key(|r| r.step.abs_diff(detection.step));
            detection.fate = match (nearest, detection.size) {
                (Some(report), _) if report.step.abs_diff(detection.step) <= self.window => {
                    Some((Fate::AlreadyReported, Some(report.step)))
                }
                (_, None) => Some((Fate::UnknownSize, None)),
                (_, Some(_)) => None,
            };
        }
        for (d, b) in nearest_pairs(&self.detections, &self.boluses, self.window) {
            let (detection, bolus) = (&mut self.detections[d], &mut self.boluses[b]);
            detection.fate = Some((Fate::MealAtBolus, Some(bolus.step)));
            bolus.fate = Some((Fate::GivesTime, Some(detection.step)));
            self.meals.extend(detection.size.map(|grams| (bolus.step, scale * grams)));
        }
        for detection in self.detections.iter_mut().filter(|d| d.fate.is_none()) {
            detection.fate = Some((Fate::MealAdded, None));
            self.meals.extend(detection.size.map(|grams| (detection.step, scale * grams)));
        }
        leave(&mut self.boluses, Fate::NoMeal);
    }

    /// The new record, and the events in order.
    fn close(self, person: &Person, sensitivity: Option<f64>) -> Reconciled {
        let record = &person.record;
        let size_scale = self.size_scale;
        let mut rows: Vec<(usize, EventRow)> = Vec::new();
        for (kind, entries) in [
            (EventKind::Detection, &self.detections),
            (EventKind::Report, &self.reports),
            (EventKind::Bolus, &self.boluses),
        ] {
            for entry in entries {
                let (fate, partner) = entry.fate.expect("every pass ends by leaving what is left");
                rows.push((
                    entry.step,
                    EventRow {
                        person_id: person.id.clone(),
                        time: record.time(entry.step),
                        kind,
                        size: entry.size,
                        evidence: entry.evidence,
                        fate,
                        partner: partner.map(|step| record.time(step)),
                    },
                ));
            }
        }
        rows.sort_by_key(|(step, row)| (*step, row.kind));
        let mut reconciled = person.clone();
        let carbs = reconciled.record.channel_mut(Channel::Carbs);
        for slot in carbs.iter_mut().flatten() {
            *slot = 0.0;
        }
        for (step, grams) in self.meals {
            carbs[step] = Some(carbs[step].unwrap_or(0.0) + grams);
        }
        Reconciled {
            person: reconciled,
            events: rows.into_iter().map(|(_, row)| row).collect(),
            sensitivity,
            size_scale,
        }
    }
}

fn leave(entries: &mut [Entry], fate: Fate) {
    for entry in entries.iter_mut().filter(|entry| entry.fate.is_none()) {
        entry.fate = Some((fate, None));
    }
}

/// A local time as cohort folders write it.
fn as_iso<S: Serializer>(time: &NaiveDateTime, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&time.format("%Y-%m-%dT%H:%M:%S"))
}

fn as_iso_if_any<S: Serializer>(
    time: &Option<NaiveDateTime>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match time {
        Some(time) => as_iso(time, serializer),
        None => serializer.serialize_none(),
    }
}

/// The recorded values of a channel with their steps.
fn checked(
    person: &Person,
    channel: Channel,
) -> Result<impl Iterator<Item = (usize, f64)> + '_, MealError> {
    let values = person.record.channel(channel);
    let wrong = values.iter().position(|v| v.is_some_and(|v| !(v.is_finite() && v >= 0.0)));
    if let Some(step) = wrong {
        return Err(MealError::Value {
            person: person.id.clone(),
            step,
            column: channel.column(),
            value: values[step].unwrap_or(f64::NAN),
            requirement: "a finite number of at least 0",
        });
    }
    Ok(values.iter().enumerate().filter_map(|(step, value)| Some((step, (*value)?))))
}

/// Sum of the carbohydrate of a person's log, g.
#[must_use]
pub fn logged(person: &Person) -> Grams {
    Grams(person.record.carbs().iter().flatten().sum())
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

#[cfg(test)]
mod tests {
    use cohort::{Record, Therapy};

    use super::*;
    use crate::detect::Evidence;

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
            evidence: Evidence::LikelihoodRatio { nats: *nats },
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

    #[test]
    fn names_are_those_that_are_written() {
        for fate in Fate::ALL {
            let written = serde_json::to_value(fate).expect("a word");
            assert_eq!(written, fate.name());
        }
        assert_eq!(Fate::ALL.map(|fate| fate as usize), std::array::from_fn(|place| place));
    }
}
