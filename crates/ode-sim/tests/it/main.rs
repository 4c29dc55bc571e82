//! The simulator: conservation, derivatives, steady states and virtual people.

mod conservation;
mod derivatives;
mod development_set;
mod properties;
mod published_population;
mod steady_states;
mod virtual_people;
