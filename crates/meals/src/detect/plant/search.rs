//! Which meals, together, explain the innovations.

use crate::detect::plant::PlantSettings;
use crate::detect::plant::filter::Innovations;
use crate::detect::plant::insulin::InsulinAction;
use crate::detect::plant::signature::{GUT_TIMES, appearances, follow};
use crate::signals::Signals;

/// Steps after eating through which there must be readings: an hour.
const SHOWN_WITHIN: usize = 12;
/// Most steps from one reading to the next in that hour, and from the last one before eating: a
/// quarter of an hour, as sensors have that are read four times an hour.
const BETWEEN_READINGS: usize = 3;
/// Steps from eating to a bolus, and from a bolus to eating, that count as near.
const BOLUS_AFTER: usize = 9;
const BOLUS_BEFORE: usize = 6;
/// Smallest bolus that counts, U.
const SMALLEST_BOLUS: f64 = 0.5;
/// Rounds of moving, dropping and adding meals after the first choice.
const ROUNDS: usize = 3;
/// Steps by which a meal may move in a round.
const MOVES: usize = 9;
/// Sweeps of fitting sizes; each halves what is left of an error of two meals an hour apart.
const SWEEPS: usize = 12;

/// A meal in the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meal {
    /// Step at whose start it is eaten.
    pub step: usize,
    /// Its size, g.
    pub grams: f64,
    /// Logarithm of the likelihood ratio, the other meals given, nats.
    pub nats: f64,
    gut: usize,
}

/// What the search ends with.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The meals, in order.
    pub meals: Vec<Meal>,
    /// Logarithm of the likelihood of the readings with them, nats.
    pub log_likelihood: f64,
}

/// A search over one record.
pub struct Search<'a> {
    settings: &'a PlantSettings,
    /// Signatures of all onsets and guts, `horizon` values each, and the sums of their squares.
    signatures: Vec<f64>,
    energies: Vec<f64>,
    /// Logarithm of the likelihood ratio that an onset must exceed; infinite where none may be.
    needed: Vec<f64>,
    /// Whitened innovations without the meals chosen so far.
    residual: Vec<f64>,
    log_likelihood: f64,
    meals: Vec<Meal>,
}

impl<'a> Search<'a> {
    /// Lays out the signatures.
    #[must_use]
    pub fn new(
        signals: &Signals<'_>,
        action: &InsulinAction,
        innovations: &Innovations,
        settings: &'a PlantSettings,
    ) -> Self {
        let (steps, horizon) = (signals.cgm.len(), settings.horizon);
        let needed = needed(signals, settings);
        let mut signatures = vec![0.0; steps * GUT_TIMES.len() * horizon];
        let mut energies = vec![0.0; steps * GUT_TIMES.len()];
        let appearances = appearances(action, horizon);
        for step in (0..steps).filter(|step| needed[*step].is_finite()) {
            for (gut, appearance) in appearances.iter().enumerate() {
                let place = place(step, gut);
                let slot = &mut signatures[place * horizon..][..horizon];
                follow(step, appearance, action, innovations, slot);
                energies[place] = slot.iter().map(|value| value * value).sum();
            }
        }
        // Beyond the end there is nothing to explain: a horizon of zeros spares the bounds.
        let mut residual: Vec<f64> = innovations.whitened().map(|w| w.unwrap_or(0.0)).collect();
        residual.resize(steps + horizon + 1, 0.0);
        Self {
            settings,
            signatures,
            energies,
            needed,
            residual,
            log_likelihood: innovations.log_likelihood(),
            meals: Vec::new(),
        }
    }

    /// Chooses the meals.
    #[must_use]
    pub fn run(self) -> Found {
        self.run_rounds(ROUNDS)
    }

    fn run_rounds(mut self, rounds: usize) -> Found {
        let before: f64 = self.residual.iter().map(|r| r * r).sum();
        self.add_all();
        for _ in 0..rounds {
            let chosen = self.meals.clone();
            self.move_each();
            self.drop_weak();
            self.add_all();
            let place = |meal: &Meal| (meal.step, meal.gut);
            if chosen.iter().map(place).eq(self.meals.iter().map(place)) {
                break;
            }
        }
        self.fit(0, usize::MAX);
        self.drop_weak();
        for index in 0..self.meals.len() {
            let nats = self.nats(self.meals[index]);
            self.meals[index].nats = nats;
        }
        let after: f64 = self.residual.iter().map(|r| r * r).sum();
        Found { meals: self.meals, log_likelihood: self.log_likelihood + 0.5 * (before - after) }
    }

    /// Product of a signature with the residual.
    fn product(&self, step: usize, gut: usize) -> f64 {
        let horizon = self.settings.horizon;
        let signature = &self.signatures[place(step, gut) * horizon..][..horizon];
        let pairs = signature.iter().zip(&self.residual[step + 1..]);
        pairs.map(|(shift, residual)| shift * residual).sum()
    }

    /// The best size of a meal, g, and the logarithm of its likelihood ratio, nats.
    fn gain(&self, step: usize, gut: usize) -> (f64, f64) {
        let energy = self.energies[place(step, gut)];
        if energy <= 0.0 {
            return (0.0, f64::NEG_INFINITY);
        }
        let product = self.product(step, gut);
        let (smallest, largest) = self.settings.sizes;
        let free = product / energy;
        if free < smallest {
            return (0.0, f64::NEG_INFINITY);
        }
        let grams = free.min(largest);
        (grams, grams * (product - 0.5 * grams * energy))
    }

    /// Takes a meal out of the residual, or (`sign` -1) puts it back.
    fn explain(&mut self, meal: &Meal, sign: f64) {
        let horizon = self.settings.horizon;
        let signature = &self.signatures[place(meal.step, meal.gut) * horizon..][..horizon];
        for (residual, shift) in self.residual[meal.step + 1..].iter_mut().zip(signature) {
            *residual -= sign * meal.grams * shift;
        }
    }

    /// The logarithm of the likelihood ratio of a chosen meal, the others given, nats.
    fn nats(&mut self, meal: Meal) -> f64 {
        self.explain(&meal, -1.0);
        let nats = self.gain(meal.step, meal.gut).1;
        self.explain(&meal, 1.0);
        nats
    }

    /// The best gut at a step: the meal and how far it exceeds what is needed there.
    fn best_at(&self, step: usize) -> Option<(Meal, f64)> {
        if !self.needed[step].is_finite() {
            return None;
        }
        let mut best: Option<Meal> = None;
        for gut in 0..GUT_TIMES.len() {
            let (grams, nats) = self.gain(step, gut);
            if nats > best.map_or(0.0, |meal| meal.nats) {
                best = Some(Meal { step, grams, nats, gut });
            }
        }
        best.map(|meal| (meal, meal.nats - self.needed[step]))
    }

    /// How far the best meal at a step exceeds what is needed there.
    fn surplus_at(&self, step: usize) -> f64 {
        self.best_at(step).map_or(f64::NEG_INFINITY, |(_, surplus)| surplus)
    }

    fn free(&self, step: usize) -> bool {
        self.meals.iter().all(|meal| meal.step.abs_diff(step) >= self.settings.pause)
    }

    /// Adds the strongest meal until none exceeds what is needed.
    fn add_all(&mut self) {
        let reach = self.settings.horizon;
        let mut surplus: Vec<f64> =
            (0..self.needed.len()).map(|step| self.surplus_at(step)).collect();
        loop {
            let mut best = (0.0, None);
            for (step, value) in surplus.iter().enumerate() {
                if *value > best.0 && self.free(step) {
                    best = (*value, Some(step));
                }
            }
            let Some((meal, _)) = best.1.and_then(|step| self.best_at(step)) else { return };
            self.explain(&meal, 1.0);
            let place = self.meals.partition_point(|other| other.step < meal.step);
            self.meals.insert(place, meal);
            let from = meal.step.saturating_sub(2 * reach);
            self.fit(from, meal.step + 2 * reach);
            let until = (meal.step + 3 * reach).min(surplus.len());
            let near = surplus.iter_mut().enumerate().take(until).skip(from.saturating_sub(reach));
            for (step, value) in near {
                *value = self.surplus_at(step);
            }
        }
    }

    /// Fits the size of each meal of some steps, the others given, again and again.
    fn fit(&mut self, from: usize, until: usize) {
        for _ in 0..SWEEPS {
            for index in 0..self.meals.len() {
                let meal = self.meals[index];
                if meal.step < from || meal.step > until {
                    continue;
                }
                let energy = self.energies[place(meal.step, meal.gut)];
                let better = meal.grams + self.product(meal.step, meal.gut) / energy;
                let better = better.clamp(0.0, self.settings.sizes.1);
                self.explain(&Meal { grams: better - meal.grams, ..meal }, 1.0);
                self.meals[index].grams = better;
            }
        }
    }

    /// Moves each meal to the best onset about it, the others given.
    fn move_each(&mut self) {
        for index in 0..self.meals.len() {
            let meal = self.meals.remove(index);
            self.explain(&meal, -1.0);
            let (from, until) = (meal.step.saturating_sub(MOVES), meal.step + MOVES);
            let mut best = (f64::NEG_INFINITY, meal);
            for step in from..=until.min(self.needed.len().saturating_sub(1)) {
                if let Some((moved, surplus)) = self.best_at(step)
                    && surplus > best.0
                    && self.free(step)
                {
                    best = (surplus, moved);
                }
            }
            self.explain(&best.1, 1.0);
            self.meals.insert(index, best.1);
        }
        self.meals.sort_by_key(|meal| meal.step);
        self.fit(0, usize::MAX);
    }

    /// Drops the weakest meal until none is below what is needed.
    fn drop_weak(&mut self) {
        loop {
            let mut weakest: Option<(f64, usize)> = None;
            for place in 0..self.meals.len() {
                let meal = self.meals[place];
                let surplus = self.nats(meal) - self.needed[meal.step];
                if surplus < weakest.map_or(0.0, |(least, _)| least) {
                    weakest = Some((surplus, place));
                }
            }
            let Some((_, place)) = weakest else { return };
            let meal = self.meals.remove(place);
            self.explain(&meal, -1.0);
            let reach = 2 * self.settings.horizon;
            self.fit(meal.step.saturating_sub(reach), meal.step + reach);
        }
    }
}

/// The place of a signature among those of all steps and guts.
fn place(step: usize, gut: usize) -> usize {
    step * GUT_TIMES.len() + gut
}

/// The logarithm of the likelihood ratio that a meal at each step must exceed: infinite where
/// readings are missing that would show it, lower about a bolus.
fn needed(signals: &Signals<'_>, settings: &PlantSettings) -> Vec<f64> {
    let read: Vec<bool> = signals.cgm.iter().map(Option::is_some).collect();
    let dosed: Vec<bool> =
        signals.bolus.iter().map(|b| b.is_some_and(|b| b >= SMALLEST_BOLUS)).collect();
    let any = |flags: &[bool], from: usize, until: usize| {
        flags[from.min(flags.len())..until.min(flags.len())].iter().any(|flag| *flag)
    };
    (0..read.len())
        .map(|step| {
            let end = step + SHOWN_WITHIN;
            let shown = (step.saturating_sub(BETWEEN_READINGS - 1)..=end + 1 - BETWEEN_READINGS)
                .all(|from| any(&read, from, from + BETWEEN_READINGS));
            if !shown || end >= read.len() {
                return f64::INFINITY;
            }
            let bolus = any(&dosed, step.saturating_sub(BOLUS_BEFORE), step + 1 + BOLUS_AFTER);
            (settings.threshold - if bolus { settings.bolus_bonus } else { 0.0 }).max(0.5)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use cohort::Channel;

    use super::*;
    use crate::detect::plant::synthetic::person;

    #[test]
    fn a_threshold_is_lower_about_a_bolus_and_infinite_without_readings() {
        let mut record = person(200, &[], &[(100, 2.0), (150, 0.4)]);
        record.record.channel_mut(Channel::Cgm)[20..60].fill(None);
        let signals = Signals::of(&record).expect("values that can be");
        let settings = PlantSettings::working();
        let needed = needed(&signals, &settings);
        let (usual, lower) = (settings.threshold, settings.threshold - settings.bolus_bonus);
        let cases = [
            (5, usual),
            (9, usual), // steps 20 and 21 are missing of the hour, which a slow sensor has too
            (10, f64::INFINITY),
            (40, f64::INFINITY),
            (59, f64::INFINITY), // nothing was read for a quarter of an hour before
            (60, usual),
            (90, usual),
            (91, lower),
            (106, lower),
            (107, usual),
            (150, usual), // 0.4 U are no bolus
            (187, usual),
            (188, f64::INFINITY), // the record ends within the hour
        ];
        for (step, expected) in cases {
            assert_eq!(needed[step], expected, "step {step}");
        }
    }

    #[test]
    fn two_meals_an_hour_and_a_half_apart_are_told_apart_and_share_no_gram() {
        let (meals, boluses) = ([(100, 50.0), (118, 50.0)], []);
        let record = person(400, &meals, &boluses);
        let signals = Signals::of(&record).expect("values that can be");
        let settings = PlantSettings::working();
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let innovations = Innovations::of(&signals, &action, &settings.noise);
        let found = Search::new(&signals, &action, &innovations, &settings).run();
        assert_eq!(found.meals.len(), 2, "{found:?}");
        let grams: f64 = found.meals.iter().map(|meal| meal.grams).sum();
        // The body's sensitivity is known here; what is left is the sensor's extra 2 min and the
        // gut's time constant, which is estimated.
        assert!((grams / 100.0 - 1.0).abs() < 0.2, "{found:?}");
        for (meal, (eaten, _)) in found.meals.iter().zip(meals) {
            assert!(meal.step.abs_diff(eaten) <= 3, "{found:?}");
            assert!(meal.nats > settings.threshold);
        }
        assert!(found.log_likelihood > innovations.log_likelihood() + 6.0);
    }

    #[test]
    fn the_evidence_of_a_single_meal_is_the_gain_in_likelihood() {
        let record = person(300, &[(100, 50.0)], &[]);
        let signals = Signals::of(&record).expect("values that can be");
        let settings = PlantSettings::working();
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let innovations = Innovations::of(&signals, &action, &settings.noise);
        let found = Search::new(&signals, &action, &innovations, &settings).run();
        assert_eq!(found.meals.len(), 1, "{found:?}");
        let gained = found.log_likelihood - innovations.log_likelihood();
        assert!((found.meals[0].nats - gained).abs() < 1e-6, "{gained} {found:?}"); // rounding
    }

    #[test]
    fn a_meal_in_the_shadow_of_another_moves_to_its_place() {
        let meals = [(100, 40.0), (113, 80.0)];
        let record = person(300, &meals, &[]);
        let signals = Signals::of(&record).expect("values that can be");
        let settings = PlantSettings::working();
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let innovations = Innovations::of(&signals, &action, &settings.noise);
        let search = || Search::new(&signals, &action, &innovations, &settings);
        let (greedy, moved) = (search().run_rounds(0), search().run());
        assert_eq!(moved.meals.len(), 2, "{moved:?}");
        for (meal, (eaten, _)) in moved.meals.iter().zip(meals) {
            assert!(meal.step.abs_diff(eaten) <= 2, "{moved:?}");
        }
        // What the first choice took of one meal for the other is given back.
        assert!(moved.log_likelihood > greedy.log_likelihood + 0.1, "{moved:?} {greedy:?}");
    }

    #[test]
    fn meals_keep_the_pause_and_their_largest_size() {
        let record = person(400, &[(100, 60.0), (106, 60.0), (112, 60.0)], &[]);
        let signals = Signals::of(&record).expect("values that can be");
        let settings = PlantSettings { sizes: (5.0, 40.0), ..PlantSettings::working() };
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let innovations = Innovations::of(&signals, &action, &settings.noise);
        let found = Search::new(&signals, &action, &innovations, &settings).run().meals;
        assert!(!found.is_empty());
        assert!(found.iter().all(|meal| meal.grams <= 40.0), "{found:?}");
        let apart = |pair: &[Meal]| pair[1].step - pair[0].step >= settings.pause;
        assert!(found.windows(2).all(apart), "{found:?}");
    }
}
