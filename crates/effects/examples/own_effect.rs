//! A user's own effect: coffee. Caffeine blunts insulin for some hours.
//!
//! The effect stands in `own_effect/caffeine.rs`. The diagnosis fits, ranks and names it like the others where it is
//! handed in beside the library: `cargo run -p gap --example with_own_effect -- COHORT` does that, and the test
//! `own_effect` of `cli` shows that it is named in a world that has it and not in the same world without it.

#![expect(clippy::print_stdout, reason = "an example shows what it made")]

#[path = "own_effect/caffeine.rs"]
mod caffeine;

use caffeine::Caffeine;
use effects::{Course, Effect, Field, Modulation, STEP_MINUTES, library};

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
