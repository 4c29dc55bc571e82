//! A person's models, one a method.

use std::ops::Range;
use std::sync::Arc;

use cohort::Person;
use contract::run_errors::RunError;
use nn_statespace::{DoseGains, PopulationModel};
use ode_sim::OdePlant;
use twins::{PersonWindows, SteadyStates, Twin};

use crate::error::EvaluationError;
use crate::method::Method;
use crate::readings::{Runs, runs};
use crate::settings::ode_baseline;

/// A model of a person.
#[derive(Debug, Clone)]
pub enum Model {
    /// The population network alone.
    Population(Arc<PopulationModel>),
    /// The population network and a residual network.
    Twin(Twin),
    /// A twin and the error of its free runs: outcomes are those of courses drawn around them.
    Spread(Twin, RunError),
    /// The ODE model.
    Ode(OdePlant),
    /// The ODE model under several draws of its parameters, at least one.
    Draws(Vec<OdePlant>),
}

impl Model {
    /// What a sensor would have read of free runs through parts of a person's record, under each of
    /// the model's plants, and how many starts of the first plant are not at rest.
    ///
    /// `steady` holds the steady states of the population network, which are the same under any
    /// gains on doses; how a network gets from one to the next is not.
    pub(crate) fn runs(
        &self,
        steady: &SteadyStates<'_, PopulationModel>,
        of: (&Person, &PersonWindows),
        parts: &[Range<usize>],
    ) -> Result<(Vec<Runs>, usize), EvaluationError> {
        let ode = |plant: &OdePlant| runs(plant, &SteadyStates::new(plant), of, parts);
        let found: Vec<(Runs, usize)> = match self {
            Self::Twin(twin) | Self::Spread(twin, _) => {
                vec![runs(twin, &steady.of(&twin.population), of, parts)?]
            }
            Self::Population(population) => {
                vec![runs(&**population, &steady.of(population), of, parts)?]
            }
            Self::Ode(plant) => vec![ode(plant)?],
            Self::Draws(plants) => plants.iter().map(ode).collect::<Result<_, _>>()?,
        };
        let not_at_rest = found.first().map_or(0, |(_, not_at_rest)| *not_at_rest);
        Ok((found.into_iter().map(|(runs, _)| runs).collect(), not_at_rest))
    }
}

/// Everything that stands for one person.
#[derive(Debug, Clone)]
pub struct PersonModels {
    models: Vec<(Method, Model)>,
}

impl PersonModels {
    /// A twin, its population model, and the ODE model with population parameters.
    #[must_use]
    pub fn new(person: &Person, twin: Twin) -> Self {
        let gains = twin.population.scaler().dose_gains();
        let population = Model::Population(if gains == DoseGains::NONE {
            Arc::clone(&twin.population)
        } else {
            let plain = PopulationModel::clone(&twin.population).with_dose_gains(DoseGains::NONE);
            Arc::new(plain.expect("gains of 1 are positive"))
        });
        let ode = Model::Ode(ode_baseline(person.weight));
        let twin = (Method::Twin, Model::Twin(twin));
        Self { models: vec![twin, (Method::Population, population), (Method::Ode, ode)] }
    }

    /// The same with a further model; one of the same method is replaced.
    #[must_use]
    pub fn with(mut self, method: Method, model: Model) -> Self {
        match self.models.iter_mut().find(|(known, _)| *known == method) {
            Some(entry) => entry.1 = model,
            None => self.models.push((method, model)),
        }
        self
    }

    /// The models in the order in which they were given, the twin first.
    #[must_use]
    pub fn all(&self) -> &[(Method, Model)] {
        &self.models
    }

    /// The model of a method.
    #[must_use]
    pub fn of(&self, method: Method) -> Option<&Model> {
        self.models.iter().find(|(known, _)| *known == method).map(|(_, model)| model)
    }
}
