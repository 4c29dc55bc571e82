//! What a cohort may lack: nothing, something unknown, one effect, or two.

/// What is lacking, as indices of effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Lacking {
    /// Nothing.
    Nothing,
    /// Something that is none of the effects.
    Unknown,
    /// One effect.
    One(usize),
    /// Two effects, the lower index first.
    Two(usize, usize),
}

impl Lacking {
    /// Of one or two effects; `None` of more, or of one twice.
    #[must_use]
    pub fn of(effects: &[usize]) -> Option<Self> {
        match *effects {
            [] => Some(Self::Nothing),
            [one] => Some(Self::One(one)),
            [one, other] if one != other => Some(Self::Two(one.min(other), one.max(other))),
            _ => None,
        }
    }

    /// Whether an effect is part of it.
    #[must_use]
    pub fn has(self, effect: usize) -> bool {
        match self {
            Self::Nothing | Self::Unknown => false,
            Self::One(one) => one == effect,
            Self::Two(one, other) => one == effect || other == effect,
        }
    }
}

/// All that may be lacking of so many effects, in a fixed order.
///
/// The log odds of a set beside nothing are the sum of those of its members, with one number more for pairs: two effects act
/// independently but for how often two do.
#[derive(Debug, Clone, PartialEq)]
pub struct Sets {
    effects: usize,
    all: Vec<Lacking>,
}

impl Sets {
    /// Of so many effects.
    #[must_use]
    pub fn of(effects: usize) -> Self {
        let mut all = vec![Lacking::Nothing];
        all.extend((0..effects).map(Lacking::One));
        all.push(Lacking::Unknown);
        for one in 0..effects {
            all.extend((one + 1..effects).map(|other| Lacking::Two(one, other)));
        }
        Self { effects, all }
    }

    /// The sets, in order.
    #[must_use]
    pub fn all(&self) -> &[Lacking] {
        &self.all
    }

    /// Number of log odds that a network answers with: one an effect, and that of something unknown.
    #[must_use]
    pub fn odds(&self) -> usize {
        self.effects + 1
    }

    /// The index of a set.
    #[must_use]
    pub fn index(&self, lacking: Lacking) -> Option<usize> {
        self.all.iter().position(|set| *set == lacking)
    }

    /// Membership, row by row: (odds, sets), a 1 where the log odds count in the set.
    pub(crate) fn membership(&self) -> Vec<f32> {
        let member = |row: usize, set: &Lacking| {
            let counts = if row == self.effects { *set == Lacking::Unknown } else { set.has(row) };
            f32::from(u8::from(counts))
        };
        (0..self.odds()).flat_map(|row| self.all.iter().map(move |set| member(row, set))).collect()
    }

    /// A 1 for each pair.
    pub(crate) fn pairs(&self) -> Vec<f32> {
        let pair = |set: &Lacking| f32::from(u8::from(matches!(set, Lacking::Two(..))));
        self.all.iter().map(pair).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_nothing_singles_unknown_and_pairs() {
        let sets = Sets::of(3);
        assert_eq!(sets.all().len(), 1 + 3 + 1 + 3);
        assert_eq!(sets.index(Lacking::Nothing), Some(0));
        assert_eq!(sets.index(Lacking::Unknown), Some(4));
        assert_eq!(Lacking::of(&[2, 0]), Some(Lacking::Two(0, 2)));
        assert_eq!(sets.index(Lacking::Two(0, 2)), Some(6));
        assert_eq!((Lacking::of(&[1, 1]), Lacking::of(&[0, 1, 2])), (None, None));
    }

    #[test]
    fn membership_says_which_odds_count() {
        let sets = Sets::of(2);
        // Nothing, 0, 1, unknown, {0, 1}.
        let expected = [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        assert_eq!(sets.membership(), expected);
        assert_eq!(sets.pairs(), [0.0, 0.0, 0.0, 0.0, 1.0]);
    }
}
