//! `steady_state.json`: where a model stands still, over glucose.

/// Steady states of a model, beside a published table where one is given.
#[apply(strict!)]
pub struct SteadyStates {
    /// One row a value of glucose.
    pub rows: Vec<SteadyRow>,
    /// `steady_state/1`.
    pub schema: String,
}

/// The steady state at one value of glucose.
#[apply(strict!)]
#[derive(Copy)]
pub struct SteadyRow {
    /// The constant basal rate, U/h.
    pub basal_u_h: f64,
    /// C1 there, scaled.
    pub c1: f64,
    /// Whether the state is a physical one.
    pub found: bool,
    /// Glucose asked for, mg/dL.
    pub glucose_mg_dl: f64,
    /// The published row; null where no table is given.
    pub published: Option<PublishedState>,
    /// Largest rate of change, scaled units per minute.
    pub residual: f64,
}

/// What a published row amounts to.
#[apply(strict!)]
#[derive(Copy)]
pub struct PublishedState {
    /// C1 there, scaled.
    pub c1: f64,
    /// Meal that would put as much glucose into the blood over a day as the excess of C1 does, g.
    pub phantom_carbs_g: f64,
    /// Largest rate of change at the best constant basal rate, scaled units per minute.
    pub residual: f64,
}
