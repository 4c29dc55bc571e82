//! What `diagnose --model` names: the ODE, a population network, or people's twins.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use cohort::{Cohort, Person};
use gap::{Body, Ode, Plants};
use nn_statespace::PopulationModel;
use physiology::STEPS_PER_DAY;
use twins::{Twin, is_twin};

use crate::files::{find, read_bytes, read_population, read_twin};
use crate::stages::{train, twin};
use plants::{NetworkBody, TwinBody, check_wiring};

/// The plant to be diagnosed.
#[derive(Debug)]
pub(crate) enum Diagnosed {
    /// The ODE.
    Ode,
    /// The population network.
    Network(Arc<PopulationModel>),
    /// Twins by person, on one population network.
    Twins(Arc<PopulationModel>, BTreeMap<String, Arc<Twin>>),
}

/// Word for the ODE.
pub(crate) const ODE: &str = "ode";

impl Diagnosed {
    /// Reads what `--model` names: `ode`, a file, or a folder of twins. `population` is the model
    /// that twins were trained on, if it does not lie beside them.
    pub(crate) fn read(model: &str, population: Option<&Path>) -> Result<Self> {
        if model == ODE {
            return Ok(Self::Ode);
        }
        let path = Path::new(model);
        let read = if path.is_dir() {
            of_folder(path, population)
        } else if path.is_file() {
            of_file(path, population)
        } else {
            bail!(
                "there is no '{model}'; --model takes {ODE}, the file of a population model or of a \
                 twin, or an output folder of the command twin"
            )
        }?;
        if let Self::Network(population) | Self::Twins(population, _) = &read {
            check_wiring(population).with_context(|| format!("'{model}' cannot be diagnosed"))?;
        }
        Ok(read)
    }

    /// The plants in the diagnosis, and the records on which they can be judged.
    pub(crate) fn judged_on(&self, cohort: &Cohort) -> Result<Judged> {
        let (plants, notes): (Box<dyn Plants>, _) = match self {
            Self::Ode => (Box::new(Ode), Vec::new()),
            Self::Network(population) => {
                (Box::new(network(population)), vec![OTHER_PLANT.to_owned()])
            }
            Self::Twins(_, twins) => return of_twins(cohort, twins),
        };
        Ok(Judged { cohort: cohort.clone(), plants, notes })
    }

    /// The network without residuals; `None` unless the plant is a twin.
    pub(crate) fn without_residuals(&self) -> Option<impl Plants + use<>> {
        match self {
            Self::Twins(population, _) => Some(network(population)),
            _ => None,
        }
    }
}

/// A plant with the records on which it can be judged.
pub(crate) struct Judged {
    /// The cohort, cut to days that did not train.
    pub(crate) cohort: Cohort,
    /// The plant.
    pub(crate) plants: Box<dyn Plants>,
    /// What has to be known to read the answer.
    pub(crate) notes: Vec<String>,
}

/// What the posterior knows of other plants than the ODE.
const OTHER_PLANT: &str = "The posterior learned from what the ODE plant misses in made people; what it says of another plant is less \
     certain (docs/blind-check.md counts it for the network of the repository). Read a name as a direction to look in.";

/// The network for everybody.
struct NetworkPlants(Arc<dyn Body>);

fn network(population: &Arc<PopulationModel>) -> NetworkPlants {
    NetworkPlants(Arc::new(NetworkBody(Arc::clone(population))))
}

impl Plants for NetworkPlants {
    fn name(&self) -> &str {
        "network"
    }

    fn body_of(&self, _: &Person) -> Result<Option<Arc<dyn Body>>, String> {
        Ok(Some(Arc::clone(&self.0)))
    }
}

/// Everybody's own twin, or why there is none to judge.
struct TwinPlants(BTreeMap<String, Result<Arc<dyn Body>, String>>);

impl Plants for TwinPlants {
    fn name(&self) -> &str {
        "twin"
    }

    fn body_of(&self, person: &Person) -> Result<Option<Arc<dyn Body>>, String> {
        match self.0.get(&person.id) {
            Some(body) => body.clone().map(Some),
            None => Err("no twin of this person".to_owned()),
        }
    }
}

/// People cut to the days that did not train their twins.
fn of_twins(cohort: &Cohort, twins: &BTreeMap<String, Arc<Twin>>) -> Result<Judged> {
    if !cohort.people.iter().any(|person| twins.contains_key(&person.id)) {
        let names: Vec<&str> = twins.keys().map(String::as_str).take(5).collect();
        bail!(
            "the model holds twins of {}, none of whom is in the cohort; a twin is diagnosed on the \
             records of its own person",
            names.join(", ")
        );
    }
    let fewest = gap::InclusionRule::working().fewest_days;
    let mut notes = vec![OTHER_PLANT.to_owned()];
    let mut bodies = BTreeMap::new();
    let mut cut = cohort.clone();
    let mut unknown = Vec::new();
    for person in &mut cut.people {
        let Some(twin) = twins.get(&person.id) else { continue };
        let body: Arc<dyn Body> = Arc::new(TwinBody(Arc::clone(twin)));
        let len = person.record.len();
        let Some(trained) = twin.training_days_of(&person.record) else {
            unknown.push(person.id.clone());
            bodies.insert(person.id.clone(), Ok(body));
            continue;
        };
        let first = (trained * STEPS_PER_DAY).min(len);
        let left = (len - first) / STEPS_PER_DAY;
        let held_out = person.record.slice(first..len).filter(|_| left >= fewest);
        let result = match held_out {
            Some(record) => {
                // The baseline that the twin was trained with.
                person.heart_rate_baseline = person.resting_heart_rate();
                person.record = record;
                Ok(body)
            }
            None => Err(format!("{left} whole days did not train the twin, fewer than {fewest}")),
        };
        bodies.insert(person.id.clone(), result);
    }
    if bodies.len() > unknown.len() {
        notes.push(
            "Twins are judged on the days after those that trained them; days in `people` count these."
                .to_owned(),
        );
    }
    if !unknown.is_empty() {
        notes.push(format!(
            "The files of the twins of {} do not say on which days they were trained: they are \
             judged on whole records, and what they seem to have absorbed may be memory.",
            unknown.join(", ")
        ));
    }
    Ok(Judged { cohort: cut, plants: Box::new(TwinPlants(bodies)), notes })
}

/// A file: a population model, or a twin with the model it was trained on.
fn of_file(path: &Path, population: Option<&Path>) -> Result<Diagnosed> {
    let bytes = read_bytes(path)?;
    if !is_twin(&bytes) {
        let model = PopulationModel::from_safetensors(&bytes).with_context(|| {
            format!("'{}' holds neither a population model nor a twin", path.display())
        })?;
        return Ok(Diagnosed::Network(Arc::new(model)));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let population = population_beside(folder, population)?;
    let twin = read_twin(path, Arc::clone(&population))?;
    let twins = [(twin.card.person_id.clone(), Arc::new(twin))].into();
    Ok(Diagnosed::Twins(population, twins))
}

/// An output folder of the command twin, or the twins in it.
fn of_folder(folder: &Path, population: Option<&Path>) -> Result<Diagnosed> {
    let inner = folder.join(twin::TWINS);
    let twins_folder = if inner.is_dir() { inner } else { folder.to_path_buf() };
    let mut twins: BTreeMap<String, Arc<Twin>> = BTreeMap::new();
    let mut files = find(&twins_folder, "", ".safetensors")?;
    files.retain(|path| path.file_name() != Some(train::MODEL.as_ref()));
    if files.is_empty() {
        bail!(
            "there are no twins in '{}'; give a file, or an output folder of the command twin",
            folder.display()
        );
    }
    let population = population_beside(&twins_folder, population)?;
    for path in files {
        let twin = read_twin(&path, Arc::clone(&population))?;
        let person = twin.card.person_id.clone();
        if twins.insert(person.clone(), Arc::new(twin)).is_some() {
            bail!(
                "'{}' is a second twin of person '{person}'; keep one of them in the folder",
                path.display()
            );
        }
    }
    Ok(Diagnosed::Twins(population, twins))
}

/// The population model that was named, or that lies in the folder of the twins or in the one above.
fn population_beside(folder: &Path, named: Option<&Path>) -> Result<Arc<PopulationModel>> {
    let beside = [folder.join(train::MODEL), folder.join("..").join(train::MODEL)];
    let found = named.map(Path::to_path_buf).or_else(|| beside.into_iter().find(|p| p.is_file()));
    let Some(path) = found else {
        bail!(
            "a twin is of no use without the population model that it was trained on, and there is no \
             {} beside '{}'; name it with --population",
            train::MODEL,
            folder.display()
        );
    };
    Ok(Arc::new(read_population(&path)?))
}
