//! Why a mechanism cannot be assembled, in the words of its scene.

use std::collections::BTreeSet;

use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::failure::Failure;
use cotree_fmu::failure::LoopGap;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::{Condition, Program};
use nalgebra::{DMatrix, DVector};

use super::suspect::{rivals, suspect};
use crate::diagnostic::suggest::list;
use crate::diagnostic::{Fault, Span};
use crate::equations::{Constraint, CoupledChord, Equations};
use crate::expr::Symbol;
use crate::model::{Mechanism, Part};
use crate::network::{Constrained, ElementId, Origin, SignedRow, Topology};
use crate::redundancy::matrices::jacobian;
use crate::typeset::rounded;

/// The fault behind a failure of the first assembly.
pub fn explain(equations: &mut Equations, model: &Model, failure: &Failure, length: f64) -> Fault {
    match failure {
        Failure::LoopsOpen { gap } | Failure::NotImplied { gap, .. } => open_loop(equations, gap, length),
        Failure::LockUp { time, gap } => locked(equations, *time, gap),
        Failure::Contradiction { conditions, velocity, .. } => contradiction(equations, model, conditions, *velocity),
        Failure::OtherBranch { condition: name, guess, found, angular } => {
            let kind = CoordinateKind { angular: *angular, rate: false };
            let message = format!(
                "the loops close in another assembly mode than guessed: the guess of `{name}` is {}, but it becomes {}",
                kind.show(*guess),
                kind.show(*found)
            );
            Fault::new("assembly::other_branch", message, condition_span(equations, name)).label("the guess").help(
                "give a closer guess, or guesses of more coordinates; `cotree assemblies` lists the assembly modes",
            )
        }
        Failure::Redundant { gap, .. } | Failure::Drift { gap, .. } | Failure::DriverJumps { gap, .. } => {
            Fault::new("assembly::conflict", failure.to_string(), owner_span(equations, &gap.owner))
                .label("contradicts the others")
        }
        Failure::Undecided { joints, .. }
        | Failure::EndOfReach { joints, .. }
        | Failure::DriverTurnsBack { joints, .. }
        | Failure::NotPassed { joints, .. }
        | Failure::BranchLost { joints, .. }
        | Failure::SingularAhead { joints, .. }
        | Failure::ChoiceDependent { joints, .. }
        | Failure::Undetermined { joints, .. } => {
            let span = joints.first().map_or_else(Span::default, |joint| owner_span(equations, joint));
            Fault::new("assembly::singular", failure.to_string(), span)
                .label("depends on the others in this configuration")
        }
        Failure::DriverUndefined { owner, .. } => {
            Fault::new("assembly::not_finite", failure.to_string(), owner_span(equations, owner)).label("not a number")
        }
        Failure::WayEnds
        | Failure::Contact { .. }
        | Failure::Beside { .. }
        | Failure::Beyond { .. }
        | Failure::NotFinite { .. }
        | Failure::NoValue { .. }
        | Failure::OutOfRange { .. }
        | Failure::StepUnderflow { .. }
        | Failure::TooManySteps { .. }
        | Failure::TooMuchWork { .. }
        | Failure::EventJumps { .. }
        | Failure::OutOfTime { .. }
        | Failure::Interrupted { .. }
        | Failure::Boundless { .. }
        | Failure::SlidingMode { .. } => Fault::new("assembly::not_finite", failure.to_string(), Span::default()),
    }
}

/// A loop whose equations are not numbers: what is prescribed is none, or a law of positions.
fn without_value(equations: &Equations, gap: &LoopGap) -> Fault {
    let drivers = drivers(equations);
    let span =
        drivers.first().map_or_else(|| owner_span(equations, &gap.owner), |driver| owner_span(equations, driver));
    let message = format!("the loop equation of `{}` is not finite at the start", gap.owner);
    let what =
        if drivers.is_empty() { "its laws".to_owned() } else { format!("the prescribed motion ({})", list(&drivers)) };
    let help =
        format!("check {what} for a division by zero, a root or logarithm of a negative number, or a number too large");
    Fault::new("assembly::not_finite", message, span).label("not a number").help(help)
}

/// Prescribed motions that begin with no finite rate.
pub(crate) fn without_rate(mechanism: &Mechanism) -> Vec<Fault> {
    let time = mechanism.experiment.start;
    let fault = |part: &Part| {
        let message = format!("the law of driver `{}` has no finite rate at t = {time} s", part.name);
        let help = "the derivative of a root, or of a power below 1, is infinite where its argument is zero: start away from that point, or write the law without it";
        Fault::new("assembly::not_finite", message, part.span).label("its derivative is not a number").help(help)
    };
    crate::laws::without_rate(mechanism, time).map(fault).collect()
}

fn open_loop(equations: &Equations, gap: &LoopGap, length: f64) -> Fault {
    if !gap.size.is_finite() {
        return without_value(equations, gap);
    }
    let missing = show(gap.size, gap.angular);
    let message = format!("the loops cannot be closed: the smallest gap is {missing} at `{}`", gap.owner);
    if let Some(suspect) = suspect(equations, length) {
        return suspect.fault("assembly::open_loop", &message);
    }
    if let Some(fault) = rivals(equations, length, &format!("the smallest gap is {missing} at `{}`", gap.owner)) {
        return fault;
    }
    let mut others = loop_of(equations, gap);
    others.retain(|name| !drivers(equations).contains(name));
    let check = match drivers(equations).as_slice() {
        [] => "check the lengths".to_string(),
        drivers => format!("check the lengths and the prescribed motion ({})", list(drivers)),
    };
    let within = if others.is_empty() { String::new() } else { format!(" of its loop with {}", list(&others)) };
    Fault::new("assembly::open_loop", message, owner_span(equations, &gap.owner))
        .label("is not closed")
        .help(format!("{check}{within}, or give a better guess of the initial configuration"))
}

fn locked(equations: &Equations, time: f64, gap: &LoopGap) -> Fault {
    let speed = CoordinateKind { angular: gap.angular, rate: true }.show(gap.size);
    let drivers = drivers(equations);
    let message = format!(
        "the mechanism cannot follow {}: at t = {time} s the gap at `{}` grows at {speed}",
        list(&drivers),
        gap.owner
    );
    Fault::new("assembly::conflict", message, owner_span(equations, &gap.owner)).label("the gap would grow").help(
        "this loop is overconstrained by its joints or by another driver: remove a driver, or a joint of this loop",
    )
}

fn contradiction(equations: &mut Equations, model: &Model, names: &[String], velocity: bool) -> Fault {
    let (level, contradict) = match (velocity, names.len()) {
        (true, 1) => ("velocity", "contradicts"),
        (true, _) => ("velocities", "contradict"),
        (false, 1) => ("position", "contradicts"),
        (false, _) => ("positions", "contradict"),
    };
    let spans: Vec<Span> = names.iter().map(|name| condition_span(equations, name)).collect();
    let (causes, several) = causes(equations, model, names, velocity);
    let make = if several { "make" } else { "makes" };
    let needed = names.last().and_then(|name| Some((name, needed(model, name, velocity)?)));
    let is_free = needed.as_ref().is_some_and(|(_, needed)| needed.is_free);
    let message = match needed {
        Some((name, Needed { given, found, is_free: true })) => {
            let leave = if several { "leave" } else { "leaves" };
            format!(
                "no configuration was found with `{name}` = {given}: {causes} {leave} it free, and {found} is possible"
            )
        }
        Some((name, Needed { given, found, .. })) => {
            format!("`{name}` is {given} in `[initial]`, but {causes} {make} it {found}")
        }
        None => format!("the initial {level} {} {contradict} {causes}", list(names)),
    };
    let help = match names {
        [name] if is_free => format!("give `{name}` a value closer to that, make it a guess, or guess other positions"),
        [name] => format!("remove `{name}` from `[initial]`, or make it a guess"),
        _ => format!("remove one of {}, or make it a guess", list(names)),
    };
    let last = spans.last().copied().unwrap_or_default();
    let mut also: Vec<Span> = spans.iter().rev().skip(1).rev().copied().collect();
    also.extend(equations.system.mechanism.drivers.iter().map(|driver| driver.span));
    let fault = Fault::new("assembly::contradiction", message, last).label("contradicts the others");
    Fault { also, ..fault.help(help) }
}

/// What an initial value contradicts, as the subject of a sentence: drivers, loops, other initial values. Also whether that is a plural.
fn causes(equations: &mut Equations, model: &Model, names: &[String], velocity: bool) -> (String, bool) {
    let drivers = drivers(equations);
    let mut causes = Vec::new();
    if !drivers.is_empty() {
        let word = if drivers.len() == 1 { "driver" } else { "drivers" };
        causes.push(format!("the {word} {}", list(&drivers)));
    }
    let driven_alone = !drivers.is_empty() && names.iter().all(|name| is_prescribed(equations, name));
    if !driven_alone {
        if !model.program().constraints.is_empty() {
            causes.push("the loops".to_string());
        }
        let known = conditions(model.program(), velocity).iter().filter(|condition| condition.known);
        if known.count() > 1 || causes.is_empty() {
            causes.push(format!("the other initial {}", if velocity { "velocities" } else { "positions" }));
        }
    }
    (causes.join(" and "), !driven_alone || drivers.len() > 1)
}

/// Is a variable given by drivers alone, without any coordinate?
fn is_prescribed(equations: &mut Equations, name: &str) -> bool {
    let mechanism = &equations.system.mechanism;
    let variable = mechanism.initial.iter().map(|initial| initial.variable);
    let Some(variable) = variable.into_iter().find(|variable| mechanism.variable_name(*variable) == name) else {
        return false;
    };
    let value = equations.variable(variable);
    !equations.system.arena.symbols([value]).iter().any(|symbol| matches!(symbol, Symbol::Coordinate(..)))
}

/// What stands against the value of a condition.
struct Needed {
    /// The value in the scene, and one that everything else permits.
    given: String,
    found: String,
    /// Does everything else permit others too?
    is_free: bool,
}

/// The value of a condition without which everything else can be.
fn needed(model: &Model, name: &str, velocity: bool) -> Option<Needed> {
    let mut program = model.program().clone();
    let index = conditions(&program, velocity).iter().position(|condition| condition.name == name)?;
    let list = if velocity { &mut program.initial.velocities } else { &mut program.initial.positions };
    list[index].known = false;
    if !velocity {
        program.initial.velocities.iter_mut().for_each(|condition| condition.known = false);
    }
    let free = Model::of_positions(program).ok()?;
    let mut state = free.default_state(free.program().experiment.start);
    solve_initial(&free, &mut state).ok()?;
    let mut machine = Machine::new(&free);
    machine.load(&free, &state);
    let initial = &free.program().initial;
    let tape = if velocity { &initial.velocity } else { &initial.position };
    machine.run(tape);
    let list = conditions(free.program(), velocity);
    let kind = CoordinateKind { angular: list[index].angular, rate: velocity };
    let [given, found] = [index + list.len(), index].map(|result| kind.show(machine.result(tape, result)));
    // Velocities are linear: what they contradict determines them.
    let is_free = !velocity && is_free(&free, &state, &mut machine, index);
    Some(Needed { given, found, is_free })
}

/// Can the value of a condition on positions change where the loops and the known conditions hold?
fn is_free(model: &Model, state: &State, machine: &mut Machine, index: usize) -> bool {
    /// Less than this share of its gradient is a rounding error.
    const SHARE: f64 = 1e-6;
    let initial = &model.program().initial;
    let loops = jacobian(model, state);
    let columns = loops.ncols();
    let mut jacobian_rows = vec![DVector::zeros(columns); initial.positions.len()];
    let tape = &initial.position_jacobian;
    machine.run(&tape.tape);
    for (&(row, column), value) in tape.entries.iter().zip(tape.tape.results(machine.registers())) {
        // Inputs that are integrated are given.
        if (column as usize) < columns {
            jacobian_rows[row as usize][column as usize] += value;
        }
    }
    let known =
        (0..jacobian_rows.len()).filter(|&row| initial.positions[row].known).map(|row| jacobian_rows[row].transpose());
    let rows: Vec<_> = loops.row_iter().map(|row| row.into_owned()).chain(known).collect();
    let scales = DVector::from_iterator(columns, model.program().coordinates.iter().map(|coordinate| coordinate.scale));
    let mut gradient = jacobian_rows[index].component_mul(&scales);
    let whole = gradient.norm();
    // A mechanism that drivers alone move has no coordinate that could change it.
    if whole == 0.0 {
        return false;
    }
    if !rows.is_empty() {
        let held = DMatrix::from_fn(rows.len(), columns, |row, column| rows[row][column] * scales[column]).transpose();
        let directions = held.svd(true, false);
        let limit = SHARE * directions.singular_values.max();
        let Some(u) = &directions.u else { return false };
        for (direction, _) in u.column_iter().zip(&directions.singular_values).filter(|(_, size)| **size > limit) {
            let part = direction.dot(&gradient);
            gradient.axpy(-part, &direction, 1.0);
        }
    }
    gradient.norm() > SHARE * whole
}

fn conditions(program: &Program, velocity: bool) -> &[Condition] {
    if velocity { &program.initial.velocities } else { &program.initial.positions }
}

/// Names of the branches that close the loop of a chord, arms left out.
pub fn circuit_names(equations: &Equations, constraint: &Constraint) -> Vec<String> {
    let (system, trees) = (&equations.system, &equations.trees);
    let translation = Topology::new(&system.translation, &trees.translation);
    let rotation = Topology::new(&system.rotation, &trees.rotation);
    let coupled = constraint.coupled.iter().flat_map(|chord| match chord {
        CoupledChord::Force(ends, ..) => translation.circuit_between(*ends),
        CoupledChord::Torque(ends, _) => rotation.circuit_between(*ends),
    });
    let row: SignedRow = match constraint.constrained {
        _ if !constraint.coupled.is_empty() => coupled.collect(),
        Constrained::Angle => rotation.circuit(constraint.element),
        Constrained::Along(_) | Constrained::Length => translation.circuit(constraint.element),
    };
    // Arms and axes of the circuit turn as the rotational tree says.
    let carriers = row.iter().filter_map(|(element, _)| system.element(*element).translation.as_ref()?.carrier());
    let ground = system.r_node(None);
    let turned: Vec<_> =
        carriers.flat_map(|body| rotation.circuit_between([ground, system.r_node(Some(body))])).collect();
    let turned = turned.into_iter().filter(|(element, _)| !matches!(system.element(*element).origin, Origin::Body(_)));
    let named = row.into_iter().chain(turned).map(|(element, _)| system.element(element));
    let mut names: Vec<String> = named
        .filter(|element| !matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_)))
        .map(|element| element.name.clone())
        .collect();
    let mut seen = BTreeSet::new();
    names.retain(|name| seen.insert(name.clone()));
    names
}

pub fn span_of(equations: &Equations, element: ElementId) -> Span {
    equations.system.span(element)
}

fn loop_of(equations: &Equations, gap: &LoopGap) -> Vec<String> {
    let is_owner = |row: &&Constraint| {
        equations.system.element(row.element).name == gap.owner
            && (row.constrained == Constrained::Angle) == gap.angular
    };
    equations.constraints.iter().find(is_owner).map_or_else(Vec::new, |row| circuit_names(equations, row))
}

pub fn owner_span(equations: &Equations, name: &str) -> Span {
    let element = equations.system.elements.iter().position(|element| element.name == name);
    element.map_or_else(Span::default, |index| span_of(equations, ElementId(index)))
}

fn condition_span(equations: &Equations, name: &str) -> Span {
    let mechanism = &equations.system.mechanism;
    let initial = mechanism.initial.iter().find(|initial| mechanism.variable_name(initial.variable) == name);
    initial.map_or_else(Span::default, |initial| initial.span)
}

fn drivers(equations: &Equations) -> Vec<String> {
    equations.system.mechanism.drivers.iter().map(|driver| driver.name.clone()).collect()
}

/// A gap in millimetres or degrees, without its sign.
pub fn show(size: f64, angular: bool) -> String {
    CoordinateKind { angular, rate: false }.show(size.abs())
}

#[derive(Clone, Copy)]
struct CoordinateKind {
    angular: bool,
    rate: bool,
}

impl CoordinateKind {
    /// In the units in which people think of mechanisms, with four digits.
    fn show(self, value: f64) -> String {
        let (value, unit) = match (self.angular, self.rate) {
            (true, false) => (value.to_degrees(), "deg"),
            (true, true) => (value, "rad/s"),
            (false, false) => (1e3 * value, "mm"),
            (false, true) => (1e3 * value, "mm/s"),
        };
        format!("{} {unit}", rounded(value, 4))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let length = CoordinateKind { angular: false, rate: false };
        for (value, shown) in
            [(0.4, "400 mm"), (0.0128912, "12.89 mm"), (-1.5, "-1500 mm"), (2e-7, "0.0002 mm"), (0.0, "0 mm")]
        {
            assert_eq!(length.show(value), shown);
        }
        assert_eq!(CoordinateKind { angular: true, rate: false }.show(std::f64::consts::FRAC_PI_3), "60 deg");
        assert_eq!(CoordinateKind { angular: true, rate: true }.show(1.23456), "1.235 rad/s");
    }
}
