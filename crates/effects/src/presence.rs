//! Whether a channel was recorded well enough to build a driver on it.

/// Share of steps with a value below which a channel counts as never recorded.
const LEAST_SHARE: f64 = 0.2;

/// Whether at least a fifth of the steps have a value.
pub(crate) fn recorded<T>(channel: Option<&Vec<Option<T>>>) -> bool {
    channel.is_some_and(|values| {
        let present = values.iter().filter(|value| value.is_some()).count();
        present > 0 && present as f64 >= LEAST_SHARE * values.len() as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_is_enough_and_less_is_not() {
        let with = |present: usize| -> Vec<Option<f64>> {
            (0..100).map(|k| (k < present).then_some(1.0)).collect()
        };
        assert!(recorded(Some(&with(20))));
        assert!(!recorded(Some(&with(19))));
        assert!(!recorded(Some(&Vec::<Option<f64>>::new())));
        assert!(!recorded::<f64>(None));
    }
}
