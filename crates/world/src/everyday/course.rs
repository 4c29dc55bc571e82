//! Everyday variation over the days of a life.

use super::Everyday;
use crate::behaviour::Life;
use crate::stream::{Concept, stream};

/// Logarithms of factors, one per step; all empty where nothing varies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EverydayCourse {
    action: Vec<f64>,
    production: Vec<f64>,
    gut_time: Vec<f64>,
    insulin_time: Vec<f64>,
    amount: Vec<f64>,
}

/// Factors in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EverydayFactors {
    pub(crate) action: f64,
    pub(crate) production: f64,
    pub(crate) gut_time: f64,
    pub(crate) insulin_time: f64,
    pub(crate) amount: f64,
}

impl EverydayCourse {
    /// Draws the course of a life of person `person` of the world with this seed.
    #[must_use]
    pub(crate) fn sample(everyday: &Everyday, life: &Life, seed: u64, person: usize) -> Self {
        if everyday.is_narrow() {
            return Self::default();
        }
        let steps = life.calendar.steps();
        let rng = |concept| stream(seed, person, concept);
        let (action, production) =
            (0..steps).map(|step| everyday.pattern.at(life.calendar.hour(step))).unzip();
        let mut course = Self {
            action,
            production,
            gut_time: vec![0.0; steps],
            insulin_time: vec![0.0; steps],
            amount: vec![0.0; steps],
        };
        everyday.pace.add(&mut course.gut_time, life, &mut rng(Concept::MealSpeeds));
        everyday.sites.add(
            &mut course.amount,
            &mut course.insulin_time,
            life,
            &mut rng(Concept::Sites),
        );
        course
    }

    /// The factors in a step.
    pub(crate) fn at(&self, step: usize) -> EverydayFactors {
        let of = |values: &[f64]| values.get(step).map_or(1.0, |log| log.exp());
        EverydayFactors {
            action: of(&self.action),
            production: of(&self.production),
            gut_time: of(&self.gut_time),
            insulin_time: of(&self.insulin_time),
            amount: of(&self.amount),
        }
    }
}
