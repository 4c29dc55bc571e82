//! Self-contained HTML reports from the pipeline's JSON outputs.
//!
//! The report is one file: no network, no script, no font of its own. Its figures are SVG inside
//! the page and its tables can be copied. The crate knows the JSON contract and none of the crates
//! that compute. It takes readers and returns text, and the same inputs give the same bytes.
//!
//! ```
//! use report::{Inputs, Part, render};
//!
//! let mut inputs = Inputs::default();
//! let json = r#"{"schema": "twins/1", "people": [{"person_id": "p01", "windows_train": 210,
//!     "windows_test": 95, "excluded": null, "loss_first": 1.3, "loss_last": 0.4, "epoch_kept": 60,
//!     "steps_without_heart_rate": 0, "steps_without_sleep": 12, "rmse_population": 52.1,
//!     "rmse_twin": 38.4}]}"#;
//! inputs.read(Part::Twins, json.as_bytes())?;
//! let html = render(&inputs)?;
//! assert!(html.contains("1 of 1 person has a twin."));
//! # Ok::<(), report::ReportError>(())
//! ```

mod distinct;
mod error;
mod figure;
mod html;
mod inputs;
mod number;
mod section;

pub use error::ReportError;
pub use inputs::{Inputs, Part};
pub use number::count;
pub use section::{answer, render};

/// What every report says about its use.
pub const DISCLAIMER: &str =
    "Research software. Not a medical device; not validated for any treatment decision.";
