//! Joints.

use super::Resolver;
use super::lower::Context;
use crate::mechanism::{BinaryOperator, Formula, Friction, Function, Joint, JointKind};
use crate::scene::constant;
use crate::scene::dimension::{
    ANGLE, ANGULAR_VELOCITY, ANYTHING, DAMPING, FORCE, TORQUE, TORSION_DAMPING, VELOCITY, Wanted,
};
use crate::scene::fault::Fault;
use crate::scene::model::{self, Vector};

impl Resolver<'_> {
    pub(super) fn joints(&mut self) -> Vec<Joint> {
        let scene = self.scene;
        scene.joints.iter().filter_map(|joint| self.joint(joint)).collect()
    }

    fn joint(&mut self, joint: &model::Joint) -> Option<Joint> {
        let user = format!("joint `{}`", joint.name.text);
        let between = self.joined(joint, &user);
        let of = |key: &str| format!("`{key}` of {user}");
        let kind = match &joint.kind {
            model::JointKind::Revolute { damping, friction } => {
                self.must_not_turn(&format!("revolute {user}"), joint.name.span);
                JointKind::Revolute {
                    damping: self.constant_or_zero(damping.as_ref(), &of("damping"), &TORSION_DAMPING),
                    friction: self.friction(friction.as_ref(), &user, [&TORQUE, &ANGULAR_VELOCITY]),
                }
            }
            model::JointKind::Prismatic { axis, angle, damping, friction } => {
                if self.one_dimensional() {
                    self.faults.push(
                        Fault::new(
                            "scene::one_dimension",
                            format!("prismatic {user} is not needed in one dimension"),
                            joint.name.span,
                        )
                        .label("not with `dimension = 1`")
                        .help("remove it: every mass slides along x already"),
                    );
                    return None;
                }
                JointKind::Prismatic {
                    axis: self.axis(axis, &of("axis")),
                    angle: self.constant_or_zero(angle.as_ref(), &of("angle"), &ANGLE),
                    damping: self.constant_or_zero(damping.as_ref(), &of("damping"), &DAMPING),
                    friction: self.friction(friction.as_ref(), &user, [&FORCE, &VELOCITY]),
                }
            }
            model::JointKind::Weld { angle } => {
                if let (true, Some(angle)) = (self.one_dimensional(), angle) {
                    self.must_not_turn(&of("angle"), angle.span);
                }
                JointKind::Weld { angle: self.constant_or_zero(angle.as_ref(), &of("angle"), &ANGLE) }
            }
            model::JointKind::Slot { axis, damping, friction } => {
                self.must_have_plane(&user, joint.name.span);
                JointKind::Slot {
                    axis: self.axis(axis, &of("axis")),
                    damping: self.constant_or_zero(damping.as_ref(), &of("damping"), &DAMPING),
                    friction: self.friction(friction.as_ref(), &user, [&FORCE, &VELOCITY]),
                }
            }
            _ => self.coupling(joint, &user)?,
        };
        Some(Joint { name: joint.name.text.clone(), between: between?, kind, span: joint.name.span })
    }

    fn friction(
        &mut self,
        friction: Option<&model::Friction>,
        user: &str,
        [level, speed]: [&Wanted; 2],
    ) -> Option<Friction> {
        friction.map(|friction| Friction {
            coulomb: self.not_negative(&friction.coulomb, &format!("`coulomb` of the friction of {user}"), level),
            velocity: self.positive_constant(
                &friction.velocity,
                &format!("`velocity` of the friction of {user}"),
                speed,
            ),
        })
    }

    /// The unit vector along an axis.
    pub(super) fn axis(&mut self, axis: &Vector, what: &str) -> [Formula; 2] {
        let [x, y] = self.vector(axis, what, &ANYTHING, Context::Constant);
        let length = self.value(&x).hypot(self.value(&y));
        if length == 0.0 {
            self.faults.push(
                Fault::new("scene::zero_axis", format!("{what} has no length, so it has no direction"), axis.span)
                    .label("length zero")
                    .help("give a direction, of any length: `axis = [1.0, 0.0]`"),
            );
        }
        match (constant::number(&x), constant::number(&y)) {
            (Some(x), Some(y)) => [Formula::Number(x / length), Formula::Number(y / length)],
            _ => {
                let squared = |a: &Formula| constant::combine(BinaryOperator::Power, a.clone(), Formula::Number(2.0));
                let sum = constant::combine(BinaryOperator::Add, squared(&x), squared(&y));
                let norm = constant::apply(Function::Sqrt, vec![sum]);
                [x, y].map(|component| constant::combine(BinaryOperator::Divide, component, norm.clone()))
            }
        }
    }
}
