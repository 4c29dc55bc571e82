//! Where a plant misses a cohort: innovations, free-run errors, context cells, person-level intervals
