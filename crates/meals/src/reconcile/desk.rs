//! The passes over detections, reports and boluses in which nothing is used twice.

use cohort::{Channel, Person};

use super::{EventKind, EventRow, Fate, ReconcileSettings, Reconciled};
use crate::detect::{Detected, Detection};
use crate::error::MealError;
use crate::score::each_once;
use crate::signals::doses;

/// Fewest pairs of a report and an estimate from which a person's own measure is taken.
const FEWEST_PAIRS: usize = 5;
/// Range of that measure.
const SIZE_SCALES: (f64, f64) = (0.5, 2.0);

/// An event on the desk.
#[derive(Debug, Clone, Copy)]
struct Entry {
    step: usize,
    size: Option<f64>,
    evidence: Option<f64>,
    fate: Option<(Fate, Option<usize>)>,
}

/// Everything that is to be reconciled, and the meals decided on so far.
pub(super) struct Desk {
    detections: Vec<Entry>,
    reports: Vec<Entry>,
    boluses: Vec<Entry>,
    meals: Vec<(usize, f64)>,
    window: usize,
    size_scale: f64,
}

/// A pair that could be: its distance, minus its evidence, and the places of both.
type Near = (usize, f64, usize, usize);

/// The nearest pair first, of equally near ones the one with the stronger evidence.
fn in_order(mut near: Vec<Near>) -> Vec<Near> {
    near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then((a.2, a.3).cmp(&(b.2, b.3))));
    near
}

/// Pairs of the entries of two lists that nothing became of yet and that lie at most `window`
/// steps apart, in order; each entry is in at most one pair.
fn nearest_pairs(left: &[Entry], right: &[Entry], window: usize) -> Vec<(usize, usize)> {
    let mut near: Vec<Near> = Vec::new();
    for (l, a) in left.iter().enumerate().filter(|(_, a)| a.fate.is_none()) {
        for (r, b) in right.iter().enumerate().filter(|(_, b)| b.fate.is_none()) {
            let distance = a.step.abs_diff(b.step);
            if distance <= window {
                near.push((distance, -a.evidence.unwrap_or(0.0), l, r));
            }
        }
    }
    let pairs = in_order(near).into_iter().map(|(_, _, l, r)| (l, r));
    each_once(pairs, left.len(), right.len())
}

impl Desk {
    pub(super) fn new(
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
            let (size, evidence) = (meal.carbs.map(|grams| grams.0), Some(meal.evidence));
            Ok(Entry { step: meal.step, size, evidence, fate: None })
        };
        let mut detections = detected.meals.iter().map(entry).collect::<Result<Vec<_>, _>>()?;
        detections.sort_by_key(|detection| detection.step);
        let logged = |step, size| Entry { step, size: Some(size), evidence: None, fate: None };
        let carbs = given(doses(person, Channel::Carbs)?);
        let reports = carbs.map(|(step, grams)| logged(step, grams)).collect();
        let mut boluses: Vec<Entry> = Vec::new();
        let mut last = None;
        for (step, units) in given(doses(person, Channel::Bolus)?) {
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

    pub(super) fn published(&mut self) {
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
        let mut same: Vec<Near> = Vec::new();
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
        let mut report_of: Vec<Option<usize>> = vec![None; pairs.len()];
        for (_, _, place, r) in in_order(same) {
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

    pub(super) fn additive(&mut self) {
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
            let is_near = |report: &Entry| report.step.abs_diff(bolus.step) <= self.window;
            if self.reports.iter().any(is_near) {
                // That meal's bolus; the time of another is not known so well.
                continue;
            }
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
    pub(super) fn close(self, person: &Person, sensitivity: Option<f64>) -> Reconciled {
        let record = &person.record;
        let size_scale = self.size_scale;
        let mut events: Vec<EventRow> = Vec::new();
        for (kind, entries) in [
            (EventKind::Detection, &self.detections),
            (EventKind::Report, &self.reports),
            (EventKind::Bolus, &self.boluses),
        ] {
            for entry in entries {
                let (fate, partner) = entry.fate.expect("every pass ends by leaving what is left");
                events.push(EventRow {
                    person_id: person.id.clone(),
                    time: record.time(entry.step),
                    kind,
                    size: entry.size,
                    evidence: entry.evidence,
                    fate,
                    partner: partner.map(|step| record.time(step)),
                });
            }
        }
        events.sort_by_key(|event| (event.time, event.kind));
        let mut reconciled = person.clone();
        let carbs = reconciled.record.channel_mut(Channel::Carbs);
        for slot in carbs.iter_mut().flatten() {
            *slot = 0.0;
        }
        for (step, grams) in self.meals {
            carbs[step] = Some(carbs[step].unwrap_or(0.0) + grams);
        }
        Reconciled { person: reconciled, events, sensitivity, size_scale }
    }
}

fn leave(entries: &mut [Entry], fate: Fate) {
    for entry in entries.iter_mut().filter(|entry| entry.fate.is_none()) {
        entry.fate = Some((fate, None));
    }
}

/// The values above 0 with their steps.
fn given(values: &[Option<f64>]) -> impl Iterator<Item = (usize, f64)> {
    values.iter().enumerate().filter_map(|(k, value)| Some((k, value.filter(|v| *v > 0.0)?)))
}
