//! Weight files: what is written is read, and what is broken is refused.

use std::collections::HashMap;
use std::sync::Arc;

use nn_statespace::{
    CentreAndScale, DoseGains, GlucoseClamp, HiddenLayerNetwork, PerCompartment, PopulationModel,
    Scaler,
};
use physiology::Compartment;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use twins::{HeartRateScaler, Twin};

use crate::synthetic::{population, trained_looking, twin_of};

fn twin() -> Twin {
    let scaler = HeartRateScaler { center: -5.055213928222656, scale: 18.085603713989258 };
    Twin {
        heart_rate_scaler: Some(scaler),
        ..twin_of(trained_looking(1), GlucoseClamp::Reproduction)
    }
}

#[test]
fn a_twin_is_read_as_it_was_written() {
    for twin in [twin(), Twin { heart_rate_scaler: None, ..twin() }] {
        let bytes = twin.to_bytes().expect("writable");
        // The clamp is a way of running the model and does not change which model it is.
        for clamp in [GlucoseClamp::Reproduction, GlucoseClamp::Off] {
            let back = Twin::from_bytes(&bytes, population(clamp)).expect("readable");
            assert_eq!(back.residual, twin.residual);
            assert_eq!(back.heart_rate_scaler, twin.heart_rate_scaler);
            assert_eq!((back.inputs, &back.card), (twin.inputs, &twin.card));
        }
    }
}

#[test]
fn gains_on_doses_are_kept_and_bad_ones_refused() {
    let gains = DoseGains { insulin: 0.7, carbs: 1.0 / 3.0 };
    let own = |gains| {
        let population = PopulationModel::clone(&population(GlucoseClamp::Off));
        Arc::new(population.with_dose_gains(gains).expect("positive"))
    };
    let scaled = Twin { population: own(gains), ..twin() };
    let bytes = scaled.to_bytes().expect("writable");
    // The file names the population, whoever's gains it runs with.
    let back = Twin::from_bytes(&bytes, population(GlucoseClamp::Off)).expect("readable");
    assert_eq!(back.population.scaler().dose_gains(), gains);
    assert_eq!(back.to_bytes().expect("writable"), bytes);
    let plain = twin().to_bytes().expect("writable");
    assert!(plain.len() < bytes.len());
    let back = Twin::from_bytes(&plain, population(GlucoseClamp::Off)).expect("readable");
    assert_eq!(back.population.scaler().dose_gains(), DoseGains::NONE);

    let place = bytes.windows(8).position(|eight| eight == 0.7_f64.to_le_bytes()).expect("there");
    let mut broken = bytes.clone();
    broken[place..place + 8].copy_from_slice(&(-0.7_f64).to_le_bytes());
    let error = Twin::from_bytes(&broken, population(GlucoseClamp::Off)).expect_err("negative");
    assert!(error.to_string().contains("-0.7"), "{error}");
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = twin().to_bytes().expect("writable");
    let population = population(GlucoseClamp::Off);
    for len in (0..bytes.len()).step_by(997).chain([bytes.len() - 1]) {
        let error = Twin::from_bytes(&bytes[..len], Arc::clone(&population)).expect_err("cut off");
        assert!(error.to_string().contains("truncated"), "{len}: {error}");
    }
}

#[test]
fn other_files_are_told_apart() {
    let values = [0.0_f64; 4].map(f64::to_le_bytes).concat();
    let view = TensorView::new(Dtype::F64, vec![4], &values).expect("four values");
    let metadata = HashMap::from([("population".to_owned(), "{}".to_owned())]);
    let other = safetensors::serialize([("Q1.hidden.bias", view)], Some(metadata)).expect("bytes");
    let error = Twin::from_bytes(&other, population(GlucoseClamp::Off)).expect_err("no twin");
    let message = error.to_string();
    assert!(message.starts_with("no twin in this file"), "{message}");
    assert!(message.contains("population") && message.contains("Q1.hidden.bias"), "{message}");
}

#[test]
fn another_population_model_is_refused() {
    let bytes = twin().to_bytes().expect("writable");
    let one = population(GlucoseClamp::Off);
    let networks = PerCompartment::from_fn(|c| {
        let n = one.network(c);
        let b2 = if c == Compartment::I { 1e-3 } else { n.b2() };
        let (w1, b1, w2) = (n.w1().to_vec(), n.b1().to_vec(), n.w2().to_vec());
        HiddenLayerNetwork::new(n.inputs(), w1, b1, w2, b2).expect("shapes fit")
    });
    let parts = (one.wiring().clone(), *one.scaler(), one.card().clone());
    let other = PopulationModel::new(parts.0, networks, parts.1, GlucoseClamp::Off, parts.2);
    let error = Twin::from_bytes(&bytes, Arc::new(other.expect("shapes fit"))).expect_err("other");
    assert!(error.to_string().contains("trained on the population model"), "{error}");
    let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
    let scaler = Scaler::new(PerCompartment::from_fn(|_| unit), unit, unit).expect("positive");
    let networks = PerCompartment::from_fn(|c| one.network(c).clone());
    let parts = (one.wiring().clone(), one.card().clone());
    let other = PopulationModel::new(parts.0, networks, scaler, GlucoseClamp::Off, parts.1);
    assert!(Twin::from_bytes(&bytes, Arc::new(other.expect("shapes fit"))).is_err());
}

#[test]
fn a_broken_tensor_is_named() {
    let bytes = twin().to_bytes().expect("writable");
    let file = SafeTensors::deserialize(&bytes).expect("our own");
    let (_, metadata) = SafeTensors::read_metadata(&bytes).expect("our own");
    let spoil = |name: &str, change: &dyn Fn(Vec<u8>, Vec<usize>) -> (Vec<u8>, Vec<usize>)| {
        let changed: Vec<(String, Vec<u8>, Vec<usize>)> = file
            .tensors()
            .into_iter()
            .map(|(n, view)| {
                let (data, shape) = (view.data().to_vec(), view.shape().to_vec());
                let (data, shape) = if n == name { change(data, shape) } else { (data, shape) };
                (n, data, shape)
            })
            .filter(|(_, data, _)| !data.is_empty())
            .collect();
        let views = changed.iter().map(|(n, data, shape)| {
            (n.as_str(), TensorView::new(Dtype::F64, shape.clone(), data).expect("a view"))
        });
        let bytes = safetensors::serialize(views, metadata.metadata().clone()).expect("bytes");
        let error = Twin::from_bytes(&bytes, population(GlucoseClamp::Off)).expect_err("broken");
        error.to_string()
    };
    let nan = |mut data: Vec<u8>, shape| {
        data[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
        (data, shape)
    };
    assert!(spoil("layers.1.weight", &nan).contains("layers.1.weight holds a value"));
    assert!(spoil("heart_rate_scaler", &nan).contains("heart rate scaled by NaN"));
    let gone = |_, _| (Vec::new(), vec![0]);
    assert!(spoil("layers.2.bias", &gone).contains("layers.2.bias is missing"));
    let short = |data: Vec<u8>, _| (data[..80].to_vec(), vec![10]);
    assert!(spoil("layers.0.weight", &short).contains("layers.0.weight has 10 values, 1280"));
}
