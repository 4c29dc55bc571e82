//! A body of the UVA/Padova kind: another structure than the plants under test.
//!
//! Glucose, insulin and gut follow the equations of Dalla Man, Rizza and Cobelli (IEEE Trans Biomed
//! Eng 2007;54:1740). Subcutaneous insulin follows those of the GIM software (Dalla Man et al., J
//! Diabetes Sci Technol 2007;1:323), and uptake at low glucose the T1D simulator of 2013 (Dalla Man
//! et al., J Diabetes Sci Technol 2014;8:26, *S2013* below). Glucagon is left out because the
//! values of its parameters are not published. Written from the equations; no code of the simulator
//! is used.
//!
//! The structure differs from [`Body`](crate::hovorka) in five points: the stomach empties at a rate
//! that depends on its content; insulin reaches the blood by two routes and passes the liver; its
//! action on production is delayed by a chain; uptake saturates (Michaelis-Menten) in the tissues;
//! and production falls with glucose itself.

mod body;
mod equations;
mod exertion;
mod intraday;
mod parameters;
mod steady_state;

pub use body::PadovaState;
pub use equations::PadovaCompartments;
pub use exertion::Exertion;
pub use parameters::PadovaParameters;

pub(crate) use intraday::action_within_days;
