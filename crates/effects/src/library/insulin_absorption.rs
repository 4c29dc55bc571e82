//! Insulin is absorbed faster on one day than on another.

use super::prelude::*;

/// Standard deviation of the logarithm of the time of absorption from day to day at amplitude 1.
const LOG_SD: f64 = 0.18;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct InsulinAbsorption;

impl Effect for InsulinAbsorption {
    fn card(&self) -> Card {
        Card {
            id: EffectId::INSULIN_ABSORPTION,
            port: Port::InsulinAbsorption,
            summary: "the time of insulin absorption varies from day to day",
            size_at_one: "a coefficient of variation of 18 % between days",
            source: "10 to 25 % within a person: Heinemann, Diabetes Technol Ther 2002;4:673; Heinemann et al., \
                     Diabetes Care 1998;21:1910",
            signature: "errors after boluses, of one sign on a day and of another on the next, with no mean",
            channels: &[Channel::Insulin],
            confusable_with: &[
                EffectId::SET_AGEING,
                EffectId::SLEEP_LOSS,
                EffectId::POST_EXERCISE_SENSITIVITY,
            ],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.4, largest: 3.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        (!course.is_empty()).then_some(Form::Random {
            field: Field::InsulinTime,
            unit: RandomUnit::Day,
            log_sd: LOG_SD,
        })
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::fortnight;

    #[test]
    fn it_is_drawn_anew_every_day_within_the_published_range() {
        let form = InsulinAbsorption.form(&fortnight());
        let Some(Form::Random { field: Field::InsulinTime, unit: RandomUnit::Day, log_sd }) = form
        else {
            panic!("insulin absorption is random by day: {form:?}");
        };
        assert!((0.10..=0.25).contains(&log_sd));
    }
}
