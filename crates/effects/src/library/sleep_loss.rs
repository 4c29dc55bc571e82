//! The day after a short night: muscle responds less to insulin.

use super::prelude::*;

/// Action after a night 4.1 h short at amplitude 1, as a factor: between the 14 and 21 % measured.
const FACTOR: f64 = 0.82;
/// How much shorter that night was, h: 469 against 222 min asleep (Donga et al.).
const SHORT_BY: f64 = 4.1;
/// Usual sleep, h. Centring takes it out again; it only places the limits below.
const USUAL: f64 = 7.5;
/// Sleep below which the night counts as short in the variant with a threshold, h.
const SHORT_NIGHT: f64 = 6.0;
/// What a night below the threshold counts, against one 4.1 h short.
const SHORT_NIGHT_COUNTS: f64 = 0.5;
/// Share of the time in bed that is usually slept.
const USUAL_EFFICIENCY: f64 = 0.88;
/// Efficiency lost in a fragmented night that counts as one 4.1 h short (Stamatakis & Punjabi, Chest 2010;137:95:
/// sensitivity 25 % lower).
const FRAGMENTED_BY: f64 = 0.2;
/// Hour from which a night's sleep is counted.
const EVENING: f64 = 18.0;
/// Hour from which the day feels it.
const MORNING: f64 = 7.0;
/// Length of a step, h.
const STEP_HOURS: f64 = STEP_MINUTES / 60.0;
/// Least sleep of a night that was recorded at all, h.
const LEAST: f64 = 1.0;
/// Least length of a record before its first morning, h.
const LEAST_BEFORE: f64 = 9.0;

/// What of the night counts.
#[derive(Debug, Clone, Copy)]
enum Measure {
    /// Hours short of usual.
    Hours,
    /// Whether the night was short.
    Threshold,
    /// Share of the time in bed lain awake.
    Efficiency,
}

/// When of the day after it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Span {
    /// From the morning to the evening.
    Day,
    /// From the evening to midnight; a blend with the day lasts as long as the person is awake.
    Evening,
}

/// What is tried, in the order of the variants.
const VARIANTS: [(Measure, Span); 5] = [
    (Measure::Hours, Span::Day),
    (Measure::Threshold, Span::Day),
    (Measure::Efficiency, Span::Day),
    (Measure::Hours, Span::Evening),
    (Measure::Threshold, Span::Evening),
];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SleepLoss;

impl Effect for SleepLoss {
    fn card(&self) -> Card {
        Card {
            id: EffectId::SLEEP_LOSS,
            port: Port::InsulinAction,
            summary: "muscle, not liver, responds less to insulin the day after a short night",
            size_at_one: "action 18 % lower the day after a night four hours short",
            source: "14 to 21 %: Donga et al., Diabetes Care 2010;33:1573; fragmented sleep: Stamatakis & Punjabi, \
                     Chest 2010;137:95",
            signature: "glucose under-predicted through days after short nights, over-predicted after long ones",
            channels: &[Channel::Sleep],
            confusable_with: &[
                EffectId::POST_EXERCISE_SENSITIVITY,
                EffectId::SET_AGEING,
                EffectId::INSULIN_ABSORPTION,
            ],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        recorded(course.asleep.as_ref()).then_some(Form::Driven)
    }

    fn variants(&self) -> usize {
        VARIANTS.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let (measure, span) = VARIANTS[variant % VARIANTS.len()];
        let losses = losses(measure, span, course);
        let centred = centre_within_clock_slots(course, &losses);
        for (loss, modulation) in centred.iter().zip(into) {
            modulation[Field::Action] *= (amplitude * FACTOR.ln() * loss).exp();
        }
    }
}

/// Sleep lost in the night before, 1 for 4.1 h, from the morning to midnight; unknown after midnight and where
/// the night was not recorded.
///
/// The night counts from the evening on and up to the step, so that late sleepers are not yet rested
/// at the start of the day; centring within clock slots takes out what all days share.
fn losses(measure: Measure, span: Span, course: &Course) -> Vec<Option<f64>> {
    let Some(asleep) = course.asleep.as_ref().filter(|channel| recorded(Some(channel))) else {
        return vec![None; course.len()];
    };
    let (mut hours, mut in_bed, mut covered) = (0.0, 0.0, 0.0);
    let mut night_was_seen = false;
    let mut today = None;
    let mut before = MORNING;
    let mut losses = Vec::with_capacity(course.len());
    for (hour, share) in course.hour.iter().zip(asleep) {
        let evening_begins = *hour >= EVENING && before < EVENING;
        let evening_was_missing = *hour < before && before < EVENING;
        if evening_begins || evening_was_missing {
            (hours, in_bed, covered) = (0.0, 0.0, 0.0);
        }
        if *hour >= MORNING && before < MORNING {
            night_was_seen = covered >= LEAST_BEFORE;
        }
        if *hour < MORNING {
            (night_was_seen, today) = (false, None);
        }
        before = *hour;
        covered += STEP_HOURS;
        if let Some(share) = share.filter(|share| *share > 0.0) {
            hours += share.min(1.0) * STEP_HOURS;
            in_bed += STEP_HOURS;
        }
        if (MORNING..EVENING).contains(hour) {
            today = (night_was_seen && hours >= LEAST).then(|| loss(measure, hours, in_bed));
        }
        let in_evening = *hour >= EVENING;
        losses.push(today.filter(|_| in_evening == (span == Span::Evening)));
    }
    losses
}

/// Sleep lost in a night, 1 for 4.1 h.
fn loss(measure: Measure, hours: f64, in_bed: f64) -> f64 {
    match measure {
        Measure::Hours => ((USUAL - hours) / SHORT_BY).clamp(-0.5, 1.5),
        Measure::Threshold => SHORT_NIGHT_COUNTS * (SHORT_NIGHT + 0.5 - hours).clamp(0.0, 1.0),
        Measure::Efficiency => {
            ((USUAL_EFFICIENCY - hours / in_bed) / FRAGMENTED_BY).clamp(-0.5, 1.5)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{
        DAY, SHORT_NIGHT_BEFORE, fortnight, looks_only_back, modulated, zero_mean_by_slot,
    };

    #[test]
    fn action_is_down_through_the_day_after_a_short_night_and_on_no_other() {
        let course = fortnight();
        for (variant, (_, span)) in VARIANTS.into_iter().enumerate() {
            let steps = modulated(&SleepLoss, variant, 1.0, &course);
            let hour = if span == Span::Day { 12 } else { 21 };
            let then = |day: usize| steps[day * DAY + 12 * hour][Field::Action];
            assert!(then(SHORT_NIGHT_BEFORE) < 0.95, "variant {variant}");
            assert!(then(SHORT_NIGHT_BEFORE + 1) > 1.0, "variant {variant}");
            let other = if span == Span::Day { 21 } else { 12 };
            assert_eq!(steps[SHORT_NIGHT_BEFORE * DAY + 12 * other][Field::Action], 1.0);
            assert_eq!(steps[SHORT_NIGHT_BEFORE * DAY + 12][Field::Action], 1.0);
            zero_mean_by_slot(&course, &steps, Field::Action);
        }
    }

    #[test]
    fn a_night_as_short_as_the_published_one_counts_once() {
        assert!((loss(Measure::Hours, USUAL - SHORT_BY, 4.0) - 1.0).abs() < 1e-12);
        assert_eq!(loss(Measure::Threshold, 5.0, 5.5), SHORT_NIGHT_COUNTS);
        assert_eq!(loss(Measure::Threshold, 7.0, 7.5), 0.0);
        assert!((loss(Measure::Efficiency, 0.68 * 8.0, 8.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_driver_looks_only_back_and_a_night_without_record_is_unknown() {
        // The nights that are exchanged are not short: the threshold in the evening sees nothing of it.
        let reached =
            VARIANTS.into_iter().filter(|v| !matches!(v, (Measure::Threshold, Span::Evening)));
        for (measure, span) in reached {
            looks_only_back(|course| losses(measure, span, course));
        }
        let mut course = fortnight();
        let asleep = course.asleep.as_mut().expect("the sample has sleep");
        asleep[4 * DAY + 200..5 * DAY + 120].fill(None);
        let losses = losses(Measure::Hours, Span::Day, &course);
        assert_eq!(losses[5 * DAY + 150], None);
        assert!(losses[6 * DAY + 150].is_some());
        // The record starts at midnight: the first night is not seen whole.
        assert_eq!(losses[150], None);
    }

    #[test]
    fn without_sleep_there_is_no_form() {
        let course = Course { asleep: None, ..fortnight() };
        assert_eq!(SleepLoss.form(&course), None);
    }
}
