//! Everyday variation over the days of a life.

use super::Everyday;
use crate::behaviour::Life;
use crate::stream::{Concept, stream};

/// Logarithms of factors in one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EverydayLogs {
    /// On insulin action, everywhere.
    pub action: f64,
    /// On endogenous glucose production.
    pub production: f64,
    /// On the time of the gut.
    pub gut_time: f64,
    /// On the time of insulin absorption.
    pub insulin_time: f64,
    /// On the insulin that arrives.
    pub amount: f64,
}

impl Everyday {
    /// Draws the course of a life of person `person` of the world with this seed, step by step;
    /// empty where nothing varies.
    #[must_use]
    pub(crate) fn course(&self, life: &Life, seed: u64, person: usize) -> Vec<EverydayLogs> {
        if self.is_narrow() {
            return Vec::new();
        }
        let mut course: Vec<EverydayLogs> = (0..life.calendar.steps())
            .map(|step| {
                let (action, production) = self.pattern.at(life.calendar.hour(step));
                EverydayLogs { action, production, ..EverydayLogs::default() }
            })
            .collect();
        self.pace.add(&mut course, life, &mut stream(seed, person, Concept::MealSpeeds));
        self.sites.add(&mut course, life, &mut stream(seed, person, Concept::Sites));
        course
    }
}
