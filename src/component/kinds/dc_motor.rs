//! DC motor (T): a torque by a current, which its winding lets grow slowly.

use crate::component::frame::Placed;
use crate::component::key::{BETWEEN_BODIES, Form, Key};
use crate::component::{Component, Icon, OwnState, Room, torsion};
use crate::model::measure::{CURRENT, INDUCTANCE, MOTOR_CONSTANT, NUMBER, RESISTANCE, VOLTAGE};
use crate::model::{Formula, Part, Quantity as Q, Range};
use crate::scene::{Load, Quantity};

pub(crate) const DC_MOTOR: Component = Component {
    about: "a motor with the current of its winding as a state",
    equations: "T = ratio constant i; inductance i' = voltage - resistance i - ratio constant omega",
    keys: &[
        BETWEEN_BODIES,
        Key::required(
            "voltage",
            Form::Law(VOLTAGE),
            "the voltage at its terminals: a law",
            "give the voltage: `voltage = \"12 V\"`, or a law of inputs and motions",
        ),
        Key::required(
            "resistance",
            Form::Constant(RESISTANCE, Range::NotNegative),
            "the resistance of its winding",
            "give the resistance: `resistance = \"0.8 ohm\"`",
        ),
        Key::required(
            "inductance",
            Form::Constant(INDUCTANCE, Range::Positive),
            "the inductance of its winding",
            "give the inductance: `inductance = \"4 mH\"`",
        ),
        Key::required(
            "constant",
            Form::Constant(MOTOR_CONSTANT, Range::Positive),
            "its torque per current, which is also its voltage per angular velocity",
            "give the torque per current: `constant = \"0.05 N.m/A\"`",
        ),
        Key::default(
            "ratio",
            Form::Constant(NUMBER, Range::NotZero),
            "turns of its rotor per turn between the bodies; its gear has no inertia and no backlash",
            "1",
        ),
        Key::default("current", Form::Constant(CURRENT, Range::Any), "its current at the start", "0"),
    ],
    variables: &[Q::Angle, Q::Omega, Q::Torque, Q::Current],
    law_variables: &[Q::Angle, Q::Omega, Q::Current],
    pose: &[Q::Angle, Q::Torque, Q::Current],
    room: Room::Turning,
    law: |part| Some(constant(part) * part.variable(Q::Current)),
    energy: |part| {
        let current = part.variable(Q::Current);
        Some(Formula::Number(0.5) * part.key("inductance") * current.clone() * current)
    },
    states: current,
    ..Component::load("dc_motor", torsion::rows, placed, |_| Icon::Turn)
};

/// Torque by current, and voltage by angular velocity, at the bodies.
fn constant(part: &Part) -> Formula {
    match part.value("ratio") {
        Some(_) => part.key("ratio") * part.key("constant"),
        None => part.key("constant"),
    }
}

fn current(part: &Part) -> Vec<OwnState> {
    let drop = part.key("resistance") * part.variable(Q::Current) + constant(part) * part.variable(Q::Omega);
    let rate = (part.key("voltage") - drop) / part.key("inductance");
    vec![OwnState { quantity: Q::Current, start: part.key("current"), rate, nominal: 1.0 }]
}

/// Seen in a mirror it turns the other way at the same current.
fn placed(placed: &mut Placed<'_>) {
    placed.sign("constant");
}

impl Load {
    /// A DC motor between two bodies, with its voltage, its resistance, its inductance, and its torque by current.
    pub fn dc_motor(
        first: &str,
        second: &str,
        voltage: impl Into<Quantity>,
        [resistance, inductance, constant]: [Quantity; 3],
    ) -> Load {
        let motor = Load::new("dc_motor").set("between", [first, second]).set("voltage", voltage.into());
        motor.set("resistance", resistance).set("inductance", inductance).set("constant", constant)
    }

    /// Turns of the rotor of a [`Load::dc_motor`] for one turn between the bodies.
    #[must_use]
    pub fn ratio(self, ratio: impl Into<Quantity>) -> Load {
        self.set("ratio", ratio.into())
    }

    /// The current of a [`Load::dc_motor`] at the start.
    #[must_use]
    pub fn current(self, current: impl Into<Quantity>) -> Load {
        self.set("current", current.into())
    }
}
