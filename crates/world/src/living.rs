//! One person's days as the source of the inputs of a simulation: what the sensor shows, what the
//! pump delivers, what is eaten, and what of it is logged.

use ode_sim::{BolusCalculator, OdeError, Pump, pump};
use physiology::{
    Context, FastCarbs, Grams, InputSource, MgPerDl, Minutes, STEP, STEPS_PER_DAY, StepInput,
    Units, UnitsPerHour,
};

use crate::behaviour::{BolusTiming, Life};
use crate::devices::WornSensors;
use crate::everyday::Rescues;
use crate::logging::Logging;
use crate::reactions::Reaction;
use crate::therapy::{Aid, Depot, Observation, Order, Pen, TherapySettings};

/// Time constants with which pumps and people compute insulin and carbohydrate on board.
const INSULIN_TAU: Minutes = Minutes(75.0);
const CARBS_TAU: Minutes = Minutes(45.0);
/// Steps for which a reading stays usable: 20 min.
const READING_LIVES: usize = 4;
/// Readings below which a low is treated, awake and (through the alarm) asleep, mg/dL.
const LOW_AWAKE: f64 = 68.0;
const LOW_ASLEEP: f64 = 60.0;
/// Glucose that is felt without a reading, mg/dL.
const FELT_LOW: f64 = 55.0;
/// Probability in each step that a low is treated, awake and asleep.
const TREATS_AWAKE: f64 = 0.25;
const TREATS_ASLEEP: f64 = 0.10;
/// Steps between two treatments: the advice to wait 15 min and test again.
const TREATMENT_PAUSE: usize = 3;
/// Reading that is corrected by hand, mg/dL, the probability of that in each step awake, and the
/// steps that must have passed since the last bolus.
const HIGH: f64 = 230.0;
const CORRECTS: f64 = 0.08;
const CORRECTION_PAUSE: usize = 24;
/// Share of the programmed rate that is left in exercise without automated delivery: a temporary
/// rate of half, as consensus advice has it (Riddell et al., Lancet Diabetes Endocrinol
/// 2017;5:377).
const IN_EXERCISE: f64 = 0.5;
/// Reading below which something is eaten before exercise, mg/dL, how often, and how much (Riddell
/// et al., Lancet Diabetes Endocrinol 2017;5:377 advise 10 to 20 g below 90 to 126 mg/dL).
const EXERCISE_SNACK_BELOW: f64 = 126.0;
const EXERCISE_SNACKS: f64 = 0.7;
const EXERCISE_SNACK: Grams = Grams(15.0);

/// What is logged of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Logged {
    /// Sensor reading, mg/dL; `None` if lost.
    pub(crate) cgm: Option<MgPerDl>,
    /// Basal rate ordered. The pump delivers it in increments, with a delay of less than one of
    /// them.
    pub(crate) basal: UnitsPerHour,
    /// Bolus delivered.
    pub(crate) bolus: Units,
    /// Carbohydrate as counted.
    pub(crate) carbs: Grams,
}

/// What a person does about glucose.
pub(crate) struct Therapy {
    /// The settings in use.
    pub(crate) settings: TherapySettings,
    /// What decides basal insulin, unless it follows the programme.
    pub(crate) aid: Option<Aid>,
    /// How lows are treated.
    pub(crate) rescues: Rescues,
    /// The injections, for a person who injects.
    pub(crate) injected: Option<Injected>,
}

/// A life lived under a therapy, step by step.
pub(crate) struct Living<'a> {
    life: &'a Life,
    logging: Logging,
    reactions: &'a [Reaction],
    sensors: WornSensors,
    therapy: Therapy,
    pump: Pump,
    calculator: BolusCalculator,
    next_meal: usize,
    due: Vec<(usize, Grams)>,
    boluses: Depot,
    beyond_profile: Depot,
    announced: Depot,
    readings: [Option<f64>; READING_LIVES],
    last_bolus: Option<usize>,
    last_treatment: Option<usize>,
    /// What was logged, one entry a step.
    pub(crate) log: Vec<Logged>,
    /// The lows that were treated with slow food, with their steps.
    pub(crate) slow_rescues: Vec<(usize, Grams)>,
    /// The error that ended the life early, if a device failed.
    pub(crate) failure: Option<OdeError>,
}

/// What is injected instead of a pump's insulin.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Injected {
    /// The pen.
    pub(crate) pen: Pen,
    /// Rates at which long-acting insulin arrives, U/h, one per step.
    pub(crate) rates: Vec<f64>,
}

/// Carbohydrate against a low.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Treatment {
    fast: Grams,
    slow: Grams,
    logged: Grams,
}

impl<'a> Living<'a> {
    /// A life from its first step.
    ///
    /// # Errors
    /// If the settings are not positive numbers.
    pub(crate) fn new(
        life: &'a Life,
        logging: Logging,
        reactions: &'a [Reaction],
        sensors: WornSensors,
        therapy: Therapy,
    ) -> Result<Self, OdeError> {
        Ok(Self {
            life,
            logging,
            reactions,
            sensors,
            pump: Pump::new(pump::INCREMENT)?,
            calculator: therapy.settings.calculator()?,
            therapy,
            next_meal: 0,
            due: Vec::new(),
            boluses: Depot::new(INSULIN_TAU),
            beyond_profile: Depot::new(INSULIN_TAU),
            announced: Depot::new(CARBS_TAU),
            readings: [None; READING_LIVES],
            last_bolus: None,
            last_treatment: None,
            log: Vec::with_capacity(life.calendar.steps()),
            slow_rescues: Vec::new(),
            failure: None,
        })
    }

    /// The latest usable reading.
    fn reading(&self) -> Option<f64> {
        self.readings.iter().rev().find_map(|r| *r)
    }

    /// Change of the readings over the last 15 min, mg/dL per minute; 0 if one is missing.
    fn trend(&self) -> f64 {
        match (self.readings[READING_LIVES - 1], self.readings[0]) {
            (Some(now), Some(before)) => (now - before) / ((READING_LIVES - 1) as f64 * STEP.0),
            _ => 0.0,
        }
    }

    /// What is eaten and announced of the meals of a step. Boluses that are due are noted.
    fn eat(&mut self, step: usize) -> (Grams, Grams) {
        let (mut eaten, mut logged) = (Grams(0.0), Grams(0.0));
        while let Some(meal) = self.life.meals.get(self.next_meal).filter(|m| m.step <= step) {
            self.next_meal += 1;
            eaten = eaten + meal.eaten;
            let Some(counted) = self.logging.of_meal(meal) else { continue };
            logged = logged + counted;
            match meal.bolus {
                BolusTiming::Prompt => self.due.push((step, counted)),
                BolusTiming::Late(steps) => self.due.push((step + steps, counted)),
                BolusTiming::Missed => {}
            }
        }
        (eaten, logged)
    }

    /// The bolus that the person gives in a step.
    fn user_bolus(&mut self, step: usize, reaction: &Reaction) -> Units {
        let reading = self.reading();
        let counted: f64 = self.due.iter().filter(|(at, _)| *at <= step).map(|(_, g)| g.0).sum();
        self.due.retain(|(at, _)| *at > step);
        if counted > 0.0 {
            self.announced.add(counted);
        }
        let since = self.last_bolus.map_or(usize::MAX, |at| step - at);
        let corrects = reading.is_some_and(|g| g > HIGH)
            && !self.life.is_asleep(step)
            && since >= CORRECTION_PAUSE
            && reaction.correct < CORRECTS;
        if counted == 0.0 && !corrects {
            return Units(0.0);
        }
        match reading {
            Some(glucose) => self.calculator.bolus(
                Grams(counted),
                MgPerDl(glucose),
                Units(self.boluses.remaining()),
            ),
            None => self.calculator.meal_bolus(Grams(counted)),
        }
    }

    /// Carbohydrate against a low, and what is logged of it.
    fn treatment(&mut self, step: usize, glucose: MgPerDl, reaction: &Reaction) -> Treatment {
        let asleep = self.life.is_asleep(step);
        let (threshold, chance) =
            if asleep { (LOW_ASLEEP, TREATS_ASLEEP) } else { (LOW_AWAKE, TREATS_AWAKE) };
        let low = match self.reading() {
            Some(reading) => reading < threshold,
            None => glucose.0 < FELT_LOW,
        };
        let waits = self.last_treatment.is_some_and(|at| step - at < TREATMENT_PAUSE);
        if !low || waits || reaction.treat >= chance {
            return Treatment::default();
        }
        self.last_treatment = Some(step);
        let eaten = Grams(self.therapy.rescues.amount(reaction.treat_size));
        let logged = if self.logging.omits_rescue(step, reaction) { Grams(0.0) } else { eaten };
        if self.therapy.rescues.is_slow(reaction.treat_size) {
            self.slow_rescues.push((step, eaten));
            return Treatment { slow: eaten, logged, ..Treatment::default() };
        }
        Treatment { fast: eaten, logged, ..Treatment::default() }
    }

    /// The order of basal insulin, and of an automatic bolus.
    fn order(&mut self, observation: &Observation) -> Order {
        if let Some(aid) = &mut self.therapy.aid {
            return aid.order(observation);
        }
        // With injections nothing decides from hour to hour; this order is not carried out.
        let share = if observation.exercising { IN_EXERCISE } else { 1.0 };
        let programmed = self.therapy.settings.basal_at(observation.hour);
        Order { basal: programmed * share, bolus: Units(0.0) }
    }

    /// One step: reads, eats, doses, logs.
    fn live_step(
        &mut self,
        step: usize,
        glucose: MgPerDl,
        reaction: &Reaction,
    ) -> Result<StepInput, OdeError> {
        // Sensors show whole mg/dL.
        let cgm = self.sensors.sense(step, glucose)?.map(|shown| MgPerDl(shown.0.round()));
        self.readings.rotate_left(1);
        self.readings[READING_LIVES - 1] = cgm.map(|g| g.0);

        let session = self.life.session_at(step);
        let (mut eaten, mut logged) = self.eat(step);
        if session.is_some_and(|s| s.start == step)
            && self.reading().is_some_and(|g| g < EXERCISE_SNACK_BELOW)
            && reaction.snack < EXERCISE_SNACKS
        {
            // Portions of snacks and treatments are known, so they are logged to the gram.
            eaten = eaten + EXERCISE_SNACK;
            logged = logged + EXERCISE_SNACK;
        }
        let rescue = self.treatment(step, glucose, reaction);
        let by_hand = self.user_bolus(step, reaction);

        let calendar = &self.life.calendar;
        let hour = calendar.hour(step);
        let order = self.order(&Observation {
            hour,
            glucose: self.reading().map(MgPerDl),
            trend: self.trend(),
            insulin_on_board: Units(self.beyond_profile.remaining() + by_hand.0),
            carbs_on_board: Grams(self.announced.remaining()),
            exercising: session.is_some(),
        });
        // Pumps log a thousandth of a unit per hour at most.
        let basal = UnitsPerHour((order.basal.0 * 1000.0).round() / 1000.0);
        let wanted = StepInput {
            basal,
            bolus: by_hand + order.bolus,
            carbs: eaten + rescue.slow,
            rescue: FastCarbs { amount: rescue.fast, eaten_before: Minutes(0.0) },
            exercise: session.map(|s| s.exercise),
            context: Context {
                heart_rate_over_baseline: None,
                hour: hour as u8,
                weekend: calendar.is_weekend(step / STEPS_PER_DAY),
                sleep_efficiency: self.life.asleep.get(step).copied(),
            },
        };
        let given = match &self.therapy.injected {
            Some(Injected { pen, rates }) => StepInput {
                basal: UnitsPerHour(rates.get(step).copied().unwrap_or(0.0)),
                bolus: pen.dialled(by_hand),
                ..wanted
            },
            None => self.pump.deliver(&wanted)?,
        };
        // Whole increments as a decimal number, so that the log shows 0.15 and not
        // 0.15000000000000002.
        let bolus = Units((given.bolus.0 * 100.0).round() / 100.0);
        if bolus.0 > 0.0 {
            self.last_bolus = Some(step);
        }
        let programmed = self.therapy.settings.basal_at(hour).during(STEP).0;
        self.boluses.add(bolus.0);
        self.beyond_profile.add(bolus.0 + basal.during(STEP).0 - programmed);
        for depot in [&mut self.boluses, &mut self.beyond_profile, &mut self.announced] {
            depot.pass_step();
        }
        self.log.push(Logged { cgm, basal, bolus, carbs: logged + rescue.logged });
        Ok(StepInput { bolus, ..given })
    }
}

impl InputSource for Living<'_> {
    fn next(&mut self, step: usize, glucose: MgPerDl) -> Option<StepInput> {
        if step >= self.life.calendar.steps() {
            return None;
        }
        let reaction = *self.reactions.get(step)?;
        self.live_step(step, glucose, &reaction).map_err(|error| self.failure = Some(error)).ok()
    }
}
