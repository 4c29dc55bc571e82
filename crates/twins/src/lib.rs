//! Digital twins: the residual network of one person, its training and replay, and the ODE baselines
