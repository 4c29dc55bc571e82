//! What every effect of the library must keep, whatever it is about.

use super::{find, library};
use crate::course::Course;
use crate::effect::Form;
use crate::modulation::{Field, Modulation};
use crate::port::Port;
use crate::relations::ShownBy;
use crate::sample::{CUTS, fortnight, modulated, other_after};

/// Centred across days: a later day reaches an earlier one through the mean of its clock slot. Their own
/// tests look at the driver before centring.
const CENTRED: [&str; 4] =
    ["post_exercise_sensitivity", "sleep_loss", "set_ageing", "sensor_drift"];

#[test]
fn all_names_of_the_contract_are_there_with_their_ports() {
    let expected = [
        ("exercise", Port::GlucoseFlux),
        ("post_exercise_sensitivity", Port::InsulinAction),
        ("dawn", Port::Egp),
        ("circadian_sensitivity", Port::InsulinAction),
        ("sleep_loss", Port::InsulinAction),
        ("slow_meals", Port::GutAbsorption),
        ("carb_miscount", Port::CarbAmount),
        ("missed_meals", Port::CarbAmount),
        ("unlogged_rescue_carbs", Port::GlucoseFlux),
        ("set_ageing", Port::InsulinInput),
        ("set_failure", Port::InsulinInput),
        ("insulin_absorption", Port::InsulinAbsorption),
        ("counter_regulation", Port::Egp),
        ("alcohol", Port::Egp),
        ("renal_threshold", Port::GlucoseFlux),
        ("sensor_lag", Port::Sensor),
        ("sensor_drift", Port::Sensor),
        ("compression_lows", Port::Sensor),
    ];
    let cards: Vec<_> = library().iter().map(|e| (e.card().id.name(), e.card().port)).collect();
    assert_eq!(cards, expected);
    assert!(find("compression_lows").is_some() && find("astrology").is_none());
}

#[test]
fn cards_are_complete_and_name_only_effects_that_exist() {
    for effect in library() {
        let card = effect.card();
        let texts = [card.summary, card.size_at_one, card.source, card.signature];
        assert!(texts.iter().all(|text| text.len() > 20 && !text.contains("  ")), "{}", card.id);
        assert!(!card.channels.is_empty(), "{}", card.id);
        for other in card.confusable_with {
            assert!(find(other.name()).is_some() && *other != card.id, "{} and {other}", card.id);
        }
        let prior = card.prior;
        assert_eq!(prior.median, 1.0, "{}: 1 is the published size", card.id);
        assert!(prior.log_sd > 0.0 && prior.largest > 1.0, "{}", card.id);
    }
}

#[test]
fn amplitude_zero_changes_nothing_and_larger_ones_change_more() {
    let course = fortnight();
    for effect in library() {
        let name = effect.card().id.name();
        if effect.form(&course) != Some(Form::Driven) {
            continue;
        }
        assert!(effect.variants_for(&course) <= effect.variants(), "{name}");
        for variant in 0..effect.variants_for(&course) {
            let none = modulated(&*effect, variant, 0.0, &course);
            assert!(none.iter().all(Modulation::is_neutral), "{name} {variant}");
            let size = |amplitude: f64| -> f64 {
                let steps = modulated(&*effect, variant, amplitude, &course);
                steps.iter().flat_map(|m| Field::ALL.map(|f| distance(f, m[f]))).sum()
            };
            let (half, full) = (size(0.5), size(1.0));
            assert!(half > 0.0, "{name} {variant} does something");
            // Near to linear in the amplitude, so that one slope describes it: factors are powers, and
            // a factor in exercise reaches three.
            assert!((1.6..=2.05).contains(&(full / half)), "{name} {variant}: {}", full / half);
        }
    }
}

/// How far a value is from changing nothing: factors by their logarithm.
fn distance(field: Field, value: f64) -> f64 {
    if field.neutral() == 0.0 { value.abs() } else { value.ln().abs() }
}

#[test]
fn every_value_stays_finite_and_every_factor_positive_at_the_largest_amplitude() {
    let course = fortnight();
    for effect in library() {
        let card = effect.card();
        for variant in 0..effect.variants() {
            for step in modulated(&*effect, variant, card.prior.largest, &course) {
                for field in Field::ALL {
                    let value = step[field];
                    assert!(value.is_finite(), "{} {field:?}", card.id);
                    assert!(field.neutral() == 0.0 || value > 0.0, "{} {field:?}", card.id);
                }
            }
        }
    }
}

#[test]
fn effects_multiply_and_add_to_what_is_there() {
    let course = fortnight();
    for effect in library() {
        let alone = modulated(&*effect, 0, 1.0, &course);
        let mut start = Modulation::NEUTRAL;
        for field in Field::ALL {
            start[field] += 0.25;
        }
        let mut steps = vec![start; course.len()];
        effect.modulate(0, 1.0, &course, &mut steps);
        for (step, alone) in steps.iter().zip(&alone) {
            for field in Field::ALL {
                let expected = if field.neutral() == 0.0 {
                    start[field] + alone[field]
                } else {
                    start[field] * alone[field]
                };
                // One more rounding.
                assert!((step[field] - expected).abs() <= 1e-12 * expected.abs().max(1.0));
            }
        }
    }
}

#[test]
fn nothing_uses_the_future() {
    let course = fortnight();
    for effect in library() {
        let name = effect.card().id.name();
        if CENTRED.contains(&name) {
            continue;
        }
        for variant in 0..effect.variants() {
            let here = modulated(&*effect, variant, 1.0, &course);
            for cut in CUTS {
                let there = modulated(&*effect, variant, 1.0, &other_after(&course, cut));
                assert_eq!(here[..cut], there[..cut], "{name} {variant} before step {cut}");
            }
        }
    }
}

#[test]
fn events_are_well_formed() {
    let course = fortnight();
    let mut seen = 0;
    for effect in library() {
        let name = effect.card().id.name();
        let Some(Form::Events(events)) = effect.form(&course) else { continue };
        seen += 1;
        assert!(
            !events.profiles.is_empty()
                && events
                    .profiles
                    .iter()
                    .all(|p| !p.is_empty() && p.iter().all(|value| value.is_finite())),
            "{name}"
        );
        assert!(
            events.onsets.windows(2).all(|pair| pair[0] < pair[1]),
            "{name}: in order, once each"
        );
        assert!(events.onsets.iter().all(|k| *k < course.len()), "{name}");
        let weights: f64 = events.sizes.iter().map(|(_, weight)| weight).sum();
        assert!((weights - 1.0).abs() < 1e-12 && events.per_day > 0.0, "{name}");
    }
    assert_eq!(seen, 6);
}

#[test]
fn a_bare_record_has_no_form_where_channels_are_needed_and_nothing_panics() {
    let hour: Vec<f64> = (0..600).map(|k| (k % 288) as f64 / 12.0).collect();
    let n = hour.len();
    let bare = Course {
        day: (0..n).map(|k| k / 288).collect(),
        weekend: vec![false; n],
        carbs: vec![0.0; n],
        bolus: vec![0.0; n],
        glucose: vec![120.0; n],
        hour,
        ..Course::default()
    };
    let without = [
        "exercise",
        "post_exercise_sensitivity",
        "sleep_loss",
        "slow_meals",
        "carb_miscount",
        "missed_meals",
        "unlogged_rescue_carbs",
        "counter_regulation",
        "renal_threshold",
    ];
    for effect in library() {
        let name = effect.card().id.name();
        assert_eq!(effect.form(&bare).is_none(), without.contains(&name), "{name}");
        for variant in 0..effect.variants() {
            let _ = modulated(&*effect, variant, 1.0, &bare);
            let _ = modulated(&*effect, variant, 1.0, &Course::default());
        }
        let _ = effect.form(&Course::default());
    }
}

#[test]
fn what_sensor_lags_show_changes_nothing_but_the_lag() {
    let course = fortnight();
    let shown: Vec<_> = library()
        .into_iter()
        .filter(|effect| effect.card().relations.shown_by == ShownBy::SensorLag)
        .collect();
    assert_eq!(shown.len(), 1);
    for effect in shown {
        let steps = modulated(&*effect, 0, 1.0, &course);
        let mut expected = Modulation::NEUTRAL;
        expected[Field::SensorLag] = steps[0][Field::SensorLag];
        assert!(!expected.is_neutral() && steps.iter().all(|step| *step == expected));
    }
}

#[test]
fn sparse_channels_count_as_absent() {
    let mut course = fortnight();
    let n = course.len();
    let sparse = |k: usize, value: f64| k.is_multiple_of(10).then_some(value);
    course.heart_rate_over_rest = Some((0..n).map(|k| sparse(k, 60.0)).collect());
    course.walked = None;
    course.asleep = Some((0..n).map(|k| sparse(k, 1.0)).collect());
    for name in ["exercise", "post_exercise_sensitivity", "sleep_loss"] {
        let effect = find(name).expect("in the library");
        assert_eq!(effect.form(&course), None, "{name}");
        assert!(modulated(&*effect, 0, 1.0, &course).iter().all(Modulation::is_neutral), "{name}");
    }
}
