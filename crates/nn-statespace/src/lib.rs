//! The physiologically wired neural state-space model: networks, scaler, roll-out, training, weight files
