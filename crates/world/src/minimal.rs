//! A body of the minimal-model kind: one compartment of glucose and a remote insulin.
//!
//! Glucose disposal follows the minimal model (Bergman, Ider, Bowden and Cobelli, Am J Physiol
//! 1979;236:E667) with the zero-order uptake of its labelled form (Caumo and Cobelli, Am J Physiol
//! 1993;264:E829). It is completed for type 1 diabetes as the identifiable virtual patient is
//! (Kanderian et al., J Diabetes Sci Technol 2009;3:1047): no secretion, insulin under the skin, a
//! gut. The liver has its own remote insulin, and production falls exponentially with it. The
//! stomach empties by the power exponential of Elashoff et al. (Gastroenterology 1982;83:1306),
//! each meal by its own clock. A large depot of insulin is absorbed more slowly than a small one.
//! Written from the equations.

mod body;
mod equations;
mod exertion;
mod parameters;
mod steady_state;
mod stomach;

pub use body::MinimalState;
pub use equations::MinimalCompartments;
pub use exertion::WorkDone;
pub use parameters::MinimalParameters;
pub use stomach::{Portion, Stomach};
