//! Hydraulic cylinder (F): two chambers of oil with a valve, whose pressures are states.

use super::actuator;
use crate::component::frame::anywhere;
use crate::component::key::{BETWEEN_POINTS, Form, Key};
use crate::component::{Component, Icon, OwnState, Room, line};
use crate::expr::Unary;
use crate::model::measure::{ANYTHING, AREA, LENGTH, NUMBER, PRESSURE, VOLUME};
use crate::model::{Comparison, Formula, Part, Quantity as Q, Range};
use crate::scene::Load;

/// Flow through a valve goes with the root of the pressure that is left, in turbulence; below a pressure of this size \[Pa\] it is linear, as laminar flow is. So the root has a
/// rate at zero. From a thousand times that on, a hundredth of an atmosphere, the flow differs from the root by less than 3e-7.
const LAMINAR: f64 = 1.0;
/// About the atmosphere \[Pa\].
const ATMOSPHERE: f64 = 1e5;

pub(crate) const CYLINDER: Component = Component {
    about: "a hydraulic cylinder with a valve: the pressures of both chambers are states",
    equations: "F = p_cap area_cap - p_rod area_rod; p_cap' = bulk (flow - leak - area_cap rate)/(volume_cap + area_cap stroke), p_rod' likewise",
    keys: &[
        BETWEEN_POINTS,
        Key::required(
            "areas",
            Form::ConstantVector(AREA),
            "the areas of the piston: behind it, and around the rod",
            "give both areas: `areas = [\"8 cm2\", \"5 cm2\"]`",
        ),
        Key::required(
            "volumes",
            Form::ConstantVector(VOLUME),
            "the volumes of oil, pipes included, where its length is `retracted`: behind the piston, and around the rod",
            "give both volumes: `volumes = [\"2e-4 m3\", \"3e-4 m3\"]`",
        ),
        Key::required(
            "retracted",
            Form::Constant(LENGTH, Range::Positive),
            "the length at which the volumes are these",
            "give that length: `retracted = \"0.5 m\"`",
        ),
        Key::required(
            "bulk",
            Form::Constant(PRESSURE, Range::Positive),
            "the bulk modulus of the oil",
            "give the bulk modulus: `bulk = \"1.2 GPa\"`",
        ),
        Key::required(
            "opening",
            Form::Law(NUMBER),
            "the opening of its valve, from -1 to 1: a law; positive lets the supply into the cap",
            "give the opening: `opening = \"0.5*sin(t)\"`, or a law of inputs",
        ),
        Key::required(
            "valve",
            Form::Constant(ANYTHING, Range::Positive),
            "flow through the open valve per square root of the pressure drop [m3/s per square root of a Pascal]",
            "give the flow per square root of the pressure drop: `valve = 2e-8`",
        ),
        Key::required(
            "supply",
            Form::Constant(PRESSURE, Range::Any),
            "the pressure of the pump",
            "give the pressure of the pump: `supply = \"12 MPa\"`",
        ),
        Key::default("tank", Form::Constant(PRESSURE, Range::Any), "the pressure of the tank", "0"),
        Key::default(
            "leakage",
            Form::Constant(ANYTHING, Range::NotNegative),
            "leakage past the piston per pressure difference [m3/s per Pascal]",
            "0",
        ),
        Key::required(
            "pressures",
            Form::ConstantVector(PRESSURE),
            "the pressures at the start: behind the piston, and around the rod",
            "give both pressures: `pressures = [\"1.6 MPa\", \"2 MPa\"]`",
        ),
    ],
    variables: &[Q::Length, Q::Rate, Q::Force, Q::CapPressure, Q::RodPressure],
    law_variables: &[Q::Length, Q::Rate, Q::CapPressure, Q::RodPressure],
    pose: &[Q::Length, Q::Force, Q::CapPressure, Q::RodPressure],
    law: |part| {
        let [cap, rod] = part.vector("areas");
        Some(part.variable(Q::CapPressure) * cap - part.variable(Q::RodPressure) * rod)
    },
    states: pressures,
    room: Room::Plane,
    ..Component::load(
        "cylinder",
        |part, system| line::rows(system, part, "F"),
        anywhere,
        |_| Icon::Line(actuator::cylinder),
    )
};

/// Rates of both pressures: what flows in, less what the piston makes room for, by the volume, times the bulk modulus.
fn pressures(part: &Part) -> Vec<OwnState> {
    let [cap_area, rod_area] = part.vector("areas");
    let [cap_volume, rod_volume] = part.vector("volumes");
    let [cap_start, rod_start] = part.vector("pressures");
    let (cap, rod, speed) = (part.variable(Q::CapPressure), part.variable(Q::RodPressure), part.variable(Q::Rate));
    let stroke = part.variable(Q::Length) - part.key("retracted");
    let leak = part.key("leakage") * (cap.clone() - rod.clone());
    let (supply, tank) = (part.key("supply"), part.key("tank"));
    let into = through(part, supply.clone() - cap.clone(), cap.clone() - tank.clone());
    let out = through(part, rod.clone() - tank, supply - rod);
    let rate = |flow: Formula, volume: Formula| part.key("bulk") * flow / volume;
    let grown = |area: &Formula| area.clone() * stroke.clone();
    let cap_rate = rate(into - leak.clone() - cap_area.clone() * speed.clone(), cap_volume + grown(&cap_area));
    let rod_rate = rate(rod_area.clone() * speed + leak - out, rod_volume - grown(&rod_area));
    let state = |quantity, start, rate| OwnState { quantity, start, rate, nominal: ATMOSPHERE };
    vec![state(Q::CapPressure, cap_start, cap_rate), state(Q::RodPressure, rod_start, rod_rate)]
}

/// The flow through the valve, with the pressure that is left across it while the opening is positive and while it is negative.
fn through(part: &Part, positive: Formula, negative: Formula) -> Formula {
    let opening = part.key("opening");
    let flow = |left: Formula| part.key("valve") * opening.clone() * signed_root(left);
    let parts = [opening.clone(), Formula::Number(0.0), flow(positive), flow(negative)];
    Formula::If(Comparison::Greater, Box::new(parts))
}

/// x / (x^2 + LAMINAR^2)^(1/4): the root with the sign of what is under it.
fn signed_root(left: Formula) -> Formula {
    let square = left.clone() * left.clone() + Formula::Number(LAMINAR * LAMINAR);
    left / square.of(Unary::Sqrt).of(Unary::Sqrt)
}

impl Load {
    /// A hydraulic cylinder between two points; what it is made of are its keys.
    pub fn cylinder(first: &str, second: &str) -> Load {
        Load::new("cylinder").set("between", [first, second])
    }
}
