//! The optimiser, with moments that can be read and put back.

/// Adam with bias correction (paper: "recommended default parameters") and decoupled weight decay.
///
/// The arithmetic is that of candle's `AdamW`, to the last bit. That one keeps its moments to itself,
/// so that a run could not be taken up again where it stopped, and takes its gradients from a graph.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    /// Running mean of the gradient.
    pub(super) first_moment: Vec<f32>,
    /// Running mean of its square.
    pub(super) second_moment: Vec<f32>,
    /// Updates so far.
    pub(super) updates: u32,
    weight_decay: f64,
}

const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

impl Adam {
    /// For so many parameters, without weight decay.
    #[must_use]
    pub fn new(parameters: usize) -> Self {
        let zeros = vec![0.0; parameters];
        Self { first_moment: zeros.clone(), second_moment: zeros, updates: 0, weight_decay: 0.0 }
    }

    /// As it stood after so many updates, without weight decay.
    pub(super) fn resumed(first_moment: Vec<f32>, second_moment: Vec<f32>, updates: u32) -> Self {
        Self { first_moment, second_moment, updates, weight_decay: 0.0 }
    }

    /// The same with every parameter shrunk by the share `weight_decay` times the learning rate in
    /// each update.
    #[must_use]
    pub fn with_weight_decay(self, weight_decay: f64) -> Self {
        Self { weight_decay, ..self }
    }

    /// Moves the parameters against the gradient; all slices have the length given at the start.
    pub fn update(&mut self, parameters: &mut [f32], gradient: &[f32], learning_rate: f64) {
        self.updates += 1;
        let kept = (1.0 - learning_rate * self.weight_decay) as f32;
        let power = i32::try_from(self.updates).unwrap_or(i32::MAX);
        let correction = |beta: f64| (1.0 / (1.0 - beta.powi(power))) as f32;
        let (scale_1, scale_2) = (correction(BETA_1), correction(BETA_2));
        let moments = self.first_moment.iter_mut().zip(&mut self.second_moment);
        for ((parameter, slope), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
            *m = *m * BETA_1 as f32 + slope * (1.0 - BETA_1) as f32;
            *v = *v * BETA_2 as f32 + slope * slope * (1.0 - BETA_2) as f32;
            let direction = *m * scale_1 / ((*v * scale_2).sqrt() + EPSILON as f32);
            *parameter = *parameter * kept - direction * learning_rate as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use candle_core::backprop::GradStore;
    use candle_core::{Device, Tensor, Var};
    use candle_nn::{AdamW, Optimizer, ParamsAdamW};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn updates_are_candles_to_the_last_bit() {
        for weight_decay in [0.0, 1e-5, 0.3] {
            check(weight_decay);
        }
    }

    fn check(weight_decay: f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut draw = || -> Vec<f32> { (0..100).map(|_| rng.random_range(-1.0..1.0)).collect() };
        let mut parameters = draw();
        let tensor = |v: &[f32]| Tensor::from_slice(v, v.len(), &Device::Cpu).expect("one axis");
        let variable = Var::from_tensor(&tensor(&parameters)).expect("a copy");
        let settings = ParamsAdamW { lr: 0.0, beta1: 0.9, beta2: 0.999, eps: 1e-8, weight_decay };
        let mut theirs = AdamW::new(vec![variable.clone()], settings).expect("zeros");
        let mut ours = Adam::new(parameters.len()).with_weight_decay(weight_decay);
        for update in 0..50 {
            let learning_rate = 1e-2 * (-0.1 * f64::from(update)).exp();
            // Slopes of very different sizes, and none at all.
            let size = [1.0, 1e-6, 0.0, 1e4][update as usize % 4];
            let gradient: Vec<f32> = draw().iter().map(|slope| slope * size).collect();
            let mut store = GradStore::default();
            store.insert(&variable, tensor(&gradient));
            theirs.set_learning_rate(learning_rate);
            theirs.step(&store).expect("one shape");
            ours.update(&mut parameters, &gradient, learning_rate);
            let expected = variable.to_vec1::<f32>().expect("one axis");
            assert_eq!(parameters, expected, "update {update}");
        }
    }
}
