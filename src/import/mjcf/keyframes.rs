//! The start from a keyframe. Its angles are radians whatever the compiler says.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::MjcfReader;
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::robot::{Activation, JointMotion};
use crate::import::xml::XmlElement;

impl JointMotion {
    /// How many numbers MuJoCo's qpos and qvel have for it.
    fn widths(self) -> [usize; 2] {
        match self {
            JointMotion::Free => [7, 6],
            JointMotion::Ball => [4, 3],
            JointMotion::Hinge | JointMotion::Slide | JointMotion::Planar | JointMotion::Other(_) => [1, 1],
        }
    }
}

impl<'a> MjcfReader<'a> {
    pub fn keyframes(&mut self, root: &'a XmlElement) -> Fallible<()> {
        let keys: Vec<&XmlElement> = root.all("keyframe").flat_map(|section| section.all("key")).collect();
        let key = match &self.options.key {
            Some(wanted) => {
                let named = keys
                    .iter()
                    .position(|key| key.attribute("name").is_some_and(|attribute| attribute.value == *wanted));
                let index = named.or_else(|| wanted.parse::<usize>().ok().filter(|index| *index < keys.len()));
                Some(index.ok_or_else(|| {
                    let names: Vec<&str> = keys
                        .iter()
                        .filter_map(|key| key.attribute("name"))
                        .map(|attribute| attribute.value.as_str())
                        .collect();
                    ImportRefusal::new(format!("--key {wanted}: the file has no such keyframe")).help(format!(
                        "it has {} keyframes, from 0; their names are {}",
                        keys.len(),
                        names.join(", ")
                    ))
                })?)
            }
            None if keys.len() == 1 => Some(0),
            None => None,
        };
        keys.iter().for_each(|key| key.mark());
        match key {
            Some(index) => {
                let element = keys[index];
                self.start(element)?;
                let name = element.attribute("name").map_or(index.to_string(), |attribute| attribute.value.clone());
                self.report.note(format!("the motion starts from keyframe `{name}`"));
            }
            None if keys.len() > 1 => {
                self.report.note(format!("the motion starts from the reference configuration: the file has {} keyframes, and --key picks one", keys.len()));
            }
            None => {}
        }
        Ok(())
    }

    fn start(&mut self, key: &'a XmlElement) -> Fallible<()> {
        let numbers = |name: &str, count: usize| -> Fallible<Option<Vec<f64>>> {
            let Some(attribute) = key.attribute(name) else { return Ok(None) };
            let numbers = attribute.numbers()?;
            match numbers.len() == count {
                true => Ok(Some(numbers)),
                false => Err(ImportRefusal::new(format!(
                    "`{name}` has {} numbers, but the model has {count}",
                    numbers.len()
                ))
                .at(&attribute.place)),
            }
        };
        // MuJoCo numbers joints by bodies, in the order of the tree.
        let order: Vec<usize> = self.model.bodies.iter().flat_map(|body| body.joints.iter().copied()).collect();
        let total = |which: usize| order.iter().map(|&joint| self.model.joints[joint].kind.widths()[which]).sum();
        let (qpos, qvel) = (numbers("qpos", total(0))?, numbers("qvel", total(1))?);
        let states = self.controls.iter().map(|(_, states)| states).sum();
        let (ctrl, act) = (numbers("ctrl", self.controls.len())?, numbers("act", states)?);
        let (mut position, mut velocity) = (0, 0);
        for &joint in &order {
            let [width, rates] = self.model.joints[joint].kind.widths();
            if let Some(values) = qpos.as_ref().map(|all| &all[position..position + width]) {
                self.place_joint(joint, values);
            }
            if let Some(values) = qvel.as_ref().map(|all| &all[velocity..velocity + rates]) {
                self.move_joint(joint, values);
            }
            (position, velocity) = (position + width, velocity + rates);
        }
        // Actuators that are left out have their numbers, too.
        let mut state = 0;
        for (index, &(actuator, states)) in self.controls.iter().enumerate() {
            if let Some(actuator) = actuator.map(|index| &mut self.model.actuators[index]) {
                actuator.start = ctrl.as_ref().map_or(0.0, |values| values[index]);
                if let Activation::Integrator(_, start) | Activation::Filter(_, _, start) = &mut actuator.activation {
                    *start = act.as_ref().map_or(0.0, |values| values[state]);
                }
            }
            state += states;
        }
        Ok(())
    }

    fn place_joint(&mut self, joint: usize, values: &[f64]) {
        let joint = &mut self.model.joints[joint];
        match (joint.kind, values) {
            (JointMotion::Free, &[x, y, z, w, i, j, k]) => {
                let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-12).unwrap_or_default();
                let pose = Isometry3::from_parts(Translation3::new(x, y, z), turn);
                joint.free = Some((pose, Vector3::zeros(), Vector3::zeros()));
            }
            (JointMotion::Hinge | JointMotion::Slide, &[value]) => joint.start = value - joint.zero,
            _ => {}
        }
    }

    fn move_joint(&mut self, joint: usize, values: &[f64]) {
        let joint = &mut self.model.joints[joint];
        match (joint.kind, values) {
            // The angular velocity is in the axes of the body.
            (JointMotion::Free, &[x, y, z, p, q, r]) => {
                if let Some((pose, velocity, omega)) = &mut joint.free {
                    *velocity = Vector3::new(x, y, z);
                    *omega = pose.rotation * Vector3::new(p, q, r);
                }
            }
            (JointMotion::Hinge | JointMotion::Slide, &[rate]) => joint.rate = rate,
            _ => {}
        }
    }
}
