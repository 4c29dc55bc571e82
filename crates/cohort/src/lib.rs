//! The record schema of a type 1 diabetes cohort, its importers, windows and splits
