//! A person's models, one a method.

use std::sync::Arc;

use cohort::Person;
use contract::run_errors::RunError;
use nn_statespace::{DoseGains, PopulationModel};
use ode_sim::OdePlant;
use twins::Twin;

use crate::method::Method;
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
        Self {
            models: vec![
                (Method::Twin, Model::Twin(twin)),
                (Method::Population, population),
                (Method::Ode, ode),
            ],
        }
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

    /// The twin.
    #[must_use]
    pub fn twin(&self) -> &Twin {
        match &self.models[0].1 {
            Model::Twin(twin) => twin,
            _ => unreachable!("`new` puts the twin first and `with` replaces like by like"),
        }
    }
}
