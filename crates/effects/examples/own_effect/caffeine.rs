//! Coffee: caffeine blunts insulin for some hours.
//!
//! The record has no channel for coffee, so this one takes the hours from the user: a cup in the morning, or
//! one after lunch.

use effects::{
    Allowance, Card, Channel, Course, Effect, EffectId, Field, Form, Modulation, Port, Prior,
    Relations,
};

/// Fall of insulin action at the peak at amplitude 1, as a share.
const FALL: f64 = 0.15;
/// Time from a cup to its peak, min.
const PEAK: f64 = 60.0;
/// Half-life afterwards, min.
const HALF_LIFE: f64 = 300.0;

/// Coffee at the same hours of every day.
#[derive(Debug)]
pub(crate) struct Caffeine {
    /// Alternatives: the hours of the cups of a day.
    pub(crate) habits: Vec<Vec<f64>>,
}

impl Effect for Caffeine {
    fn card(&self) -> Card {
        Card {
            id: EffectId::new("caffeine"),
            port: Port::InsulinAction,
            summary: "caffeine blunts insulin for some hours after a cup",
            size_at_one: "action 15 % lower an hour after a cup, with a half-life of five hours",
            source: "about 15 % lower sensitivity: Keijzers et al., Diabetes Care 2002;25:364",
            signature: "glucose under-predicted for hours after the times of coffee",
            channels: &[Channel::Clock],
            confusable_with: &[EffectId::CIRCADIAN_SENSITIVITY, EffectId::DAWN],
            // A pattern over the day is allowed for in every body. Coffee at fixed hours is one.
            relations: Relations { is_itself: &[Allowance::Clock], ..Relations::USUAL },
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, _: &Course) -> Option<Form> {
        Some(Form::Driven)
    }

    fn variants(&self) -> usize {
        self.habits.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let Some(cups) = self.habits.get(variant) else { return };
        for (hour, modulation) in course.hour.iter().zip(into) {
            let acting: f64 =
                cups.iter().map(|cup| after((hour - cup).rem_euclid(24.0) * 60.0)).sum();
            modulation[Field::Action] *= (amplitude * (1.0 - FALL).ln() * acting).exp();
        }
    }
}

/// What is left of a cup so many minutes later; 1 at its peak.
fn after(minutes: f64) -> f64 {
    if minutes < PEAK { minutes / PEAK } else { 0.5_f64.powf((minutes - PEAK) / HALF_LIFE) }
}
