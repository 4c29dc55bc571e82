//! The development set of the paper: seven-day simulations of the nominal person under many meals,
//! bolus timings, doses and starts.
//!
//! Paper, section on the development dataset: 323,400 days; daily meals
//! ([`MealDay`]); boluses by the 1700 rule at the meal or 5 to 45 min
//! late, under- and over-dosed; five initial glucose values N(156, 45) for each meal scenario;
//! further weeks with more than 20 % of the time below 70 mg/dL or more than 40 % above 250 mg/dL, in which
//! insulin varies more: other basal rates, and boluses without a meal;
//! split 60/20/20 so that no daily meal scenario lies in two subsets.
//!
//! Nothing is stored but the pool of daily meals: each week is made from (seed, index) when asked
//! for, so weeks can be made in any order, on any number of threads, and streamed.

use physiology::{
    Kilograms, MgPerDl, OpenLoop, Plant, STEPS_PER_DAY, StepInput, Trajectory, Units, UnitsPerHour,
    simulate,
};
use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, Normal};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::dosing::{BolusCalculator, insulin_to_carb_ratio, total_daily_insulin};
use crate::equations::EgpMode;
use crate::error::{OdeError, not_negative, require};
use crate::integrator::Integrator;
use crate::meal_day::MealDay;
use crate::parameters::OdeParameters;
use crate::plant::OdePlant;
use crate::population::{BASAL_TARGET, MEAN_WEIGHT};
use crate::random::{Purpose, stream};
use crate::state::OdeState;
use crate::steady_state;

/// Days of a simulation (paper).
pub const DAYS_PER_WEEK: usize = 7;
/// Steps of a simulation.
pub const STEPS_PER_WEEK: usize = DAYS_PER_WEEK * STEPS_PER_DAY;
/// Mean and SD of initial glucose, mg/dL (paper: CGM at midnight).
pub const INITIAL_GLUCOSE: (f64, f64) = (156.0, 45.0);
/// Range to which initial glucose is confined by drawing again, mg/dL: what a CGM can show.
pub const INITIAL_RANGE: (f64, f64) = (40.0, 400.0);
/// Longest delay of a bolus, in steps: 45 min (paper).
pub const MAX_DELAY_STEPS: usize = 9;
/// Share of the time below 70 mg/dL above which a week counts as low (paper).
pub const LOW_SHARE: f64 = 0.2;
/// Share of the time above 250 mg/dL above which a week counts as high (paper).
pub const HIGH_SHARE: f64 = 0.4;
/// Shares of the training and validation subsets; the test subset has the rest (paper).
pub const SPLIT: (f64, f64) = (0.6, 0.2);

/// Dose factors among which an additional low or high week is sought (assumed).
const LOW_DOSES: std::ops::Range<f64> = 1.2..2.2;
/// See [`LOW_DOSES`].
const HIGH_DOSES: std::ops::Range<f64> = 0.0..0.7;
/// Factors on the basal rate of a day of an additional week, where it has not the usual one: more of it in low
/// weeks, less in high ones and on one such day in five none, which is what a draw below zero means (assumed).
const LOW_BASAL: std::ops::Range<f64> = 1.0..2.2;
/// See [`LOW_BASAL`].
const HIGH_BASAL: std::ops::Range<f64> = -0.25..1.0;
/// Boluses without a meal on a day of a low week that has one, U (assumed).
const EXTRA_BOLUS: std::ops::Range<f64> = 0.5..8.0;
/// Weeks simulated in search of one additional week before giving up.
const MAX_ATTEMPTS: usize = 1000;

/// What a development set consists of.
#[derive(Debug, Clone, PartialEq)]
pub struct DevelopmentPlan {
    /// Seed of everything.
    pub seed: u64,
    /// Daily meal scenarios in the pool; at least 35, so that each subset has seven.
    pub meal_days: usize,
    /// Seven-day meal scenarios; at least 5.
    pub meal_weeks: usize,
    /// Initial glucose values for each seven-day meal scenario (paper: 5).
    pub starts_per_week: usize,
    /// Delays of all boluses of a week, in steps (paper: 0 to 9).
    pub delays: Vec<usize>,
    /// Factors on all boluses of a week.
    pub dose_factors: Vec<f64>,
    /// Additional weeks, by turns low and high.
    pub additional_weeks: usize,
    /// What the plant does where production would turn negative.
    pub egp: EgpMode,
}

impl DevelopmentPlan {
    /// The paper's size: 46,200 weeks, that is 323,400 days.
    ///
    /// The paper gives neither the dose factors nor the number of additional weeks; here doses are
    /// 0.7, 1 and 1.3 times the rule's, 36,000 weeks cover every combination
    /// (240 meal weeks x 5 starts x 10 delays x 3 doses), and 10,200 are additional. Production is
    /// not let below zero, so that overdosed weeks stay physical.
    #[must_use]
    pub fn paper(seed: u64) -> Self {
        Self {
            seed,
            meal_days: 1000,
            meal_weeks: 240,
            starts_per_week: 5,
            delays: (0..=MAX_DELAY_STEPS).collect(),
            dose_factors: vec![0.7, 1.0, 1.3],
            additional_weeks: 10_200,
            egp: EgpMode::NonNegative,
        }
    }

    /// A set of the same make for trying things out: 60 weeks.
    #[must_use]
    pub fn quick(seed: u64) -> Self {
        Self {
            meal_days: 60,
            meal_weeks: 10,
            starts_per_week: 2,
            delays: vec![0, MAX_DELAY_STEPS],
            dose_factors: vec![1.0],
            additional_weeks: 20,
            ..Self::paper(seed)
        }
    }

    /// Weeks that cover every combination.
    #[must_use]
    pub fn combinations(&self) -> usize {
        self.meal_weeks * self.starts_per_week * self.delays.len() * self.dose_factors.len()
    }

    /// All weeks, the additional ones included.
    #[must_use]
    pub fn weeks(&self) -> usize {
        self.combinations() + self.additional_weeks
    }

    /// All days.
    #[must_use]
    pub fn days(&self) -> usize {
        self.weeks() * DAYS_PER_WEEK
    }
}

named::named! {
    /// Part of the development set.
    Subset {
        /// For fitting.
        Train: "train",
        /// For stopping.
        Validation: "validation",
        /// For the final judgement.
        Test: "test",
    }
}

named::named! {
    /// Why a week is in the set.
    Origin {
        /// One of the combinations.
        Combination: "combination",
        /// Added for more than 20 % of the time below 70 mg/dL.
        AdditionalLow: "additional_low",
        /// Added for more than 40 % of the time above 250 mg/dL.
        AdditionalHigh: "additional_high",
    }
}

/// One seven-day simulation, not yet run.
#[derive(Debug, Clone, PartialEq)]
pub struct Week {
    /// Its place in the set.
    pub index: usize,
    /// The subset it belongs to.
    pub subset: Subset,
    /// Why it is in the set.
    pub origin: Origin,
    /// The seven daily meal scenarios, as places in the pool.
    pub meal_days: [usize; DAYS_PER_WEEK],
    /// Glucose at the start (midnight).
    pub initial_glucose: MgPerDl,
    /// Delay of each bolus, in steps.
    pub delay: usize,
    /// Factor on each bolus of a meal.
    pub dose_factor: f64,
    /// Factor on the basal rate, a day each.
    pub basal_factors: [f64; DAYS_PER_WEEK],
    /// Boluses without a meal: step of the week and size.
    pub extra_boluses: Vec<(usize, Units)>,
    /// The state at the start: steady at the initial glucose.
    pub initial: OdeState,
    /// The 2016 inputs.
    pub inputs: Vec<StepInput>,
}

/// Where the glucose of a week lay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeShares {
    /// Share of the time below 70 mg/dL, 0 to 1.
    pub below_70: f64,
    /// Share of the time above 250 mg/dL, 0 to 1.
    pub above_250: f64,
}

/// The development set of a plan.
#[derive(Debug, Clone)]
pub struct DevelopmentSet {
    plan: DevelopmentPlan,
    plant: OdePlant,
    basal: UnitsPerHour,
    calculator: BolusCalculator,
    pool: Vec<MealDay>,
    /// Seven places in the pool for each meal week.
    weeks: Vec<(Subset, [usize; DAYS_PER_WEEK])>,
}

impl DevelopmentSet {
    /// Draws the pool of daily meals, splits it 60/20/20, and makes each meal week of days of one
    /// subset.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for a plan too small for the split, without weeks, with a delay
    /// beyond a day, or with a dose factor that is negative or not finite.
    pub fn new(plan: DevelopmentPlan) -> Result<Self, OdeError> {
        check(&plan)?;
        let parameters = OdeParameters::nominal();
        let weight = Kilograms(MEAN_WEIGHT);
        let plant =
            OdePlant { parameters, weight, integrator: Integrator::ForwardEuler, egp: plan.egp };
        let basal = steady_state::at_glucose(&parameters, weight, BASAL_TARGET)?.basal;
        let ratio = insulin_to_carb_ratio(total_daily_insulin(basal));
        let calculator = BolusCalculator::new(ratio, None)?;
        let day = |place| MealDay::draw(&mut stream(plan.seed, Purpose::MealDay, place));
        let pool = Subset::ALL.into_iter().flat_map(|subset| streams(&plan, subset)).map(day);
        let pool = pool.collect();
        let weeks = meal_weeks(&plan);
        Ok(Self { plan, plant, basal, calculator, pool, weeks })
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &DevelopmentPlan {
        &self.plan
    }

    /// The plant on which weeks are run: the nominal person under Euler at 5 min.
    #[must_use]
    pub fn plant(&self) -> &OdePlant {
        &self.plant
    }

    /// The pool of daily meal scenarios.
    #[must_use]
    pub fn pool(&self) -> &[MealDay] {
        &self.pool
    }

    /// The pool places that a subset's weeks draw on.
    #[must_use]
    pub fn pool_of(&self, subset: Subset) -> std::ops::Range<usize> {
        pool_of(&self.plan, subset)
    }

    /// Number of weeks.
    #[must_use]
    pub fn len(&self) -> usize {
        self.plan.weeks()
    }

    /// Whether the set has no weeks; never so after [`new`](Self::new).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Week `index`, by itself.
    ///
    /// Additional weeks are found by simulating candidates of this index's own random stream until
    /// one is low (even places) or high (odd places) enough.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for an index beyond the set or if no candidate is found;
    /// those of [`steady_state::at_glucose`] and [`run`](Self::run).
    pub fn week(&self, index: usize) -> Result<Week, OdeError> {
        let combinations = self.plan.combinations();
        let is_there = index < self.len();
        require(is_there, "week index", index as f64, "below the number of weeks")?;
        match index.checked_sub(combinations) {
            None => self.combination(index),
            Some(place) if place % 2 == 0 => self.additional(index, Origin::AdditionalLow),
            Some(_) => self.additional(index, Origin::AdditionalHigh),
        }
    }

    /// Runs a week; 2017 states, the start first.
    ///
    /// # Errors
    /// [`OdeError::Simulation`] if a state leaves the finite numbers.
    pub fn run(&self, week: &Week) -> Result<Trajectory<OdeState>, OdeError> {
        let mut source = OpenLoop::new(&week.inputs);
        Ok(simulate(&self.plant, week.initial, &mut source, week.inputs.len())?)
    }

    /// Weeks `range` with their trajectories, made in parallel, in order.
    ///
    /// The whole set does not fit into memory: ask for a few hundred weeks at a time.
    ///
    /// # Errors
    /// The first error of [`week`](Self::week) or [`run`](Self::run).
    pub fn simulate(
        &self,
        range: std::ops::Range<usize>,
    ) -> Result<Vec<(Week, Trajectory<OdeState>)>, OdeError> {
        range
            .into_par_iter()
            .map(|index| {
                let week = self.week(index)?;
                let run = self.run(&week)?;
                Ok((week, run))
            })
            .collect()
    }

    /// Where the glucose of a run lay, the start not counted.
    #[must_use]
    pub fn time_shares(&self, run: &Trajectory<OdeState>) -> TimeShares {
        let count = |holds: fn(f64) -> bool| {
            let after = run.states.iter().skip(1);
            let hits = after.filter(|state| holds(self.plant.glucose(state).0)).count();
            hits as f64 / run.inputs.len().max(1) as f64
        };
        TimeShares { below_70: count(|g| g < 70.0), above_250: count(|g| g > 250.0) }
    }

    fn combination(&self, index: usize) -> Result<Week, OdeError> {
        let plan = &self.plan;
        // Mixed radix: doses run fastest, meal weeks slowest.
        let (rest, dose) = (index / plan.dose_factors.len(), index % plan.dose_factors.len());
        let (rest, delay) = (rest / plan.delays.len(), rest % plan.delays.len());
        let (meal_week, start) = (rest / plan.starts_per_week, rest % plan.starts_per_week);
        // A start belongs to its meal week, whatever delay and dose.
        let mut rng =
            stream(plan.seed, Purpose::Week, (meal_week * plan.starts_per_week + start) as u64);
        let week = self.begun(index, Origin::Combination, meal_week, initial_glucose(&mut rng));
        let (delay, dose_factor) = (plan.delays[delay], plan.dose_factors[dose]);
        self.assembled(Week { delay, dose_factor, ..week })
    }

    fn additional(&self, index: usize, origin: Origin) -> Result<Week, OdeError> {
        let mut rng = stream(self.plan.seed, Purpose::Scenario, index as u64);
        for _ in 0..MAX_ATTEMPTS {
            let low = origin == Origin::AdditionalLow;
            let (doses, basal) =
                if low { (LOW_DOSES, LOW_BASAL) } else { (HIGH_DOSES, HIGH_BASAL) };
            let meal_week = rng.random_range(0..self.weeks.len());
            let week = self.begun(index, origin, meal_week, initial_glucose(&mut rng));
            let week = self.assembled(Week {
                delay: rng.random_range(0..=MAX_DELAY_STEPS),
                dose_factor: rng.random_range(doses),
                basal_factors: std::array::from_fn(|_| {
                    if rng.random() { 1.0 } else { rng.random_range(basal.clone()).max(0.0) }
                }),
                extra_boluses: if low { extra_boluses(&mut rng) } else { Vec::new() },
                ..week
            })?;
            let shares = self.time_shares(&self.run(&week)?);
            let enough =
                if low { shares.below_70 > LOW_SHARE } else { shares.above_250 > HIGH_SHARE };
            if enough {
                return Ok(week);
            }
        }
        let (name, value) = ("additional week", index as f64);
        Err(OdeError::Argument { name, value, requirement: "reachable with the meals of the pool" })
    }

    /// A week in which insulin follows the rule, as yet without start and inputs.
    fn begun(
        &self,
        index: usize,
        origin: Origin,
        meal_week: usize,
        initial_glucose: MgPerDl,
    ) -> Week {
        let (subset, meal_days) = self.weeks[meal_week];
        Week {
            index,
            subset,
            origin,
            meal_days,
            initial_glucose,
            delay: 0,
            dose_factor: 1.0,
            basal_factors: [1.0; DAYS_PER_WEEK],
            extra_boluses: Vec::new(),
            initial: OdeState::default(),
            inputs: Vec::new(),
        }
    }

    /// The week with its start and inputs.
    fn assembled(&self, week: Week) -> Result<Week, OdeError> {
        let OdePlant { parameters, weight, .. } = &self.plant;
        let initial = steady_state::at_glucose(parameters, *weight, week.initial_glucose)?.state;
        let mut inputs =
            vec![StepInput { basal: self.basal, ..StepInput::default() }; STEPS_PER_WEEK];
        for (day, place) in week.meal_days.into_iter().enumerate() {
            let basal = UnitsPerHour(self.basal.0 * week.basal_factors[day]);
            inputs[day * STEPS_PER_DAY..][..STEPS_PER_DAY].iter_mut().for_each(|i| i.basal = basal);
            for meal in self.pool[place].meals() {
                let step = day * STEPS_PER_DAY + meal.step;
                inputs[step].carbs = inputs[step].carbs + meal.carbs;
                // A bolus that would come after the end of the week is not part of it.
                if let Some(input) = inputs.get_mut(step + week.delay) {
                    let bolus = self.calculator.meal_bolus(meal.carbs) * week.dose_factor;
                    input.bolus = input.bolus + bolus;
                }
            }
        }
        for (step, bolus) in &week.extra_boluses {
            inputs[*step].bolus = inputs[*step].bolus + *bolus;
        }
        Ok(Week { initial, inputs, ..week })
    }
}

fn check(plan: &DevelopmentPlan) -> Result<(), OdeError> {
    let (days, weeks) = (plan.meal_days as f64, plan.meal_weeks as f64);
    let enough_days = plan.meal_days >= 5 * DAYS_PER_WEEK;
    require(enough_days, "meal days", days, "at least 35, seven in each subset")?;
    require(plan.meal_weeks >= 5, "meal weeks", weeks, "at least 5, one in each subset")?;
    let some = plan.combinations() > 0;
    require(some, "combinations", 0.0, "at least one start, delay and dose factor")?;
    for delay in &plan.delays {
        let is_short = *delay < STEPS_PER_DAY;
        require(is_short, "bolus delay in steps", *delay as f64, "shorter than a day")?;
    }
    plan.dose_factors.iter().try_for_each(|factor| not_negative("dose factor", *factor))
}

/// How many of `total` fall into the first one and the first two subsets.
fn borders(total: usize) -> (usize, usize) {
    let at = |share: f64| (share * total as f64).round() as usize;
    (at(SPLIT.0), at(SPLIT.0 + SPLIT.1))
}

/// Days of the pool are drawn alike, so that a split by place is a random one.
fn pool_of(plan: &DevelopmentPlan, subset: Subset) -> std::ops::Range<usize> {
    let (first, second) = borders(plan.meal_days);
    match subset {
        Subset::Train => 0..first,
        Subset::Validation => first..second,
        Subset::Test => second..plan.meal_days,
    }
}

/// The streams of a subset's days: the same for the first, second and every day of a subset in each plan of a seed, so
/// that what one plan tests on trained no network of another.
fn streams(plan: &DevelopmentPlan, subset: Subset) -> impl Iterator<Item = u64> {
    let paper = pool_of(&DevelopmentPlan::paper(plan.seed), subset);
    // Beyond the paper's days each subset has streams of its own.
    let beyond = (1 + subset as u64) << 32;
    let stream =
        move |k: usize| paper.clone().nth(k).map_or(beyond + k as u64, |place| place as u64);
    (0..pool_of(plan, subset).len()).map(stream)
}

/// Deals the days of each subset to its weeks, as evenly as they go: a subset's days are shuffled
/// and dealt out seven at a time, again and again.
fn meal_weeks(plan: &DevelopmentPlan) -> Vec<(Subset, [usize; DAYS_PER_WEEK])> {
    // A stream that no single week uses.
    let mut rng: ChaCha12Rng = stream(plan.seed, Purpose::MealDay, plan.meal_days as u64);
    let (first, second) = borders(plan.meal_weeks);
    let sizes = [first, second - first, plan.meal_weeks - second];
    let mut weeks = Vec::with_capacity(plan.meal_weeks);
    for (subset, size) in Subset::ALL.into_iter().zip(sizes) {
        let mut days: Vec<usize> = pool_of(plan, subset).collect();
        let mut dealt = Vec::new();
        while dealt.len() < size {
            days.shuffle(&mut rng);
            dealt.extend(days.as_chunks::<DAYS_PER_WEEK>().0.iter().map(|week| (subset, *week)));
        }
        weeks.extend(dealt.into_iter().take(size));
    }
    weeks
}

/// On every second day one bolus at any time.
fn extra_boluses(rng: &mut impl Rng) -> Vec<(usize, Units)> {
    let mut boluses = Vec::new();
    for day in 0..DAYS_PER_WEEK {
        if rng.random() {
            let step = day * STEPS_PER_DAY + rng.random_range(0..STEPS_PER_DAY);
            boluses.push((step, Units(rng.random_range(EXTRA_BOLUS))));
        }
    }
    boluses
}

fn initial_glucose(rng: &mut impl Rng) -> MgPerDl {
    let (mean, sd) = INITIAL_GLUCOSE;
    let normal = Normal::new(mean, sd).expect("both constants are positive");
    loop {
        let glucose = normal.sample(rng);
        if (INITIAL_RANGE.0..=INITIAL_RANGE.1).contains(&glucose) {
            return MgPerDl(glucose);
        }
    }
}
