//! A user's own effect: coffee. Caffeine blunts insulin for some hours.
//!
//! The record has no channel for coffee, so this one takes the hours from the user: a cup in the morning, or
//! one after lunch. Hand it to the diagnosis beside the library and it is fitted and ranked like the others.

#![expect(clippy::print_stdout, reason = "an example shows what it made")]

use effects::{
    Card, Channel, Course, Effect, Field, Form, Modulation, Port, Prior, STEP_MINUTES, library,
};

/// Fall of insulin action at the peak at amplitude 1, as a share.
const FALL: f64 = 0.15;
/// Time from a cup to its peak, min.
const PEAK: f64 = 60.0;
/// Half-life afterwards, min.
const HALF_LIFE: f64 = 300.0;

/// Coffee at the same hours of every day.
#[derive(Debug)]
struct Caffeine {
    /// Alternatives: the hours of the cups of a day.
    habits: Vec<Vec<f64>>,
}

impl Effect for Caffeine {
    fn card(&self) -> Card {
        Card {
            name: "caffeine",
            port: Port::InsulinAction,
            summary: "caffeine blunts insulin for some hours after a cup",
            size_at_one: "action 15 % lower an hour after a cup, with a half-life of five hours",
            source: "about 15 % lower sensitivity: Keijzers et al., Diabetes Care 2002;25:364",
            signature: "glucose under-predicted for hours after the times of coffee",
            channels: &[Channel::Clock],
            confusable_with: &["circadian_sensitivity", "dawn"],
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

fn main() {
    let caffeine = Caffeine { habits: vec![vec![7.5], vec![7.5, 13.5]] };
    let day: Vec<f64> = (0..288).map(|k| f64::from(k) * STEP_MINUTES / 60.0).collect();
    let course = Course { hour: day, ..Course::default() };
    let mut steps = vec![Modulation::NEUTRAL; course.len()];
    caffeine.modulate(1, 1.0, &course, &mut steps);
    for hour in [6, 9, 12, 15, 18, 21] {
        println!(
            "{hour:>2} h: insulin acts {:.2} times as strongly",
            steps[12 * hour][Field::Action]
        );
    }

    println!("\n{}", caffeine.card().in_words());
    let mut mine = library();
    mine.push(Box::new(caffeine));
    println!("{} effects to try", mine.len());
}
