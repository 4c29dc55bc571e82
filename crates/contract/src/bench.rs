//! `bench.json`: how fast things are. Each kind of benchmark has a schema of its own.

use crate::diagnosis::Verdict;
use crate::meals::Score;

/// `bench`: diagnoses of made people.
#[apply(strict!)]
pub struct DiagnosisBench {
    /// Days of a person.
    pub days: usize,
    /// The effect that acts in everybody, or `none`.
    pub effect: String,
    /// The parts of the work on one person.
    pub parts: Vec<Part>,
    /// One row a size of cohort.
    pub rows: Vec<DiagnosisRow>,
    /// `bench-diagnosis/1`.
    pub schema: String,
    /// Threads.
    pub threads: usize,
}

/// One part of the work on one person.
#[apply(strict!)]
pub struct Part {
    /// Time on one thread, ms.
    pub milliseconds_per_person: f64,
    /// What is done.
    pub part: String,
}

/// The diagnosis of one cohort.
#[apply(strict!)]
pub struct DiagnosisRow {
    /// Effects that were named.
    pub effects: Vec<String>,
    /// People who were left out.
    pub excluded: usize,
    /// Largest memory in use up to the end of the diagnosis, MiB; the people themselves included. Null where the
    /// system does not tell.
    pub peak_mib: Option<f64>,
    /// People.
    pub people: usize,
    /// People a second.
    pub people_per_second: f64,
    /// Processor time of all threads, s, where the system tells it; other programs hardly change it.
    pub processor_seconds: Option<f64>,
    /// Time taken, s.
    pub seconds: f64,
    /// The answer.
    pub verdict: Verdict,
}

/// `bench --what meals`: detectors and rules against what was eaten.
#[apply(strict!)]
pub struct MealsBench {
    /// Days of a person.
    pub days: usize,
    /// Detectors in each world.
    pub detectors: Vec<MealRow>,
    /// Logs in each world, before and after reconciliation.
    pub logs: Vec<MealRow>,
    /// People of a world.
    pub people: usize,
    /// `bench-meals/1`.
    pub schema: String,
    /// The detector on the plant by its threshold, over all worlds of a generator.
    pub thresholds: Vec<MealRow>,
    /// `meals`.
    pub what: String,
}

/// One line of the tables.
#[apply(strict!)]
pub struct MealRow {
    /// What acts in the world; null for all worlds of the generator together.
    pub condition: Option<Condition>,
    /// Who made the world.
    pub generator: String,
    /// How well meals agree.
    pub score: Score,
    /// `grid`, `plant`, `plant at N nats`, or the log and the rule by which it was reconciled.
    pub what: String,
}

/// What acts in a world.
#[apply(word!)]
pub enum Condition {
    /// Nothing.
    NoEffect,
    /// Meals are not logged.
    MissedMeals,
    /// Carbohydrate is miscounted.
    CarbMiscount,
    /// Every effect, by each person's own amplitude.
    EveryEffect,
}

/// `bench --what training-step`: one update of the population network.
#[apply(strict!)]
pub struct TrainingStepBench {
    /// Windows of a batch.
    pub batch: usize,
    /// One row an engine and number of threads.
    pub rows: Vec<StepRow>,
    /// `bench-training-step/1`.
    pub schema: String,
    /// Steps of a window.
    pub steps: usize,
    /// `training_step`.
    pub what: String,
}

/// What one engine took for an update.
#[apply(strict!)]
pub struct StepRow {
    /// The engine.
    pub engine: String,
    /// Least time, ms.
    pub least_ms: f64,
    /// Median time, ms.
    pub median_ms: f64,
    /// `update`: loss, gradient and update of the weights; `gradient`: without the update.
    pub part: String,
    /// Threads.
    pub threads: usize,
}

/// `bench --what twins`: simulation and training of twins.
#[apply(strict!)]
pub struct TwinsBench {
    /// One row a job, engine and number of threads.
    pub rows: Vec<JobRow>,
    /// `bench-twins/1`.
    pub schema: String,
    /// The paper's training of several people.
    pub training: WholeTraining,
    /// `twins`.
    pub what: String,
}

/// What one engine took for one job.
#[apply(strict!)]
pub struct JobRow {
    /// The engine.
    pub engine: String,
    /// The job.
    pub job: String,
    /// Least time, ms.
    pub least_ms: f64,
    /// Median time, ms.
    pub median_ms: f64,
    /// Processor time of all threads, ms, where the system tells it.
    pub processor_ms: Option<f64>,
    /// Threads.
    pub threads: usize,
}

/// The paper's training of several people.
#[apply(strict!)]
#[derive(Copy)]
pub struct WholeTraining {
    /// Passes through the windows.
    pub epochs: usize,
    /// People.
    pub people: usize,
    /// Processor time of all threads, s, where the system tells it.
    pub processor_seconds: Option<f64>,
    /// Time taken, s.
    pub seconds: f64,
    /// Threads.
    pub threads: usize,
    /// Training windows, over all people.
    pub windows: usize,
}
