//! What is one too many where loops cannot be closed: a second joint between the same bodies, a joint that leaves no freedom, or a driver among others.

use crate::diagnostic::suggest::list;
use crate::diagnostic::{Fault, Span};
use crate::equations::Equations;
use crate::formulate::start::Start;
use crate::model::{DriverId, JointId, Mechanism, Owner, Part};
use crate::network::{Angle, ElementId, Origin};

/// Beyond so many joints no single one is looked for.
const MOST_JOINTS: usize = 60;
/// Nor is a driver beyond so many.
const MOST_DRIVERS: usize = 12;

/// A joint without which the loops close.
pub struct Suspect {
    name: String,
    span: Span,
    /// The joint between the same bodies, or what the joint is.
    why: String,
}

impl Suspect {
    /// The fault, named after this joint.
    pub fn fault(&self, code: &'static str, message: &str) -> Fault {
        Fault::new(code, format!("{message}; without `{}` the loops close", self.name), self.span)
            .label("leaves no motion that closes the loops")
            .help(format!("{}; remove `{}`, or give it a degree of freedom", self.why, self.name))
    }

    pub fn name(&self) -> &str {
        &self.name
    }
}

/// The joint that is one too many, if the joints alone leave nothing to move.
pub fn suspect(equations: &Equations, length: f64) -> Option<Suspect> {
    let mechanism = &equations.system.mechanism;
    if freedoms(equations) > 0 || mechanism.joints.len() > MOST_JOINTS {
        return None;
    }
    let beside = |index: usize| {
        let ends = |part: &Part| {
            let mut bodies = part.bodies();
            bodies.sort();
            bodies
        };
        let between = ends(&mechanism.joints[index]);
        mechanism.joints[..index].iter().find(|joint| ends(joint) == between)
    };
    let joints = || (0..mechanism.joints.len()).rev();
    let second = joints().filter_map(|index| {
        let why = format!("`{}` joins the same two bodies already", beside(index)?.name);
        Some((index, why))
    });
    let rigid = joints().filter(|&index| is_rigid(equations, JointId(index))).map(|index| {
        let joint = &mechanism.joints[index];
        (index, format!("`{}` is a {}, which has no degree of freedom", joint.name, joint.component().words()))
    });
    second.chain(rigid).find(|(index, _)| Start::find(&mechanism.without_joint(JointId(*index)), length).is_some()).map(
        |(index, why)| {
            let joint = &mechanism.joints[index];
            Suspect { name: joint.name.clone(), span: joint.span, why }
        },
    )
}

/// The fault of drivers that do not go together, if they are what keeps the loops open: they prescribe more than the joints leave free, or without
/// either of several the loops close. `missing` says how far they are open.
pub fn rivals(equations: &Equations, length: f64, missing: &str) -> Option<Fault> {
    let drivers = &equations.system.mechanism.drivers;
    let (freedoms, prescribed) = (freedoms(equations), prescribed(equations));
    let is_more = freedoms > 0 && prescribed > freedoms;
    let mut rivals = opened_by(&equations.system.mechanism, length);
    if rivals.len() < 2 {
        rivals = if is_more { drivers.iter().collect() } else { Vec::new() };
    }
    let (last, others) = rivals.split_last()?;
    let names = list(rivals.iter().map(|driver| &driver.name));
    let who = if others.is_empty() {
        format!("driver {names} overconstrains the mechanism")
    } else {
        format!("drivers {names} conflict")
    };
    let why = match is_more {
        true => {
            let freedoms = match freedoms {
                1 => "1 degree of freedom".to_string(),
                _ => format!("{freedoms} degrees of freedom"),
            };
            format!("the joints leave {freedoms}, but drivers prescribe {prescribed} motions")
        }
        false => "without any one of them the loops close".to_string(),
    };
    let fault = Fault::new("assembly::conflict", format!("{who}: {why}; {missing}"), last.span);
    let also = others.iter().map(|driver| driver.span).collect();
    let help = "remove a driver, or make the prescribed motions compatible; if they are, check the lengths and give a better guess of the initial configuration";
    Some(Fault { also, ..fault.label("incompatible with the rest of the mechanism").help(help) })
}

/// The drivers without each of which, alone, the loops close; none where there are many.
fn opened_by(mechanism: &Mechanism, length: f64) -> Vec<&Part> {
    let count = mechanism.drivers.len();
    if !(2..=MOST_DRIVERS).contains(&count) {
        return Vec::new();
    }
    let without = |index: usize| mechanism.without_drivers(&[], |part| part.owner == Owner::Driver(DriverId(index))).0;
    let closes = |index: &usize| Start::find(&without(*index).kinematic(), length).is_some();
    (0..count).filter(closes).map(|index| &mechanism.drivers[index]).collect()
}

/// How many motions the drivers prescribe.
fn prescribed(equations: &Equations) -> i64 {
    let drivers = equations.system.mechanism.drivers.iter();
    drivers.map(|driver| if driver.is_angular() || driver.joint().is_some() { 1 } else { 2 }).sum()
}

/// How many freedoms the joints leave, by counting, as if there were no drivers.
fn freedoms(equations: &Equations) -> i64 {
    let drivers = equations.system.mechanism.drivers.iter();
    // Where a driver stands for its joint in the tree, what the joint holds of itself is no equation.
    let is_held = |element: ElementId| match equations.system.element(element).origin {
        Origin::Joint(joint) => drivers.clone().any(|driver| driver.joint() == Some(joint)),
        _ => false,
    };
    let held = equations.constraints.iter().filter(|row| row.is_trivial() && is_held(row.element)).count();
    let rows = (equations.constraints.len() - held) as i64;
    equations.coordinates.len() as i64 - rows + prescribed(equations)
}

/// Does a joint hold its bodies together in every direction?
fn is_rigid(equations: &Equations, joint: JointId) -> bool {
    let Some(id) = equations.system.find(Origin::Joint(joint)) else { return false };
    let element = equations.system.element(id);
    let still = element.translation.as_ref().is_some_and(|row| row.motion.is_empty() && !row.reaction.is_empty());
    still && element.rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Constant(_)))
}
