//! What the data-quality checks find in clean records, and in the same records with planted faults.

mod cannot_be_a_person;
mod clock_offsets;
mod dose_faults;
mod planted;
mod real_records;
mod sensor_faults;
