//! The network as a plant, its kernel, its training and its files.

mod damaged_files;
mod kernel;
mod plant;
mod published;
mod training;
