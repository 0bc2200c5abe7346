//! Values of symbols from the registers of the runtime.

use cotree::expr::{Order, Symbol};
use cotree_fmu::program::Layout;

/// The value of a symbol in a register file.
pub fn value(layout: &Layout, registers: &[f64], symbol: Symbol) -> f64 {
    let register = match symbol {
        Symbol::Time => layout.time(),
        Symbol::Parameter(i) => layout.parameters() + i,
        Symbol::Discrete(i) => layout.discrete() + i,
        Symbol::Input(i, Order::Position) => layout.inputs() + i,
        Symbol::Input(i, Order::Velocity) => layout.input_rates() + i,
        Symbol::Input(i, Order::Acceleration) => layout.input_accelerations() + i,
        Symbol::Follower(i, Order::Position) => layout.followers() + i,
        Symbol::Follower(i, Order::Velocity) => layout.follower_rates() + i,
        Symbol::Follower(i, Order::Acceleration) => layout.follower_accelerations() + i,
        Symbol::Coordinate(i, Order::Position) => layout.positions() + i,
        Symbol::Coordinate(i, Order::Velocity) => layout.rates() + i,
        Symbol::Coordinate(i, Order::Acceleration) => layout.accelerations() + i,
        Symbol::State(i, Order::Position) => layout.states() + i,
        Symbol::State(i, _) => layout.state_rates() + i,
        Symbol::Reaction(i) => layout.reactions() + i,
        Symbol::Missing(..) | Symbol::Argument => panic!("{symbol:?} has no value"),
    };
    registers[register]
}
