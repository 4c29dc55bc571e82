//! The glucoregulatory ODE plant of type 1 diabetes: equations, integrators, steady state, virtual patients, scenarios, sensor and pump models
