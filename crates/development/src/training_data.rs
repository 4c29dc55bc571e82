//! The development set in memory, as windows: what `train` needs of it.

use nn_statespace::Scaler;
use nn_statespace::training::{CarbStart, WindowSet};
use nn_statespace::training_set::CompactRun;
use ode_sim::development_set::Subset;
use ode_sim::{DevelopmentPlan, DevelopmentSet};
use rayon::prelude::*;

use crate::error::DevelopmentError;
use crate::weeks::{TRAINING_STRIDE, WINDOW, WeekFacts, check_split, data_hash, simulated};

/// Windows for fitting and for stopping, scaled by the training rows.
#[derive(Debug)]
pub struct TrainingData {
    /// For fitting, overlapping.
    pub training: WindowSet,
    /// For stopping, side by side.
    pub validation: WindowSet,
    /// The hash of the whole development set, as `development-set` writes it.
    pub sha256: String,
}

impl TrainingData {
    /// Simulates the development set of `plan`. Rows are kept once, in single precision, and those
    /// of the test subset not at all: 97 kB a week. `week_done` is called after each week, from any thread.
    ///
    /// # Errors
    /// Those of the set and of its windows, and [`DevelopmentError::Leak`].
    pub fn simulate(
        plan: &DevelopmentPlan,
        week_done: &(dyn Fn() + Sync),
    ) -> Result<Self, DevelopmentError> {
        let set = DevelopmentSet::new(plan.clone())?;
        let weeks: Vec<(WeekFacts, Option<CompactRun>)> = (0..set.len())
            .into_par_iter()
            .map(|index| {
                let (facts, rows) = simulated(&set, index)?;
                week_done();
                let rows = (facts.subset != Subset::Test).then_some(rows);
                Ok((facts, rows))
            })
            .collect::<Result<_, DevelopmentError>>()?;
        let (facts, rows): (Vec<_>, Vec<_>) = weeks.into_iter().unzip();
        check_split(&set, &facts)?;
        let (mut training, mut validation) = (Vec::new(), Vec::new());
        for (facts, rows) in facts.iter().zip(rows) {
            match facts.subset {
                Subset::Train => training.extend(rows),
                Subset::Validation | Subset::Test => validation.extend(rows),
            }
        }
        let scaler = Scaler::fit_compact(&training)?;
        let cut =
            |runs, stride| WindowSet::in_place(&scaler, runs, WINDOW, stride, CarbStart::Reported);
        Ok(Self {
            training: cut(training, TRAINING_STRIDE)?,
            validation: cut(validation, WINDOW)?,
            sha256: data_hash(&facts),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn training_sees_the_development_set_without_its_test_subset() {
        let plan = DevelopmentPlan::quick(4);
        let data = TrainingData::simulate(&plan, &|| ()).expect("data");
        let set = DevelopmentSet::new(plan).expect("a plan");
        let weeks: Vec<_> =
            (0..set.len()).map(|index| simulated(&set, index).expect("a week")).collect();
        let facts: Vec<WeekFacts> = weeks.iter().map(|(facts, _)| facts.clone()).collect();
        assert_eq!(data.sha256, data_hash(&facts));
        let of = |subset| weeks.iter().filter(move |(facts, _)| facts.subset == subset);
        // (2016 - 60) / 15 + 1 and (2016 - 60) / 60 + 1 windows a week.
        assert_eq!(data.training.len(), 131 * of(Subset::Train).count());
        assert_eq!(data.validation.len(), 33 * of(Subset::Validation).count());
        let training: Vec<CompactRun> = of(Subset::Train).map(|(_, rows)| rows.clone()).collect();
        let scaler = Scaler::fit_compact(&training).expect("rows");
        assert_eq!(*data.training.scaler(), scaler, "of training rows alone");
        assert_eq!(*data.validation.scaler(), scaler);
    }
}
