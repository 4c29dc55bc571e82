//! The filter on data of its own model: innovations are white with unit variance.

use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::PersonalFactors;
use gap::filter::kalman::filter;
use gap::{NoiseModel, Observations};
use ode_sim::OdeParameters;
use physiology::Kilograms;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::synthetic::{Gap, World, person, with_gaps};

fn model() -> AugmentedModel {
    AugmentedModel::new(OdeParameters::nominal(), Kilograms(76.3), NoiseModel::working())
}

/// Normalised innovations after the first day, by step.
fn normalised(gaps: bool, seed: u64) -> Vec<Option<f64>> {
    let world = World { gap: Gap::None, days: 14, spread: 0.0 };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut person = person("p", &PersonalFactors::default(), &world, &mut rng);
    if gaps {
        person = with_gaps(person, &mut rng);
    }
    let observations = Observations::from_person(&person).expect("a good record");
    let run = filter(&model(), &observations).expect("finite");
    run.innovations[288..].iter().map(|i| i.map(|i| i.normalised())).collect()
}

#[test]
fn innovations_of_the_filters_own_model_are_white_with_unit_variance() {
    for gaps in [false, true] {
        let z: Vec<Option<f64>> = (0..4).flat_map(|seed| normalised(gaps, seed)).collect();
        let values: Vec<f64> = z.iter().flatten().copied().collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| v * v).sum::<f64>() / n;
        // NIS: n times the mean square is chi-squared with n degrees of freedom, so the mean square
        // has standard deviation sqrt(2/n) = 0.012. Six of them leave room for linearisation.
        assert!((variance - 1.0).abs() < 6.0 * (2.0 / n).sqrt(), "gaps {gaps}: NIS {variance}");
        assert!(mean.abs() < 4.0 / n.sqrt(), "gaps {gaps}: mean {mean}");
        for lag in 1..=12 {
            let products: Vec<f64> =
                z.iter().zip(&z[lag..]).filter_map(|(a, b)| Some((*a)? * (*b)?)).collect();
            let correlation = products.iter().sum::<f64>() / products.len() as f64;
            // Standard error 1/sqrt(n); four of them over twelve lags and two cases.
            assert!(correlation.abs() < 4.0 / n.sqrt(), "gaps {gaps}, lag {lag}: {correlation}");
        }
    }
}
