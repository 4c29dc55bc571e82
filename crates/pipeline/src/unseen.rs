//! The posteriors of the blind check: each has not seen the worlds of one hand.

use std::borrow::Cow;

use anyhow::Result;

static WITHOUT: [(&str, &[u8]); 5] = [
    ("another", include_bytes!("../posterior/without-another.safetensors")),
    ("hovorka", include_bytes!("../posterior/without-hovorka.safetensors")),
    ("padova", include_bytes!("../posterior/without-padova.safetensors")),
    ("minimal", include_bytes!("../posterior/without-minimal.safetensors")),
    ("saturating", include_bytes!("../posterior/without-saturating.safetensors")),
];

/// The file of a posterior that never saw the worlds of `hand`; that in use where there is no hand, as in real people.
pub(crate) fn posterior_file(hand: Option<&str>) -> Result<Cow<'static, [u8]>> {
    let own = WITHOUT.iter().find(|(left_out, _)| Some(*left_out) == hand);
    Ok(match own {
        Some((_, file)) => Cow::Borrowed(file),
        None => Cow::Owned(gap::working_posterior().bytes()?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use posterior::Posterior;

    #[test]
    fn each_saw_all_hands_but_one_and_the_posterior_in_use_saw_all() {
        let read = |hand| {
            let file = posterior_file(hand).expect("a file");
            Posterior::from_bytes(&file).expect("a posterior")
        };
        let hands = |posterior: &Posterior| -> Vec<String> {
            posterior.card().hands.iter().map(|(hand, _)| hand.clone()).collect()
        };
        let all = read(None);
        assert_eq!(hands(&all).len(), WITHOUT.len());
        for (hand, _) in WITHOUT {
            let found = read(Some(hand));
            let others: Vec<String> = hands(&all).into_iter().filter(|own| own != hand).collect();
            assert_eq!(hands(&found), others);
            assert_eq!(found.effects(), all.effects());
        }
    }
}
