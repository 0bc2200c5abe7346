//! Which joint is one too many where loops cannot be closed: a second one between the same bodies, or one that leaves no freedom.

use crate::component::Angle;
use crate::component::Origin;
use crate::diagnostic::{Fault, Span};
use crate::equations::Equations;
use crate::formulate::assembly::list;
use crate::formulate::start::Start;
use crate::graph::ElementId;
use crate::mechanism::{Coordinates, JointId, Mechanism, Owner, Part, Value};

/// Beyond so many joints no single one is looked for.
const MOST_JOINTS: usize = 60;

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
        Fault::new(code, format!("{message}; without `{}` they close", self.name), self.span)
            .label("leaves no motion that closes them")
            .help(format!("{}; remove `{}`, or let it move", self.why, self.name))
    }

    pub fn name(&self) -> &str {
        &self.name
    }
}

/// The joint that is one too many, if the joints alone leave nothing to move.
pub fn suspect(equations: &Equations, length: f64) -> Option<Suspect> {
    let mechanism = equations.system.mechanism;
    if freedoms(equations) > 0 || mechanism.joints.len() > MOST_JOINTS {
        return None;
    }
    let beside = |index: usize| {
        let ends = |part: &Part| {
            let mut bodies = part.bodies();
            bodies.sort();
            bodies
        };
        let own = ends(&mechanism.joints[index]);
        mechanism.joints[..index].iter().find(|joint| ends(joint) == own)
    };
    let joints = || (0..mechanism.joints.len()).rev();
    let second = joints().filter_map(|index| {
        let why = format!("`{}` joins the same two bodies already", beside(index)?.name);
        Some((index, why))
    });
    let rigid = joints().filter(|&index| is_rigid(equations, JointId(index))).map(|index| {
        let joint = &mechanism.joints[index];
        (index, format!("`{}` is a {}, which leaves its bodies no motion", joint.name, joint.component().words()))
    });
    second.chain(rigid).find(|(index, _)| Start::find(&without(mechanism, JointId(*index)), length).is_some()).map(
        |(index, why)| {
            let joint = &mechanism.joints[index];
            Suspect { name: joint.name.clone(), span: joint.span, why }
        },
    )
}

/// That there are more drivers than freedoms.
pub fn too_many_drivers(equations: &Equations) -> Option<String> {
    let drivers: Vec<String> = equations.system.mechanism.drivers.iter().map(|driver| driver.name.clone()).collect();
    let freedoms = freedoms(equations);
    let is_more = freedoms > 0 && i64::try_from(drivers.len()).is_ok_and(|count| count > freedoms);
    is_more.then(|| {
        let freedoms = if freedoms == 1 { "1 freedom".to_string() } else { format!("{freedoms} freedoms") };
        format!("the joints leave {freedoms}, but {} prescribe motion: remove one", list(&drivers))
    })
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
    let driven: i64 = drivers.map(|driver| if driver.is_angular() || driver.joint().is_some() { 1 } else { 2 }).sum();
    equations.coordinates.len() as i64 - rows + driven
}

/// Does a joint hold its bodies together in every direction?
fn is_rigid(equations: &Equations, joint: JointId) -> bool {
    let Some(id) = equations.system.find(Origin::Joint(joint)) else { return false };
    let element = equations.system.element(id);
    let still = element.translation.as_ref().is_some_and(|row| row.motion.is_empty() && !row.reaction.is_empty());
    still && element.rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Constant(_)))
}

/// The mechanism without a joint, as far as its positions need it.
fn without(mechanism: &Mechanism, joint: JointId) -> Mechanism {
    let renumber = |id: &mut JointId| id.0 -= usize::from(id.0 > joint.0);
    let renumbered = |part: &Part| {
        let mut part = part.clone();
        for (_, value) in &mut part.values {
            if let Value::Joint(id) = value {
                renumber(id);
            }
        }
        if let Owner::Joint(id) = &mut part.owner {
            renumber(id);
        }
        part
    };
    let mut rest = mechanism.clone();
    rest.joints.remove(joint.0);
    rest.joints = rest.joints.iter().map(renumbered).collect();
    rest.drivers = rest.drivers.iter().filter(|driver| driver.joint() != Some(joint)).map(renumbered).collect();
    rest.initial.retain(|initial| !matches!(initial.variable.owner, Owner::Joint(id) if id == joint));
    rest.initial.retain(|initial| matches!(initial.variable.owner, Owner::Place(_) | Owner::Joint(_)));
    for initial in &mut rest.initial {
        if let Owner::Joint(id) = &mut initial.variable.owner {
            renumber(id);
        }
    }
    (rest.loads, rest.outputs, rest.coordinates) = (Vec::new(), Vec::new(), Coordinates::Recommended);
    rest
}
