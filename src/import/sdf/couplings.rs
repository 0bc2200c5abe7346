//! Joints that follow others: `mimic`, and the gearboxes of SDF, which couple the turns of two links against a third.

use nalgebra::Vector3;

use super::{NamedJoint, SdfReader, is_gearbox, joined, number};
use crate::import::refusal::Fallible;
use crate::import::robot::{JointFollower, JointMotion, SpatialModel};
use crate::import::xml::XmlElement;

impl<'a> SdfReader<'a> {
    /// q = multiplier (q_leader - reference) + offset.
    pub fn followers(&self, model: &mut SpatialModel) -> Fallible<()> {
        for (name, scope, element) in &self.joints {
            let of_axis = element.child("axis").and_then(|axis| axis.child("mimic"));
            let Some(mimic) = of_axis.or_else(|| element.child("drake:mimic")) else { continue };
            let given = mimic.must("joint")?;
            let [Some(joint), Some(leader)] = [self.moving.get(name), self.moving.get(&joined(scope, given))] else {
                return Err(mimic.refuse(format!("{}: there is no joint `{given}` that moves", element.called())));
            };
            // Gazebo has elements, Drake attributes.
            let value = |key: &str, default: f64| match mimic.attribute(key) {
                Some(attribute) => attribute.number(),
                None => number(mimic.child(key), default),
            };
            let ratio = value("multiplier", 1.0)?;
            let offset = value("offset", 0.0)? - ratio * value("reference", 0.0)?;
            let short = name.rsplit("::").next().unwrap_or(name);
            model.joints[*joint].start = offset + ratio * model.joints[*leader].start;
            model.followers.push(JointFollower {
                name: format!("{short}_mimic"),
                place: mimic.place.clone(),
                joint: *joint,
                leader: Some(*leader),
                offset,
                ratio,
            });
        }
        Ok(())
    }

    /// theta_2 = -gearbox_ratio theta_1: the turns of the parent and of the child against the reference body, about `axis` and `axis2`. Each is that of a hinge of
    /// the file between those two links.
    pub fn gearboxes(&mut self, model: &mut SpatialModel, bodies: &[usize]) -> Fallible<()> {
        for (name, scope, element) in self.joints.iter().filter(|(.., joint)| is_gearbox(joint)) {
            let named = NamedJoint { name, scope, element };
            let body = |key: &str| -> Fallible<usize> {
                let child =
                    element.child(key).ok_or_else(|| element.refuse(format!("{} has no <{key}>", element.called())))?;
                Ok(self.frame_in_body(model, bodies, (scope, child.text.trim()), element)?.0)
            };
            let reference = body("gearbox_reference_body")?;
            let [(leader, first), (joint, second)] = [
                self.turn(model, named, [reference, body("parent")?], element.child("axis"))?,
                self.turn(model, named, [reference, body("child")?], element.child("axis2").or(element.child("axis")))?,
            ];
            let ratio = -number(element.child("gearbox_ratio"), 1.0)? * first * second;
            let short = name.rsplit("::").next().unwrap_or(name).to_owned();
            let place = element.place.clone();
            model.followers.push(JointFollower { name: short, place, joint, leader: Some(leader), offset: 0.0, ratio });
            model.joints[joint].start = ratio * model.joints[leader].start;
        }
        Ok(())
    }

    /// The hinge by which a link turns on another, and whether its axis is that of the gearbox or the opposite.
    fn turn(
        &self,
        model: &SpatialModel,
        named: NamedJoint<'_, 'a>,
        [reference, body]: [usize; 2],
        axis: Option<&'a XmlElement>,
    ) -> Fallible<(usize, f64)> {
        let element = named.element;
        let hinge = model.bodies[body].joints.iter().copied().find(|&joint| {
            model.joints[joint].kind == JointMotion::Hinge
                && model.mover(model.bodies[body].parent) == model.mover(reference)
        });
        let joint = hinge.ok_or_else(|| {
            let [body, reference] = [body, reference].map(|body| &model.bodies[body].name);
            element
                .refuse(format!("{}: no hinge joins `{body}` to `{reference}`, its reference body", element.called()))
                .help("remove it from the file, and add `type = \"gear\"` with its ratio to the scene")
        })?;
        let Some(axis) = axis else { return Ok((joint, 1.0)) };
        let along: Vector3<f64> = self.axis(named, axis, &model.world(body))?;
        Ok((joint, along.dot(&model.joints[joint].axis).signum()))
    }
}
