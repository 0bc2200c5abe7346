//! The mechanism in statics: drivers are constant, initial velocities are zero, and a body without a torque does not rotate.

use cotree::expr::Order;
use cotree::model::{Formula, KeyValue, Mechanism, Motion};
use cotree::network::System;

/// The same mechanism with its drivers constant at their start values, and without initial velocities. Bodies that nothing turns are particles: they would rest at any angle.
pub fn at_rest(mechanism: &Mechanism) -> Mechanism {
    let mut resting = mechanism.clone();
    let start = mechanism.experiment.start;
    for (_, value) in resting.drivers.iter_mut().flat_map(|driver| &mut driver.values) {
        match value {
            // An integrated input is at rest already: the rates of a resting point are zero.
            KeyValue::Motion(Motion::Given(formula)) => hold(formula, start),
            KeyValue::Vector(position) => position.iter_mut().for_each(|formula| hold(formula, start)),
            _ => {}
        }
    }
    resting.initial.retain(|initial| initial.variable.quantity.order() == Some(Order::Position));
    for body in System::new(&resting).unturned() {
        resting.bodies[body.0].inertia = Some(Formula::Number(0.0));
    }
    resting
}

fn hold(formula: &mut Formula, time: f64) {
    match formula {
        Formula::Time => *formula = Formula::Number(time),
        other => other.parts_mut().iter_mut().for_each(|part| hold(part, time)),
    }
}
