//! The variables of the FMU: parameters, inputs, coordinates with their derivatives, and the outputs of the scene.

use std::collections::{HashMap, HashSet};

use cotree_fmu::program::{Source, Variable};

use super::dependencies::{self, Moving};
use super::initial::{Given, settable};
use super::variable::{Causality, ScalarVariable, Start, Variability};
use crate::equations::Equations;
use crate::expr::{Expr, Order, Symbol};
use crate::model::{Calculated, DisplayUnit, Mechanism, Output, Parameter, Unit};

/// A variable: what an importer sees, and where its value comes from.
#[derive(Clone, Debug)]
pub struct TableRow {
    pub variable: ScalarVariable,
    pub source: Source,
    /// Where its initial value is among the parameters of the program, if that can be set.
    pub initial: Option<u32>,
    pub value: Expr,
}

impl TableRow {
    /// Does the scene ask for it?
    pub fn is_output(&self) -> bool {
        self.variable.causality == Causality::Output
    }
}

/// All variables, and the expressions of those that need a kernel.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub rows: Vec<TableRow>,
    pub results: Vec<Expr>,
    places: HashMap<Expr, usize>,
}

impl Table {
    pub(crate) fn new(equations: &mut Equations, outputs: &[Output], driven: bool, moving: &Moving) -> Table {
        let mut table = Table::default();
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

    pub fn variables(&self) -> Vec<Variable> {
        self.rows
            .iter()
            .map(|row| Variable { name: row.variable.name.clone(), source: row.source, initial: row.initial })
            .collect()
    }

    fn add_parameters_and_inputs(&mut self, equations: &mut Equations) {
        let mechanism = &*equations.system.mechanism.clone();
        for (index, parameter) in mechanism.parameters.iter().enumerate() {
            let value = equations.system.arena.symbol(Symbol::Parameter(index));
            let own = described("parameter", &parameter.name, &parameter.description);
            let Parameter { value: start, min, max, tunable, .. } = *parameter;
            let causality = Causality::Parameter { start, min, max };
            let variable = ScalarVariable::new(parameter.name.clone(), own, parameter.unit.clone(), causality);
            let variable = ScalarVariable { variability: Variability::of_parameter(tunable), ..variable };
            self.push(variable, Source::Parameter(index as u32), value);
        }
        for Calculated { parameter, formula } in &mechanism.calculated {
            let value = equations.formula(formula);
            let source = self.computed(equations, value);
            let calculated = format!("calculated: `{}`", mechanism.written(formula));
            let own = [&parameter.description, &calculated].map(String::as_str).into_iter();
            let own = own.filter(|text| !text.is_empty()).collect::<Vec<_>>().join("; ");
            let (name, unit) = (parameter.name.clone(), parameter.unit.clone());
            let variable = ScalarVariable::new(name, own, unit, Causality::CalculatedParameter);
            let variability = Variability::of_parameter(parameter.tunable);
            self.push(ScalarVariable { variability, ..variable }, source, value);
        }
        for (index, input) in mechanism.inputs.iter().enumerate() {
            let value = equations.system.arena.symbol(Symbol::Input(index, Order::Position));
            let own = described("input", &input.name, &input.description);
            let causality = Causality::Input { start: input.start, min: input.min, max: input.max };
            let variable = ScalarVariable::new(input.name.clone(), own, input.unit.clone(), causality);
            self.push(variable, Source::Input(index as u32), value);
        }
    }

    fn add_outputs(&mut self, equations: &mut Equations, outputs: &[Output], members: &[TableRow]) {
        let named: HashMap<&str, &TableRow> =
            members.iter().map(|member| (member.variable.name.as_str(), member)).collect();
        for output in outputs {
            let (name, description) = (output.name.clone(), output.description.clone());
            if let Some(&member) = named.get(output.name.as_str()) {
                let unit = member.variable.unit.clone();
                let variable = ScalarVariable::new(name, description, unit, Causality::Output);
                self.rows.push(TableRow { variable, ..member.clone() });
                continue;
            }
            let value = equations.formula(&output.value);
            let source = self.computed(equations, value);
            self.push(ScalarVariable::new(name, description, output.unit.clone(), Causality::Output), source, value);
        }
    }

    /// Coordinates, rates and accelerations that are no outputs. In a dynamic model v is the derivative of q and a that of v.
    fn add_members(&mut self, members: &[TableRow], equations: &Equations, driven: bool) {
        let there: HashSet<String> = self.rows.iter().map(|row| row.variable.name.clone()).collect();
        self.rows.extend(members.iter().filter(|member| !there.contains(&member.variable.name)).cloned());
        if driven {
            return;
        }
        let mechanical = equations.coordinates.len();
        let places: HashMap<Source, usize> =
            self.rows.iter().enumerate().map(|(place, row)| (row.source, place)).collect();
        for row in &mut self.rows {
            // Continuous states are q and v of each coordinate in turn, then those of the scene.
            let (of, state) = match row.source {
                Source::Rate(index) => (Source::Coordinate(index), 2 * index as usize),
                Source::Acceleration(index) if (index as usize) < mechanical => {
                    (Source::Rate(index), 2 * index as usize + 1)
                }
                Source::Acceleration(index) => (Source::Rate(index), mechanical + index as usize),
                Source::Time | Source::Parameter(_) | Source::Input(_) | Source::Output { .. } => continue,
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
        let named: HashMap<String, usize> = rows.map(|(place, row)| (row.variable.name.clone(), place)).collect();
        for (index, settable) in settable(equations).into_iter().enumerate() {
            let name = settable.given.name(mechanism);
            let place = named.get(&name).copied().or_else(|| {
                // States are all there.
                let Given::Line(line) = settable.given else { return None };
                let variable = mechanism.initial[line].variable;
                let value = equations.variable(variable);
                let source = self.computed(equations, value);
                let angular = variable.quantity.turns();
                let unit = if angular { Unit::angle() } else { Unit::length() };
                let rate = variable.quantity.order() == Some(Order::Velocity);
                let unit = if rate { unit.per_second() } else { unit };
                let own = "known at the start".to_owned();
                self.push(ScalarVariable::new(name, own, unit, Causality::Local), source, value);
                Some(self.rows.len() - 1)
            });
            let Some(place) = place else { continue };
            self.rows[place].initial = Some((mechanism.parameters.len() + index) as u32);
            self.rows[place].variable.start = Some(match settable.given.is_known(mechanism) {
                true => Start::Exact(settable.value),
                false => Start::Approximate(settable.value),
            });
        }
    }

    /// A variable is shown in the unit of `[display]`, else in the one that its initial value is written in.
    fn add_display_units(&mut self, mechanism: &Mechanism) {
        let written = mechanism.initial.iter().filter_map(|line| {
            let display = line.display.as_ref()?;
            Some((mechanism.variable_name(line.variable), display))
        });
        let written: HashMap<String, &DisplayUnit> = written.collect();
        let variables = self.rows.iter_mut().map(|row| &mut row.variable);
        for variable in variables.filter(|variable| variable.unit.display.is_none()) {
            let asked = Some(mechanism.display.of(&variable.unit)).filter(|shown| shown.name != variable.unit.si);
            variable.unit.display = asked.or_else(|| written.get(&variable.name).map(|&display| display.clone()));
        }
    }

    /// A description without any variable would not be valid.
    fn add_time(&mut self, equations: &mut Equations) {
        let value = equations.system.arena.symbol(Symbol::Time);
        let variable = ScalarVariable::new("time".into(), "time".into(), Unit::time(), Causality::Independent);
        self.push(variable, Source::Time, value);
    }

    fn push(&mut self, variable: ScalarVariable, source: Source, value: Expr) {
        self.rows.push(TableRow { variable, source, initial: None, value });
    }
}

/// The user's description of something that the importer sets, or else what it is.
fn described(kind: &str, name: &str, own: &str) -> String {
    if own.is_empty() { format!("{kind} `{name}` of the scene") } else { own.to_owned() }
}

/// q, v and a of every coordinate; every state and its rate.
fn coordinate_members(equations: &mut Equations) -> Vec<TableRow> {
    let mut table = Table::default();
    for (index, coordinate) in equations.coordinates.clone().into_iter().enumerate() {
        let kind = if coordinate.angular { Unit::angle() } else { Unit::length() };
        let [rate, acceleration] = [kind.per_second(), kind.per_second().per_second()];
        let owner = equations.system.element(coordinate.element).name.clone();
        let (name, place) = (coordinate.name, index as u32);
        let members = [
            (name.position, "coordinate", kind, Source::Coordinate(place), Order::Position),
            (name.rate, "rate of the coordinate", rate, Source::Rate(place), Order::Velocity),
            (
                name.acceleration,
                "acceleration of the coordinate",
                acceleration,
                Source::Acceleration(place),
                Order::Acceleration,
            ),
        ];
        for (name, what, unit, source, order) in members {
            let value = equations.system.arena.symbol(Symbol::Coordinate(index, order));
            let variable = ScalarVariable::new(name, format!("{what} of `{owner}`"), unit, Causality::Local);
            table.push(variable, source, value);
        }
    }
    let mechanism = equations.system.mechanism.clone();
    for (index, state) in mechanism.states.iter().enumerate() {
        let place = (equations.coordinates.len() + index) as u32;
        let rate = format!("der({})", state.name);
        let description = if state.description.is_empty() { "state" } else { &state.description };
        let members = [
            (state.name.clone(), description.to_owned(), state.unit.clone(), Source::Rate(place), Order::Position),
            (
                rate,
                format!("rate of `{}`", state.name),
                state.unit.per_second(),
                Source::Acceleration(place),
                Order::Velocity,
            ),
        ];
        for (name, description, unit, source, order) in members {
            let value = equations.system.arena.symbol(Symbol::State(index, order));
            table.push(ScalarVariable::new(name, description, unit, Causality::Local), source, value);
        }
    }
    table.rows
}
