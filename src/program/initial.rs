//! The known and guessed initial values as kernels: values, targets, and the derivatives of the values.

use std::collections::HashMap;

use cotree_fmu::program::Condition;

use crate::equations::Equations;
use crate::expr::{Expr, Order, Symbol};

/// Conditions of one order with their expressions.
#[derive(Clone, Debug, Default)]
pub struct Conditions {
    pub conditions: Vec<Condition>,
    pub results: Vec<Expr>,
    /// (row, column) and derivative; columns are coordinates, then followers.
    pub jacobian: Vec<((u32, u32), Expr)>,
}

/// A line of `[initial]` whose value is a number: it can be set under the name of its variable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settable {
    /// Its place in [`Mechanism::initial`].
    pub line: usize,
    pub value: f64,
}

/// All initial values that can be set. In the register file they come after the scene's parameters.
pub(crate) fn settable(equations: &mut Equations) -> Vec<Settable> {
    let mut settable = Vec::new();
    let mechanism = &*equations.system.mechanism.clone();
    for (line, initial) in mechanism.initial.iter().enumerate() {
        let value = equations.formula(&initial.value);
        if let Some(value) = equations.system.arena.as_constant(value) {
            settable.push(Settable { line, value });
        }
    }
    settable
}

/// The conditions on positions (`Order::Position`) or on velocities.
pub fn conditions(equations: &mut Equations, order: Order, length: f64) -> Conditions {
    let mechanism = &*equations.system.mechanism.clone();
    let settable = settable(equations);
    let lines = mechanism.initial.iter().enumerate();
    let chosen = lines.filter(|(_, initial)| initial.variable.quantity.order() == Some(order));
    let places: HashMap<usize, usize> =
        settable.iter().enumerate().map(|(place, settable)| (settable.line, place)).collect();
    let mut result = Conditions::default();
    let mut targets = Vec::new();
    for (row, (line, initial)) in chosen.enumerate() {
        let value = equations.variable(initial.variable);
        let angular = initial.variable.quantity.turns();
        result.conditions.push(Condition {
            name: mechanism.variable_name(initial.variable),
            known: initial.known,
            angular,
            scale: if angular { 1.0 } else { length },
        });
        result.results.push(value);
        targets.push(match places.get(&line) {
            Some(place) => equations.system.arena.symbol(Symbol::Parameter(mechanism.parameters.len() + place)),
            None => equations.formula(&initial.value),
        });
        differentiate(equations, value, order, row, &mut result.jacobian);
    }
    result.results.extend(targets);
    result
}

fn differentiate(
    equations: &mut Equations,
    value: Expr,
    order: Order,
    row: usize,
    jacobian: &mut Vec<((u32, u32), Expr)>,
) {
    let coordinates = equations.coordinates.len();
    for symbol in equations.system.arena.symbols([value]) {
        let column = match symbol {
            Symbol::Coordinate(index, of) if of == order => index,
            Symbol::Follower(index, of) if of == order => coordinates + index,
            Symbol::Coordinate(..) | Symbol::Follower(..) | Symbol::Time | Symbol::Parameter(_) | Symbol::Input(..) => {
                continue;
            }
            Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => continue,
        };
        let entry = equations.system.arena.derivative(value, symbol);
        if entry != Expr::ZERO {
            jacobian.push(((row as u32, column as u32), entry));
        }
    }
}
