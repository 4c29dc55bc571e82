//! Mixed-integer linear programmes through good_lp and HiGHS: three forms of the paper's question.
//!
//! - **Gradient** ([`solve`]): the largest slope M. One binary `q_j` a switch that the box leaves undecided, over the inputs x
//!   of the box: maximise `constant + sum c_j q_j` subject to `a_j >= L_j (1 - q_j)` where `c_j > 0` and
//!   `a_j <= U_j q_j` where `c_j < 0`, with `L_j <= a_j <= U_j` the switch's range over the box.
//! - **Difference** and **two copies** ([`solve_step`]): z, the largest movement against the property when the tested input
//!   grows by at most delta; the second is the paper's own (section "Conformance Verification").
//!
//! The solver works to tolerances in floating point: what it
//! calls optimal and what it calls a bound are **claims**. Its point is evaluated exactly; only that
//! number is attained.
//!
//! The caution is not idle: HiGHS 1.15.0 calls 2.958 optimal for a programme of six binaries that has
//! a feasible point of value 3.583, which it accepts if it is handed over as a start (the network is in
//! `tests/it/engines.rs`). [`crate::verify()`] flags such rows.

mod step;

use std::time::Duration;

use good_lp::{Expression, ProblemVariables, SolverModel, Variable, variable};
use highs::HighsModelStatus;

use crate::error::{ConformanceError, require};
use crate::interior::{UnitRow, deepest_point, point_at, unit_inputs};
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::{BoxRegion, Region};
use crate::slope::SlopeSum;

pub use contract::conformance::{Form, MilpReport, MilpStatus, StepReport};
pub use step::solve_step;

/// Limits of one solve. One thread is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MilpLimits {
    /// HiGHS' `time_limit`.
    pub time: Duration,
    /// HiGHS' `mip_rel_gap`, 0 or more.
    pub relative_gap: f64,
}

impl MilpLimits {
    fn check(&self) -> Result<(), ConformanceError> {
        let gap = self.relative_gap;
        require(gap.is_finite() && gap >= 0.0, "milp relative_gap", gap, "0 or more")
    }
}

/// How far the solver's numbers may stray within its feasibility tolerances; scaled output per
/// minute per scaled input. On the published networks its bounds fall short of the truth by 3e-8.
pub const CLAIM_TOLERANCE: f64 = 1e-6;

/// Solves the gradient form for `property` of `network` over `region`.
///
/// # Errors
/// Those of [`crate::verify()`] about network, property and region; [`ConformanceError::Limit`] for a
/// negative gap; [`ConformanceError::Solver`] where HiGHS fails other than by reaching a limit.
pub fn solve(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    limits: &MilpLimits,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Result<MilpReport, ConformanceError> {
    limits.check()?;
    let (boxed, tested) = property.box_in(network, region)?;
    let sum = SlopeSum::new(network, tested, property.direction).within(&boxed);

    let began = clock();
    let rest = sum.restricted_to(&boxed);
    let constant = rest.constant.round_up();
    let (status, attained, claimed_objective, claimed_bound) = if rest.switches.is_empty() {
        let attained = (rest.constant.round_down(), boxed.lower().to_vec());
        (MilpStatus::Constant, Some(attained), None, Some(constant))
    } else {
        let solved =
            solve_switches(&rest, &boxed, limits).map_err(|failure| failed(property, failure))?;
        let attained = solved.columns.as_ref().and_then(|columns| {
            let (inputs, binaries) = columns.split_at(boxed.lower().len());
            let on: Vec<bool> = binaries.iter().map(|&q| q > 0.5).collect();
            let inside = deepest_point(&rest, &boxed, &on);
            [Some(point_at(inputs, &boxed, rest.tested)), inside]
                .into_iter()
                .flatten()
                .map(|point| (sum.at(&point).round_down(), point))
                .max_by(|a, b| a.0.total_cmp(&b.0))
        });
        let objective = solved.columns.as_ref().map(|_| constant + solved.objective);
        (solved.status, attained, objective, solved.bound.map(|bound| constant + bound))
    };
    let (m_lower, point) = attained.unzip();
    Ok(MilpReport {
        status,
        m_lower,
        point,
        claimed_objective,
        claimed_bound,
        binaries: rest.switches.len(),
        seconds: clock().saturating_sub(began).as_secs_f64(),
    })
}

/// Stage and reason of a failure of HiGHS.
type Failure = (&'static str, String);

/// The error of a row for a failure of HiGHS.
fn failed(property: &Property, (stage, reason): Failure) -> ConformanceError {
    let (network, input) = (property.network.clone(), property.input.clone());
    ConformanceError::Solver { network, input, stage, reason }
}

/// Solves for the switches undecided over a box. Columns are the inputs, from 0 to 1 across the box,
/// then a binary a switch.
fn solve_switches(
    rest: &SlopeSum,
    region: &BoxRegion,
    limits: &MilpLimits,
) -> Result<Solved, Failure> {
    let rows: Vec<UnitRow> =
        rest.switches.iter().map(|switch| UnitRow::new(switch, region)).collect();
    let mut variables = ProblemVariables::new();
    let inputs = unit_inputs(&mut variables, region);
    let binaries: Vec<Variable> = rows.iter().map(|_| variables.add(variable().binary())).collect();
    let objective: Expression = rows.iter().zip(&binaries).map(|(row, &q)| row.gain * q).sum();
    let mut problem = variables.maximise(objective).using(good_lp::highs);
    for (row, &q) in rows.iter().zip(&binaries) {
        // Divided by the range, so that every row has coefficients of order 1.
        let constraint = if row.gain > 0.0 {
            (row.expression(&inputs, -row.low) - q).geq(-1.0)
        } else {
            (row.expression(&inputs, row.high) - q).leq(0.0)
        };
        problem.add_constraint(constraint);
    }
    run(problem, limits)
}

/// What HiGHS says of a programme.
struct Solved {
    status: MilpStatus,
    /// Values of all variables in the order they were added, if it has a feasible point.
    columns: Option<Vec<f64>>,
    objective: f64,
    /// Infinite in the solver before its first relaxation is solved.
    bound: Option<f64>,
}

/// Solves a programme on one thread.
fn run(
    problem: good_lp::solvers::highs::HighsProblem,
    limits: &MilpLimits,
) -> Result<Solved, Failure> {
    // good_lp has neither bound nor node count; the model inside has, without its options.
    let mut model = problem.try_into_inner().map_err(|e| ("building", e.to_string()))?;
    let refused = |_| ("setting options", "option refused".to_owned());
    model.try_set_option("output_flag", false).map_err(refused)?;
    model.try_set_option("threads", 1).map_err(refused)?;
    model.try_set_option("parallel", "off").map_err(refused)?;
    model.try_set_option("random_seed", 0).map_err(refused)?;
    model.try_set_option("time_limit", limits.time.as_secs_f64()).map_err(refused)?;
    model.try_set_option("mip_rel_gap", limits.relative_gap).map_err(refused)?;
    model.try_set_option("mip_abs_gap", 0.0).map_err(refused)?;
    // The tightest that HiGHS accepts for both is 1e-10; 1e-9 leaves it room to converge.
    model.try_set_option("mip_feasibility_tolerance", 1e-9).map_err(refused)?;
    model.try_set_option("primal_feasibility_tolerance", 1e-9).map_err(refused)?;
    let solved = model.try_solve().map_err(|e| ("solving", format!("{e:?}")))?;

    let status = match solved.status() {
        HighsModelStatus::Optimal => MilpStatus::Optimal,
        HighsModelStatus::ReachedTimeLimit
        | HighsModelStatus::ReachedIterationLimit
        | HighsModelStatus::ReachedSolutionLimit
        | HighsModelStatus::ReachedMemoryLimit
        | HighsModelStatus::ReachedInterrupt => MilpStatus::Limit,
        other => return Err(("solving", format!("{other:?}"))),
    };
    let unread = |e| ("reading the result", format!("{e:?}"));
    let bound = solved.double_info_value(c"mip_dual_bound").map_err(unread)?;
    let feasible = solved.primal_solution_status() == highs::HighsSolutionStatus::Feasible;
    let objective = solved.objective_value();
    let columns = feasible.then(|| solved.get_solution().columns().to_vec());
    Ok(Solved { status, columns, objective, bound: Some(bound).filter(|bound| bound.is_finite()) })
}
