//! The robust scaler: the only passage between physical and scaled states.

use std::ops::{Index, IndexMut};

use physiology::{Compartment, Grams, States, StepInput, UnitsPerHour};
use serde::{Deserialize, Serialize};

use crate::error::ModelError;
use crate::per_compartment::PerCompartment;
use crate::signal::Signal;

/// The ten states in the networks' own units: centred and scaled by a [`Scaler`], unitless.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScaledStates(PerCompartment<f64>);

impl ScaledStates {
    /// The compartments with their values, in the paper's order.
    pub fn iter(&self) -> impl Iterator<Item = (Compartment, f64)> + '_ {
        self.0.iter().map(|(compartment, value)| (compartment, *value))
    }
}

impl Index<Compartment> for ScaledStates {
    type Output = f64;
    fn index(&self, compartment: Compartment) -> &f64 {
        &self.0[compartment]
    }
}

impl IndexMut<Compartment> for ScaledStates {
    fn index_mut(&mut self, compartment: Compartment) -> &mut f64 {
        &mut self.0[compartment]
    }
}

/// The two inputs of the model in scaled units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaledInputs {
    /// Insulin infusion rate u_I, basal and bolus together.
    pub insulin: f64,
    /// Carbohydrate intake u_carb of the sample.
    pub carbs: f64,
}

/// Centre and scale of one signal: scaled = (physical - centre) / scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CentreAndScale {
    /// The median of the training rows (paper, appendix on the robust scaler), physical units.
    pub centre: f64,
    /// The interquartile range of the training rows, physical units; 1 where that is 0.
    pub scale: f64,
}

impl CentreAndScale {
    /// Median and interquartile range of `values`, with quartiles interpolated linearly between
    /// order statistics as NumPy and scikit-learn do. A range of 0 (a signal that hardly ever
    /// moves, such as carbohydrate intake) becomes a scale of 1, again as scikit-learn does.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] if a value is not a finite number, [`ModelError::NoRows`] if
    /// there is none; `signal` names it.
    pub fn robust(signal: Signal, values: Vec<f64>) -> Result<Self, ModelError> {
        crate::network::finite(signal.name(), &values)?;
        Self::of(values).ok_or(ModelError::NoRows(signal))
    }

    /// The same of finite values that are no signal's; `None` if there are none.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        let centre = quantile(&values, 0.5);
        let range = quantile(&values, 0.75) - quantile(&values, 0.25);
        Some(Self { centre, scale: if range > 0.0 { range } else { 1.0 } })
    }

    /// A physical value in scaled units.
    #[must_use]
    pub fn scale(self, physical: f64) -> f64 {
        (physical - self.centre) / self.scale
    }

    /// A scaled value in physical units.
    #[must_use]
    pub fn unscale(self, scaled: f64) -> f64 {
        scaled * self.scale + self.centre
    }
}

/// Factors on the doses that reach the networks: how strongly one body answers to a unit of insulin and to a
/// gram of carbohydrate, the population being 1. Positive, so that whatever rises with a dose still does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DoseGains {
    /// Factor on insulin, basal and bolus alike.
    pub insulin: f64,
    /// Factor on carbohydrate.
    pub carbs: f64,
}

impl DoseGains {
    /// The population's.
    pub const NONE: Self = Self { insulin: 1.0, carbs: 1.0 };
}

/// Centre and scale of each state and of both inputs.
///
/// The paper scales by the median and the interquartile range of the training set (appendix on
/// the robust scaler). C1 has no ground truth; it keeps centre 0 and scale 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaler {
    states: PerCompartment<CentreAndScale>,
    insulin: CentreAndScale,
    carbs: CentreAndScale,
    gains: DoseGains,
}

impl Scaler {
    /// A scaler from its constants: one pair for each state, one for the insulin rate in U/h and
    /// one for the carbohydrate of a sample in g.
    ///
    /// # Errors
    /// [`ModelError::Scale`] if a centre is not finite or a scale is not a positive finite number.
    pub fn new(
        states: PerCompartment<CentreAndScale>,
        insulin: CentreAndScale,
        carbs: CentreAndScale,
    ) -> Result<Self, ModelError> {
        let scaler = Self { states, insulin, carbs, gains: DoseGains::NONE };
        for signal in Signal::all() {
            let CentreAndScale { centre, scale } = scaler.of(signal);
            if !centre.is_finite() || !scale.is_finite() || scale <= 0.0 {
                return Err(ModelError::Scale { signal, centre, scale });
            }
        }
        Ok(scaler)
    }

    /// The scaler with the constants that `pair` gives for each signal, or its first error.
    pub(crate) fn try_from_fn(
        pair: impl Fn(Signal) -> Result<CentreAndScale, ModelError>,
    ) -> Result<Self, ModelError> {
        let states = PerCompartment::try_from_fn(|compartment| pair(Signal::State(compartment)))?;
        Self::new(states, pair(Signal::Insulin)?, pair(Signal::Carbs)?)
    }

    /// The same constants for a body that answers to doses with these gains.
    ///
    /// # Errors
    /// [`ModelError::DoseGain`] if a gain is not a positive finite number.
    pub fn with_dose_gains(self, gains: DoseGains) -> Result<Self, ModelError> {
        for (signal, gain) in [(Signal::Insulin, gains.insulin), (Signal::Carbs, gains.carbs)] {
            if !gain.is_finite() || gain <= 0.0 {
                return Err(ModelError::DoseGain { signal, gain });
            }
        }
        Ok(Self { gains, ..self })
    }

    /// The gains of doses.
    #[must_use]
    pub fn dose_gains(&self) -> DoseGains {
        self.gains
    }

    /// Physical states in scaled units.
    #[must_use]
    pub fn scale(&self, states: &States) -> ScaledStates {
        ScaledStates(PerCompartment::from_fn(|c| self.states[c].scale(states[c])))
    }

    /// Scaled states in physical units.
    #[must_use]
    pub fn unscale(&self, scaled: &ScaledStates) -> States {
        let mut states = States::default();
        for (compartment, value) in scaled.iter() {
            states[compartment] = self.states[compartment].unscale(value);
        }
        states
    }

    /// The inputs of a step in scaled units.
    ///
    /// The insulin rate is basal and bolus together, so that a bolus of b U counts as 12 b U/h in
    /// its sample. Carbohydrate is what was eaten in the sample, fast carbohydrate included: the
    /// model has one carbohydrate input and its own absorption. Exercise and context do not reach
    /// the population model.
    #[must_use]
    pub fn scale_input(&self, input: &StepInput) -> ScaledInputs {
        ScaledInputs {
            insulin: self.scale_insulin(input.insulin()),
            carbs: self.scale_carbs(input.carbs + input.rescue.amount),
        }
    }

    /// An insulin rate in scaled units.
    #[must_use]
    pub fn scale_insulin(&self, rate: UnitsPerHour) -> f64 {
        self.insulin.scale(self.gains.insulin * rate.0)
    }

    /// A scaled insulin rate in U/h.
    #[must_use]
    pub fn unscale_insulin(&self, scaled: f64) -> UnitsPerHour {
        UnitsPerHour(self.insulin.unscale(scaled) / self.gains.insulin)
    }

    /// The carbohydrate of a sample in scaled units.
    #[must_use]
    pub fn scale_carbs(&self, carbs: Grams) -> f64 {
        self.carbs.scale(self.gains.carbs * carbs.0)
    }

    /// A physical value of a signal in scaled units, doses after their gains.
    pub(crate) fn scale_value(&self, signal: Signal, value: f64) -> f64 {
        match signal {
            Signal::State(compartment) => self.states[compartment].scale(value),
            Signal::Insulin => self.scale_insulin(UnitsPerHour(value)),
            Signal::Carbs => self.scale_carbs(Grams(value)),
        }
    }

    /// Centre and scale of a signal; of doses after their gains.
    #[must_use]
    pub fn of(&self, signal: Signal) -> CentreAndScale {
        match signal {
            Signal::State(compartment) => self.states[compartment],
            Signal::Insulin => self.insulin,
            Signal::Carbs => self.carbs,
        }
    }
}

/// The `share`-quantile of ascending `values`, interpolated linearly between order statistics.
fn quantile(values: &[f64], share: f64) -> f64 {
    let position = share * (values.len() - 1) as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(values.len() - 1);
    values[below] + (position - below as f64) * (values[above] - values[below])
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{FastCarbs, Units};

    fn example() -> Scaler {
        let states = PerCompartment::from_fn(|c| CentreAndScale {
            centre: c as usize as f64,
            scale: 0.5 + c as usize as f64,
        });
        let insulin = CentreAndScale { centre: 1.0, scale: 0.5 };
        Scaler::new(states, insulin, CentreAndScale { centre: 0.0, scale: 2.0 }).expect("positive")
    }

    #[test]
    fn quartiles_are_interpolated_as_in_numpy() {
        // numpy.percentile([1, 2, 4, 8], [25, 50, 75]) = 1.75, 3, 5
        let pair = CentreAndScale::robust(Signal::Insulin, vec![8.0, 1.0, 4.0, 2.0]);
        assert_eq!(pair.expect("finite"), CentreAndScale { centre: 3.0, scale: 3.25 });
    }

    #[test]
    fn a_signal_that_hardly_moves_keeps_its_unit() {
        let pair = CentreAndScale::robust(Signal::Carbs, vec![0.0, 0.0, 0.0, 0.0, 60.0]);
        assert_eq!(pair.expect("finite"), CentreAndScale { centre: 0.0, scale: 1.0 });
    }

    #[test]
    fn gains_act_on_doses_alone() {
        let plain = example();
        let gains = DoseGains { insulin: 0.5, carbs: 2.0 };
        let own = plain.with_dose_gains(gains).expect("positive");
        assert_eq!(own.scale_insulin(UnitsPerHour(3.0)), plain.scale_insulin(UnitsPerHour(1.5)));
        assert_eq!(own.scale_carbs(Grams(20.0)), plain.scale_carbs(Grams(40.0)));
        assert!((own.unscale_insulin(own.scale_insulin(UnitsPerHour(3.0))).0 - 3.0).abs() < 1e-12);
        assert_eq!(own.scale(&States::default()), plain.scale(&States::default()));
        for gain in [0.0, -1.0, f64::NAN] {
            let error = plain.with_dose_gains(DoseGains { carbs: gain, ..gains });
            assert!(matches!(error, Err(ModelError::DoseGain { signal: Signal::Carbs, .. })));
        }
    }

    #[test]
    fn scaling_and_unscaling_cancel() {
        let scaler = example();
        let mut states = States::default();
        for (i, compartment) in Compartment::ALL.into_iter().enumerate() {
            states[compartment] = 10.0 - 3.0 * i as f64;
        }
        let back = scaler.unscale(&scaler.scale(&states));
        for (compartment, value) in states.iter() {
            assert!((back[compartment] - value).abs() < 1e-13); // rounding of two operations
        }
    }

    #[test]
    fn a_bolus_is_a_rate_over_its_sample_and_fast_carbs_are_carbs() {
        let input = StepInput {
            basal: UnitsPerHour(1.0),
            bolus: Units(2.0),
            carbs: Grams(30.0),
            rescue: FastCarbs { amount: Grams(10.0), ..FastCarbs::default() },
            ..StepInput::default()
        };
        let scaled = example().scale_input(&input);
        assert_eq!(scaled, ScaledInputs { insulin: 48.0, carbs: 20.0 });
    }

    #[test]
    fn a_scale_that_is_not_positive_is_refused_by_name() {
        let mut states = PerCompartment::from_fn(|_| CentreAndScale { centre: 0.0, scale: 1.0 });
        states[Compartment::X3].scale = 0.0;
        let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
        let error = Scaler::new(states, unit, unit).expect_err("zero scale");
        assert!(error.to_string().contains("X3"), "{error}");
    }
}
