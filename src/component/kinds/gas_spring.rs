//! Gas spring (F): gas in a cylinder pushes two points apart, p V^n = constant. The exponent n is 1 if the gas keeps its temperature and 1.4
//! if air keeps its heat (a polytropic process).

use super::actuator;
use crate::component::frame::anywhere;
use crate::component::key::{BETWEEN_POINTS, Form, Key};
use crate::component::{Component, Icon, IconStroke, line};
use crate::expr::Unary;
use crate::model::measure::{FORCE, LENGTH, NUMBER};
use crate::model::{Comparison, Formula, Part, Quantity as Q, Range};
use crate::scene::{Load, Quantity};

pub(crate) const GAS_SPRING: Component = Component {
    about: "gas in a cylinder that pushes two points apart",
    equations: "F = push (column/(column + x))^exponent, x = |r| - length",
    keys: &[
        BETWEEN_POINTS,
        Key::required(
            "push",
            Form::Constant(FORCE, Range::Any),
            "the force that pushes the points apart at `length`",
            "give the force that pushes the points apart at `length` [N]: `push = 300`",
        ),
        Key::required(
            "length",
            Form::Constant(LENGTH, Range::Any),
            "the distance between the points where the force is `push`",
            "give the distance between the points where the force is `push`: `length = \"0.3 m\"`",
        ),
        Key::required(
            "column",
            Form::Constant(LENGTH, Range::Positive),
            "the length of the column of gas there: its volume over the area of the piston",
            "give the length of the column of gas where the force is `push`: `column = \"0.2 m\"`",
        ),
        Key::required(
            "exponent",
            Form::Constant(NUMBER, Range::Positive),
            "the exponent of the volume in p V^n: 1 at constant temperature, 1.4 for air without exchange of heat",
            "give the exponent of p V^n: `exponent = 1.4`",
        ),
    ],
    variables: &[Q::Length, Q::Rate, Q::Force],
    pose: &[Q::Length, Q::Force],
    pulls: true,
    law: |part| Some(part.key("push") * ratio(part).power(part.key("exponent"))),
    energy,
    ..Component::load("gas_spring", |part, system| line::rows(system, part, "k"), anywhere, |_| Icon::Line(strut))
};

/// V0/V
fn ratio(part: &Part) -> Formula {
    part.key("column") / (part.key("column") + part.variable(Q::Length) - part.key("length"))
}

/// The integral of the force from `length`: with l = log(V0/V), p V0 (exp((n - 1) l) - 1)/(n - 1), next to n = 1 by its series p V0 (l + (n - 1) l^2/2 + ...). At
/// |n - 1| = 1e-5 the next term, (n - 1)^2 l^3/6, and the rounding error of the quotient, 1e-16/|n - 1|, are both about 1e-11.
fn energy(part: &Part) -> Option<Formula> {
    let (one, less) = (Formula::Number(1.0), part.key("exponent") - Formula::Number(1.0));
    let whole = part.key("push") * part.key("column");
    let logarithm = || ratio(part).of(Unary::Log);
    if part.formula("exponent") == &one {
        return Some(whole * logarithm());
    }
    let power = whole.clone() / less.clone() * (ratio(part).power(less.clone()) - one.clone());
    if matches!(part.formula("exponent"), Formula::Number(_)) {
        return Some(power);
    }
    let series = whole * logarithm() * (one + less.clone() / Formula::Number(2.0) * logarithm());
    let away = less.of(Unary::Abs);
    Some(Formula::If(Comparison::Less, Box::new([away, Formula::Number(1e-5), series, power])))
}

/// A cylinder with gas below its piston.
fn strut(length: f64) -> Vec<IconStroke> {
    let mut strokes = actuator::cylinder(length);
    let gas = |share: f64, y: f64| IconStroke::open(vec![[share * length, y], [share * length + 0.1, y]]);
    strokes
        .extend([(0.25, 0.6), (0.25, -0.7), (0.31, -0.1), (0.37, 0.7), (0.37, -0.6)].map(|(share, y)| gas(share, y)));
    strokes
}

impl Load {
    /// Gas in a cylinder that pushes two points apart: `push` where they are `length` apart and the gas fills `column`.
    pub fn gas_spring(
        first: &str,
        second: &str,
        push: impl Into<Quantity>,
        [length, column]: [f64; 2],
        exponent: impl Into<Quantity>,
    ) -> Load {
        let load = Load::new("gas_spring").set("between", [first, second]).set("push", push.into());
        let load = load.set("length", Quantity::from(length)).set("column", Quantity::from(column));
        load.set("exponent", exponent.into())
    }
}
