//! A person as every fold needs her.

use effects::{Course, Form};

use super::NamedEffect;
use super::drivers::Driver;
use super::folds::{FOLDS, Folds};
use crate::calibrated_person::CalibratedPerson;

/// A person with what her drivers look at.
pub(super) struct Subject<'a> {
    pub(super) input: &'a CalibratedPerson<'a>,
    pub(super) course: Course,
    pub(super) folds: Folds,
    /// How each effect found acts for her.
    pub(super) forms: Vec<Option<Form>>,
    /// The effects that have a driver in somebody's record, and the amplitudes at which fits start.
    pub(super) drivers: Vec<Driver<'a>>,
    pub(super) starts: Vec<f64>,
}

impl<'a> Subject<'a> {
    pub(super) fn new(input: &'a CalibratedPerson<'a>, found: &[NamedEffect<'_>]) -> Self {
        let course = input.course();
        let folds = Folds::new(&course.day, FOLDS);
        let forms = found.iter().map(|f| f.effect.form(&course)).collect();
        Self { input, course, folds, forms, drivers: Vec::new(), starts: Vec::new() }
    }

    /// Gives the person the drivers of the effects that have one in somebody's record.
    pub(super) fn drive(&mut self, index: usize, driven: &[&NamedEffect<'a>]) {
        for found in driven {
            self.drivers.push(Driver::new(found.effect, found.variant, &self.course));
            let largest = found.effect.card().prior.largest;
            self.starts.push(found.amplitude(index).clamp(0.0, largest));
        }
    }
}
