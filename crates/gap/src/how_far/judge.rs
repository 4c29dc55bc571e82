//! Free runs and one-step predictions of one person on the days held out in one fold.
//!
//! A free run goes through [`simulate`], or through [`PreparedSteps`] where nothing that acts depends on the run.

use std::ops::Range;

use effects::{Course, Modulation};
use physiology::{MgPerDl, OpenLoop, Plant as _, STEPS_PER_DAY, STEPS_PER_HOUR, simulate};
use stats::Outcomes;

use super::drivers::{self, Driver};
use super::floor::{ExpectedErrors, Rollouts};
use super::prepared_steps::PreparedSteps;
use super::reconstruction::{self, Hidden};
use super::refit::{Fit, model, stretch};
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::kalman::filter;
use crate::filter::observations::{Observations, Reading};
use crate::filter::scored::normalised;
use crate::filter::state::AugmentedState;
use crate::filter::whitening::huber_loss;
use crate::modulated_plant::{ModulatedPlant, ModulatedState};

/// Steps from one start of a free run to the next: two hours.
const EVERY: usize = 2 * STEPS_PER_HOUR;
/// One start in so many has its floor taken: at two hours between starts, every twenty hours, so that all
/// parts of the day come up.
const FLOOR_EVERY: usize = 10;
/// Smallest share of readings in a day whose outcomes are compared (Battelino et al., Diabetes Care 2019;42:1593).
const LEAST_READINGS: f64 = 0.7;
/// Steps of record that the filter sees before the first day held out: a day, twice the burn-in.
const LEAD: usize = STEPS_PER_DAY;
/// Rounds in which a run and what its own glucose drives are brought into agreement.
const ROUNDS: usize = 6;
/// Largest change of a run's glucose at which the two agree, mg/dL.
const AGREED: f64 = 0.5;

/// One held-out day of a person.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct HeldOutDay {
    /// Free runs by horizon.
    pub(super) horizons: Vec<HeldOutHorizon>,
    /// Log-likelihood of the readings, nats.
    pub(super) log_likelihood: f64,
    /// Readings that it counts.
    pub(super) innovations: f64,
    /// Outcomes of the readings and of the free run through the day.
    pub(super) outcomes: Option<(Outcomes, Outcomes)>,
}

/// Free runs that start on one day, at one horizon.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct HeldOutHorizon {
    /// Their number.
    pub(super) runs: f64,
    /// Sum of absolute errors, mg/dL.
    pub(super) sizes: f64,
    /// Number of those whose floor was taken.
    pub(super) floor_runs: f64,
    /// Sum of expected absolute errors of a perfect model, mg/dL.
    pub(super) floors: f64,
}

/// What is judged: a fit, under drivers or none.
#[derive(Debug, Clone, Copy)]
pub(super) struct CandidateFit<'a> {
    pub(super) fit: &'a Fit,
    pub(super) drivers: &'a [Driver<'a>],
    /// What was reconstructed.
    pub(super) hidden: &'a [Hidden],
    /// Whether the error floor is wanted as well.
    pub(super) floor: bool,
}

impl CandidateFit<'_> {
    /// What some drivers do in each step, and what was reconstructed.
    fn modulations(&self, course: &Course, only: impl Fn(&Driver<'_>) -> bool) -> Vec<Modulation> {
        let amplitudes = &self.fit.amplitudes;
        let mut modulations = drivers::modulations(self.drivers, amplitudes, course, only);
        reconstruction::add(self.hidden, &mut modulations);
        modulations
    }
}

/// A person's record with one block of days held out.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldOutBlock<'a> {
    pub(super) observations: &'a Observations,
    /// The person's model, with whatever factors.
    pub(super) model: &'a AugmentedModel,
    pub(super) block: &'a Range<usize>,
    /// First steps of the whole days in the block.
    pub(super) whole_days: &'a [usize],
    pub(super) config: &'a DiagnosisConfig,
}

impl HeldOutBlock<'_> {
    /// Judges a candidate; one entry a calendar day of the block, in their order.
    ///
    /// `course` is what drivers look at. Its glucose up to each start is that of a filter that has seen the
    /// readings up to there; it is replaced by this candidate's.
    ///
    /// # Errors
    /// As [`filter`] and [`GapError::FreeRun`].
    pub(super) fn judge(
        &self,
        candidate: &CandidateFit<'_>,
        course: &mut Course,
    ) -> Result<Vec<HeldOutDay>, GapError> {
        let model = model(self.model, &candidate.fit.factors);
        let span = self.filtered_steps();
        let modulations = candidate.modulations(course, |_| true);
        let record = stretch(self.observations, &span, &modulations);
        let filtered = filter(&model, &record)?;
        for (glucose, state) in course.glucose[span.clone()].iter_mut().zip(&filtered.states) {
            *glucose = model.person().glucose(&state.body).0;
        }
        let horizons = &self.config.free_run.horizons;
        let first_day = course.day[self.block.start];
        let horizon = HeldOutHorizon::default();
        let empty = HeldOutDay { horizons: vec![horizon; horizons.len()], ..HeldOutDay::default() };
        let mut days = vec![empty; course.day[self.block.end - 1] - first_day + 1];

        let scored = self.config.calibration.scored(self.observations, &span);
        let whitening = &candidate.fit.whitening;
        let standardised = whitening.standardised(&normalised(&filtered.innovations, &scored));
        for step in self.block.clone() {
            let offset = step - span.start;
            let innovation = standardised[offset].zip(filtered.innovations[offset]);
            let Some((value, innovation)) = innovation else { continue };
            let spread = whitening.scale * (std::f64::consts::TAU * innovation.variance).sqrt();
            let day = &mut days[course.day[step] - first_day];
            day.log_likelihood -= huber_loss(value, 1.0) + spread.ln();
            day.innovations += 1.0;
        }

        let known = candidate.modulations(course, |driver| !driver.reads_glucose);
        let inputs = &self.observations.inputs;
        let prepared = PreparedSteps::of(&model, inputs, &known, self.block.clone());
        let runner = Runner { held_out: self, candidate, model: &model, course, known: &known };
        let mut rollouts = Rollouts::new(&model, &record, &filtered);
        for (index, start) in self.starts(&course.day, span.start).into_iter().enumerate() {
            let offset = start - span.start;
            let begin = &filtered.states[offset];
            let day = &mut days[course.day[start] - first_day];
            let takes_floor = candidate.floor && index % FLOOR_EVERY == 0;
            let quick = prepared.as_ref().filter(|_| !takes_floor && !runner.feeds_back());
            let quick = quick.and_then(|steps| steps.readings(start, begin, runner.steps(start)));
            if let Some(readings) = quick {
                self.score_run(start, &readings, day);
                continue;
            }
            let run = runner.run(start, begin)?;
            self.score_run(start, &run.readings, day);
            if takes_floor {
                let (rollouts, states) = (&mut rollouts, &run.states);
                let modulations = run.own.as_deref().unwrap_or(&known);
                let errors = ExpectedErrors { rollouts, offset, states, modulations, horizons };
                let expected = pulp::Arch::new().dispatch(errors)?;
                for (horizon, error) in day.horizons.iter_mut().zip(expected) {
                    if let Some(error) = error {
                        horizon.floor_runs += 1.0;
                        horizon.floors += error;
                    }
                }
            }
        }
        Ok(days)
    }

    /// Steps that the filter sees: the block and the day before it.
    pub(super) fn filtered_steps(&self) -> Range<usize> {
        self.block.start.saturating_sub(LEAD)..self.block.end
    }

    /// Steps at which runs start: every so often from the first step of each day, with a reading, and with
    /// no unrecorded dose that could still act.
    fn starts(&self, days: &[usize], first_filtered: usize) -> Vec<usize> {
        let rule = &self.config.free_run;
        let trusted = self.observations.trusted(rule.dose_memory);
        let earliest = self.block.start.max(first_filtered + rule.burn_in);
        let mut first_of_day = self.block.start;
        (self.block.clone())
            .filter(|step| {
                if days[*step] != days[first_of_day] {
                    first_of_day = *step;
                }
                *step >= earliest
                    && (step - first_of_day).is_multiple_of(EVERY)
                    && trusted[*step]
                    && self.observations.readings[*step] != Reading::Missing
            })
            .collect()
    }

    /// `shown` is what a sensor would show in the run, mg/dL, an entry a step.
    fn score_run(&self, start: usize, shown: &[f64], day: &mut HeldOutDay) {
        let Observations { readings, doses_recorded, .. } = self.observations;
        // What the sensor read so many steps on, and what the run shows.
        let both = |steps: usize| {
            let shown = *shown.get(steps)?;
            Some((readings[start + steps].value()?, shown))
        };
        let complete =
            |steps: usize| doses_recorded[start..start + steps].iter().all(|recorded| *recorded);
        for (horizon, steps) in day.horizons.iter_mut().zip(&self.config.free_run.horizons) {
            if let Some((observed, shown)) = both(*steps).filter(|_| complete(*steps)) {
                horizon.runs += 1.0;
                horizon.sizes += (observed - shown).abs();
            }
        }
        let whole = self.whole_days.contains(&start) && shown.len() >= STEPS_PER_DAY;
        if whole && complete(STEPS_PER_DAY) {
            // The first reading is where the run starts.
            let pairs = (1..STEPS_PER_DAY).filter_map(both).map(|(o, s)| (MgPerDl(o), MgPerDl(s)));
            let (real, simulated): (Vec<MgPerDl>, Vec<MgPerDl>) = pairs.unzip();
            if real.len() as f64 >= LEAST_READINGS * (STEPS_PER_DAY - 1) as f64 {
                day.outcomes = Outcomes::of(real).ok().zip(Outcomes::of(simulated).ok());
            }
        }
    }
}

/// A free run.
struct FreeRun {
    /// States from the start on.
    states: Vec<ModulatedState>,
    /// What a sensor would show in them, mg/dL.
    readings: Vec<f64>,
    /// Modulations of the whole record under which it ran, where they are its own.
    own: Option<Vec<Modulation>>,
}

/// Starts free runs of one candidate.
struct Runner<'a> {
    held_out: &'a HeldOutBlock<'a>,
    candidate: &'a CandidateFit<'a>,
    model: &'a AugmentedModel,
    course: &'a Course,
    /// Modulations that do not look at glucose.
    known: &'a [Modulation],
}

impl Runner<'_> {
    /// Steps of the run from a start: as many as the longest horizon has, and none beyond the block.
    fn steps(&self, start: usize) -> usize {
        let longest = self.held_out.config.free_run.horizons.iter().copied().max().unwrap_or(0);
        longest.min(self.held_out.block.end - 1 - start)
    }

    /// Whether something that acts reads the run's own glucose.
    fn feeds_back(&self) -> bool {
        let mut acting = self.candidate.drivers.iter().zip(&self.candidate.fit.amplitudes);
        acting
            .any(|(driver, amplitude)| driver.signalled && driver.reads_glucose && *amplitude > 0.0)
    }

    /// A run from the start of a step, as long as the longest horizon and no longer than the block.
    ///
    /// What reads glucose is driven by the run's own: the run is repeated with the glucose of the round
    /// before until they agree. Effects look only back, so that each round is right for longer.
    fn run(&self, start: usize, filtered: &AugmentedState) -> Result<FreeRun, GapError> {
        if !self.feeds_back() {
            return self.simulated(start, filtered, None);
        }
        let CandidateFit { drivers, fit, .. } = self.candidate;
        let glucose = |state: &AugmentedState| self.model.person().glucose(&state.body).0;
        let mut course = self.course.clone();
        course.glucose[start..].fill(glucose(filtered));
        let mut rounds = 0;
        loop {
            let mut own = self.known.to_vec();
            drivers::add(drivers, &fit.amplitudes, &course, |d| d.reads_glucose, &mut own);
            let found = self.simulated(start, filtered, Some(own))?;
            let (mut change, mut end) = (0.0f64, 0.0);
            for (held, state) in course.glucose[start..].iter_mut().zip(&found.states) {
                end = glucose(&state.state);
                change = change.max((end - *held).abs());
                *held = end;
            }
            course.glucose[start + found.states.len()..].fill(end);
            rounds += 1;
            if change < AGREED || rounds == ROUNDS {
                return Ok(found);
            }
        }
    }

    fn simulated(
        &self,
        start: usize,
        filtered: &AugmentedState,
        own: Option<Vec<Modulation>>,
    ) -> Result<FreeRun, GapError> {
        let Observations { person, inputs, .. } = self.held_out.observations;
        let plant = ModulatedPlant::new(self.model, own.as_deref().unwrap_or(self.known));
        let (begin, steps) = (ModulatedPlant::start(start, filtered), self.steps(start));
        let run = simulate(&plant, begin, &mut OpenLoop::new(&inputs[start..]), steps)
            .map_err(|source| GapError::FreeRun { person: person.clone(), start, source })?;
        let readings = run.states.iter().map(|state| plant.reading(state)).collect();
        Ok(FreeRun { states: run.states, readings, own })
    }
}

#[cfg(test)]
mod tests {
    use cohort::{Channel, Person};

    use super::super::sample;
    use super::*;
    use crate::course::course;
    use crate::filter::calibration::PersonalFactors;
    use crate::free_run::FreeRunRule;

    const BLOCK: Range<usize> = 864..1152;
    const HORIZONS: [usize; 4] = [6, 60, 200, 287];

    /// The run that starts with the block, by horizon, under an effect that reads glucose.
    fn judged(person: &Person, horizons: &[usize]) -> Vec<HeldOutHorizon> {
        let mut observations = Observations::from_person(person).expect("a good record");
        // No run starts but the first.
        for step in BLOCK.step_by(EVERY).skip(1) {
            observations.readings[step] = Reading::Missing;
        }
        let mut course = course(person, vec![100.0; person.record.len()]);
        let found = ["exercise"].map(|n| effects::find(n).expect("in the library"));
        let drivers: Vec<Driver<'_>> =
            found.iter().map(|effect| Driver::new(effect.as_ref(), 0, &course)).collect();
        assert!(drivers.iter().all(|driver| driver.signalled && driver.reads_glucose));
        let fit = Fit {
            factors: PersonalFactors::default(),
            amplitudes: vec![1.0],
            whitening: sample::UNWHITENED,
        };
        let free_run = FreeRunRule { horizons: horizons.to_vec(), ..FreeRunRule::working() };
        let config = DiagnosisConfig { free_run, ..DiagnosisConfig::working() };
        let person_model = sample::model(observations.weight);
        let held_out = HeldOutBlock {
            observations: &observations,
            model: &person_model,
            block: &BLOCK,
            whole_days: &[],
            config: &config,
        };
        let candidate = CandidateFit { fit: &fit, drivers: &drivers, hidden: &[], floor: true };
        let days = held_out.judge(&candidate, &mut course).expect("runs");
        let counted = |horizon: &HeldOutHorizon| (horizon.runs, horizon.floor_runs) == (1.0, 1.0);
        assert!(days[0].horizons.iter().all(counted));
        days[0].horizons.clone()
    }

    /// Absolute errors of [`judged`] at [`HORIZONS`].
    fn errors(person: &Person) -> Vec<f64> {
        judged(person, &HORIZONS).iter().map(|horizon| horizon.sizes).collect()
    }

    #[test]
    fn horizons_may_come_in_any_order() {
        let person = sample::person(5);
        let mut backwards = HORIZONS;
        backwards.reverse();
        let mut found = judged(&person, &backwards);
        found.reverse();
        assert_eq!(found, judged(&person, &HORIZONS));
    }

    fn with_readings(from: usize, value: impl Fn(usize) -> f64) -> Person {
        let mut person = sample::person(5);
        for (step, reading) in
            person.record.channel_mut(Channel::Cgm).iter_mut().enumerate().skip(from)
        {
            *reading = Some(value(step));
        }
        person
    }

    #[test]
    fn a_run_does_not_know_the_readings_after_its_start() {
        // Readings wobble: a straight line would be taken for drawn.
        let low = |step: usize| 41.0 + (step * step % 7) as f64;
        let high = |step: usize| 390.0 - (step * step % 5) as f64;
        let after = BLOCK.start + 1;
        let lows = errors(&with_readings(after, low));
        let highs = errors(&with_readings(after, high));
        for ((steps, below), above) in HORIZONS.into_iter().zip(lows).zip(highs) {
            let target = BLOCK.start + steps;
            // The prediction lies between both readings, so that the two errors add up to their distance.
            let sum = below + above;
            let distance = high(target) - low(target);
            assert!((sum - distance).abs() < 1e-9, "{steps} steps: {sum} against {distance}"); // rounding
        }
    }

    #[test]
    fn a_run_knows_the_readings_before_its_start() {
        let before = errors(&sample::person(5));
        let moved = errors(&with_readings(BLOCK.start - 12, |step| 200.0 + (step % 3) as f64));
        assert!((before[0] - moved[0]).abs() > 1.0);
    }

    /// Share of plasma glucose that leaves in a minute.
    const DRAINED: f64 = 0.002;

    /// A drain in proportion to glucose, and twice that for half an hour after glucose falls below 120.
    #[derive(Debug)]
    struct Drain;

    impl effects::Effect for Drain {
        fn card(&self) -> effects::Card {
            effects::find("exercise").expect("in the library").card()
        }

        fn form(&self, _: &Course) -> Option<effects::Form> {
            Some(effects::Form::Driven)
        }

        fn modulate(&self, _: usize, _: f64, course: &Course, into: &mut [Modulation]) {
            let mut since = 99;
            for (step, modulation) in into.iter_mut().enumerate() {
                let crossed = step > 0 && course.glucose[step - 1] >= 120.0;
                since = if crossed && course.glucose[step] < 120.0 { 0 } else { since + 1 };
                let twice = if since < 6 { 2.0 } else { 1.0 };
                modulation[effects::Field::Flux] -=
                    twice * DRAINED * course.glucose[step] * 0.16 / 18.0;
            }
        }
    }

    #[test]
    fn a_driver_that_reads_glucose_gets_the_runs_own() {
        let person = sample::person(5);
        let observations = Observations::from_person(&person).expect("a good record");
        let course = course(&person, vec![150.0; person.record.len()]);
        let drivers = [Driver::new(&Drain, 0, &course)];
        let fit = Fit {
            factors: PersonalFactors::default(),
            amplitudes: vec![1.0],
            whitening: sample::UNWHITENED,
        };
        let config = DiagnosisConfig::working();
        let person_model = sample::model(observations.weight);
        let held_out = HeldOutBlock {
            observations: &observations,
            model: &person_model,
            block: &BLOCK,
            whole_days: &[],
            config: &config,
        };
        let candidate = CandidateFit { fit: &fit, drivers: &drivers, hidden: &[], floor: false };
        let model = model(&person_model, &fit.factors);
        let known = vec![Modulation::NEUTRAL; person.record.len()];
        let runner = Runner {
            held_out: &held_out,
            candidate: &candidate,
            model: &model,
            course: &course,
            known: &known,
        };
        let (mut state, _) = model.start(physiology::UnitsPerHour(1.0), MgPerDl(150.0));
        let run = runner.run(BLOCK.start, &state).expect("finite");
        // Step by step, with the glucose of each step as it comes.
        let mut own = Course { glucose: vec![150.0; BLOCK.start], ..Course::default() };
        for offset in 0..run.states.len() - 1 {
            let step = BLOCK.start + offset;
            own.glucose.push(model.person().glucose(&state.body).0);
            let mut steps = vec![Modulation::NEUTRAL; own.glucose.len()];
            effects::Effect::modulate(&Drain, 0, 1.0, &own, &mut steps);
            state = model.step(&state, &observations.inputs[step], &steps[step]).expect("finite");
            let reading = crate::filter::observations::within_sensor_range(state.interstitial.0);
            let distance = (reading - run.readings[offset + 1]).abs();
            // Rounds end when glucose moves by less than 0.5 mg/dL.
            assert!(distance < AGREED, "{offset} steps on: {distance} mg/dL");
        }
        let drained = run.readings.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(drained < 120.0, "the crossing has to come up: {drained}");
    }
}
