//! End-to-end tests on people made here with the ODE plant, and on open data.

mod body;
mod calibration;
mod filter;
mod how_far;
mod hupa;
mod localisation;
mod synthetic;
mod tangent;
