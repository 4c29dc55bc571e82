//! The forms that effects take in a world.
//!
//! An effect has a name, a port and a size. Its course differs between studies and between people
//! who describe it. Each world draws one form of each effect, which its people share;
//! [`Shapes`](super::Shapes) holds what is individual. The first form of each effect is the typical
//! one. Forms are scaled so that an amplitude of 1 has about the same size in all. A blind check
//! finds the amplitude that moves glucose as far as planned in any case.

use rand::{Rng, RngExt};

use super::{Amplitudes, Effect};
use crate::generator::Generator;

/// Declares the forms of each effect, and [`Forms`], which has a field with one of each.
macro_rules! forms {
    ($($(#[$about:meta])* $effect:ident, $field:ident: $name:ident { $($variants:tt)+ })+) => {
        $(named::named! { $(#[$about])* $name { $($variants)+ } })+

        /// One form of each effect.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct Forms { $($(#[$about])* pub $field: $name,)+ }

        impl Forms {
            /// The first form of each effect.
            pub const TYPICAL: Self = Self { $($field: $name::ALL[0],)+ };

            /// The form of each effect whose index is chosen, given the number of its forms.
            fn chosen(mut index: impl FnMut(Effect, usize) -> usize) -> Self {
                Self { $($field: $name::ALL[index(Effect::$effect, $name::ALL.len())],)+ }
            }

            /// The form of an effect in words.
            #[must_use]
            pub const fn words(&self, effect: Effect) -> &'static str {
                match effect { $(Effect::$effect => self.$field.name(),)+ }
            }
        }
    };
}

forms! {
    /// When the dawn comes.
    Dawn, dawn: DawnForm {
        /// A bump about waking.
        AboutWaking: "a bump about waking",
        /// At fixed hours, independent of waking (Perriello et al., Diabetologia 1991;34:21).
        Plateau: "a plateau from 3 to 9 o'clock",
        /// Rising from the night on, over soon after waking.
        Ramp: "a ramp from 2 o'clock to waking",
        /// With getting up ("foot on the floor").
        AfterWaking: "three hours from waking on",
    }
    /// What working muscle feels of a session.
    Exercise, exercise: ExerciseForm {
        /// The session.
        Held: "as long as the session",
        /// It fades over an hour after the end.
        Lingering: "an hour beyond the session",
        /// Nothing in the first quarter of an hour.
        Late: "from a quarter of an hour into the session on",
        /// Strong at first, then half.
        Fading: "fading within the session",
    }
    /// When insulin acts more after exercise.
    PostExerciseSensitivity, after_exercise: AfterExerciseForm {
        /// From the session on, for hours, as the body has it.
        Decaying: "from the session on, fading",
        /// In the night that follows.
        Overnight: "in the night after a session",
        /// Soon, and again 7 to 11 h later (McMahon et al., J Clin Endocrinol Metab 2007;92:963).
        TwoPhases: "in two phases, soon and 7 to 11 h later",
    }
    /// How a short night acts.
    SleepLoss, sleep_loss: SleepLossForm {
        /// By hours missed, until the next night.
        NextDay: "by hours missed, all day",
        /// All or nothing.
        Threshold: "one size after nights two hours short",
        /// Strong in the morning, fading.
        Morning: "strong in the morning, fading",
        /// By the mean of three nights.
        Cumulative: "by the mean of three nights",
    }
    /// Which meals are slow.
    SlowMeals, slow_meals: SlowMealsForm {
        /// Rich dinners and lunches.
        RichDinners: "rich dinners and some lunches",
        /// Any fatty meal at any hour.
        AnyFatty: "any fatty meal at any hour",
        /// Large ones.
        Large: "large meals, by size",
        /// All in the evening.
        Evenings: "all meals of the evening",
    }
    /// When alcohol acts.
    Alcohol, alcohol: AlcoholForm {
        /// From 2 to 12 h.
        Night: "from 2 to 12 h after",
        /// The next morning (Turner et al., Diabetes Care 2001;24:1888).
        NextMorning: "from 7 to 15 h after",
        /// Soon, while gluconeogenesis is inhibited.
        Early: "within 6 h, deeper",
        /// From the first glass, fading.
        Fading: "from the first hour on, fading",
    }
    /// How a set ages.
    SetAgeing, set_ageing: SetAgeingForm {
        /// With the square of the time after an onset.
        Quadratic: "with the square of the time after an onset",
        /// From the first hour, in proportion.
        Linear: "in proportion to its age",
        /// In the last day alone.
        Late: "after two days",
        /// At first, then no more.
        Saturating: "in the first day, then held",
    }
    /// The unit over which insulin is absorbed faster or slower.
    InsulinAbsorption, absorption: AbsorptionForm {
        /// Days.
        ByDay: "by day",
        /// Sites.
        BySite: "by infusion set",
        /// Half-days, wandering.
        Wandering: "wandering over half days",
        /// The age of the site (Clausen et al., Diabetes Technol Ther 2009;11:575).
        FasterWithAge: "faster with the age of the set",
    }
    /// How carbohydrate is miscounted.
    CarbMiscount, miscount: MiscountForm {
        /// Too low, large meals more.
        TooLow: "too low, large meals more",
        /// Large meals alone.
        LargeOnly: "large meals too low, others right",
        /// Dinners alone.
        Dinners: "dinners too low, others right",
        /// Towards what is usual: small ones high, large ones low.
        TowardUsual: "towards 45 g: small meals high, large ones low",
    }
    /// Which meals are missed.
    MissedMeals, missed: MissedForm {
        /// Any.
        Any: "any meal",
        /// Snacks above all.
        Snacks: "snacks above all",
        /// Evenings above all.
        Evenings: "evenings above all",
        /// Small ones above all.
        Small: "small meals above all",
    }
    /// Which rescues are not logged.
    UnloggedRescueCarbs, unlogged: UnloggedForm {
        /// Any.
        Any: "at random",
        /// At night.
        Nights: "at night above all",
        /// Away from home by day.
        Daytime: "from 9 to 18 o'clock above all",
    }
    /// The day of insulin action.
    CircadianSensitivity, circadian: CircadianForm {
        /// One trough.
        Trough: "one trough",
        /// A cosine.
        Cosine: "a cosine",
        /// Two troughs, twelve hours apart.
        TwoTroughs: "two troughs twelve hours apart",
        /// Blocks (Visentin et al., Diabetes Technol Ther 2015;17:1).
        Blocks: "blocks of 1, 0.8, 0.9 and 1",
    }
    /// How a set fails.
    SetFailure, set_failure: SetFailureForm {
        /// In part, before the change.
        Partial: "in part, before the change",
        /// Wholly, for a shorter time.
        Complete: "wholly, before the change",
        /// Slowly.
        Slow: "slowly, over a day",
        /// From its insertion on, for hours.
        AtInsertion: "from insertion on, for hours",
    }
    /// How the liver answers a low.
    CounterRegulation, low: LowForm {
        /// In proportion below 70 mg/dL.
        Proportional: "in proportion below 70 mg/dL",
        /// All at once below 62 mg/dL.
        Threshold: "all at once below 62 mg/dL",
        /// In proportion, and for long after.
        Prolonged: "in proportion, fading six times as slowly",
        /// Before it is a low.
        Early: "in proportion below 80 mg/dL",
    }
    /// How kidneys differ.
    RenalThreshold, renal: RenalForm {
        /// Threshold and rate in opposite directions.
        Opposite: "threshold and rate in opposite directions",
        /// The threshold alone.
        ThresholdOnly: "the threshold alone",
        /// The rate alone.
        RateOnly: "the rate alone",
    }
    /// How a sensor follows later.
    SensorLag, lag: LagForm {
        /// By a first-order lag.
        FirstOrder: "a first-order lag",
        /// By a delay.
        Delay: "a pure delay",
        /// By a mean of its last readings.
        MovingMean: "a moving mean",
    }
    /// How a sensor drifts.
    SensorDrift, drift: DriftForm {
        /// It loses gain.
        Loss: "a loss of gain that levels off",
        /// Its gain goes up or down, by sensor.
        Signed: "a slope of the gain whose sign is each sensor's",
        /// It is off on its first day, up or down.
        FirstDay: "off on the first day, up or down",
        /// It loses gain at its end.
        EndOfLife: "a loss of gain from the fifth day on",
    }
    /// How readings fall under pressure.
    CompressionLows, compression: CompressionForm {
        /// Sharply.
        Sharp: "a sharp fall and rebound",
        /// Less, and for longer.
        Long: "shallow and long",
        /// More, and briefly.
        Brief: "deep and brief",
        /// Sinking, with a jump back.
        Sinking: "sinking slowly, with a jump back",
    }
}

impl Forms {
    /// Draws the forms of a world for the hand of a generator.
    ///
    /// A hand uses the typical form (35 %), one that it prefers (45 %) and, where an effect has
    /// four, a third (20 %); one form of four it never draws. The choice rotates from effect to
    /// effect, and with it the hands that agree: no two do in half of the effects with four forms.
    #[must_use]
    pub fn sample(hand: Generator, rng: &mut (impl Rng + ?Sized)) -> Self {
        Self::chosen(|effect, count| {
            let draw = rng.random::<f64>();
            let others = count - 1;
            let own = (hand as usize + effect as usize) % Generator::ALL.len() % others;
            match draw {
                draw if draw < 0.35 => 0,
                draw if draw < 0.80 || others < 3 => 1 + own,
                _ => 1 + (own + 1) % others,
            }
        })
    }

    /// The amplitudes with which effects act in a body. Those that in these forms act through its
    /// conditions alone are off there.
    #[must_use]
    pub(crate) fn in_body(&self, amplitudes: Amplitudes) -> Amplitudes {
        match self.after_exercise {
            AfterExerciseForm::Decaying => amplitudes,
            AfterExerciseForm::Overnight | AfterExerciseForm::TwoPhases => {
                amplitudes.without(Effect::PostExerciseSensitivity)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, WORLD, stream};
    use std::collections::{BTreeMap, BTreeSet};

    #[test]
    fn every_effect_has_three_forms_and_each_hand_lacks_some() {
        let mut seen: BTreeMap<(Effect, Generator), BTreeSet<&str>> = BTreeMap::new();
        for hand in Generator::ALL {
            for seed in 0..120 {
                let forms = Forms::sample(hand, &mut stream(seed, WORLD, Concept::Forms));
                for effect in Effect::ALL {
                    seen.entry((effect, hand)).or_default().insert(forms.words(effect));
                }
            }
        }
        for effect in Effect::ALL {
            let of = |hand: &Generator| &seen[&(effect, *hand)];
            let all: BTreeSet<&str> = Generator::ALL.iter().flat_map(of).copied().collect();
            assert!(all.len() >= 3, "{effect:?}: {all:?}");
            for hand in Generator::ALL {
                let drawn = of(&hand).len();
                assert!((2..all.len()).contains(&drawn), "{effect:?} {hand:?}: {drawn}");
                assert!(of(&hand).contains(Forms::TYPICAL.words(effect)));
            }
        }
        let effects = |of: &dyn Fn(&Effect) -> bool| Effect::ALL.iter().filter(|e| of(e)).count();
        let rich = |effect: &Effect| {
            let all = Generator::ALL.iter().flat_map(|hand| &seen[&(*effect, *hand)]);
            all.collect::<BTreeSet<_>>().len() == 4
        };
        for (index, one) in Generator::ALL.into_iter().enumerate() {
            for other in Generator::ALL.into_iter().skip(index + 1) {
                let agree = |e: &Effect| rich(e) && seen[&(*e, one)] == seen[&(*e, other)];
                let (agree, all) = (effects(&agree), effects(&rich));
                assert!(2 * agree < all, "{one:?} {other:?}: {agree} of {all}");
            }
        }
    }
}
