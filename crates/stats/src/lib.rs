//! Glycaemic outcomes, paired equivalence tests, person-level bootstrap, multiplicity
