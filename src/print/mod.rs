//! Equations for people and for other programs.

mod c;
mod formula;
mod text;

pub use c::c_code;
pub use text::text;

use crate::equations::Equations;
use crate::expr::{Order, Symbol};

/// What a symbol is called in the user's words.
pub fn symbol_name(equations: &Equations, symbol: Symbol) -> String {
    let mechanism = equations.system.mechanism;
    let primes = |order: Order| match order {
        Order::Position => "",
        Order::Velocity => "'",
        Order::Acceleration => "''",
    };
    match symbol {
        Symbol::Time => "t".to_string(),
        Symbol::Parameter(i) => mechanism.parameters[i].name.clone(),
        Symbol::Input(i, order) => format!("{}{}", mechanism.inputs[i].name, primes(order)),
        Symbol::Follower(i, order) => {
            let driver = equations.system.followers[i].0;
            format!("{}{}", mechanism.drivers[driver.0].name, primes(order))
        }
        Symbol::Coordinate(i, Order::Position) => equations.coordinates[i].name.position.clone(),
        Symbol::Coordinate(i, Order::Velocity) => equations.coordinates[i].name.rate.clone(),
        Symbol::Coordinate(i, Order::Acceleration) => equations.coordinates[i].name.acceleration.clone(),
        Symbol::Reaction(i) => format!("lambda{}", i + 1),
        Symbol::Missing(body, crate::expr::Property::Mass) => format!("{}.mass", mechanism.bodies[body].name),
        Symbol::Missing(body, crate::expr::Property::Inertia) => format!("{}.inertia", mechanism.bodies[body].name),
    }
}
