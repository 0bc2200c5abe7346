//! The drawing of a mechanism whose position is known.

use super::drawing::{Body, Drawing, Force, Joint, JointKind, Spring, Turn};
use crate::mechanism::{
    self, BodyId, Dimension, Driver, DriverKind, Formula, JointId, Load, LoadKind, Mechanism, Place,
};

/// Where everything is.
#[derive(Clone, Copy)]
pub struct Pose<'a> {
    /// A point in the world [m].
    pub place: &'a dyn Fn(Place) -> [f64; 2],
    /// The angle of a body [rad].
    pub angle: &'a dyn Fn(BodyId) -> f64,
    /// The value of a formula. An input that is zero is best taken as 1, so that the force it makes has a direction.
    pub value: &'a dyn Fn(&Formula) -> f64,
}

impl Drawing {
    /// Draws a mechanism.
    pub fn of(mechanism: &Mechanism, pose: &Pose) -> Drawing {
        let mut drawing = Drawing {
            title: mechanism.name.clone(),
            bodies: (0..mechanism.bodies.len())
                .map(|index| body(mechanism, BodyId(index), pose))
                .collect(),
            joints: mechanism
                .joints
                .iter()
                .map(|joint| self::joint(joint, pose))
                .collect(),
            ..Drawing::default()
        };
        for load in &mechanism.loads {
            drawing.add_load(mechanism, load, pose);
        }
        for driver in &mechanism.drivers {
            drawing.add_driver(mechanism, driver, pose);
        }
        if mechanism.dimension == Dimension::One {
            drawing.put_on_rails();
        }
        drawing.ground = ground(mechanism).into_iter().map(pose.place).collect();
        drawing
    }

    fn add_load(&mut self, mechanism: &Mechanism, load: &Load, pose: &Pose) {
        let name = load.name.clone();
        match &load.kind {
            LoadKind::Force {
                on,
                vector,
                in_body,
            } => {
                let turned = on.body().filter(|_| *in_body).map_or(0.0, pose.angle);
                let direction = rotated(vector.each_ref().map(pose.value), turned);
                if direction != [0.0, 0.0] {
                    self.forces.push(Force {
                        name,
                        at: (pose.place)(*on),
                        direction,
                    });
                }
            }
            LoadKind::Spring { between, .. } | LoadKind::Actuator { between, .. } => {
                self.springs.push(Spring {
                    name,
                    ends: between.map(pose.place),
                });
            }
            LoadKind::Torque { between, .. }
            | LoadKind::TorsionSpring { between, .. }
            | LoadKind::TorsionActuator { between, .. } => {
                self.turns.push(Turn {
                    name,
                    at: hinge(mechanism, *between, pose),
                });
            }
        }
    }

    fn add_driver(&mut self, mechanism: &Mechanism, driver: &Driver, pose: &Pose) {
        let name = driver.name.clone();
        match &driver.kind {
            DriverKind::Angle { between, joint, .. } => {
                let at = match joint {
                    Some(JointId(index)) => (pose.place)(mechanism.joints[*index].between[1]),
                    None => hinge(mechanism, *between, pose),
                };
                self.turns.push(Turn { name, at });
            }
            DriverKind::Displacement {
                joint: JointId(index),
                ..
            } => {
                let joint = &self.joints[*index];
                if let JointKind::Prismatic(direction) = joint.kind {
                    self.forces.push(Force {
                        name,
                        at: joint.at[1],
                        direction,
                    });
                }
            }
            // A point that follows a path has no direction of its own.
            DriverKind::Position { .. } => {}
        }
    }

    /// Masses on a line slide on the ground.
    fn put_on_rails(&mut self) {
        let rail = |(index, body): (usize, &Body)| Joint {
            name: String::new(),
            kind: JointKind::Prismatic([1.0, 0.0]),
            between: [None, Some(index)],
            at: [body.centre; 2],
        };
        self.joints.extend(self.bodies.iter().enumerate().map(rail));
    }
}

fn body(mechanism: &Mechanism, id: BodyId, pose: &Pose) -> Body {
    let body = &mechanism.bodies[id.0];
    let points = (0..body.points.len())
        .map(|point| (pose.place)(Place::Point(id, point)))
        .collect();
    Body {
        name: body.name.clone(),
        points,
        centre: (pose.place)(Place::Centre(id)),
    }
}

fn joint(joint: &mechanism::Joint, pose: &Pose) -> Joint {
    let kind = match &joint.kind {
        mechanism::JointKind::Revolute { .. } => JointKind::Revolute,
        mechanism::JointKind::Prismatic { axis, .. } => {
            let angle = joint.between[0].body().map_or(0.0, pose.angle);
            JointKind::Prismatic(rotated(axis.each_ref().map(pose.value), angle))
        }
        mechanism::JointKind::Weld { .. } => JointKind::Weld,
    };
    let between = joint.between.map(|place| place.body().map(|body| body.0));
    Joint {
        name: joint.name.clone(),
        kind,
        between,
        at: joint.between.map(pose.place),
    }
}

/// Where two bodies turn against one another: their revolute joint, otherwise the mass centre of one of them.
fn hinge(mechanism: &Mechanism, bodies: [Option<BodyId>; 2], pose: &Pose) -> [f64; 2] {
    let joins = |joint: &&mechanism::Joint| {
        let own = joint.between.map(Place::body);
        own == bodies || own == [bodies[1], bodies[0]]
    };
    let revolute =
        |joint: &&mechanism::Joint| matches!(joint.kind, mechanism::JointKind::Revolute { .. });
    match mechanism.joints.iter().filter(revolute).find(joins) {
        Some(joint) => (pose.place)(joint.between[1]),
        None => (pose.place)(bodies[1].or(bodies[0]).map_or(Place::Origin, Place::Centre)),
    }
}

/// Points of the ground that joints and springs use.
fn ground(mechanism: &Mechanism) -> Vec<Place> {
    let joints = mechanism.joints.iter().flat_map(|joint| joint.between);
    let springs = mechanism.loads.iter().flat_map(|load| match load.kind {
        LoadKind::Spring { between, .. } | LoadKind::Actuator { between, .. } => between.to_vec(),
        _ => Vec::new(),
    });
    let mut places: Vec<Place> = joints
        .chain(springs)
        .filter(|place| place.body().is_none())
        .collect();
    places.sort_unstable();
    places.dedup();
    places
}

fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// Bodies at their index, turned by a quarter; numbers only.
    fn drawing(scene: &str) -> Drawing {
        let mechanism = Scene::from_toml(scene)
            .unwrap()
            .resolve()
            .unwrap()
            .mechanism;
        let number = |formula: &Formula| {
            if let Formula::Number(value) = formula {
                *value
            } else {
                1.0
            }
        };
        let place = |place: Place| match place {
            Place::Origin => [0.0, 0.0],
            Place::Ground(point) => [-1.0, point as f64],
            Place::Centre(body) => [body.0 as f64, 0.0],
            Place::Point(body, point) => [body.0 as f64, 1.0 + point as f64],
        };
        let angle = |_: BodyId| std::f64::consts::FRAC_PI_2;
        Drawing::of(
            &mechanism,
            &Pose {
                place: &place,
                angle: &angle,
                value: &number,
            },
        )
    }

    #[test]
    fn every_element_finds_its_place() {
        let drawing = drawing(
            r#"
            format = 1
            name = "arm"
            [inputs]
            push = "0 N"
            [ground.points]
            bearing = [0, 0]
            unused = [0, 1]
            [bodies.arm]
            mass = 1
            inertia = 1
            points = { pivot = [0, -1] }
            [bodies.bead]
            mass = 1
            inertia = 1
            [joints.hinge]
            type = "revolute"
            between = ["ground.bearing", "arm.pivot"]
            [joints.rail]
            type = "prismatic"
            between = ["arm", "bead"]
            axis = [1, 0]
            [drivers.motor]
            between = ["ground", "arm"]
            angle = "t"
            [loads.wind]
            type = "force"
            on = "bead"
            vector = ["push", 0]
            [loads.wire]
            type = "spring"
            between = ["ground", "bead"]
            stiffness = 1
            length = 1
            "#,
        );
        assert_eq!(drawing.bodies.len(), 2);
        assert_eq!(drawing.joints[0].between, [None, Some(0)]);
        assert_eq!(drawing.joints[1].between, [Some(0), Some(1)]);
        let JointKind::Prismatic(axis) = drawing.joints[1].kind else {
            panic!("{:?}", drawing.joints[1])
        };
        assert!(
            axis[0].abs() < 1e-12 && (axis[1] - 1.0).abs() < 1e-12,
            "turns with the arm: {axis:?}"
        );
        assert_eq!(
            drawing.turns,
            [Turn {
                name: "motor".into(),
                at: [0.0, 1.0]
            }]
        );
        assert_eq!(drawing.forces[0].direction, [1.0, 0.0]);
        assert_eq!(drawing.springs[0].ends, [[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(drawing.ground, [[0.0, 0.0], [-1.0, 0.0]]);
    }

    #[test]
    fn masses_on_a_line_stand_on_the_ground() {
        let scene = "format = 1\nname = \"line\"\ndimension = 1\n[bodies.left]\nmass = 1\n[bodies.right]\nmass = 1\n";
        let drawing = drawing(scene);
        assert_eq!(drawing.joints.len(), 2);
        assert!(drawing.svg().contains(">left</text>"));
    }
}
