//! The known and guessed initial values as kernels: values, targets, and the derivatives of the values.

use std::collections::HashMap;

use cotree_fmu::program::Condition;

use crate::equations::Equations;
use crate::expr::{Expr, Order, Symbol};
use crate::model::{Formula, Mechanism};

/// Conditions of one order with their expressions.
#[derive(Clone, Debug, Default)]
pub struct Conditions {
    pub conditions: Vec<Condition>,
    pub results: Vec<Expr>,
    /// (row, column) and derivative; columns are coordinates, then followers.
    pub jacobian: Vec<((u32, u32), Expr)>,
}

/// What is given at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Given {
    /// A line of `[initial]`, by its place there.
    Line(usize),
    /// The start of a state.
    State(usize),
}

/// A start that is a number: it can be set under the name of its variable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settable {
    pub given: Given,
    pub value: f64,
}

impl Given {
    /// The name of its variable.
    pub fn name(self, mechanism: &Mechanism) -> String {
        match self {
            Given::Line(line) => mechanism.variable_name(mechanism.initial[line].variable),
            Given::State(state) => mechanism.states[state].name.clone(),
        }
    }

    /// Known, or a guess?
    pub fn is_known(self, mechanism: &Mechanism) -> bool {
        match self {
            Given::Line(line) => mechanism.initial[line].known,
            Given::State(_) => true,
        }
    }
}

/// All initial values that can be set. In the register file they come after the scene's parameters.
pub(crate) fn settable(equations: &mut Equations) -> Vec<Settable> {
    let mut settable = Vec::new();
    let mechanism = &*equations.system.mechanism.clone();
    let lines = mechanism.initial.iter().enumerate().map(|(line, initial)| (Given::Line(line), &initial.value));
    let states = mechanism.states.iter().enumerate().map(|(index, state)| (Given::State(index), &state.start));
    for (given, formula) in lines.chain(states) {
        let value = equations.formula(formula);
        if let Some(value) = equations.system.arena.as_constant(value) {
            settable.push(Settable { given, value });
        }
    }
    settable
}

/// The conditions on positions (`Order::Position`) or on velocities, to which states belong.
pub fn conditions(equations: &mut Equations, order: Order, length: f64) -> Conditions {
    let mechanism = &*equations.system.mechanism.clone();
    let settable = settable(equations);
    let places: HashMap<Given, usize> =
        settable.iter().enumerate().map(|(place, settable)| (settable.given, place)).collect();
    let mut result = Conditions::default();
    let mut targets = Vec::new();
    for (row, GivenValue { given, condition, formula }) in given(mechanism, order, length).into_iter().enumerate() {
        let value = match given {
            Given::Line(line) => equations.variable(mechanism.initial[line].variable),
            Given::State(state) => equations.system.arena.symbol(Symbol::State(state, Order::Position)),
        };
        result.conditions.push(condition);
        result.results.push(value);
        targets.push(match places.get(&given) {
            Some(place) => equations.system.arena.symbol(Symbol::Parameter(mechanism.parameters.len() + place)),
            None => equations.formula(formula),
        });
        differentiate(equations, value, order, row, &mut result.jacobian);
    }
    result.results.extend(targets);
    result
}

/// The conditions of an order, without their expressions.
pub(super) fn listed(mechanism: &Mechanism, order: Order, length: f64) -> Vec<Condition> {
    given(mechanism, order, length).into_iter().map(|given| given.condition).collect()
}

/// What is given, as a condition, and its value.
struct GivenValue<'m> {
    given: Given,
    condition: Condition,
    formula: &'m Formula,
}

/// What is given of an order.
fn given(mechanism: &Mechanism, order: Order, length: f64) -> Vec<GivenValue<'_>> {
    let lines = mechanism.initial.iter().enumerate();
    let chosen = lines.filter(|(_, initial)| initial.variable.quantity.order() == Some(order));
    let of_line = chosen.map(|(line, initial)| {
        let angular = initial.variable.quantity.turns();
        let name = mechanism.variable_name(initial.variable);
        let condition = Condition { name, known: initial.known, angular, scale: if angular { 1.0 } else { length } };
        GivenValue { given: Given::Line(line), condition, formula: &initial.value }
    });
    let states = mechanism.states.iter().enumerate().filter(|_| order == Order::Velocity);
    let of_state = states.map(|(index, state)| {
        let condition = Condition { name: state.name.clone(), known: true, angular: false, scale: state.nominal };
        GivenValue { given: Given::State(index), condition, formula: &state.start }
    });
    of_line.chain(of_state).collect()
}

fn differentiate(
    equations: &mut Equations,
    value: Expr,
    order: Order,
    row: usize,
    jacobian: &mut Vec<((u32, u32), Expr)>,
) {
    let layout = equations.motion_layout();
    for symbol in equations.system.arena.symbols([value]) {
        let column = match symbol {
            Symbol::Coordinate(index, of) if of == order => index,
            // A state is the rate of a coordinate.
            Symbol::State(index, Order::Position) if order == Order::Velocity => layout.state(index),
            Symbol::Follower(index, of) if of == order => layout.count() + index,
            Symbol::Coordinate(..) | Symbol::Follower(..) | Symbol::Time | Symbol::Parameter(_) => continue,
            Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::State(..)
            | Symbol::Reaction(_)
            | Symbol::Missing(..)
            | Symbol::Argument => continue,
        };
        let entry = equations.system.arena.derivative(value, symbol);
        if entry != Expr::ZERO {
            jacobian.push(((row as u32, column as u32), entry));
        }
    }
}
