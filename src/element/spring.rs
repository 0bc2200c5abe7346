//! The law of springs and torsion springs, and the energy that they store. One-sided springs act above or below their free length
//! only, and then only towards it: damping never makes a rope push or a stop pull.

use crate::mechanism::{
    BinaryOperator, Comparison, Formula, Function, LoadId, Owner, Quantity, Side, SpringLaw, Variable,
};

use BinaryOperator::{Add, Multiply, Power, Subtract};

const ZERO: Formula = Formula::Number(0.0);

fn binary(operator: BinaryOperator, a: Formula, b: Formula) -> Formula {
    Formula::Binary(operator, Box::new([a, b]))
}

/// `value` on the side where the spring acts, else zero.
fn one_sided(side: Side, stretch: Formula, value: Formula) -> Formula {
    let condition = match side {
        Side::Both => return value,
        Side::Above => Comparison::Greater,
        Side::Below => Comparison::Less,
    };
    Formula::If(condition, Box::new([stretch, ZERO, value, ZERO]))
}

fn own(load: LoadId, quantity: Quantity) -> Formula {
    Formula::Variable(Variable { owner: Owner::Load(load), quantity })
}

/// x, from the free length or angle.
fn stretch(load: LoadId, quantity: Quantity, law: &SpringLaw) -> Formula {
    binary(Subtract, own(load, quantity), law.free.clone())
}

/// -k x - k3 x^3 - c v: what pushes apart (or turns on) the second end.
pub(super) fn force(load: LoadId, [x, v]: [Quantity; 2], law: &SpringLaw) -> Formula {
    let stretch = stretch(load, x, law);
    let linear = binary(Multiply, law.stiffness.clone(), stretch.clone());
    let cube = binary(Power, stretch.clone(), Formula::Number(3.0));
    let cubic = binary(Multiply, law.cubic.clone(), cube);
    let damper = binary(Multiply, law.damping.clone(), own(load, v));
    let pull = binary(Add, binary(Add, linear, cubic), damper);
    let force = Formula::Negate(Box::new(pull));
    let towards_free = match law.side {
        Side::Both => return force,
        Side::Above => Formula::Call(Function::Min, vec![force, ZERO]),
        Side::Below => Formula::Call(Function::Max, vec![force, ZERO]),
    };
    one_sided(law.side, stretch, towards_free)
}

/// k x^2 / 2 + k3 x^4 / 4
pub(crate) fn energy(load: LoadId, x: Quantity, law: &SpringLaw) -> Formula {
    let stretch = stretch(load, x, law);
    let square = binary(Power, stretch.clone(), Formula::Number(2.0));
    let fourth = binary(Power, stretch.clone(), Formula::Number(4.0));
    let linear = binary(Multiply, Formula::Number(0.5), binary(Multiply, law.stiffness.clone(), square));
    let cubic = binary(Multiply, Formula::Number(0.25), binary(Multiply, law.cubic.clone(), fourth));
    one_sided(law.side, stretch, binary(Add, linear, cubic))
}
