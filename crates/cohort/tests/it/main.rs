//! Cohort folders, other people's formats and real records.

mod cohort_folder;
mod downloads;
mod exports;
mod foreign_formats;
mod reference_people;
mod t1d_uom_events;
mod tables;
