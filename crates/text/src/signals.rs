//! Signals in the equations: inputs, states of the scene, and the motions of drivers that integrate an input, with their derivatives.

use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol};
use cotree::model::{DiscreteKind, Owner};

use super::document::Piece;
use super::name::symbol_name;
use super::tree::FormulaTree;

/// A row for each signal in some formulas: its name, its unit, and its origin.
pub fn signals(equations: &Equations, formulas: &[Expr]) -> Vec<Vec<Piece>> {
    let mut symbols: Vec<Symbol> = equations.system.arena.symbols(formulas.iter().copied()).into_iter().collect();
    symbols.sort_unstable();
    let row = |symbol| {
        let words = match symbol {
            Symbol::Input(input, order) => input_words(equations, input, order),
            Symbol::Discrete(index) => discrete_words(equations, index)?,
            Symbol::Follower(follower, order) => follower_words(equations, follower, order),
            Symbol::State(state, order) => state_words(equations, state, order),
            Symbol::Time | Symbol::Parameter(_) | Symbol::Coordinate(..) => return None,
            Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => return None,
        };
        Some(std::iter::once(Piece::Math(FormulaTree::Name(symbol_name(equations, symbol)))).chain(words).collect())
    };
    symbols.into_iter().filter_map(row).collect()
}

fn input_words(equations: &Equations, input: usize, order: Order) -> Vec<Piece> {
    let mechanism = &equations.system.mechanism;
    let variable = &mechanism.inputs[input];
    let unit = unit(&variable.unit.si, order);
    vec![Piece::words(unit), Piece::words(derived(order as i32)), Piece::Code(variable.name.clone())]
}

/// None of the state of a contact and of joints and drivers that events remove: these belong to modes.
fn discrete_words(equations: &Equations, index: usize) -> Option<Vec<Piece>> {
    let mechanism = &equations.system.mechanism;
    let discrete = &mechanism.discrete[index];
    let unit = unit(&discrete.unit.si, Order::Position);
    let (what, name) = match discrete.kind {
        DiscreteKind::Sampled => ("sampled value", &discrete.name),
        DiscreteKind::Time => ("when the event happened last:", &discrete.name),
        DiscreteKind::Presence(Owner::Load(load)) => ("1 while the load is there:", &mechanism.loads[load.0].name),
        DiscreteKind::Captured(_) => ("held where it engages:", &discrete.name),
        DiscreteKind::Presence(_) | DiscreteKind::Contact | DiscreteKind::Impulse | DiscreteKind::Setting => {
            return None;
        }
        DiscreteKind::Course(..) => return None,
    };
    Some(vec![Piece::words(unit), Piece::words(what), Piece::Code(name.clone())])
}

fn state_words(equations: &Equations, state: usize, order: Order) -> Vec<Piece> {
    let variable = &equations.system.mechanism.states[state];
    let what = if order == Order::Position { "state" } else { "rate of the state" };
    vec![Piece::words(unit(&variable.unit.si, order)), Piece::words(what), Piece::Code(variable.name.clone())]
}

fn follower_words(equations: &Equations, follower: usize, order: Order) -> Vec<Piece> {
    let system = &equations.system;
    let (driver, input, given) = system.followers[follower];
    let driver = &system.mechanism.drivers[driver.0];
    let length = if driver.is_angular() { "rad" } else { "m" };
    let what = match order {
        Order::Position => "motion of the driver",
        Order::Velocity => "rate of the driver",
        Order::Acceleration => "acceleration of the driver",
    };
    vec![
        Piece::words(unit(length, order)),
        Piece::words(what),
        Piece::Code(driver.name.clone()),
        Piece::words(format!("= {}", derived(order as i32 - given as i32))),
        Piece::Code(system.mechanism.inputs[input.0].name.clone()),
    ]
}

fn derived(times: i32) -> &'static str {
    match times {
        ..=-2 => "second integral of the input",
        -1 => "integral of the input",
        0 => "input",
        1 => "rate of the input",
        2.. => "second time derivative of the input",
    }
}

fn unit(position: &str, order: Order) -> String {
    let position = if position.is_empty() { "1" } else { position };
    match order {
        Order::Position => position.to_owned(),
        Order::Velocity => format!("{position}/s"),
        Order::Acceleration => format!("{position}/s^2"),
    }
}
