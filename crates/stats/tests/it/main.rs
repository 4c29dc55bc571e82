//! Intervals, multiplicity and published equivalence tests.

mod bootstrap_and_multiplicity;
mod published_tost;
