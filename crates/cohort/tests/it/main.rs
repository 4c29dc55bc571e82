//! Cohort folders, damaged files and real records.

mod cohort_folder;
mod damaged_files;
mod downloads;
mod exports;
mod foreign_formats;
mod reference_people;
mod t1d_uom_events;
mod tables;
