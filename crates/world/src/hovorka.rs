//! The ODE under test (Resalat et al. 2019, after Hovorka et al. 2004) with a person's own
//! parameters, at one minute, and with exercise of its own.

mod body;
mod exertion;
mod parameters;

pub use body::HovorkaState;
pub use exertion::ExerciseTrace;
pub use parameters::HovorkaParameters;
