//! Joints that couple motions: rolling discs, distance links, gears, racks.

use super::Resolver;
use crate::mechanism::{BodyId, JointKind, Place};
use crate::scene::dimension::{ANGLE, LENGTH, NUMBER};
use crate::scene::fault::Fault;
use crate::scene::model::{self, Joint};
use crate::scene::span::{Span, Text};

impl Resolver<'_> {
    /// What a joint joins: two points, two wheels, or a pinion and a point of a rack.
    pub(super) fn joined(&mut self, joint: &Joint, user: &str) -> Option<[Place; 2]> {
        let [first, second] = &joint.between;
        let centre = |body: Option<BodyId>| body.map_or(Place::Origin, Place::Centre);
        match joint.kind {
            model::JointKind::Gear { .. } => Some(self.body_pair(&joint.between, user)?.map(centre)),
            model::JointKind::Rack { .. } => {
                let (pinion, rack) = (self.body(first, user), self.place(second, user));
                let (pinion, rack) = (pinion?, rack?);
                self.different(pinion, rack.body(), &joint.between, user)?;
                Some([centre(pinion), rack])
            }
            _ => self.places(&joint.between, user),
        }
    }

    /// The kinds of joints that `joint` leaves to this file.
    pub(super) fn coupling(&mut self, joint: &Joint, user: &str) -> Option<JointKind> {
        self.must_have_plane(user, joint.name.span);
        let of = |key: &str| format!("`{key}` of {user}");
        Some(match &joint.kind {
            model::JointKind::Rolling { axis, radius, displacement } => JointKind::Rolling {
                axis: self.axis(axis, &of("axis")),
                radius: self.positive_constant(radius, &of("radius"), &LENGTH),
                displacement: self.constant_or_zero(displacement.as_ref(), &of("displacement"), &LENGTH),
            },
            model::JointKind::Distance { length } => {
                JointKind::Distance { length: self.positive_constant(length, &of("length"), &LENGTH) }
            }
            model::JointKind::Gear { carrier, ratio, angle } => {
                let ratio = self.nonzero_constant(ratio, &of("ratio"), &NUMBER);
                let angle = self.constant_or_zero(angle.as_ref(), &of("angle"), &ANGLE);
                let carrier = carrier.as_ref().map_or(Some(None), |name| self.body(name, user));
                self.carrier_apart(joint, carrier?, user)?;
                JointKind::Gear { carrier: carrier?, ratio, angle }
            }
            model::JointKind::Rack { carrier, axis, radius, displacement } => {
                let axis = self.axis(axis, &of("axis"));
                let radius = self.nonzero_constant(radius, &of("radius"), &LENGTH);
                let displacement = self.constant_or_zero(displacement.as_ref(), &of("displacement"), &LENGTH);
                let carrier = carrier.as_ref().map_or(Some(Place::Origin), |name| self.place(name, user));
                self.carrier_apart(joint, carrier?.body(), user)?;
                JointKind::Rack { carrier: carrier?, axis, radius, displacement }
            }
            // `joint` handles these itself.
            model::JointKind::Revolute { .. }
            | model::JointKind::Prismatic { .. }
            | model::JointKind::Weld { .. }
            | model::JointKind::Slot { .. } => return None,
        })
    }

    /// The carrier must be neither of what it carries.
    fn carrier_apart(&mut self, joint: &Joint, carrier: Option<BodyId>, user: &str) -> Option<()> {
        let name = carrier.map_or("ground", |body| self.scene.bodies[body.0].name.text.as_str());
        let is_carrier = |end: &&Text| end.text.split('.').next() == Some(name);
        let Some(end) = joint.between.iter().find(is_carrier) else { return Some(()) };
        let message = format!("{user} moves `{name}` against its own carrier");
        self.faults.push(Fault::new("scene::self_connection", message, end.span).label("is the carrier").help(
            "name the body in which the wheels have their bearings: `carrier = \"arm\"`; without one it is the ground",
        ));
        None
    }

    /// Refuses what needs two directions in a scene of one dimension.
    pub(super) fn must_have_plane(&mut self, user: &str, span: Span) {
        if self.one_dimensional() {
            let message = format!("{user} needs the plane, but this scene has one dimension");
            self.faults.push(Fault::new("scene::one_dimension", message, span).label("not with `dimension = 1`").help(
                "remove `dimension = 1`, or use masses, forces, springs, actuators, welds and position drivers only",
            ));
        }
    }
}
