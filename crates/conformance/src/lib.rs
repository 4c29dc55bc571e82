//! Monotonicity of one-hidden-layer ReLU networks over boxes: properties, MILP, certified bounds, verdicts
