//! Assumptions about freedoms of the initial state that the scene leaves open.

use crate::expr::{Order, Symbol};
use crate::formulate::Formulated;

pub fn assumptions(formulated: &mut Formulated) -> Vec<String> {
    let mobility = formulated.mobility();
    let follows_recommended = !formulated.lowered.program.initial.first_positions.is_empty();
    let state = formulated.state.clone();
    let equations = &mut formulated.equations;
    let mechanism = equations.system.mechanism;
    let values: Vec<_> = mechanism.initial.iter().map(|initial| equations.variable(initial.variable)).collect();
    let said = equations.system.arena.symbols(values);
    let mut sentences = Vec::new();
    for (index, coordinate) in equations.coordinates.iter().enumerate() {
        if said.binary_search(&Symbol::Coordinate(index, Order::Position)).is_ok() {
            continue;
        }
        let unit = if coordinate.angular { "rad" } else { "m" };
        let name = &coordinate.name.position;
        let value = state.positions()[index];
        let from = if follows_recommended { "as in the recommended trees" } else { "searched from 0" };
        sentences.push(format!("`{name}` is neither given nor guessed: {from}, found at {value:.6} {unit}"));
    }
    let known = said.iter().filter(|symbol| matches!(symbol, Symbol::Coordinate(_, Order::Velocity))).count();
    if known < mobility {
        sentences.push("velocities that are not given are zero as far as the loops and drivers allow".to_string());
    }
    sentences
}
