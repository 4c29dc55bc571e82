//! Training data with progress.

use anyhow::Result;
use development::TrainingData;
use ode_sim::DevelopmentPlan;

use crate::progress::Progress;

/// Simulates the development set of `plan` and says what it takes.
pub(crate) fn simulated(plan: &DevelopmentPlan) -> Result<TrainingData> {
    let progress = Progress::begin("simulate", plan.weeks());
    let data = TrainingData::simulate(plan, &|| progress.advance("weeks"))?;
    progress.finish(&format!(
        "{} days for the development set, {:.0} MB of training and validation rows",
        plan.days(),
        (data.training.bytes() + data.validation.bytes()) as f64 / 1e6
    ));
    Ok(data)
}
