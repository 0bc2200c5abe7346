//! The mechanism of statics: drivers constant, no initial velocities.

use cotree::expr::Order;
use cotree::lower::order_of;
use cotree::mechanism::{Formula, Mechanism, Motion, Value};

/// The same mechanism with its drivers constant at their start values, and without initial velocities.
pub fn at_rest(mechanism: &Mechanism) -> Mechanism {
    let mut resting = mechanism.clone();
    let start = mechanism.experiment.start;
    for (_, value) in resting.drivers.iter_mut().flat_map(|driver| &mut driver.values) {
        match value {
            // An integrated input is at rest already: the rates of a resting point are zero.
            Value::Motion(Motion::Given(formula)) => hold(formula, start),
            Value::Vector(position) => position.iter_mut().for_each(|formula| hold(formula, start)),
            _ => {}
        }
    }
    resting.initial.retain(|initial| order_of(initial.variable.quantity) == Order::Position);
    resting
}

fn hold(formula: &mut Formula, time: f64) {
    match formula {
        Formula::Time => *formula = Formula::Number(time),
        other => other.parts_mut().iter_mut().for_each(|part| hold(part, time)),
    }
}
