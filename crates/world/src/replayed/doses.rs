//! The recorded doses without gaps.

use cohort::{Channel, CohortError, MissingDoses, Person};
use physiology::{StepInput, UnitsPerHour};

/// What was given in each step of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Doses {
    /// Doses and context; carbohydrate as logged, no exercise.
    pub(super) inputs: Vec<StepInput>,
    /// Share of the steps with a basal rate, 0 to 1.
    pub(super) basal_recorded: f64,
}

impl Doses {
    /// The doses of a person. A missing basal rate is replaced by the median of its hour of the
    /// day; a missing bolus or meal counts as not given.
    pub(super) fn of(person: &Person) -> Result<Self, CohortError> {
        let record = &person.record;
        let mut inputs = person.inputs(0..record.len(), MissingDoses::Zero)?;
        let usual = usual_basal(person);
        let mut recorded = 0_usize;
        for (step, input) in inputs.iter_mut().enumerate() {
            match record.channel(Channel::Basal)[step] {
                Some(_) => recorded += 1,
                None => input.basal = UnitsPerHour(usual[usize::from(record.hour(step))]),
            }
        }
        let basal_recorded = recorded as f64 / (inputs.len() as f64).max(1.0);
        Ok(Self { inputs, basal_recorded })
    }

    /// Number of steps.
    pub(super) fn len(&self) -> usize {
        self.inputs.len()
    }
}

/// Median basal rate of each hour of the day, U/h; that of the whole day where an hour has none.
fn usual_basal(person: &Person) -> [f64; 24] {
    let mut by_hour: [Vec<f64>; 24] = std::array::from_fn(|_| Vec::new());
    for (step, rate) in person.record.basal().iter().enumerate() {
        if let Some(rate) = rate {
            by_hour[usize::from(person.record.hour(step))].push(*rate);
        }
    }
    let whole: Vec<f64> = by_hour.iter().flatten().copied().collect();
    let overall = median(whole).unwrap_or(0.0);
    by_hour.map(|rates| median(rates).unwrap_or(overall))
}

/// The middle value, `None` if there is none.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
