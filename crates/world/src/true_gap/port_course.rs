//! What an effect does at its port through the day.

use physiology::STEPS_PER_HOUR;

use super::PersonGap;
use crate::blind::PlannedEffect;
use crate::effects::{Amplitudes, Condition, Effect, LowTrace, Port, conditions};
use crate::error::WorldError;
use crate::shift::mean;
use crate::virtual_person::{LivedDays, VirtualPerson};

named::named! {
    /// Unit of a course.
    CourseUnit {
        /// Change of the factor by which the port is multiplied.
        Factor: "factor",
        /// Glucose that enters the accessible compartment, mmol/kg/min.
        Flux: "mmol/kg/min",
        /// Carbohydrate that is eaten but not in the log, g/h.
        Carbohydrate: "g/h",
        /// Change of the readings, mg/dL.
        Reading: "mg/dL",
        /// Change of glucose over runs of an hour, mg/dL/min: for effects that each kind of body
        /// has at the port in its own form.
        GlucoseRate: "mg/dL/min",
    }
}

/// The mean course of an effect over the day, at its port.
#[derive(Debug, Clone, PartialEq)]
pub struct PortCourse {
    /// The effect.
    pub effect: PlannedEffect,
    /// Where it acts.
    pub port: Port,
    /// Unit of the course.
    pub unit: CourseUnit,
    /// With minus without, by hour of the clock; `None` where no reading tells.
    pub by_hour: [Option<f64>; 24],
}

impl PortCourse {
    /// The mean course over people and their days, each with the gap to a life without any effect.
    ///
    /// # Errors
    /// If a body's model fails.
    pub fn of(
        effect: PlannedEffect,
        people: &[(&VirtualPerson, &LivedDays, &PersonGap)],
    ) -> Result<Self, WorldError> {
        let unit = unit(effect);
        let each = people
            .iter()
            .map(|(person, lived, gap)| of_person(effect, unit, person, lived, gap))
            .collect::<Result<Vec<_>, WorldError>>()?;
        let by_hour = std::array::from_fn(|hour| mean(each.iter().filter_map(|own| own[hour])));
        Ok(Self { effect, port: effect.port(), unit, by_hour })
    }
}

fn unit(effect: PlannedEffect) -> CourseUnit {
    use Effect::{
        CarbMiscount, Exercise, MissedMeals, PostExerciseSensitivity, RenalThreshold,
        UnloggedRescueCarbs,
    };
    match effect {
        PlannedEffect::Named(CarbMiscount | MissedMeals | UnloggedRescueCarbs) => {
            CourseUnit::Carbohydrate
        }
        PlannedEffect::Named(Exercise | PostExerciseSensitivity | RenalThreshold) => {
            CourseUnit::GlucoseRate
        }
        other => match other.port() {
            Port::Sensor => CourseUnit::Reading,
            Port::GlucoseFlux => CourseUnit::Flux,
            _ => CourseUnit::Factor,
        },
    }
}

fn of_person(
    effect: PlannedEffect,
    unit: CourseUnit,
    person: &VirtualPerson,
    lived: &LivedDays,
    whole: &PersonGap,
) -> Result<[Option<f64>; 24], WorldError> {
    let without = effect.set(person.amplitudes, 0.0);
    let calendar = &lived.life.calendar;
    let by_step: Vec<Option<f64>> = match unit {
        CourseUnit::GlucoseRate => {
            let alone = without == Amplitudes::NONE;
            let gap = if alone { whole } else { &person.gap(lived, &without)? };
            return Ok(std::array::from_fn(|hour| Some(gap.sums[0].mean(hour)? / 60.0)));
        }
        CourseUnit::Reading => {
            let others = person.sensed(lived, &lived.glucose, &without)?;
            person.readings_less(lived, &others)?
        }
        CourseUnit::Carbohydrate => {
            let behind = person.inputs_behind_the_log(lived, &without);
            let more = lived.inputs.iter().zip(&behind).map(|(with, other)| {
                let grams = with.carbs.0 + with.rescue.amount.0;
                Some(STEPS_PER_HOUR as f64 * (grams - other.carbs.0 - other.rescue.amount.0))
            });
            more.collect()
        }
        CourseUnit::Factor | CourseUnit::Flux => {
            let course =
                |amplitudes| conditions(&lived.life, &lived.happenings, &person.shapes, amplitudes);
            let (with, other) = (course(&person.amplitudes), course(&without));
            let mut low = LowTrace::default();
            let pairs = with.iter().zip(&other).zip(&lived.glucose);
            let changes = pairs.map(|((with, other), glucose)| {
                low = low.after_step(*glucose, with.low_form, with.low_response_time);
                let of = |condition: &Condition| {
                    at_port(effect.port(), &condition.at_glucose(*glucose, &low))
                };
                Some(of(with) - of(other))
            });
            changes.collect()
        }
    };
    Ok(std::array::from_fn(|hour| {
        let of_hour = by_step.iter().enumerate();
        let of_hour = of_hour.filter(|(step, _)| calendar.hour(*step) as usize == hour);
        mean(of_hour.filter_map(|(_, value)| *value))
    }))
}

/// The value of a condition at a port: a factor, or the flux.
fn at_port(port: Port, condition: &Condition) -> f64 {
    match port {
        Port::InsulinInput => condition.bioavailability,
        Port::InsulinAbsorption => condition.insulin_time,
        Port::InsulinAction => condition.action,
        Port::InsulinActionLiver => condition.liver_action,
        Port::Egp => condition.production,
        Port::GutAbsorption => condition.gut_time,
        Port::GlucoseFlux => condition.glucose_flux,
        // Not of the body: readings and logs have their own courses.
        Port::CarbAmount | Port::Sensor => 0.0,
    }
}
