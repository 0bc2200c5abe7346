//! From a mechanism to its equations and its program: formulate, assemble, find the redundant loop equations, lower.

pub mod assemblies;
mod contacts;
mod contradiction;
mod courses;
mod engaging;
pub mod explain;
mod feedback;
mod impulses;
mod profiles;
mod restrictions;
pub mod start;

use std::collections::BTreeSet;
use std::sync::Arc;

use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::{Initial, Role};

use self::explain::size;
use crate::diagnostic::suggest::{self, list};
use crate::diagnostic::{Fault, Span};
use crate::equations::{Constraint, Equations, Standing};
use crate::expr::{Expr, Order, Property, Symbol};
use crate::formulate::explain::assembly::{circuit_names, explain, show, span_of, without_rate};
use crate::formulate::explain::suspect::suspect;
use crate::formulate::restrictions::{Restrictions, judge, restrictions};
use crate::formulate::start::Start;
use crate::laws::Jump;
use crate::model::{BodyId, CoordinateChoice, Formula, Mechanism, Output, Owner, Variable};
use crate::network::{Constrained, ElementId, Origin, System, Trees};
use crate::program::Lowered;
use crate::scene::constant;
use crate::solve::{Obstacle, Shared};

/// A mechanism with its equations, assembled at its initial state and lowered.
#[derive(Clone, Debug)]
pub struct Formulated {
    pub equations: Equations,
    /// What is asked of the mechanism.
    pub outputs: Vec<Output>,
    pub lowered: Lowered,
    /// The consistent initial state at default parameters and inputs.
    pub state: State,
    pub redundant: Vec<usize>,
    pub warnings: Vec<Fault>,
}

impl Formulated {
    pub fn mobility(&self) -> usize {
        let independent = self.equations.rows_of(Standing::Imposed).len();
        self.equations.coordinates.len().saturating_sub(independent)
    }

    /// The same equations and program for a mechanism that differs in values only, begun where these values let it begin. None where the program cannot be given them: other initial values are numbers, loops do not close,
    /// or what joints hold in second order only was found for the former values. Which loop equations count is not asked again.
    pub fn with_values(&self, mechanism: Mechanism) -> Option<Formulated> {
        if !self.equations.system.implied.is_empty() {
            return None;
        }
        let mut copy = self.clone();
        let Formulated { equations, lowered, .. } = &mut copy;
        equations.system.mechanism = Arc::new(mechanism);
        let length = typical_length(equations);
        if !lowered.set_values(equations, length) || !check_trivial(equations, length).is_empty() {
            return None;
        }
        let start = own_start(equations, length);
        begin(equations, start.as_ref(), &mut lowered.program.initial);
        let model = Model::new(lowered.program.clone()).ok()?;
        let mut state = model.default_state(lowered.program.experiment.start);
        solve_initial(&model, &mut state).ok()?;
        keep_found(&state, &mut lowered.program.initial);
        courses::begin(equations, &mut state);
        copy.state = state;
        Some(copy)
    }
}

/// Formulates, assembles and lowers, with these outputs.
///
/// # Errors
/// Wrong trees, contradictions, loops that cannot be closed, masses that are missing where motion needs them.
pub fn formulate(mechanism: &Mechanism, outputs: &[Output]) -> Result<Formulated, Vec<Fault>> {
    formulate_with(equations(mechanism, &mechanism.coordinates)?, outputs)
}

/// As [`formulate`], for printed equations.
///
/// # Errors
/// As there, or equations that are too large to be written.
pub fn formulate_written(mechanism: &Mechanism, outputs: &[Output]) -> Result<Formulated, Vec<Fault>> {
    let formulated = formulate(mechanism, outputs)?;
    size::check_written(&formulated.equations)?;
    Ok(formulated)
}

/// As [`formulate`], for trees that are chosen already. What `[initial]` leaves open begins at the start, or where it is in the recommended trees.
/// Drivers of the recommended trees whose rates jump are loop equations instead, where that is possible: then the jumps have impulses.
///
/// # Errors
/// Contradictions, loops that cannot be closed, masses that are missing where motion needs them.
pub fn formulate_with(equations: Equations, outputs: &[Output]) -> Result<Formulated, Vec<Fault>> {
    let jumps = crate::laws::jumps(&equations.system.mechanism);
    match with_impulses(&equations, outputs, &jumps) {
        Some(formulated) => Ok(formulated),
        None => assemble(equations, &jumps)?.lower(outputs, &jumps),
    }
}

/// With loop equations for the drivers whose rates jump; none if drivers move everything, if what these drive has no mass for an impulse to act on, or if that would be too large.
fn with_impulses(equations: &Equations, outputs: &[Output], jumps: &[Jump]) -> Option<Formulated> {
    let trees = impulses::trees(equations, jumps)?;
    size::check(&equations.system, &trees).ok()?;
    let assembled = assemble(Equations::new(System::new(&equations.system.mechanism), trees), jumps).ok()?;
    if assembled.equations.is_driven() {
        return None;
    }
    assembled.lower(outputs, jumps).ok()
}

/// A mechanism with its loop equations, at its initial state.
struct Assembled {
    equations: Equations,
    length: f64,
    start: Option<Start>,
    state: State,
    /// Where the loops are closed and nothing is special.
    generic: State,
    /// Loops that do not close, and what is wrong beside that.
    faults: Vec<Fault>,
}

/// Closes the loops and finds which of their equations count.
fn assemble(mut equations: Equations, jumps: &[Jump]) -> Result<Assembled, Vec<Fault>> {
    let length = typical_length(&mut equations);
    let unmoved = contacts::check_moved(&equations);
    if !unmoved.is_empty() {
        return Err(unmoved);
    }
    let mut faults = check_trivial(&mut equations, length);
    faults.extend(without_rate(&equations.system.mechanism));
    let start = own_start(&equations, length);
    let (model, state) = first_state(&mut equations, length, start.as_ref(), &mut faults)?;
    let found = match faults.is_empty() {
        true => restrictions(equations, (model, state), length, start.as_ref())?,
        false => unclosed(equations, (model, state)),
    };
    if faults.is_empty() {
        faults.extend(contradiction::contradiction(&found));
    }
    let Restrictions { mut equations, model, mut state, generic } = found;
    courses::begin(&mut equations, &mut state);
    if faults.is_empty() {
        faults.extend(courses::check(&mut equations, &state));
    }
    if faults.is_empty() {
        faults.extend(engaging::check(&equations));
        if !faults.is_empty() {
            return Err(faults);
        }
        if let Some(mechanism) = engaging::without_repeated(&mut equations, &model, &state) {
            return assemble(Equations::new(System::new(&mechanism), equations.trees), jumps);
        }
        let driven = equations.is_driven();
        faults.extend(contacts::check_contacts(&mut equations, &state, length, driven));
        faults.extend(profiles::check_profiles(&mut equations, &state, length));
        if !faults.is_empty() {
            return Err(faults);
        }
        // What rubs where drivers move it slides as they say, and never holds.
        equations.constraints.iter_mut().filter(|row| driven || row.is_trivial()).for_each(Constraint::set_driven);
        faults.extend(contacts::check_led(&mut equations));
        if !faults.is_empty() {
            return Err(faults);
        }
        faults.extend(feedback::check_acts(&equations, jumps));
        if !faults.is_empty() {
            return Err(faults);
        }
    }
    Ok(Assembled { equations, length, start, state, generic, faults })
}

impl Assembled {
    /// Solves the equations of motion and writes the program.
    fn lower(self, outputs: &[Output], jumps: &[Jump]) -> Result<Formulated, Vec<Fault>> {
        let Assembled { mut equations, length, start, state, generic, mut faults } = self;
        let rows = equations.constraints.iter().enumerate();
        let is_redundant = |row: &Constraint| !row.is_imposed() && row.is_loop();
        let redundant: Vec<usize> = rows.filter(|(_, row)| is_redundant(row)).map(|(index, _)| index).collect();
        let mut lowered = match crate::program::program(&mut equations, outputs, length, [&state, &generic]) {
            Ok(lowered) => lowered,
            // Where the loops do not close, this may have no other cause.
            Err(_) if !faults.is_empty() => return Err(faults),
            Err(obstacle) => return Err(vec![unsolvable(&mut equations, obstacle)]),
        };
        faults.extend(check_masses(&mut equations, &lowered, outputs));
        faults.extend(check_determined(&equations, &lowered.shared, outputs));
        faults.extend(feedback::check_determined(&equations, &lowered.shared));
        if !faults.is_empty() {
            return Err(faults);
        }
        begin(&mut equations, start.as_ref(), &mut lowered.program.initial);
        keep_found(&state, &mut lowered.program.initial);
        let program = &lowered.program;
        let chosen = program.constraints.iter().any(|row| row.role == Role::Repeating)
            || program.arms.as_ref().is_some_and(|form| form.repeating() > 0);
        let mut warnings: Vec<Fault> = redundancy_warning(&equations, &lowered.shared, chosen).into_iter().collect();
        warnings.extend(crate::laws::touches(&equations.system.mechanism));
        warnings.extend(engaging::warnings(&equations));
        if program.is_driven() {
            warnings.extend(impulses::leaps(&equations.system.mechanism, jumps));
        } else {
            warnings.extend(impulses::warnings(&equations, jumps));
            warnings.extend(feedback::warnings(&equations));
        }
        Ok(Formulated { equations, outputs: outputs.to_vec(), lowered, state, redundant, warnings })
    }
}

/// The equations for a choice of trees.
///
/// # Errors
/// The user's own trees are not spanning trees, or the equations would be too large.
pub fn equations(mechanism: &Mechanism, choice: &CoordinateChoice) -> Result<Equations, Vec<Fault>> {
    let system = System::new(mechanism);
    let trees = Trees::select(&system, choice)?;
    size::check(&system, &trees)?;
    Ok(Equations::new(system, trees))
}

/// The loops as a model, and where they close; that they do not is a fault, unless there are others already.
fn first_state(
    equations: &mut Equations,
    length: f64,
    start: Option<&Start>,
    faults: &mut Vec<Fault>,
) -> Result<(Model, State), Vec<Fault>> {
    let mechanism = &*equations.system.mechanism.clone();
    let mut draft = crate::program::positions(equations, length);
    begin(equations, start, &mut draft.initial);
    let model = Model::of_positions(draft).map_err(|fault| match faults.is_empty() {
        true => vec![internal(mechanism, &fault.to_string())],
        // What is not a number has its fault already.
        false => std::mem::take(faults),
    })?;
    let mut state = model.default_state(mechanism.experiment.start);
    if let Err(failure) = solve_initial(&model, &mut state)
        && faults.is_empty()
    {
        faults.push(explain(equations, &model, &failure, length));
    }
    Ok((model, state))
}

/// Where the first state is sought.
fn begin(equations: &mut Equations, start: Option<&Start>, initial: &mut Initial) {
    match start {
        Some(start) => start.begin(equations, initial),
        None => start::begin(equations, initial),
    }
}

/// The first state that was found.
fn keep_found(state: &State, initial: &mut Initial) {
    initial.found_positions = [state.positions(), state.follower_positions()].concat();
    initial.found_rates = [state.rates(), state.follower_rates()].concat();
}

/// Where no pose closes the loops: at least so many loop equations are needed to find missing masses.
fn unclosed(mut equations: Equations, (model, state): (Model, State)) -> Restrictions {
    let some: Vec<usize> = equations.loops().map(|(index, _)| index).take(equations.coordinates.len()).collect();
    judge(&mut equations, &some, &[]);
    let generic = state.clone();
    Restrictions { equations, model, state, generic }
}

/// Where the recommended trees start, for other trees.
fn own_start(equations: &Equations, length: f64) -> Option<Start> {
    let recommended = Trees::recommended(&equations.system);
    (equations.trees != recommended).then(|| Start::find(&equations.system.mechanism, length)).flatten()
}

/// The longest arm, for tolerances relative to the size of the mechanism; 1 m for masses without arms.
fn typical_length(equations: &mut Equations) -> f64 {
    let mechanism = &*equations.system.mechanism.clone();
    let points = mechanism.bodies.iter().flat_map(|body| &body.points).chain(&mechanism.ground);
    let components: Vec<&Formula> = points.flat_map(|point| &point.at).collect();
    let exprs: Vec<Expr> = components.into_iter().map(|formula| equations.system.value(formula)).collect();
    let values = equations.system.arena.evaluate(&exprs, &|symbol: Symbol| default_value(mechanism, symbol));
    let longest = values.chunks(2).map(|point| point.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max);
    if longest > 0.0 && longest.is_finite() { longest } else { 1.0 }
}

/// Values of symbols at the start of the experiment, without coordinates.
pub fn default_value(mechanism: &Mechanism, symbol: Symbol) -> f64 {
    match symbol {
        Symbol::Parameter(i) => mechanism.parameters.get(i).map_or(0.0, |parameter| parameter.value),
        Symbol::Discrete(i) => mechanism.discrete[i].start(),
        Symbol::Input(i, Order::Position) => mechanism.inputs[i].start,
        Symbol::Time => mechanism.experiment.start,
        Symbol::State(i, Order::Position) => {
            constant::evaluate(&mechanism.states[i].start, &mechanism.parameter_values())
        }
        Symbol::Input(..) | Symbol::Follower(..) | Symbol::Coordinate(..) | Symbol::State(..) => 0.0,
        Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => 0.0,
    }
}

/// Loop equations without coordinates must be satisfied: two drivers of the same angle must agree.
fn check_trivial(equations: &mut Equations, length: f64) -> Vec<Fault> {
    let experiment = equations.system.mechanism.experiment;
    let gaps = equations.gaps();
    let (equations, mechanism) = (&*equations, &equations.system.mechanism);
    let mut faults = Vec::new();
    for (constraint, gap) in
        equations.constraints.iter().zip(gaps).filter(|(row, _)| row.is_trivial() && row.followers.is_empty())
    {
        for share in [0.0, 0.137, 0.619, 1.0] {
            let time = experiment.start + share * (experiment.stop - experiment.start);
            let at = |symbol: Symbol| if symbol == Symbol::Time { time } else { default_value(mechanism, symbol) };
            let gap = equations.system.arena.evaluate(&[gap], &at)[0];
            if gap.abs() > 1e-9 {
                faults.push(conflict(equations, constraint, time, gap, length));
                break;
            }
        }
    }
    faults
}

fn conflict(equations: &Equations, constraint: &Constraint, time: f64, gap: f64, length: f64) -> Fault {
    let closing = &equations.system.element(constraint.element).name;
    let mut others = circuit_names(equations, constraint);
    others.retain(|name| name != closing);
    let amount = show(gap, constraint.constrained == Constrained::Angle);
    let mechanism = &equations.system.mechanism;
    let driven = mechanism.drivers.iter().any(|driver| driver.name == *closing || others.contains(&driver.name));
    let when = if driven { format!("at t = {time} s ") } else { String::new() };
    let message = format!("`{closing}` contradicts {}: {when}they differ by {amount}", list(&others));
    if let Some(suspect) = suspect(equations, length).filter(|suspect| suspect.name() != closing) {
        return suspect.fault("scene::conflict", &message);
    }
    let label = match driven {
        true => "prescribes a motion that is already prescribed",
        false => "constrains a motion that is already constrained",
    };
    Fault::new("scene::conflict", message, span_of(equations, constraint.element))
        .label(label)
        .help(format!("remove `{closing}` or one of the others, or make them agree"))
}

/// Masses that the kernels and the outputs need must be given.
fn check_masses(equations: &mut Equations, lowered: &Lowered, outputs: &[Output]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut said = BTreeSet::new();
    for missing in missing(equations, &lowered.solved) {
        said.insert(missing);
        faults.push(missing_mass(equations, missing, None));
    }
    let mechanism = equations.system.mechanism.clone();
    let of_outputs = outputs.iter().map(|output| (format!("the output `{}`", output.name), &output.value));
    for (user, value) in of_outputs.chain(mechanism.read_at_instants()) {
        for missing in missing_for(equations, value) {
            if said.insert(missing) {
                faults.push(missing_mass(equations, missing, Some(&user)));
            }
        }
    }
    faults
}

/// A missing mass or inertia that a value needs.
fn missing_for(equations: &mut Equations, value: &Formula) -> Vec<Symbol> {
    let value = equations.formula(value);
    let mut roots = vec![value];
    if equations.system.arena.symbols([value]).iter().any(|symbol| matches!(symbol, Symbol::Reaction(_))) {
        roots.extend(equations.dynamics().load.clone());
        roots.extend(equations.dynamics().mass.iter().flatten().map(|(_, entry)| *entry));
    }
    missing(equations, &roots)
}

/// An output that cannot be computed, because a body lacks a mass or an inertia.
pub struct LackingOutput<'o> {
    pub output: &'o Output,
    pub body: usize,
    pub property: Property,
}

/// The outputs that cannot be computed.
///
/// # Errors
/// There are no equations for this mechanism.
pub fn lacking<'o>(mechanism: &Mechanism, outputs: &'o [Output]) -> Result<Vec<LackingOutput<'o>>, Vec<Fault>> {
    let mut equations = equations(mechanism, &mechanism.coordinates)?;
    let missing = outputs.iter().filter_map(|output| match missing_for(&mut equations, &output.value).first() {
        Some(&Symbol::Missing(body, property)) => Some(LackingOutput { output, body, property }),
        None => None,
        Some(
            Symbol::Time
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Coordinate(..)
            | Symbol::State(..)
            | Symbol::Reaction(_)
            | Symbol::Argument,
        ) => None,
    });
    Ok(missing.collect())
}

fn missing(equations: &Equations, roots: &[Expr]) -> Vec<Symbol> {
    let mut symbols = equations.system.arena.symbols(roots.iter().copied());
    symbols.retain(|symbol| matches!(symbol, Symbol::Missing(..)));
    symbols
}

fn missing_mass(equations: &Equations, symbol: Symbol, user: Option<&str>) -> Fault {
    let mechanism = &equations.system.mechanism;
    let (body, key) = match symbol {
        Symbol::Missing(body, Property::Inertia) => (body, "inertia"),
        Symbol::Missing(body, Property::Mass) => (body, "mass"),
        Symbol::Time
        | Symbol::Parameter(_)
        | Symbol::Discrete(_)
        | Symbol::Input(..)
        | Symbol::Follower(..)
        | Symbol::Coordinate(..)
        | Symbol::State(..)
        | Symbol::Reaction(_)
        | Symbol::Argument => {
            return internal(mechanism, &format!("{symbol:?}"));
        }
    };
    let owner = &mechanism.bodies[body];
    let (why, label) = match user {
        Some(user) => (format!("{user} needs it"), "has no mass properties for it"),
        None => ("its motion is not prescribed".to_string(), "moves under forces"),
    };
    Fault::new("scene::missing_mass", format!("body `{}` has no `{key}`: {why}", owner.name), owner.span)
        .label(label)
        .help(format!("add `{key} = ...` to `[bodies.{}]`", owner.name))
}

fn unsolvable(equations: &mut Equations, obstacle: Obstacle) -> Fault {
    match obstacle {
        Obstacle::Undetermined(index) => massless(equations, index),
        Obstacle::TooLarge => size::too_connected(equations),
    }
}

fn massless(equations: &mut Equations, index: usize) -> Fault {
    let particles = particles(equations);
    if let Some((_, first)) = particles.iter().find(|(coordinate, _)| *coordinate == index) {
        return without_inertia(&equations.system.mechanism, *first, &particles);
    }
    let coordinate = &equations.coordinates[index];
    let element = equations.system.element(coordinate.element);
    Fault::new(
        "scene::massless",
        format!("the acceleration of `{}` is not determined: it moves no mass", coordinate.name.position),
        span_of(equations, coordinate.element),
    )
    .label("moves no mass")
    .help(format!(
        "give `{}` or the bodies that it moves a mass and an inertia, or constrain it by a joint or driver",
        element.name
    ))
}

/// Bodies with a mass and an inertia of zero that nothing turns, each with the coordinate that says how it is turned.
fn particles(equations: &mut Equations) -> Vec<(usize, BodyId)> {
    let mechanism = &*equations.system.mechanism.clone();
    let dynamics = equations.dynamics().clone();
    let nothing_turns = |&row: &usize| {
        let still = dynamics.load[row] == Expr::ZERO && dynamics.reactions[row].is_empty();
        still && dynamics.mass[row].iter().all(|(_, entry)| *entry == Expr::ZERO)
    };
    let is_particle = |body: &BodyId| {
        let body = &mechanism.bodies[body.0];
        body.inertia == Some(Formula::Number(0.0))
            && body.mass.as_ref().is_some_and(|mass| *mass != Formula::Number(0.0))
    };
    let body = |index: usize| {
        let coordinate = &equations.coordinates[index];
        let bodies: Vec<BodyId> = match equations.system.element(coordinate.element).origin {
            _ if !coordinate.angular => Vec::new(),
            Origin::Body(body) => vec![body],
            Origin::Joint(joint) => mechanism.joints[joint.0].bodies().into_iter().flatten().collect(),
            _ => Vec::new(),
        };
        Some((index, bodies.into_iter().find(is_particle)?))
    };
    (0..equations.coordinates.len()).filter(nothing_turns).filter_map(body).collect()
}

fn without_inertia(mechanism: &Mechanism, first: BodyId, particles: &[(usize, BodyId)]) -> Fault {
    let names = suggest::list(particles.iter().map(|(_, body)| mechanism.bodies[body.0].name.as_str()));
    let what = if particles.len() == 1 { "its inertia is" } else { "their inertias are" };
    Fault::new(
        "scene::massless",
        format!("no joint or load turns {names}, and {what} zero: the angular acceleration is not determined"),
        mechanism.bodies[first.0].span,
    )
    .label("has no inertia")
    .help("give any positive inertia, such as `inertia = 1`: the other motions do not depend on it")
}

/// What is to be known where the loop equations that are left out are the same in every pose.
const FIXED: &str = "; here the same redundant loop equations are left out in every configuration, and a run may lose accuracy or end where the others become dependent: compare two tolerances";

/// Which joints and drivers share their loads with others, whatever the trees. `chosen`: independent loop equations are chosen in every pose.
fn redundancy_warning(equations: &Equations, shared: &Shared, chosen: bool) -> Option<Fault> {
    if !equations.system.implied.is_empty() {
        return Some(implied_warning(equations, shared));
    }
    let (first, names) = named(equations, &shared.owners)?;
    let message = format!(
        "overconstrained: {} have redundant constraints, so their loads are not unique (statically indeterminate)",
        list(&names)
    );
    let fault = Fault::warning("scene::redundant", message, span_of(equations, first))
        .label("part of this constraint is redundant")
        .help(format!(
            "the motion is unique; of the possible loads those of least norm are reported: the least sum of squares of their forces, and of their torques divided by the longest arm{}",
            if chosen { "" } else { FIXED }
        ));
    Some(fault)
}

/// What joints hold in second order only.
fn implied_warning(equations: &Equations, shared: &Shared) -> Fault {
    let relations: Vec<String> = equations.system.implied.iter().map(|relation| relation.name.clone()).collect();
    let owners: Vec<Owner> = shared.undetermined.iter().map(|variable| variable.owner).collect();
    let (first, names) = named(equations, &owners).map_or((None, Vec::new()), |(first, names)| (Some(first), names));
    let implied = || equations.system.find(Origin::Implied(0));
    let span = first.or_else(implied).map_or_else(Span::default, |element| span_of(equations, element));
    let (holder, whose) = match names.as_slice() {
        [] => ("the joints".to_owned(), "of joints that do it".to_owned()),
        names => (list(names), format!("of {}", list(names))),
    };
    let stay = if relations.len() == 1 { "stays" } else { "stay" };
    Fault::warning("scene::second_order", format!("{holder} imply that {} {stay} constant, but to second order only", list(&relations)), span)
        .label("takes part")
        .help(format!(
            "the motion is unique, but the reactions {whose} are unbounded and not determined; a real mechanism needs clearance there, or one joint less"
        ))
}

/// The elements of joints and drivers, each once: the first of them, and the names of all.
fn named(equations: &Equations, owners: &[Owner]) -> Option<(ElementId, Vec<String>)> {
    let mut elements: Vec<ElementId> = Vec::new();
    for element in owners.iter().filter_map(|owner| equations.system.find(Origin::of(*owner)?)) {
        if !elements.contains(&element) {
            elements.push(element);
        }
    }
    let names = elements.iter().map(|&element| equations.system.element(element).name.clone()).collect();
    Some((*elements.first()?, names))
}

/// Outputs that ask for reactions which are not determined.
fn check_determined(equations: &Equations, shared: &Shared, outputs: &[Output]) -> Vec<Fault> {
    let mechanism = &equations.system.mechanism;
    let mut faults = Vec::new();
    for output in outputs {
        let mut requested = None;
        output.value.visit(&mut |part| match part {
            Formula::Variable(variable) if shared.undetermined.contains(variable) => requested = Some(*variable),
            _ => {}
        });
        if let Some(variable) = requested {
            let name = mechanism.variable_name(variable);
            let message = format!(
                "`{name}` is not determined: the joints constrain a direction to second order only, and their reactions there are unbounded"
            );
            let owner = Origin::of(variable.owner).and_then(|origin| equations.system.find(origin));
            let span = owner.map_or_else(Span::default, |element| span_of(equations, element));
            let help =
                format!("remove the output `{}`, or give the mechanism clearance or one joint less", output.name);
            faults.push(Fault::new("scene::undetermined_reaction", message, span).label("carries it").help(help));
        }
    }
    faults
}

/// Variables that are not determined in the motion of a mechanism, whatever its outputs are.
///
/// # Errors
/// The equations cannot be formulated.
pub fn undetermined(mechanism: &Mechanism) -> Result<Vec<Variable>, Vec<Fault>> {
    if pattern(mechanism).is_none_or(|pattern| pattern.implied.is_empty()) {
        return Ok(Vec::new());
    }
    Ok(formulate(mechanism, &[])?.lowered.shared.undetermined)
}

/// Which loop equations a mechanism imposes, and what its joints imply in second order.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopPattern {
    imposed: Vec<bool>,
    implied: Vec<String>,
}

/// That of a mechanism; none if it cannot be assembled.
pub fn pattern(mechanism: &Mechanism) -> Option<LoopPattern> {
    let mut equations = equations(mechanism, &mechanism.coordinates).ok()?;
    let length = typical_length(&mut equations);
    let start = own_start(&equations, length);
    let mut faults = Vec::new();
    let (model, state) = first_state(&mut equations, length, start.as_ref(), &mut faults).ok()?;
    let found = faults.is_empty().then(|| restrictions(equations, (model, state), length, start.as_ref()))?.ok()?;
    let implied = found.equations.system.implied.iter().map(|relation| relation.name.clone()).collect();
    let imposed = found.equations.constraints.iter().map(Constraint::is_imposed).collect();
    Some(LoopPattern { imposed, implied })
}

/// An internal error, which no scene should cause.
fn internal(mechanism: &Mechanism, what: &str) -> Fault {
    Fault::internal(format!("the program of `{}` does not pass its own check: {what}", mechanism.name))
}
