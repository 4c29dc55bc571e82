//! Twins on made people: starts, training, files.

mod files;
mod published_twin;
mod starts;
mod synthetic;
mod training;
