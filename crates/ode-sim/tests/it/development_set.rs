//! The development set: size, coverage, split, additional weeks, independence of threads.

use std::collections::HashSet;

use ode_sim::development_set::{Origin, STEPS_PER_WEEK, Subset, Week};
use ode_sim::{DevelopmentPlan, DevelopmentSet, OdeError};
use physiology::Plant;

fn quick() -> DevelopmentSet {
    DevelopmentSet::new(DevelopmentPlan::quick(11)).expect("the quick plan is large enough")
}

#[test]
fn the_papers_plan_has_323_400_days() {
    let plan = DevelopmentPlan::paper(0);
    assert_eq!(plan.days(), 323_400);
    assert_eq!(plan.combinations(), 36_000);
    let set = DevelopmentSet::new(plan).expect("the paper's plan");
    let shares: Vec<usize> = Subset::ALL.iter().map(|s| set.pool_of(*s).len()).collect();
    assert_eq!(shares, [600, 200, 200]);
    let last = set.week(set.len() - 1).expect("the last week");
    assert_eq!(last.inputs.len(), STEPS_PER_WEEK);
}

#[test]
fn no_two_meal_weeks_are_alike() {
    let set = DevelopmentSet::new(DevelopmentPlan::paper(5)).expect("the paper's plan");
    let runs_of_a_meal_week = set.plan().combinations() / set.plan().meal_weeks;
    let weeks: HashSet<_> = (0..set.plan().meal_weeks)
        .map(|week| set.week(week * runs_of_a_meal_week).expect("week").meal_days)
        .collect();
    assert_eq!(weeks.len(), 240, "days that are dealt again are dealt in another order");
}

#[test]
fn combinations_cover_every_start_delay_and_dose_of_every_meal_week() {
    let set = quick();
    let plan = set.plan().clone();
    let weeks: Vec<Week> = (0..plan.combinations()).map(|k| set.week(k).expect("week")).collect();
    let kinds: HashSet<String> = weeks
        .iter()
        .map(|w| format!("{:?} {} {} {}", w.meal_days, w.initial_glucose, w.delay, w.dose_factor))
        .collect();
    assert_eq!(kinds.len(), plan.combinations(), "no combination occurs twice");
    for week in &weeks {
        assert_eq!(week.origin, Origin::Combination);
        let start = set.plant().glucose(&week.initial);
        assert!((start.0 - week.initial_glucose.0).abs() < 1e-9, "rounding of the unit conversion");
    }
}

#[test]
fn boluses_follow_meals_by_the_delay_and_scale_with_the_dose() {
    let set = quick();
    for index in 0..set.plan().combinations() {
        let week = set.week(index).expect("week");
        for (step, input) in week.inputs.iter().enumerate() {
            let carbs = step.checked_sub(week.delay).map_or(0.0, |s| week.inputs[s].carbs.0);
            let ratio = week.inputs[step].bolus.0 / carbs;
            // The nominal ratio is near 13 g/U; every bolus has exactly one meal behind it.
            assert_eq!(carbs > 0.0, input.bolus.0 > 0.0, "week {index}, step {step}");
            assert!(carbs == 0.0 || (0.05..0.12).contains(&ratio), "ratio {ratio}");
        }
    }
}

#[test]
fn insulin_of_additional_weeks_varies_in_the_direction_of_their_glucose() {
    let set = quick();
    let usual = set.week(0).expect("week").inputs[0].basal.0;
    let (mut other_basal, mut extra) = (0, 0);
    for index in 0..set.len() {
        let week = set.week(index).expect("week");
        for (day, factor) in week.basal_factors.into_iter().enumerate() {
            let allowed = match week.origin {
                Origin::Combination => factor == 1.0,
                Origin::AdditionalLow => (1.0..2.2).contains(&factor),
                Origin::AdditionalHigh => (0.0..=1.0).contains(&factor),
            };
            assert!(allowed, "week {index}: {factor}");
            let rates = week.inputs[288 * day..288 * (day + 1)].iter().map(|input| input.basal.0);
            assert!(rates.into_iter().all(|rate| rate == usual * factor));
            other_basal += usize::from(factor != 1.0);
        }
        let meals: f64 = week.inputs.iter().map(|input| input.bolus.0).sum();
        let without: f64 = week.extra_boluses.iter().map(|(_, bolus)| bolus.0).sum();
        assert!(without == 0.0 || (week.origin == Origin::AdditionalLow && meals > without));
        extra += week.extra_boluses.len();
    }
    assert!(other_basal > 50 && extra > 10, "{other_basal} days, {extra} boluses");
}

#[test]
fn no_daily_meal_scenario_lies_in_two_subsets() {
    let set = quick();
    let mut seen = HashSet::new();
    for index in 0..set.len() {
        let week = set.week(index).expect("week");
        assert!(week.meal_days.iter().all(|day| set.pool_of(week.subset).contains(day)));
        assert_eq!(week.meal_days.iter().collect::<HashSet<_>>().len(), 7, "seven different days");
        seen.insert(week.subset);
    }
    assert_eq!(seen.len(), 3, "all subsets occur");
    let pools = Subset::ALL.map(|s| set.pool_of(s));
    assert!(pools[0].end == pools[1].start && pools[1].end == pools[2].start, "no overlap");
}

#[test]
fn additional_weeks_are_low_and_high_enough() {
    let set = quick();
    let first = set.plan().combinations();
    for (week, run) in set.simulate(first..set.len()).expect("additional weeks") {
        let shares = set.time_shares(&run);
        match week.origin {
            Origin::AdditionalLow => assert!(shares.below_70 > 0.2, "{shares:?}"),
            Origin::AdditionalHigh => assert!(shares.above_250 > 0.4, "{shares:?}"),
            Origin::Combination => panic!("week {} is not a combination", week.index),
        }
        let lowest = run.states.iter().map(|x| set.plant().glucose(x).0).fold(f64::MAX, f64::min);
        assert!(lowest > 0.0, "glucose stays positive: {lowest}");
    }
}

#[test]
fn weeks_do_not_depend_on_threads_or_order() {
    let set = quick();
    let run_on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| set.simulate(0..set.len())).expect("weeks")
    };
    let (one, three) = (run_on(1), run_on(3));
    assert_eq!(one.len(), set.len());
    for ((a, run_a), (b, run_b)) in one.iter().zip(&three) {
        assert_eq!(a, b);
        assert_eq!(run_a.states, run_b.states);
    }
    let again = quick().week(set.len() - 1).expect("week");
    assert_eq!(again, one[set.len() - 1].0, "made alone, by a set of the same plan");
    let other = DevelopmentSet::new(DevelopmentPlan::quick(12)).expect("plan");
    assert_ne!(other.week(0).expect("week").inputs, one[0].0.inputs, "another seed");
}

#[test]
fn initial_glucose_has_the_papers_mean_and_spread() {
    let plan = DevelopmentPlan {
        meal_weeks: 400,
        starts_per_week: 5,
        delays: vec![0],
        dose_factors: vec![1.0],
        additional_weeks: 0,
        ..DevelopmentPlan::quick(3)
    };
    let set = DevelopmentSet::new(plan).expect("plan");
    let glucose = |index| set.week(index).expect("week").initial_glucose.0;
    let values: Vec<f64> = (0..set.len()).map(glucose).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    // Four standard errors of 2000 draws; the range cuts half a percent off the tails.
    assert!((mean - 156.0).abs() < 4.5, "{mean}");
    assert!((sd - 45.0).abs() < 3.5, "{sd}");
}

#[test]
fn plans_that_cannot_be_are_refused() {
    let base = DevelopmentPlan::quick(1);
    let cases = [
        DevelopmentPlan { meal_days: 34, ..base.clone() },
        DevelopmentPlan { meal_weeks: 4, ..base.clone() },
        DevelopmentPlan { delays: vec![], ..base.clone() },
        DevelopmentPlan { delays: vec![288], ..base.clone() },
        DevelopmentPlan { dose_factors: vec![-0.5], ..base.clone() },
        DevelopmentPlan { dose_factors: vec![f64::NAN], ..base },
    ];
    for plan in cases {
        assert!(matches!(DevelopmentSet::new(plan), Err(OdeError::Argument { .. })));
    }
    assert!(quick().week(quick().len()).is_err());
}

#[test]
fn no_plan_tests_on_meals_that_train_another() {
    let [quick, paper] = [DevelopmentPlan::quick(1), DevelopmentPlan::paper(1)]
        .map(|plan| DevelopmentSet::new(plan).expect("plans"));
    let days = |set: &DevelopmentSet, subset| set.pool()[set.pool_of(subset)].to_vec();
    for subset in Subset::ALL {
        let few = days(&quick, subset);
        assert_eq!(few, days(&paper, subset)[..few.len()]);
    }
    // A plan beyond the paper's has days of its own in each subset.
    let large = DevelopmentPlan { meal_days: 3000, ..DevelopmentPlan::quick(1) };
    let large = DevelopmentSet::new(large).expect("a plan");
    let mut all = large.pool().to_vec();
    all.sort_by_key(|day| format!("{day:?}"));
    all.dedup();
    assert_eq!(all.len(), 3000);
}
