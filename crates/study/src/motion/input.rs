//! What is driven, what is looked at, and where the scene starts.

use std::collections::HashMap;

use cotree::compile::{compile, compile_with_equations};
use cotree::diagnostic::{Text, suggest};
use cotree::formulate::start::evaluate_at;
use cotree::model::{BodyId, Class, Formula, JointId, Mechanism, Owner, Part, Place, Quantity, Unit, Variable};
use cotree::scene::Scene;

use super::drive::{self, POSE};
use super::samples::Derivatives;
use super::{Drive, MotionError, unit_of};

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
            asked(mechanism, name).or_else(|| driver.and_then(by_driver))
        }
        None => mechanism.drivers.iter().find_map(by_driver),
    };
    let names = || all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>();
    found.ok_or_else(|| match name {
        Some(name) => {
            let known = suggest::known(name, names());
            MotionError::Request(format!("no joint `{name}` can be driven; {known}"))
        }
        None if all.is_empty() => MotionError::Request("the scene has no joint that can be driven".to_string()),
        None => {
            let known = suggest::list(names());
            MotionError::Request(format!(
                "no driver moves a joint: say which is the input with --input, one of {known}"
            ))
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
fn asked(mechanism: &Mechanism, name: &str) -> Option<(JointId, Derivatives)> {
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
    match asked(mechanism, name) {
        Some(motion) if motion == input => Err(MotionError::Request(format!("`{name}` is the input, not an output"))),
        Some(motion) if on_ground(motion.0) => Ok(Some(Watched::of_joint(mechanism, motion))),
        _ => match mechanism.joints.iter().find(|joint| joint.name == name) {
            Some(joint) => {
                let own: Vec<String> = joint.component().variables.iter().map(|quantity| quantity.of(name)).collect();
                let own = suggest::list(own.iter().map(String::as_str));
                Err(MotionError::Request(format!(
                    "`{name}` is no joint on the ground that a driver could move; name a variable: {own}"
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
    if !name.contains('.') && !expressions().any(|own| own == name) {
        let owners = mechanism.bodies.iter().map(|body| body.name.as_str());
        if owners.clone().any(|own| own == name) {
            return Err(unknown(format!("name a variable of the body, such as `{name}.angle` or `{name}.x`")));
        }
        let joints = mechanism.joints.iter().map(|joint| joint.name.as_str());
        return Err(unknown(suggest::known(name, joints.chain(expressions()).chain(owners))));
    }
    let resolved = only(scene, name).resolve().map_err(|faults| match faults.list.first() {
        Some(fault) if fault.code == "scene::unknown_output" => unknown(fault.help.to_string()),
        _ => MotionError::Scene(faults),
    })?;
    let Some(output) = resolved.mechanism.outputs.into_iter().next() else { return Err(unknown(String::new())) };
    let mut variables = vec![name.to_owned()];
    let is_rate = matches!(&output.value, Formula::Variable(variable) if matches!(variable.quantity.class(), Class::Velocity | Class::Acceleration));
    if let (Formula::Variable(variable), Some((owner, _))) = (&output.value, name.rsplit_once('.')) {
        let reported = drive::names(mechanism);
        let rates = rates(variable.quantity).iter().map(|rate| rate.of(owner));
        variables.extend(rates.take_while(|rate| reported.contains(rate)));
    }
    Ok(Watched { name: name.to_owned(), variables, unit: output.unit, is_rate, joint: None })
}

/// The variables that are the derivatives of another by time, one after the other.
fn rates(of: Quantity) -> &'static [Quantity] {
    use Quantity::{A, Acceleration, Alpha, Angle, Ax, Ay, Length, Omega, Rate, S, V, Vx, Vy, X, Y};
    const CHAINS: [Derivatives; 5] =
        [[Angle, Omega, Alpha], [S, V, A], [X, Vx, Ax], [Y, Vy, Ay], [Length, Rate, Acceleration]];
    let after = |chain: &'static Derivatives| Some(&chain[chain.iter().position(|own| *own == of)? + 1..]);
    CHAINS.iter().find_map(after).unwrap_or_default()
}

/// The scene that reports one variable or output of its own, and nothing else.
fn only(scene: &Scene, name: &str) -> Scene {
    let mut scene = scene.clone();
    scene.outputs.expressions.retain(|own| own.name.text == name);
    scene.outputs.variables.clear();
    if scene.outputs.expressions.is_empty() {
        scene.outputs.variables.push(Text::from(name));
    }
    scene
}

/// The scene that reports what is looked at, and nothing else.
pub(super) fn reporting(mut scene: Scene, output: Option<&Watched>) -> Scene {
    match output.and_then(|output| output.variables.first()) {
        Some(name) => only(&scene, name),
        None => {
            scene.outputs = Default::default();
            scene
        }
    }
}

/// Is what is looked at still there when the input is driven instead of what the scene drives?
pub(super) fn is_there(scene: &Scene, mechanism: &Mechanism, drive: &Drive) -> Result<(), MotionError> {
    let Err(faults) = drive::driven(scene, mechanism, drive, drive.start, 1.0).resolve() else { return Ok(()) };
    let why: Vec<&str> = faults.list.iter().map(|fault| fault.message.as_str()).collect();
    let input = drive::called(&mechanism.joints[drive.joint.0], drive.motion);
    Err(MotionError::Request(format!("while `{input}` is driven instead of what the scene drives: {}", why.join("; "))))
}

/// A scene at its start.
pub(super) struct Start {
    /// Of the input [rad] or [m].
    pub position: f64,
    /// [rad/s] or [m/s]
    pub speed: f64,
    /// The scene, in which nothing else drives what the input drives.
    pub scene: Scene,
}

/// Where the input is when the scene starts, and how fast it moves. The driver of another joint gives way to the input, if it leaves nothing free: the pose that it chose
/// becomes a guess.
pub(super) fn start(
    scene: &Scene,
    mechanism: &Mechanism,
    driven @ (joint, [position, rate, _]): (JointId, Derivatives),
) -> Result<Start, MotionError> {
    let input = &mechanism.joints[joint.0];
    let (_, mut formulated) = compile_with_equations(&with_masses(scene, mechanism, 1.0))?;
    let free = formulated.mobility() > 0;
    let equations = &mut formulated.equations;
    let mut values = |variables: &[Variable]| {
        let exprs: Vec<_> = variables.iter().map(|&variable| equations.variable(variable)).collect();
        evaluate_at(&equations.system.arena, &formulated.state, &exprs)
    };
    let of_input = values(&[position, rate].map(|quantity| Variable { owner: Owner::Joint(joint), quantity }));
    let pose = mechanism.bodies.iter().enumerate().flat_map(|(index, body)| {
        let owner = Owner::Place(Place::Centre(BodyId(index)));
        POSE.map(|quantity| (quantity.of(&body.name), Variable { owner, quantity }))
    });
    let pose: HashMap<String, f64> = pose.map(|(name, variable)| (name, values(&[variable])[0])).collect();
    let [position, speed] = [of_input[0], of_input[1]];
    let replaces = !free && !mechanism.drivers.iter().any(|driver| drive::moves(driver, driven, input));
    let mut scene = scene.clone();
    match &mechanism.drivers[..] {
        [_] if replaces => {
            scene.drivers.clear();
            scene = drive::assembled_at(scene, mechanism, |name| pose.get(name).copied());
        }
        [_, _, ..] if replaces => {
            let names = suggest::list(mechanism.drivers.iter().map(|driver| driver.name.as_str()).collect::<Vec<_>>());
            let message = format!("the scene drives {names}: take the one out that `{}` is to replace", input.name);
            return Err(MotionError::Request(message));
        }
        _ => {}
    }
    Ok(Start { position, speed, scene })
}

/// The scene with this mass \[kg\] and moment of inertia [kg.m2] where it has none. Where it starts does not depend on them.
fn with_masses(scene: &Scene, mechanism: &Mechanism, value: f64) -> Scene {
    let mut scene = scene.clone();
    for (written, body) in scene.bodies.iter_mut().zip(&mechanism.bodies) {
        let missing = [("mass", body.mass.is_none()), ("inertia", body.inertia.is_none())];
        for (key, _) in missing.into_iter().filter(|(_, missing)| *missing) {
            *written = written.clone().with_number(key, value);
        }
    }
    scene
}

/// The scene in which what lacks a mass has none: forces are then those of the loads and of the other masses. Where motion itself needs masses it stays as it is.
pub(super) fn without_masses(scene: &Scene, mechanism: &Mechanism, drive: &Drive, lacking: &[String]) -> Scene {
    if !lacking.is_empty() {
        let light = with_masses(scene, mechanism, 0.0);
        if compile(&drive::driven(&light, mechanism, drive, drive.start, 1.0)).is_ok() {
            return light;
        }
    }
    scene.clone()
}
