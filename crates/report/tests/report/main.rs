//! The report as its readers see it, from made-up JSON.

mod blind_check;
mod browser;
mod diagnosis;
#[path = "../../examples/made_up/mod.rs"]
mod made_up;
mod maps;
mod page;
mod people;
mod reading;
mod results;
