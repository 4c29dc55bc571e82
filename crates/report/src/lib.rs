//! Self-contained HTML reports from the pipeline's JSON outputs.
//!
//! The report is one file: no network, no script, no font of its own; its figures are SVG inside
//! the page and its tables can be copied. The crate knows the JSON contract and nothing of the
//! crates that compute: it takes readers and returns text, and the same inputs give the same bytes.
//!
//! ```
//! use report::{Inputs, Part, render};
//!
//! let mut inputs = Inputs::default();
//! let json = r#"{"rows": [{"network": "I", "input": "S2", "property": "increasing",
//!     "m_lower": -0.2, "m_upper": -0.1, "verdict": "proved", "seconds": 0.01}]}"#;
//! inputs.read(Part::Conformance, json.as_bytes())?;
//! let html = render(&inputs)?;
//! assert!(html.contains("1 of 1 physiological properties is proved"));
//! # Ok::<(), report::ReportError>(())
//! ```

mod error;
mod figure;
mod html;
mod inputs;
mod number;
mod section;
pub mod view;

pub use error::ReportError;
pub use inputs::{Inputs, Part};

/// What every report says about its use.
pub const DISCLAIMER: &str =
    "Research software. Not a medical device; not validated for any treatment decision.";

/// Renders the report as one HTML document.
///
/// # Errors
///
/// [`ReportError::Figure`] where a figure cannot be drawn.
pub fn render(inputs: &Inputs) -> Result<String, ReportError> {
    section::page(inputs)
}
