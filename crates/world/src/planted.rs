//! Effects planted into real people's records.
//!
//! Body, sensor and life are a real person's. Only the log or the sensor's readings are changed, so
//! what was planted is known exactly. A meal removed from the log is a missed meal; recorded
//! insulin raised for eight hours is a set that delivers less of it; filtered readings are a slower
//! sensor. Nobody knows what else is missing in these people, so the unchanged record is kept for
//! comparison.
//!
//! A [`Planting`] says what is done; [`plant`] does it to a cohort. Nothing else of a record
//! changes. The draws depend on seed, planting and the person's index; a larger size does more of
//! the same.
//!
//! ```no_run
//! use world::planted::{Planting, plant};
//!
//! let cohort = cohort::read_folder("real-people".as_ref())?;
//! let planted = plant(&cohort, Planting::MissedMeals, 0.5, 7);
//! println!("{} meals struck from the log", planted.changed);
//! # Ok::<(), cohort::CohortError>(())
//! ```

mod insulin;
mod meals;
mod moved;
mod sensor;

use cohort::{Channel, Cohort, Record};
use rand_chacha::ChaCha8Rng;

use crate::stream::numbered;

/// What signals exercise, and what signals sleep.
const EXERCISE: [Channel; 2] = [Channel::HeartRate, Channel::Steps];
const SLEEP: [Channel; 1] = [Channel::SleepEfficiency];

named::named! {
    /// What is done to a record.
    ///
    /// The order is part of what a seed means; new ones are added at the end.
    Planting {
        /// Meals are removed from the log.
        MissedMeals: "missed_meals",
        /// Logged carbohydrate grows more slowly than what was eaten.
        CarbMiscount: "carb_miscount",
        /// Carbohydrate logged at low glucose is removed.
        UnloggedRescueCarbs: "unlogged_rescue_carbs",
        /// Dinners are logged before they are eaten.
        SlowMeals: "slow_meals",
        /// For eight hours at a time 40 % of the recorded insulin arrives.
        SetFailure: "set_failure",
        /// Less of the recorded insulin arrives the older the set is.
        SetAgeing: "set_ageing",
        /// Recorded insulin acts later on some days and earlier on others.
        InsulinAbsorption: "insulin_absorption",
        /// Some boluses are given later than they are recorded.
        LateBoluses: "late_boluses",
        /// The sensor follows glucose more slowly.
        SensorLag: "sensor_lag",
        /// The sensor loses gain from its first day to its last.
        SensorDrift: "sensor_drift",
        /// The sensor reads low for three quarters of an hour in a night.
        CompressionLows: "compression_lows",
        /// Heart rate and steps are removed.
        ExerciseStruck: "exercise_struck",
        /// Heart rate and steps are those of other days.
        ExerciseMoved: "exercise_moved",
        /// Sleep is removed.
        SleepStruck: "sleep_struck",
        /// Sleep is that of other nights.
        SleepMoved: "sleep_moved",
    }
}

/// The right answer of a diagnosis to a planting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// The plant lacks this effect of the library.
    Effect(&'static str),
    /// The plant lacks something that is in no library.
    OutsideTheLibrary,
    /// The channel of these effects is lost, so the evidence for them must disappear.
    EvidenceLost(&'static [&'static str]),
}

/// How closely the changed record matches what the effect of that name would have made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exactness {
    /// It is the effect as it is defined.
    Exact,
    /// The change is known exactly, but the effect's definition has another shape.
    OfAnotherShape(&'static str),
}

impl Planting {
    /// The right answer of a diagnosis.
    #[must_use]
    pub const fn truth(self) -> Truth {
        match self {
            Self::LateBoluses => Truth::OutsideTheLibrary,
            Self::ExerciseStruck | Self::ExerciseMoved => {
                Truth::EvidenceLost(&["exercise", "post_exercise_sensitivity"])
            }
            Self::SleepStruck | Self::SleepMoved => Truth::EvidenceLost(&["sleep_loss"]),
            _ => Truth::Effect(self.name()),
        }
    }

    /// The usual size, of which others are multiples, and its unit. A channel is removed or moved
    /// whole.
    #[must_use]
    pub const fn usual_size(self) -> (f64, &'static str) {
        match self {
            Self::MissedMeals => (0.5, "meals a day"),
            Self::CarbMiscount => (0.3, "exponent"),
            Self::UnloggedRescueCarbs => (0.5, "of those logged at lows"),
            Self::SlowMeals => (20.0, "min"),
            Self::SetFailure => (0.1, "a day"),
            Self::SetAgeing => (0.1, "lost a day"),
            Self::InsulinAbsorption => (15.0, "min from day to day"),
            Self::LateBoluses => (15.0, "min, every other bolus"),
            Self::SensorLag => (6.0, "min"),
            Self::SensorDrift => (0.1, "of the gain in 10 days"),
            Self::CompressionLows => (0.35, "of the nights"),
            Self::ExerciseStruck | Self::ExerciseMoved | Self::SleepStruck | Self::SleepMoved => {
                (1.0, "the whole channel")
            }
        }
    }

    /// Whether the planting has sizes.
    #[must_use]
    pub const fn has_sizes(self) -> bool {
        !matches!(self.truth(), Truth::EvidenceLost(_))
    }

    /// How closely the changed record matches what the effect would have made.
    #[must_use]
    pub const fn exactness(self) -> Exactness {
        match self {
            Self::SlowMeals => Exactness::OfAnotherShape("later, not slower"),
            Self::InsulinAbsorption => Exactness::OfAnotherShape("later or earlier, not slower"),
            _ => Exactness::Exact,
        }
    }

    /// Changes one record; returns how many of its entries have a new value, and what happened in
    /// it.
    fn change(
        self,
        record: &mut Record,
        size: f64,
        rng: &mut ChaCha8Rng,
    ) -> (usize, Option<Happenings>) {
        let before = record.clone();
        let mut happenings = None;
        match self {
            Self::MissedMeals => happenings = Some(meals::miss(record, size, rng)),
            Self::CarbMiscount => meals::miscount(record, size),
            Self::UnloggedRescueCarbs => {
                happenings = Some(meals::leave_out_rescues(record, size, rng));
            }
            Self::SlowMeals => meals::slow_down(record, size),
            Self::SetFailure => happenings = Some(insulin::fail_sets(record, size, rng)),
            Self::SetAgeing => insulin::age_sets(record, size, rng),
            Self::InsulinAbsorption => insulin::vary_absorption(record, size, rng),
            Self::LateBoluses => insulin::delay_boluses(record, size),
            Self::SensorLag => sensor::lag(record, size),
            Self::SensorDrift => sensor::drift(record, size, rng),
            Self::CompressionLows => sensor::press(record, size, rng),
            Self::ExerciseStruck => moved::strike(record, &EXERCISE),
            Self::ExerciseMoved => moved::move_days(record, &EXERCISE),
            Self::SleepStruck => moved::strike(record, &SLEEP),
            Self::SleepMoved => moved::move_days(record, &SLEEP),
        }
        let differ = |channel: Channel| {
            let pairs = before.channel(channel).iter().zip(record.channel(channel));
            pairs.filter(|(a, b)| a != b).count()
        };
        (Channel::ALL.into_iter().map(differ).sum(), happenings)
    }
}

/// A cohort with something planted.
#[derive(Debug, Clone, PartialEq)]
pub struct Planted {
    /// The people with their changed records.
    pub cohort: Cohort,
    /// Number of entries of all records with a new value; 0 where there was nothing to change.
    pub changed: usize,
    /// What happened, where what is planted happens now and then; `None` where it acts all the time
    /// or at every meal.
    pub happenings: Option<Happenings>,
}

/// How often something happened that happens now and then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Happenings {
    /// Times it happened.
    pub count: usize,
    /// Times it could have happened: meals that were logged, stretches of a failure's length.
    pub places: usize,
}

/// Plants into every record of a cohort.
///
/// `size` is in the unit of [`Planting::usual_size`].
#[must_use]
pub fn plant(cohort: &Cohort, planting: Planting, size: f64, seed: u64) -> Planted {
    let mut cohort = cohort.clone();
    let (mut changed, mut happenings) = (0, None);
    for (index, person) in cohort.people.iter_mut().enumerate() {
        // One stream for every size, so that a larger size does more of the same.
        let mut rng = numbered(seed ^ APART, index, planting as u64);
        let (differ, own) = planting.change(&mut person.record, size, &mut rng);
        changed += differ;
        if let Some(own) = own {
            let so_far = happenings.get_or_insert(Happenings { count: 0, places: 0 });
            so_far.count += own.count;
            so_far.places += own.places;
        }
    }
    Planted { cohort, changed, happenings }
}

/// Separates these streams from those of worlds.
const APART: u64 = 0x706c_616e_7465_6421;
