//! What is driven, what is looked at, and where the scene starts.

use std::collections::HashMap;

use cotree::compile::compile_with;
use cotree::diagnostic::suggest;
use cotree::formulate::start::evaluate_at;
use cotree::mechanism::{BodyId, JointId, Mechanism, Owner, Part, Place, Variable};
use cotree::scene::Scene;

use super::MotionError;
use super::drive::{self, POSE};

/// The joint that is driven.
pub(super) fn driven(mechanism: &Mechanism, name: Option<&str>) -> Result<JointId, MotionError> {
    let can_be_driven = |part: &&Part| drive::motion_of(part).is_some();
    let names = || mechanism.joints.iter().filter(can_be_driven).map(|joint| joint.name.as_str()).collect::<Vec<_>>();
    let by_driver = |driver: &Part| {
        let beside = |joint: &Part| driver.is_angular() && joint.bodies() == driver.bodies() && can_be_driven(&joint);
        driver.joint().or_else(|| mechanism.joints.iter().position(beside).map(JointId))
    };
    let found = match name {
        Some(name) => {
            let joint = mechanism.joints.iter().position(|joint| joint.name == name && can_be_driven(&joint));
            let driver = mechanism.drivers.iter().find(|driver| driver.name == name);
            joint.map(JointId).or_else(|| driver.and_then(by_driver))
        }
        None => mechanism.drivers.iter().find_map(by_driver),
    };
    found.ok_or_else(|| match name {
        Some(name) => {
            let known = suggest::known(name, names());
            MotionError::Request(format!("no joint `{name}` can be driven; {known}"))
        }
        None if names().is_empty() => MotionError::Request("the scene has no joint that can be driven".to_string()),
        None => {
            let known = suggest::list(names());
            MotionError::Request(format!(
                "no driver moves a joint: say which is the input with --input, one of {known}"
            ))
        }
    })
}

/// The joint on the ground whose motion is of interest.
pub(super) fn output(
    mechanism: &Mechanism,
    input: JointId,
    name: Option<&str>,
) -> Result<Option<JointId>, MotionError> {
    let can_be = |(index, joint): &(usize, &Part)| {
        *index != input.0 && joint.bodies().contains(&None) && drive::motion_of(joint).is_some()
    };
    let all = || mechanism.joints.iter().enumerate().filter(can_be);
    match name {
        None => Ok(all().next().map(|(index, _)| JointId(index))),
        Some(name) => match all().find(|(_, joint)| joint.name == name) {
            Some((index, _)) => Ok(Some(JointId(index))),
            None => {
                let known = suggest::known(name, all().map(|(_, joint)| joint.name.as_str()).collect::<Vec<_>>());
                Err(MotionError::Request(format!("no joint `{name}` on the ground can be the output; {known}")))
            }
        },
    }
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
pub(super) fn start(scene: &Scene, mechanism: &Mechanism, joint: JointId) -> Result<Start, MotionError> {
    let input = &mechanism.joints[joint.0];
    let Some([position, rate, _]) = drive::motion_of(input) else {
        return Ok(Start { position: 0.0, speed: 0.0, scene: scene.clone() });
    };
    let (_, (values, pose, free)) = compile_with(&with_masses(scene, mechanism), |formulated| {
        let equations = &mut formulated.equations;
        let mut values = |variables: &[Variable]| {
            let exprs: Vec<_> = variables.iter().map(|&variable| equations.variable(variable)).collect();
            evaluate_at(&equations.system.arena, &formulated.state, &exprs)
        };
        let of_input = values(&[position, rate].map(|quantity| Variable { owner: Owner::Joint(joint), quantity }));
        let pose = mechanism.bodies.iter().enumerate().flat_map(|(index, body)| {
            let owner = Owner::Place(Place::Centre(BodyId(index)));
            POSE.map(|quantity| (format!("{}.{}", body.name, quantity.word()), Variable { owner, quantity }))
        });
        let pose: HashMap<String, f64> = pose.map(|(name, variable)| (name, values(&[variable])[0])).collect();
        (of_input, pose, formulated.mobility() > 0)
    })?;
    let [position, speed] = [values[0], values[1]];
    let replaces = !free && !mechanism.drivers.iter().any(|driver| drive::moves(driver, joint, input));
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

/// The scene with a mass of 1 kg and a moment of inertia of 1 kg.m2 where it has none: where it starts does not depend on them.
fn with_masses(scene: &Scene, mechanism: &Mechanism) -> Scene {
    let mut scene = scene.clone();
    for (written, body) in scene.bodies.iter_mut().zip(&mechanism.bodies) {
        let missing = [("mass", body.mass.is_none()), ("inertia", body.inertia.is_none())];
        for (key, _) in missing.into_iter().filter(|(_, missing)| *missing) {
            *written = written.clone().with_number(key, 1.0);
        }
    }
    scene
}
