//! Twins on made people: gradients, starts, training, files.

mod files;
mod gradient;
mod published_twin;
mod starts;
mod synthetic;
mod training;
