//! One member of the ensemble: a small network with three answers.

use candle_core::{D, Tensor};
use candle_nn::ops::log_softmax;

use crate::error::PosteriorError;

/// Size of a gap that networks call 1, mg/dL.
pub(crate) const GAP_UNIT: f64 = 10.0;

/// How many numbers a network answers with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shape {
    pub(crate) statistics: usize,
    pub(crate) hidden: usize,
    /// Effects, and kinds outside the library.
    pub(crate) odds: usize,
    pub(crate) ports: usize,
    /// Cells of the gap.
    pub(crate) cells: usize,
}

impl Shape {
    /// Shapes of the weights, by name.
    pub(crate) fn weights(self) -> [(&'static str, Vec<usize>); 11] {
        let Self { statistics, hidden, odds, ports, cells } = self;
        [
            ("first.weight", vec![statistics, hidden]),
            ("first.bias", vec![hidden]),
            ("second.weight", vec![hidden, hidden]),
            ("second.bias", vec![hidden]),
            ("odds.weight", vec![hidden, odds]),
            ("odds.bias", vec![odds]),
            ("pair", vec![1]),
            ("ports.weight", vec![hidden, ports]),
            ("ports.bias", vec![ports]),
            ("gaps.weight", vec![hidden, 2 * cells]),
            ("gaps.bias", vec![2 * cells]),
        ]
    }
}

/// Weights in the order of [`Shape::weights`].
#[derive(Debug, Clone)]
pub(crate) struct Network {
    pub(crate) weights: Vec<Tensor>,
}

/// What a network answers, a row a cohort.
pub(crate) struct Output {
    /// Log odds of the effects and of the kinds outside the library.
    pub(crate) odds: Tensor,
    /// Log probabilities of the ports, given that something is missing.
    pub(crate) ports: Tensor,
    /// The mean gap by cell, then its mean size, in units of [`GAP_UNIT`].
    pub(crate) gaps: Tensor,
}

/// What is kept of the hidden units in training, each over the share that is.
pub(crate) struct Kept {
    pub(crate) statistics: Tensor,
    pub(crate) first: Tensor,
    pub(crate) second: Tensor,
}

impl Network {
    /// Of what was read: (cohorts, statistics).
    pub(crate) fn answer(
        &self,
        read: &Tensor,
        kept: Option<&Kept>,
    ) -> Result<Output, PosteriorError> {
        let [w1, b1, w2, b2, odds_w, odds_b, _, ports_w, ports_b, gaps_w, gaps_b] =
            &self.weights[..]
        else {
            return Err(PosteriorError::File("a network with other weights".to_owned()));
        };
        let dropped = |x: Tensor, of: fn(&Kept) -> &Tensor| match kept {
            Some(kept) => x.mul(of(kept)),
            None => Ok(x),
        };
        let x = dropped(read.clone(), |kept| &kept.statistics)?;
        let x = x.matmul(w1)?.broadcast_add(b1)?.relu()?;
        let x = dropped(x, |kept| &kept.first)?;
        let x = x.matmul(w2)?.broadcast_add(b2)?.relu()?;
        let x = dropped(x, |kept| &kept.second)?;
        let ports = x.matmul(ports_w)?.broadcast_add(ports_b)?;
        Ok(Output {
            odds: x.matmul(odds_w)?.broadcast_add(odds_b)?,
            ports: log_softmax(&ports, D::Minus1)?,
            gaps: x.matmul(gaps_w)?.broadcast_add(gaps_b)?,
        })
    }

    /// The number for pairs.
    pub(crate) fn pair(&self) -> &Tensor {
        &self.weights[6]
    }
}
