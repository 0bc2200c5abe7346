//! The request of an optimisation and its checks.

use cotree::compile::quantity;
use cotree::diagnostic::suggest;
use cotree::model::{Experiment, Unit};
use cotree::report::csv::CsvTable;
use cotree::typeset::short;

use super::goal::{Goal, MeasureLimit, Relation};
use super::search::{EndPoint, GoalCondition, GoalSum, Problem, SeenCourses};
use super::starts::{MOST_QUANTITIES, MOST_STARTS};
use super::{LimitAt, MET, OptimizeError};
use crate::analysis::{VariedQuantity, Varying};
use crate::fit::{Vary, bounds, check_times, places};
use crate::motion;
use crate::request::{LimitError, RequestFault};

/// A limit is active if the goal would change by more than this share of itself for as much again of the bound.
const ACTIVE: f64 = 1e-8;

/// What is to be best, and within which limits.
#[derive(Clone, Debug)]
pub struct OptimizeRequest {
    /// What is varied.
    pub vary: Vec<Vary>,
    pub aim: Aim,
    pub limits: Vec<MeasureLimit>,
    /// One turn or stroke of an input, whose figures are measured; the experiment of the scene if absent.
    pub turn: Option<motion::MotionRequest>,
    /// How many searches there are.
    pub starts: usize,
    /// The same one gives the same starts.
    pub seed: u64,
    /// Searches at a time; 0 for one on each processor.
    pub threads: usize,
}

/// What is to be best.
#[derive(Clone, Debug)]
pub enum Aim {
    Least(Goal),
    Most(Goal),
    /// Outputs are to be as near as possible to these columns.
    Match(CsvTable),
}

/// The same, checked.
#[derive(Debug)]
pub(super) struct Checked {
    pub problem: Problem,
    /// The values of the scene, SI.
    pub start: Vec<f64>,
    /// The outputs that are measured, one for each course.
    pub outputs: Vec<usize>,
    /// The output of each column of the table.
    pub columns: Vec<usize>,
    /// -1 where the goal is to be large: searches make its opposite small.
    pub sign: f64,
    /// In words, and its unit.
    pub goal: (String, String),
    limits: Vec<Bounded>,
}

/// What is said of a limit, which is the condition of the same number in the problem.
#[derive(Debug)]
struct Bounded {
    text: String,
    unit: String,
    bound: f64,
}

impl OptimizeRequest {
    /// The variables that have to be among the outputs of the experiment.
    pub fn variables(&self) -> Vec<String> {
        if self.turn.is_some() { Vec::new() } else { self.measured() }
    }

    fn measured(&self) -> Vec<String> {
        let goals = self.goal().into_iter().chain(self.limits.iter().map(|limit| &limit.goal));
        let measured = goals.flat_map(|goal| goal.terms.iter().map(|(_, measure)| measure.variable.clone()));
        let matched = self.table().into_iter().flat_map(|table| table.names().iter().cloned());
        let mut names: Vec<String> = Vec::new();
        for name in measured.chain(matched) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    pub(super) fn table(&self) -> Option<&CsvTable> {
        match &self.aim {
            Aim::Match(table) => Some(table),
            Aim::Least(_) | Aim::Most(_) => None,
        }
    }

    fn goal(&self) -> Option<&Goal> {
        match &self.aim {
            Aim::Least(goal) | Aim::Most(goal) => Some(goal),
            Aim::Match(_) => None,
        }
    }

    /// Everything that is wrong is said.
    pub(super) fn checked(
        &self,
        varying: &Varying,
        known: &[(String, Unit)],
        experiment: Experiment,
    ) -> Result<Checked, Vec<RequestFault>> {
        let mut faults = Vec::new();
        let parameters = varying.parameters();
        let bounds = bounds(&self.vary, parameters, &mut faults);
        let ranges = self.ranges(&bounds, parameters, &mut faults);
        self.check_size(&mut faults);
        let (mut outputs, columns) = (Vec::new(), self.columns(varying, experiment, &mut faults));
        let mut sum = |goal: &Goal, faults: &mut Vec<RequestFault>| {
            let term = |(_, measure): &(f64, cotree::run::Measure)| {
                let Some(place) = known.iter().position(|(output, _)| *output == measure.variable) else {
                    let what = if self.turn.is_some() { "figures of the turn" } else { "outputs" };
                    let known = suggest::known(&measure.variable, known.iter().map(|(output, _)| output.as_str()));
                    faults.push(RequestFault(format!(
                        "`{name}` is not among the {what}; {known}",
                        name = measure.variable
                    )));
                    return 0;
                };
                outputs.iter().position(|output| *output == place).unwrap_or_else(|| {
                    outputs.push(place);
                    outputs.len() - 1
                })
            };
            GoalSum { goal: goal.clone(), places: goal.terms.iter().map(term).collect() }
        };
        let sign = if matches!(self.aim, Aim::Most(_)) { -1.0 } else { 1.0 };
        let goal = self.goal().map(|goal| match sign < 0.0 {
            true => sum(&goal.clone().negative(), &mut faults),
            false => sum(goal, &mut faults),
        });
        let (mut conditions, mut limits) = (Vec::new(), Vec::new());
        for limit in &self.limits {
            let sum = sum(&limit.goal, &mut faults);
            match bounded(limit, sum, known) {
                Ok((bounded, condition)) => {
                    limits.push(bounded);
                    conditions.push(condition);
                }
                Err(cause) => faults.push(RequestFault(format!("`{limit}`: {cause}"))),
            }
        }
        if !faults.is_empty() {
            faults.dedup();
            return Err(faults);
        }
        let start = parameters.iter().map(|parameter| parameter.start).collect();
        let goal_named = self.named(known, &columns);
        let problem = Problem { goal, limits: conditions, bounds, ranges };
        Ok(Checked { problem, start, outputs, columns, sign, goal: goal_named, limits })
    }

    /// How much of each quantity is much.
    fn ranges(&self, bounds: &[[f64; 2]], parameters: &[VariedQuantity], faults: &mut Vec<RequestFault>) -> Vec<f64> {
        let is_open = |[low, high]: &[f64; 2]| !low.is_finite() || !high.is_finite();
        let open = bounds
            .iter()
            .zip(parameters)
            .filter(|(parameter_bound, _)| is_open(parameter_bound))
            .map(|(_, parameter_bound)| &parameter_bound.name);
        let open = suggest::list(open);
        if !open.is_empty() && self.starts > 1 {
            faults.push(RequestFault(format!("{names}: several starts need bounds: write NAME=LOW..HIGH, or search from the scene's values only (1 start)", names = open)));
        }
        let range = |(parameter_bound @ [low, high], parameter): (&[f64; 2], &VariedQuantity)| match (
            is_open(parameter_bound),
            parameter.start.abs(),
        ) {
            (false, _) => high - low,
            (true, 0.0) => 1.0,
            (true, size) => size,
        };
        bounds.iter().zip(parameters).map(range).collect()
    }

    fn check_size(&self, faults: &mut Vec<RequestFault>) {
        if !(1..=MOST_STARTS).contains(&self.starts) {
            faults.push(RequestFault(format!(
                "{starts} starts, but must be 1 to {most}",
                starts = self.starts,
                most = MOST_STARTS
            )));
        }
        if self.vary.len() > MOST_QUANTITIES {
            faults.push(RequestFault(format!(
                "{count} quantities are varied, but at most {most} can be",
                count = self.vary.len(),
                most = MOST_QUANTITIES
            )));
        }
    }

    fn columns(&self, varying: &Varying, experiment: Experiment, faults: &mut Vec<RequestFault>) -> Vec<usize> {
        let Some(table) = self.table() else { return Vec::new() };
        let columns = places(table, varying, faults);
        check_times(table, experiment, faults);
        let units: Vec<&str> =
            columns.iter().filter_map(|&place| varying.outputs().nth(place)).map(|(_, unit)| &*unit.si).collect();
        if let Some(other) = units.iter().find(|unit| **unit != units[0]) {
            faults.push(RequestFault(format!(
                "columns in `{}` and in `{other}` have no common sum of squares: use `fit`, which weighs them",
                units[0]
            )));
        }
        columns
    }

    /// The goal in words, and its unit.
    fn named(&self, known: &[(String, Unit)], columns: &[usize]) -> (String, String) {
        match &self.aim {
            Aim::Least(goal) | Aim::Most(goal) => {
                (goal.to_string(), common_unit(goal, known).map(|unit| unit.si).unwrap_or_default())
            }
            Aim::Match(_) => {
                let unit = columns.first().and_then(|&place| known.get(place)).map_or("", |(_, unit)| &unit.si);
                let squared = if unit.is_empty() { String::new() } else { format!("({unit})2") };
                ("sum of squares".to_owned(), if unit == "m" { "m2".to_owned() } else { squared })
            }
        }
    }
}

/// The unit of all measures of a sum, if it is one.
fn common_unit(goal: &Goal, known: &[(String, Unit)]) -> Result<Unit, LimitError> {
    let unit_of = |name: &str| known.iter().find(|(output, _)| output == name).map(|(_, unit)| unit.clone());
    let mut units = goal.terms.iter().filter_map(|(_, measure)| unit_of(&measure.variable));
    let first = units.next().unwrap_or_default();
    match units.find(|other| other.si != first.si) {
        Some(other) => Err(LimitError(format!("measures in `{}` and in `{}` cannot be added", first.si, other.si))),
        None => Ok(first),
    }
}

/// A limit as a condition of the problem.
fn bounded(
    limit: &MeasureLimit,
    sum: GoalSum,
    known: &[(String, Unit)],
) -> Result<(Bounded, GoalCondition), LimitError> {
    let unit = common_unit(&limit.goal, known)?;
    let bound = quantity(&limit.bound, &unit)?;
    if !bound.is_finite() {
        return Err(LimitError("the number must be finite".to_owned()));
    }
    let (sign, is_equation) = match limit.relation {
        Relation::AtMost => (1.0, false),
        Relation::AtLeast => (-1.0, false),
        Relation::Equal => (1.0, true),
    };
    let scale = if bound == 0.0 { 1.0 } else { bound.abs() };
    let condition = GoalCondition { sum, sign, bound: sign * bound, is_equation, scale };
    Ok((Bounded { text: limit.to_string(), unit: unit.si, bound }, condition))
}

impl Checked {
    /// The limits where a search ended.
    pub fn limits_at<T>(&self, found: &EndPoint<T>, seen: &SeenCourses) -> Vec<LimitAt> {
        let conditions = self.problem.limits.iter().zip(&found.multipliers);
        let at = |(limit, (condition, multiplier)): (&Bounded, (&GoalCondition, &f64))| {
            let is_active = condition.is_equation || multiplier * condition.scale > ACTIVE * found.goal.abs();
            LimitAt {
                text: limit.text.clone(),
                unit: limit.unit.clone(),
                bound: limit.bound,
                value: condition.sum.of(seen).unwrap_or(f64::NAN),
                multiplier: is_active.then_some(-self.sign * condition.sign * multiplier),
            }
        };
        self.limits.iter().zip(conditions).map(at).collect()
    }

    /// That no values meet the limits, and which the nearest ones miss.
    pub fn nearest<T>(&self, found: &EndPoint<T>, varying: &Varying) -> OptimizeError {
        let values = varying.parameters().iter().zip(&found.values);
        let values =
            values.map(|(parameter, value)| format!("{} = {} {}", parameter.name, short(*value), parameter.unit.si));
        let missed = |(limit, (condition, by)): (&Bounded, (&GoalCondition, &f64))| {
            let text = || format!("`{}` by {} {}", limit.text, short(by * condition.scale), limit.unit);
            (*by > MET).then(|| text().trim_end().to_owned())
        };
        let conditions = self.problem.limits.iter().zip(&found.beyond);
        let missed: Vec<String> = self.limits.iter().zip(conditions).filter_map(missed).collect();
        let nearest = values.map(|value| value.trim_end().to_owned()).collect::<Vec<_>>().join(", ");
        OptimizeError::Unmet { nearest, missed: missed.join(", ") }
    }
}
