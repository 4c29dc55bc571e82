//! What the data-quality checks find in clean records, and in the same records with planted faults.

mod clock_offsets;
mod dose_faults;
mod planted;
mod real_records;
mod sensor_faults;
