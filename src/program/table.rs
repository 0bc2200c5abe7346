//! The variables of the FMU: parameters, inputs, coordinates with their derivatives, and the outputs of the scene.

use std::collections::{HashMap, HashSet};

use cotree_fmu::program::{self, Source};

use super::dependencies::{self, Moving};
use super::initial::{Given, settable};
use super::variable::{Causality, ScalarVariable, StartValue, Variability};
use crate::equations::{Equations, MotionVariable};
use crate::expr::{Expr, Order, Symbol};
use crate::model::{
    Calculated, Class, DiscreteId, DiscreteKind, DisplayUnit, Formula, Mechanism, Output, Parameter, StateId, Unit,
    Variable,
};

/// A variable: what an importer sees, and where its value comes from.
#[derive(Clone, Debug)]
pub struct TableRow {
    pub variable: ScalarVariable,
    /// What of the mechanism it is; none for parameters, inputs and expressions.
    pub of: Option<Of>,
    pub source: Source,
    /// Where its initial value is among the parameters of the program, if that can be set.
    pub initial: Option<u32>,
    pub value: Expr,
}

/// What a variable is of the mechanism, by which its row is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Of {
    Variable(Variable),
    /// A state that no component brings.
    State(StateId),
    /// What ticks and events write.
    Discrete(DiscreteId),
}

impl Of {
    fn state(mechanism: &Mechanism, index: usize) -> Of {
        mechanism.states[index].variable.map_or(Of::State(StateId(index)), Of::Variable)
    }

    fn output(mechanism: &Mechanism, output: &Output) -> Option<Of> {
        match output.value {
            Formula::State(id) if output.name == mechanism.states[id.0].name => Some(Of::state(mechanism, id.0)),
            Formula::Discrete(id) if output.name == mechanism.discrete[id.0].name => Some(Of::Discrete(id)),
            _ => mechanism.variable_of(output).map(Of::Variable),
        }
    }
}

impl TableRow {
    /// True if the scene asks for the variable.
    pub fn is_output(&self) -> bool {
        self.variable.causality == Causality::Output
    }
}

/// All variables, and the expressions of those that need a kernel.
#[derive(Clone, Debug, Default)]
pub struct VariableTable {
    pub rows: Vec<TableRow>,
    pub results: Vec<Expr>,
    places: HashMap<Expr, usize>,
}

impl VariableTable {
    pub(crate) fn new(equations: &mut Equations, outputs: &[Output], driven: bool, moving: &Moving) -> VariableTable {
        let mut table = VariableTable::default();
        table.add_parameters_and_inputs(equations);
        let members = coordinate_members(equations);
        table.add_outputs(equations, outputs, &members);
        table.add_members(&members, equations, driven);
        table.add_starts(equations);
        table.add_display_units(&equations.system.mechanism);
        if table.rows.is_empty() {
            table.add_time(equations);
        }
        dependencies::in_motion(&mut table.rows, equations, moving);
        table
    }

    pub fn variables(&self) -> Vec<program::Variable> {
        self.rows
            .iter()
            .map(|row| program::Variable { name: row.variable.name.clone(), source: row.source, initial: row.initial })
            .collect()
    }

    fn add_parameters_and_inputs(&mut self, equations: &mut Equations) {
        let mechanism = &*equations.system.mechanism.clone();
        for (index, parameter) in mechanism.parameters.iter().enumerate() {
            let value = equations.system.arena.symbol(Symbol::Parameter(index));
            let text = described("parameter", &parameter.name, &parameter.description);
            let Parameter { value: start, min, max, tunable, .. } = *parameter;
            let causality = Causality::Parameter { start, min, max };
            let variable = ScalarVariable::new(parameter.name.clone(), text, parameter.unit.clone(), causality);
            let variable = ScalarVariable { variability: Variability::of_parameter(tunable), ..variable };
            self.push(variable, None, Source::Parameter(index as u32), value);
        }
        for Calculated { parameter, formula } in &mechanism.calculated {
            let value = equations.formula(formula);
            let source = self.computed(equations, value);
            let calculated = format!("calculated: `{}`", mechanism.written(formula));
            let texts = [&parameter.description, &calculated].map(String::as_str).into_iter();
            let text = texts.filter(|text| !text.is_empty()).collect::<Vec<_>>().join("; ");
            let (name, unit) = (parameter.name.clone(), parameter.unit.clone());
            let variable = ScalarVariable::new(name, text, unit, Causality::CalculatedParameter);
            let variability = Variability::of_parameter(parameter.tunable);
            self.push(ScalarVariable { variability, ..variable }, None, source, value);
        }
        for (index, input) in mechanism.inputs.iter().enumerate() {
            let value = equations.system.arena.symbol(Symbol::Input(index, Order::Position));
            let text = described("input", &input.name, &input.description);
            let causality = Causality::Input { start: input.start, min: input.min, max: input.max };
            let variable = ScalarVariable::new(input.name.clone(), text, input.unit.clone(), causality);
            self.push(variable, None, Source::Input(index as u32), value);
        }
    }

    /// What ticks and events write; whether a part is there shows in its forces, and contacts have variables of their own.
    fn add_discrete(&mut self, equations: &mut Equations) {
        let mechanism = &*equations.system.mechanism.clone();
        for (id, discrete) in mechanism.discrete_variables() {
            let what = match discrete.kind {
                DiscreteKind::Sampled => "sampled value",
                DiscreteKind::Time => "time of an event",
                DiscreteKind::Presence(_) | DiscreteKind::Contact => continue,
                DiscreteKind::Captured(_)
                | DiscreteKind::Course(..)
                | DiscreteKind::Impulse
                | DiscreteKind::Setting => continue,
            };
            let value = equations.system.arena.symbol(Symbol::Discrete(id.0));
            let text = described(what, &discrete.name, &discrete.description);
            let variable = ScalarVariable::new(discrete.name.clone(), text, discrete.unit.clone(), Causality::Local);
            let variable = ScalarVariable { variability: Variability::Discrete, ..variable };
            self.push(variable, Some(Of::Discrete(id)), Source::Discrete(id.0 as u32), value);
        }
    }

    fn add_outputs(&mut self, equations: &mut Equations, outputs: &[Output], members: &[TableRow]) {
        let mechanism = &*equations.system.mechanism.clone();
        let known: HashMap<Of, &TableRow> = members.iter().filter_map(|member| Some((member.of?, member))).collect();
        for output in outputs {
            let (name, description) = (output.name.clone(), output.description.clone());
            let of = Of::output(mechanism, output);
            if let Some(member) = of.and_then(|of| known.get(&of)) {
                let ScalarVariable { unit, variability, .. } = member.variable.clone();
                let text = if description.is_empty() { member.variable.description.clone() } else { description };
                let variable = ScalarVariable::new(name, text, unit, Causality::Output);
                let variable = ScalarVariable { variability, ..variable };
                self.rows.push(TableRow { variable, ..(*member).clone() });
                continue;
            }
            let value = equations.formula(&output.value);
            let source = self.computed(equations, value);
            let variable = ScalarVariable::new(name, description, output.unit.clone(), Causality::Output);
            let is_held = matches!(of, Some(Of::Variable(variable)) if variable.quantity.class() == Class::Contact);
            let variability = if is_held { Variability::Discrete } else { variable.variability };
            self.push(ScalarVariable { variability, ..variable }, of, source, value);
        }
    }

    /// Coordinates, rates and accelerations that are no outputs. In a dynamic model v is the derivative of q and a that of v.
    fn add_members(&mut self, members: &[TableRow], equations: &Equations, driven: bool) {
        let there: HashSet<Source> = self.rows.iter().map(|row| row.source).collect();
        self.rows.extend(members.iter().filter(|member| !there.contains(&member.source)).cloned());
        if driven {
            return;
        }
        let layout = equations.motion_layout();
        let places: HashMap<Source, usize> =
            self.rows.iter().enumerate().map(|(place, row)| (row.source, place)).collect();
        for row in &mut self.rows {
            // Continuous states are q and v of each coordinate in turn, then those of the scene.
            let (of, state) = match row.source {
                Source::Rate(index) => (Source::Coordinate(index), 2 * index as usize),
                Source::Acceleration(index) => match layout.variable(index as usize) {
                    MotionVariable::Coordinate(coordinate) => (Source::Rate(index), 2 * coordinate + 1),
                    MotionVariable::State(state) => (Source::Rate(index), 2 * layout.states().start + state),
                },
                Source::Time
                | Source::Parameter(_)
                | Source::Input(_)
                | Source::Discrete(_)
                | Source::Output { .. } => continue,
                Source::Coordinate(_) => continue,
            };
            row.variable.derivative_of = places.get(&of).copied();
            row.variable.state = row.variable.derivative_of.map(|_| state);
        }
    }

    /// The result of the output kernel with that value.
    fn computed(&mut self, equations: &Equations, value: Expr) -> Source {
        let results = &mut self.results;
        let result = *self.places.entry(value).or_insert_with(|| {
            results.push(value);
            results.len() - 1
        });
        let accelerated = equations.system.arena.symbols([value]).into_iter().any(Symbol::is_solved);
        Source::Output { result: result as u32, accelerated }
    }

    /// Assigns settable initial values to their variables; adds variables that are not in the table yet.
    fn add_starts(&mut self, equations: &mut Equations) {
        let mechanism = &*equations.system.mechanism.clone();
        let rows = self.rows.iter().enumerate().rev();
        let known: HashMap<Of, usize> = rows.filter_map(|(place, row)| Some((row.of?, place))).collect();
        for (index, settable) in settable(equations).into_iter().enumerate() {
            let of = match settable.given {
                Given::Line(line) => Of::Variable(mechanism.initial[line].variable),
                Given::State(state) => Of::state(mechanism, state),
            };
            let place = known.get(&of).copied().or_else(|| {
                // States are all there.
                let Given::Line(line) = settable.given else { return None };
                let variable = mechanism.initial[line].variable;
                let value = equations.variable(variable);
                let source = self.computed(equations, value);
                let angular = variable.quantity.turns();
                let unit = if angular { Unit::angle() } else { Unit::length() };
                let rate = variable.quantity.order() == Some(Order::Velocity);
                let unit = if rate { unit.per_second() } else { unit };
                let (name, text) = (mechanism.variable_name(variable), "known at the start".to_owned());
                self.push(ScalarVariable::new(name, text, unit, Causality::Local), Some(of), source, value);
                Some(self.rows.len() - 1)
            });
            let Some(place) = place else { continue };
            self.rows[place].initial = Some((mechanism.parameters.len() + index) as u32);
            self.rows[place].variable.start = Some(match settable.given.is_known(mechanism) {
                true => StartValue::Exact(settable.value),
                false => StartValue::Approximate(settable.value),
            });
        }
    }

    /// A variable is shown in the unit of `[display]`, else in the one that its initial value is written in.
    fn add_display_units(&mut self, mechanism: &Mechanism) {
        let written = mechanism.initial.iter().filter_map(|line| {
            let display = line.display.as_ref()?;
            Some((Of::Variable(line.variable), display))
        });
        let written: HashMap<Of, &DisplayUnit> = written.collect();
        for row in self.rows.iter_mut().filter(|row| row.variable.unit.display.is_none()) {
            let (of, variable) = (row.of, &mut row.variable);
            let requested = Some(mechanism.display.of(&variable.unit)).filter(|shown| shown.name != variable.unit.si);
            variable.unit.display = requested.or_else(|| written.get(&of?).map(|&display| display.clone()));
        }
    }

    /// A description without any variable would not be valid.
    fn add_time(&mut self, equations: &mut Equations) {
        let value = equations.system.arena.symbol(Symbol::Time);
        let variable = ScalarVariable::new("time".into(), "time".into(), Unit::time(), Causality::Independent);
        self.push(variable, None, Source::Time, value);
    }

    fn push(&mut self, variable: ScalarVariable, of: Option<Of>, source: Source, value: Expr) {
        self.rows.push(TableRow { variable, of, source, initial: None, value });
    }
}

/// The user's description of something that the importer sets, or else what it is.
fn described(kind: &str, name: &str, description: &str) -> String {
    if description.is_empty() { format!("{kind} `{name}` of the scene") } else { description.to_owned() }
}

/// q, v and a of every coordinate; every state and its rate.
fn coordinate_members(equations: &mut Equations) -> Vec<TableRow> {
    let mut table = VariableTable::default();
    for (index, coordinate) in equations.coordinates.clone().into_iter().enumerate() {
        let kind = if coordinate.angular { Unit::angle() } else { Unit::length() };
        let [rate, acceleration] = [kind.per_second(), kind.per_second().per_second()];
        let owner = equations.system.element(coordinate.element).name.clone();
        let (name, place) = (coordinate.name, index as u32);
        let members = [
            (name.position, "coordinate", kind, Source::Coordinate(place)),
            (name.rate, "rate of the coordinate", rate, Source::Rate(place)),
            (name.acceleration, "acceleration of the coordinate", acceleration, Source::Acceleration(place)),
        ];
        let members = members.into_iter().zip(coordinate.variables).zip(Order::ALL);
        for (((name, what, unit, source), variable), order) in members {
            let value = equations.system.arena.symbol(Symbol::Coordinate(index, order));
            let described = ScalarVariable::new(name, format!("{what} of `{owner}`"), unit, Causality::Local);
            table.push(described, Some(Of::Variable(variable)), source, value);
        }
    }
    let mechanism = equations.system.mechanism.clone();
    for (index, state) in mechanism.states.iter().enumerate() {
        let place = (equations.coordinates.len() + index) as u32;
        let [value, rate] =
            [Order::Position, Order::Velocity].map(|order| equations.system.arena.symbol(Symbol::State(index, order)));
        let (name, unit) = (state.name.clone(), state.unit.clone());
        let description = if state.description.is_empty() { "state" } else { &state.description };
        let described = ScalarVariable::new(name, description.to_owned(), unit, Causality::Local);
        table.push(described, Some(Of::state(&mechanism, index)), Source::Rate(place), value);
        let (name, description) = (format!("der({})", state.name), format!("rate of `{}`", state.name));
        let described = ScalarVariable::new(name, description, state.unit.per_second(), Causality::Local);
        table.push(described, None, Source::Acceleration(place), rate);
    }
    table.add_discrete(equations);
    table.rows
}
