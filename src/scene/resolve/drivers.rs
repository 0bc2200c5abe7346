//! Drivers.

use super::Resolver;
use super::lower::Context;
use super::names::Named;
use crate::mechanism::{Driver, DriverKind, Formula, InputId, JointId, Motion};
use crate::scene::dimension::{ACCELERATION, ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, LENGTH, VELOCITY, Wanted};
use crate::scene::fault::Fault;
use crate::scene::model::{self, InputAs, Turning};
use crate::scene::span::{Span, Text};
use crate::scene::suggest;
use crate::scene::unit::{compatible, from_exponents};

/// What the motion, its rate and the rate of that are.
const TURNING: [Wanted; 3] = [ANGLE, ANGULAR_VELOCITY, ANGULAR_ACCELERATION];
const SLIDING: [Wanted; 3] = [LENGTH, VELOCITY, ACCELERATION];

impl Resolver<'_> {
    pub(super) fn drivers(&mut self) -> Vec<Driver> {
        let scene = self.scene;
        scene.drivers.iter().filter_map(|driver| self.driver(driver)).collect()
    }

    fn driver(&mut self, driver: &model::Driver) -> Option<Driver> {
        let user = format!("driver `{}`", driver.name.text);
        let kind = match &driver.kind {
            model::DriverKind::Angle { of, motion } => self.angle(of, motion, &user, driver.name.span),
            model::DriverKind::Displacement { joint, motion } => {
                let motion = self.motion(motion, &format!("`displacement` of {user}"), &SLIDING);
                let joint = self.joint_named(joint, &user, "displacement");
                joint.zip(motion).map(|(joint, motion)| DriverKind::Displacement { joint, motion })
            }
            model::DriverKind::Position { on, position } => {
                let what = format!("`position` of {user}");
                let position = self.vector(position, &what, &LENGTH, Context::Driver);
                self.moving_place(on, &user).map(|on| DriverKind::Position { on, position })
            }
        };
        Some(Driver { name: driver.name.text.clone(), kind: kind?, span: driver.name.span })
    }

    fn angle(&mut self, of: &Turning, motion: &model::Motion, user: &str, span: Span) -> Option<DriverKind> {
        self.must_not_turn(user, span);
        let motion = self.motion(motion, &format!("`angle` of {user}"), &TURNING);
        let (between, joint) = match of {
            Turning::Between(between) => (self.body_pair(between, user)?, None),
            Turning::Joint(name) => {
                let joint = self.joint_named(name, user, "angle")?;
                let [first, second] = self.scene.joints[joint.0].between.clone();
                // What is wrong with these points has been said of the joint.
                let body = |this: &Self, point: &Text| {
                    let owner = point.text.split('.').next().unwrap_or_default();
                    match this.names.get(owner) {
                        Some(Named::Body(body)) => Some(Some(body)),
                        _ => (owner == "ground").then_some(None),
                    }
                };
                ([body(self, &first)?, body(self, &second)?], Some(joint))
            }
        };
        Some(DriverKind::Angle { between, joint, motion: motion? })
    }

    /// The joint that a driver names; it must permit the motion.
    fn joint_named(&mut self, name: &Text, user: &str, motion: &str) -> Option<JointId> {
        let Some(Named::Joint(id)) = self.names.get(&name.text) else {
            self.unknown_joint(name, user);
            return None;
        };
        let (found, help) = match (&self.scene.joints[id.0].kind, motion) {
            (
                model::JointKind::Revolute { .. } | model::JointKind::Slot { .. } | model::JointKind::Rolling { .. },
                "angle",
            )
            | (model::JointKind::Prismatic { .. } | model::JointKind::Slot { .. }, "displacement") => {
                return Some(id);
            }
            (model::JointKind::Revolute { .. }, _) => ("revolute", "give `angle = ...` instead of `displacement`"),
            (model::JointKind::Prismatic { .. }, _) => ("prismatic", "give `displacement = ...` instead of `angle`"),
            (model::JointKind::Rolling { .. }, _) => {
                ("a rolling disc", "give `angle = ...` instead of `displacement`: the disc's angle moves its centre")
            }
            (model::JointKind::Distance { .. }, _) => {
                ("a distance link", "its length is constant; a driver with `position` moves a point")
            }
            (model::JointKind::Gear { .. } | model::JointKind::Rack { .. }, _) => {
                ("a gear pair or rack", "name the joint in which a wheel turns or the rack slides")
            }
            (model::JointKind::Slot { .. }, _) => ("a slot", "give `displacement = ...` or `angle = ...`"),
            (model::JointKind::Weld { .. }, _) => {
                ("a weld", "a weld permits no motion: name a revolute or a prismatic joint")
            }
        };
        self.faults.push(
            Fault::new(
                "scene::driver_joint",
                format!("{user} prescribes `{motion}`, but joint `{}` is {found}", name.text),
                name.span,
            )
            .label(format!("this joint is {found}"))
            .help(help),
        );
        None
    }

    fn unknown_joint(&mut self, name: &Text, user: &str) {
        if self.is_reported(name, &name.text) {
            return;
        }
        let joints = self.names.all(|named| matches!(named, Named::Joint(_)));
        let otherwise = match joints.is_empty() {
            true => {
                "the scene has no joints; a driver between bodies takes `between = [\"ground\", \"crank\"]`".to_string()
            }
            false => format!("the joints are {}", suggest::list(joints.iter().copied())),
        };
        let help = suggest::hint(&name.text, joints.iter().copied(), otherwise);
        let message = format!("{user} uses a joint that is not in the scene: `{}`", name.text);
        self.faults.push_about(
            &name.text,
            Fault::new("scene::unknown_joint", message, name.span).label("no such joint").help(help),
        );
    }

    fn motion(&mut self, motion: &model::Motion, what: &str, wanted: &[Wanted; 3]) -> Option<Motion> {
        match motion {
            model::Motion::Given(law) => Some(Motion::Given(self.formula(law, what, &wanted[0], Context::Driver))),
            model::Motion::Follows { input, r#as } => {
                let id = self.input_named(input, what)?;
                let (wanted, motion) = match r#as {
                    InputAs::Position => (&wanted[0], Motion::Given(Formula::Input(id))),
                    InputAs::Velocity => (&wanted[1], Motion::Velocity(id)),
                    InputAs::Acceleration => (&wanted[2], Motion::Acceleration(id)),
                };
                self.check_input_unit(id, wanted, what, input.span);
                Some(motion)
            }
        }
    }

    fn check_input_unit(&mut self, id: InputId, wanted: &Wanted, what: &str, span: Span) {
        let known = self.input_units.get(id.0).copied().flatten();
        let (Some(found), Some(exponents)) = (known, wanted.exponents) else {
            return;
        };
        if !compatible(found, exponents) {
            let found = from_exponents(found).si;
            self.faults.push(
                Fault::new(
                    "scene::wrong_unit",
                    format!("{what} follows an input as {}, but the input is in `{found}`", wanted.what),
                    span,
                )
                .label(format!("not {}", wanted.what))
                .help(format!("declare the input with a unit such as `{}`, or change `as`", wanted.si)),
            );
        }
    }

    fn input_named(&mut self, name: &Text, what: &str) -> Option<InputId> {
        if let Some(Named::Input(id)) = self.names.get(&name.text) {
            return Some(id);
        }
        if !self.is_reported(name, &name.text) {
            let inputs = self.names.all(|named| matches!(named, Named::Input(_)));
            let otherwise = match inputs.is_empty() {
                true => format!("give it in `[inputs]`: `{} = 0.0`", name.text),
                false => format!("the inputs are {}", suggest::list(inputs.iter().copied())),
            };
            let help = suggest::hint(&name.text, inputs.iter().copied(), otherwise);
            let message = format!("{what} follows an input that is not in the scene: `{}`", name.text);
            self.faults.push_about(
                &name.text,
                Fault::new("scene::unknown_input", message, name.span).label("no such input").help(help),
            );
        }
        None
    }
}
