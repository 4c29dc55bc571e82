//! A body in which nearly everything saturates, with glucagon and two channels of insulin.
//!
//! Insulin under the skin takes a slow and a fast channel and is lost on both (Wilinska et al.,
//! IEEE Trans Biomed Eng 2005;52:3, their best model). Glucose leaves through carriers: brain and
//! muscle take it up by Michaelis-Menten kinetics, and the muscle's capacity saturates with insulin
//! as in clamps (Rizza, Mandarino and Gerich, Am J Physiol 1981;240:E630). The liver releases newly
//! made glucose and what glucagon frees from glycogen (Wendt et al., J Diabetes Sci Technol
//! 2017;11:1101). Glucagon reacts weakly to lows, as in long-standing type 1 diabetes. The stomach
//! passes on energy at a nearly constant rate (Brener, Hendrix and McHugh, Gastroenterology
//! 1983;85:76). Written from the equations.

mod body;
mod equations;
mod exertion;
mod parameters;
mod steady_state;

pub use body::SaturatingState;
pub use equations::SaturatingCompartments;
pub use exertion::SpentGlycogen;
pub use parameters::SaturatingParameters;
