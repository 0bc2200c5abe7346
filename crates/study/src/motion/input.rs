//! The input joint, the output, and the start of the scene.

use std::collections::HashMap;

use cotree::diagnostic::{FaultKind, suggest};
use cotree::formulate::formulate;
use cotree::model::{Class, Formula, JointId, Mechanism, Output, Owner, Part, Quantity, Unit, Variable};
use cotree::scene::{Faults, Requested, Scene};

use super::drive::{self, Moved};
use super::samples::Derivatives;
use super::{DrivenJoint, MotionError, unit_of};

/// The joint that is driven, and how.
pub(super) fn driven(mechanism: &Mechanism, name: Option<&str>) -> Result<(JointId, Derivatives), MotionError> {
    let all: Vec<(String, (JointId, Derivatives))> = motions(mechanism).collect();
    let by_driver = |driver: &Part| {
        let moved =
            |(_, input): &&(String, (JointId, Derivatives))| drive::moves(driver, *input, &mechanism.joints[input.0.0]);
        all.iter().find(moved).map(|(_, input)| *input)
    };
    let found = match name {
        Some(name) => {
            let driver = mechanism.drivers.iter().find(|driver| driver.name == name);
            requested(mechanism, name).or_else(|| driver.and_then(by_driver))
        }
        None => mechanism.drivers.iter().find_map(by_driver),
    };
    let names = || all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>();
    found.ok_or_else(|| match name {
        Some(name) => {
            let known = suggest::known(name, names());
            MotionError::Request(format!("there is no joint `{name}` that can be driven; {known}"))
        }
        None if all.is_empty() => MotionError::Request("the scene has no joint that can be driven".to_string()),
        None => {
            let known = suggest::list(names());
            MotionError::Request(format!("the scene has no driver of a joint: give --input, one of {known}"))
        }
    })
}

/// What drivers can move, by its name.
fn motions(mechanism: &Mechanism) -> impl Iterator<Item = (String, (JointId, Derivatives))> {
    mechanism.joints.iter().enumerate().flat_map(|(index, joint)| {
        drive::motions_of(joint).map(move |motion| (drive::called(joint, motion), (JointId(index), motion)))
    })
}

/// The motion with a name such as `pin`, `pin.angle` or `pin.s`.
fn requested(mechanism: &Mechanism, name: &str) -> Option<(JointId, Derivatives)> {
    let is_it = |(called, (joint, motion)): &(String, (JointId, Derivatives))| {
        called == name || motion[0].of(&mechanism.joints[joint.0].name) == name
    };
    motions(mechanism).find(is_it).map(|(_, motion)| motion)
}

/// What is looked at.
pub(super) struct Watched {
    pub name: String,
    /// Its variable, with its rate and its acceleration as far as there are variables for them.
    pub variables: Vec<String>,
    pub unit: Unit,
    /// Is it a velocity or an acceleration?
    pub is_rate: bool,
    /// What is asked for.
    pub requested: Output,
    /// The joint on the ground whose motion it is.
    pub joint: Option<(JointId, Derivatives)>,
}

impl Watched {
    fn of_joint(mechanism: &Mechanism, (id, motion): (JointId, Derivatives)) -> Watched {
        let joint = &mechanism.joints[id.0];
        Watched {
            name: drive::called(joint, motion),
            variables: motion.map(|quantity| quantity.of(&joint.name)).to_vec(),
            unit: unit_of(motion),
            is_rate: false,
            requested: mechanism.output(Variable { owner: joint.owner, quantity: motion[0] }),
            joint: Some((id, motion)),
        }
    }
}

/// The motion of a joint on the ground, a variable, or an output of the scene.
pub(super) fn output(
    scene: &Scene,
    mechanism: &Mechanism,
    input: (JointId, Derivatives),
    name: Option<&str>,
) -> Result<Option<Watched>, MotionError> {
    let on_ground = |id: JointId| mechanism.joints[id.0].bodies().contains(&None);
    let Some(name) = name else {
        let other = motions(mechanism).find(|(_, (joint, _))| *joint != input.0 && on_ground(*joint));
        return Ok(other.map(|(_, other)| Watched::of_joint(mechanism, other)));
    };
    match requested(mechanism, name) {
        Some(motion) if motion == input => Err(MotionError::Request(format!("`{name}` is the input, not an output"))),
        Some(motion) if on_ground(motion.0) => Ok(Some(Watched::of_joint(mechanism, motion))),
        _ => match mechanism.joints.iter().find(|joint| joint.name == name) {
            Some(joint) => {
                let names: Vec<String> = joint.component().variables.iter().map(|quantity| quantity.of(name)).collect();
                let names = suggest::list(names.iter().map(String::as_str));
                Err(MotionError::Request(format!(
                    "`{name}` is not a joint on the ground that a driver could move; name a variable: {names}"
                )))
            }
            None => variable(scene, mechanism, name).map(Some),
        },
    }
}

/// A variable or an output of the scene.
fn variable(scene: &Scene, mechanism: &Mechanism, name: &str) -> Result<Watched, MotionError> {
    let expressions = || scene.outputs.expressions.iter().map(|output| output.name.text.as_str());
    let unknown =
        |more: String| MotionError::Request(format!("there is no joint, variable or output `{name}`; {more}"));
    if !name.contains('.') && !expressions().any(|expression| expression == name) {
        let owners = mechanism.bodies.iter().map(|body| body.name.as_str());
        if owners.clone().any(|owner| owner == name) {
            return Err(unknown(format!("name a variable of the body, such as `{name}.angle` or `{name}.x`")));
        }
        let joints = mechanism.joints.iter().map(|joint| joint.name.as_str());
        return Err(unknown(suggest::known(name, joints.chain(expressions()).chain(owners))));
    }
    let resolved = scene.resolve_asking(&Requested::these([name])).map_err(|faults| match faults.list.first() {
        Some(fault) if fault.kind() == FaultKind::UnknownOutput => unknown(fault.help.to_string()),
        _ => MotionError::Scene(faults),
    })?;
    let Some(output) = resolved.outputs.into_iter().next() else { return Err(unknown(String::new())) };
    let mut variables = vec![name.to_owned()];
    let is_rate = matches!(&output.value, Formula::Variable(variable) if matches!(variable.quantity.class(), Class::Velocity | Class::Acceleration));
    if let (Formula::Variable(variable), Some((owner, _))) = (&output.value, name.rsplit_once('.')) {
        let reported = drive::names(mechanism);
        let rates = rates(variable.quantity).iter().map(|rate| rate.of(owner));
        variables.extend(rates.take_while(|rate| reported.contains(rate)));
    }
    let unit = output.unit.clone();
    Ok(Watched { name: name.to_owned(), variables, unit, is_rate, requested: output, joint: None })
}

/// The variables that are the derivatives of another by time, one after the other.
fn rates(of: Quantity) -> &'static [Quantity] {
    let after =
        |chain: &'static Derivatives| Some(&chain[chain.iter().position(|derivative| *derivative == of)? + 1..]);
    Quantity::MOTIONS.iter().find_map(after).unwrap_or_default()
}

/// True if what is asked of a mechanism is still there when the input is driven instead of what the scene drives. `moved` is the mechanism at its start.
pub(super) fn is_there(
    mechanism: &Mechanism,
    requested: &[Output],
    moved: &Moved,
    drive: &DrivenJoint,
) -> Result<(), MotionError> {
    let driven = drive::driven(moved, drive, drive.start, 1.0);
    let is_left = |name: &str| driven.watched.iter().any(|output| output.name == name);
    let Some(output) = requested.iter().find(|output| !is_left(&output.name)) else { return Ok(()) };
    let mut used = Vec::new();
    output.value.visit(&mut |part| match part {
        Formula::Variable(variable) if matches!(variable.owner, Owner::Driver(_)) => {
            used.push(mechanism.variable_name(*variable));
        }
        _ => {}
    });
    let input = drive::called(&mechanism.joints[drive.joint.0], drive.motion);
    let (name, used) = (&output.name, suggest::list(used));
    Err(MotionError::Request(format!(
        "while `{input}` is driven instead of the driver of the scene: `{name}` uses {used}, of the replaced driver"
    )))
}

/// A mechanism at its start.
pub(super) struct InputStart {
    /// Of the input [rad] or [m].
    pub position: f64,
    /// [rad/s] or [m/s]
    pub speed: f64,
    /// The mechanism, in which nothing else drives what the input drives.
    pub moved: Moved,
}

/// Where the input is when the scene starts, and how fast it moves. The driver of another joint gives way to the input, if it leaves nothing free: the pose that it chose
/// becomes a guess.
pub(super) fn start(
    scene: &Scene,
    mechanism: &Mechanism,
    requested: &[Output],
    driven @ (joint, [position, rate, _]): (JointId, Derivatives),
) -> Result<InputStart, MotionError> {
    let input = &mechanism.joints[joint.0];
    // Where it starts does not depend on masses.
    let formulated = formulate(&mechanism.with_mass(1.0), &[]);
    let mut formulated = formulated.map_err(|list| Faults::new(scene.source.clone(), list))?;
    let free = formulated.mobility() > 0;
    let equations = &mut formulated.equations;
    let mut values = |variables: &[Variable]| {
        let exprs: Vec<_> = variables.iter().map(|&variable| equations.variable(variable)).collect();
        equations.system.arena.evaluate(&exprs, &formulated.state)
    };
    let of_input = values(&[position, rate].map(|quantity| Variable { owner: Owner::Joint(joint), quantity }));
    let pose = mechanism.pose();
    let pose: HashMap<Variable, f64> = pose.iter().copied().zip(values(&pose)).collect();
    let [position, speed] = [of_input[0], of_input[1]];
    let replaces = !free && !mechanism.drivers.iter().any(|driver| drive::moves(driver, driven, input));
    let (begun, watched) = match &mechanism.drivers[..] {
        [_] if replaces => {
            let (left, watched) = mechanism.without_drivers(requested, |_| true);
            (left.posed(|variable| pose.get(&variable).copied()), watched)
        }
        [_, _, ..] if replaces => {
            let names = suggest::list(mechanism.drivers.iter().map(|driver| driver.name.as_str()).collect::<Vec<_>>());
            let message = format!("the scene has drivers {names}: remove the one that `{}` replaces", input.name);
            return Err(MotionError::Request(message));
        }
        _ => (mechanism.clone(), requested.to_vec()),
    };
    let moved = Moved { mechanism: begun, watched, has_efforts: true, source: scene.source.clone() };
    Ok(InputStart { position, speed, moved })
}

/// What lacks a mass has none: forces are then those of the loads and of the other masses. Where motion itself needs masses it stays as it is.
pub(super) fn without_masses(moved: Moved, drive: &DrivenJoint, lacking: &[String]) -> Moved {
    if lacking.is_empty() {
        return moved;
    }
    let light = Moved { mechanism: moved.mechanism.with_mass(0.0), ..moved.clone() };
    if drive::is_determined(&light, drive) { light } else { Moved { has_efforts: false, ..moved } }
}
