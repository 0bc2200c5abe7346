//! The variables of the FMU: parameters, inputs, coordinates with their derivatives, and the outputs of the scene.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use cotree_fmu::program::{Source, Variable};

use super::dependencies::{self, Moving};
use super::initial::{Given, settable};
use crate::equations::Equations;
use crate::expr::{Expr, Order, Symbol};
use crate::model::{Calculated, DisplayUnit, Mechanism, Unit};

#[derive(Clone, Debug)]
pub struct TableRow {
    pub name: String,
    pub description: String,
    pub unit: Unit,
    pub source: Source,
    pub output: bool,
    /// If it is a derivative: the place of the variable that it is the derivative of.
    pub derivative_of: Option<usize>,
    /// Its initial value, if that can be set.
    pub start: Option<Start>,
    /// Of a calculated parameter: may it change in a run?
    pub calculated: Option<bool>,
    pub value: Expr,
    /// Places of the inputs, states and parameters that it depends on; the number of rows stands for time.
    pub dependencies: Arc<[usize]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    pub value: f64,
    /// Known, or a guess?
    pub known: bool,
    /// Its place among the parameters of the program.
    pub parameter: u32,
}

/// All variables, and the expressions of those that need a kernel.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub rows: Vec<TableRow>,
    pub results: Vec<Expr>,
    places: HashMap<Expr, usize>,
}

impl Table {
    pub(crate) fn new(equations: &mut Equations, driven: bool, moving: &Moving) -> Table {
        let mut table = Table::default();
        table.add_parameters_and_inputs(equations);
        let members = coordinate_members(equations);
        table.add_outputs(equations, &members);
        table.add_members(&members, driven);
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
            .map(|row| Variable {
                name: row.name.clone(),
                source: row.source,
                initial: row.start.map(|start| start.parameter),
            })
            .collect()
    }

    fn add_parameters_and_inputs(&mut self, equations: &mut Equations) {
        let mechanism = &*equations.system.mechanism.clone();
        for (index, parameter) in mechanism.parameters.iter().enumerate() {
            let value = equations.system.arena.symbol(Symbol::Parameter(index));
            self.push(
                (&parameter.name, &parameter.description, &parameter.unit),
                Source::Parameter(index as u32),
                value,
            );
        }
        for Calculated { parameter, formula } in &mechanism.calculated {
            let value = equations.formula(formula);
            let source = self.computed(equations, value);
            let calculated = format!("calculated: `{}`", mechanism.written(formula));
            let own = [&parameter.description, &calculated].map(String::as_str).into_iter();
            let description = own.filter(|text| !text.is_empty()).collect::<Vec<_>>().join("; ");
            self.push((&parameter.name, &description, &parameter.unit), source, value);
            if let Some(row) = self.rows.last_mut() {
                row.calculated = Some(parameter.tunable);
            }
        }
        for (index, input) in mechanism.inputs.iter().enumerate() {
            let value = equations.system.arena.symbol(Symbol::Input(index, Order::Position));
            self.push((&input.name, &input.description, &input.unit), Source::Input(index as u32), value);
        }
    }

    fn add_outputs(&mut self, equations: &mut Equations, members: &[TableRow]) {
        let named: HashMap<&str, &TableRow> = members.iter().map(|member| (member.name.as_str(), member)).collect();
        for output in &equations.system.mechanism.clone().outputs {
            if let Some(&member) = named.get(output.name.as_str()) {
                let description = output.description.clone();
                self.rows.push(TableRow { output: true, description, ..member.clone() });
                continue;
            }
            let value = equations.formula(&output.value);
            let source = self.computed(equations, value);
            self.push((&output.name, &output.description, &output.unit), source, value);
            if let Some(row) = self.rows.last_mut() {
                row.output = true;
            }
        }
    }

    /// Coordinates, rates and accelerations that are no outputs. In a dynamic model v is the derivative of q and a that of v.
    fn add_members(&mut self, members: &[TableRow], driven: bool) {
        let there: HashSet<String> = self.rows.iter().map(|row| row.name.clone()).collect();
        self.rows.extend(members.iter().filter(|member| !there.contains(&member.name)).cloned());
        if driven {
            return;
        }
        let places: HashMap<Source, usize> =
            self.rows.iter().enumerate().map(|(place, row)| (row.source, place)).collect();
        for row in &mut self.rows {
            let state = match row.source {
                Source::Rate(index) => Source::Coordinate(index),
                Source::Acceleration(index) => Source::Rate(index),
                _ => continue,
            };
            row.derivative_of = places.get(&state).copied();
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
        let named: HashMap<String, usize> = rows.map(|(place, row)| (row.name.clone(), place)).collect();
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
                self.push((&name, "known at the start", &unit), source, value);
                Some(self.rows.len() - 1)
            });
            let Some(place) = place else { continue };
            let parameter = (mechanism.parameters.len() + index) as u32;
            self.rows[place].start =
                Some(Start { value: settable.value, known: settable.given.is_known(mechanism), parameter });
        }
    }

    /// A variable is shown in the unit of `[display]`, else in the one that its initial value is written in.
    fn add_display_units(&mut self, mechanism: &Mechanism) {
        let written = mechanism.initial.iter().filter_map(|line| {
            let display = line.display.as_ref()?;
            Some((mechanism.variable_name(line.variable), display))
        });
        let written: HashMap<String, &DisplayUnit> = written.collect();
        for row in self.rows.iter_mut().filter(|row| row.unit.display.is_none()) {
            let asked = Some(mechanism.display.of(&row.unit)).filter(|shown| shown.name != row.unit.si);
            row.unit.display = asked.or_else(|| written.get(&row.name).map(|&display| display.clone()));
        }
    }

    /// A description without any variable would not be valid.
    fn add_time(&mut self, equations: &mut Equations) {
        let value = equations.system.arena.symbol(Symbol::Time);
        self.push(("time", "time", &Unit::time()), Source::Time, value);
    }

    fn push(&mut self, (name, description, unit): (&str, &str, &Unit), source: Source, value: Expr) {
        self.rows.push(TableRow {
            name: name.to_string(),
            description: description.to_string(),
            unit: unit.clone(),
            source,
            output: false,
            derivative_of: None,
            start: None,
            calculated: None,
            value,
            dependencies: Arc::default(),
        });
    }
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
            table.push((&name, &format!("{what} of `{owner}`"), &unit), source, value);
        }
    }
    let mechanism = equations.system.mechanism.clone();
    for (index, state) in mechanism.states.iter().enumerate() {
        let place = (equations.coordinates.len() + index) as u32;
        let rate = format!("der({})", state.name);
        let description = if state.description.is_empty() { "state" } else { &state.description };
        let members = [
            (&state.name, description.to_owned(), state.unit.clone(), Source::Rate(place), Order::Position),
            (
                &rate,
                format!("rate of `{}`", state.name),
                state.unit.per_second(),
                Source::Acceleration(place),
                Order::Velocity,
            ),
        ];
        for (name, description, unit, source, order) in members {
            let value = equations.system.arena.symbol(Symbol::State(index, order));
            table.push((name, &description, &unit), source, value);
        }
    }
    table.rows
}
